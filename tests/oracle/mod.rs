//! The worked cases of an independent program, to 1e-9.

mod fits;
mod frames;
mod weights;
