//! Finds where sensors serve a design best, within what can be built, and judges the gain in
//! fields that the search did not see.
//!
//! A candidate place's readings at every pose are computed once, so that a layout costs its frame fits
//! alone. Layouts of a grid are all judged where they are few enough; steps off the grid follow.
//! `docs/methods/optimal-placement.md` derives what is done.
//!
//! Lengths are in mm, angles in radians unless a name states degrees.

mod bodies;
mod channel;
mod choice;
mod constraint;
mod covering;
mod crf_patch;
mod crowding;
mod footing;
mod grid_search;
mod judge;
mod optimize;
mod outcome;
mod places;
mod polish;
mod pose_change;
mod problem;
mod scatter;
mod search;
mod slot_grids;
mod table;
#[cfg(test)]
mod tests;
mod verdict;

pub use constraint::Constraint;
pub use crf_patch::CrfPatch;
pub use crowding::Crowding;
pub use optimize::optimize;
pub use outcome::{
    Binding, Flatness, Layout, OptimizeError, Optimized, Progress, RoomGain, RoughlyBuilt,
};
pub use pose_change::PoseChange;
pub use problem::{
    BuiltError, Goal, MountedBody, Moves, OverRooms, PoseBounds, Problem, SensorChoice, Settings,
};
