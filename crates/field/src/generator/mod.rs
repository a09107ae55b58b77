//! The field generator of a tracker, and what sensors in its field are reported at.

mod coils;
pub mod determination;
pub mod dipole;
pub mod lanes;
pub mod reading;
mod square_loop;

#[cfg(test)]
pub(crate) use coils::tests;
pub use coils::{BUILT_IN, Coil, Generator, GeneratorError, MAX_COILS, MIN_COILS};
