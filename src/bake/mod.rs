//! The job: frames, budget, progress, files.
