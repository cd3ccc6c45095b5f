//! Space-time blending of shapes and space-time transfinite interpolation of attributes.
