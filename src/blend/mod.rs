//! Weights of overlapping outputs.
