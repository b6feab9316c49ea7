//! Exact maps from output pixels to directions, and the error of any other map against them.
