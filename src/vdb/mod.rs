//! The OpenVDB border: the one room that knows OpenVDB exists, and the one place that flips the sign.
