//! Which metal is it? From measurements in a room, the compact bodies that explain what disturbs them.
//!
//! A compact body that is far beside its size adds to each coil's field `B_i` the field of a dipole
//! `f a³ B_i(c)` at its middle `c`. Places and strengths of one to three such bodies are fitted to the
//! measurements, then spheres of those strengths with all orders; how many there are is decided by
//! measurements held out.

#[cfg(test)]
mod cases;
pub mod compare;
mod extended;
mod found_body;
mod found_room;
mod held_out;
mod identification;
mod multipoles;
mod noise;
mod rows;
mod search;
mod solve;
mod sources;
#[cfg(test)]
mod tests;

pub use found_body::{
    BodyDoubt, BodyForm, CLEAR_STRENGTH, EXTENT_LIMIT, Form, FoundBody, Interval, KnownBody,
    MetalKind, POSITION_LIMIT,
};
pub use found_room::room_of_found;
pub use identification::{
    Identification, IdentifyError, IdentifySettings, MAX_BODIES, MIN_MEASUREMENTS, MISFIT,
    MOST_LEFT, Tried, Verdict, identify,
};
pub use noise::Noise;
pub use sources::{Source, SourceModel};
