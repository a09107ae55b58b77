//! The simulation of the embedded designs, in the rooms that they are in.

mod agreement;
mod agreement_frames;
mod arrows;
mod best_layouts;
mod body_compensation;
mod body_prediction;
mod comparison;
mod elevate;
mod field_lattice;
mod model_validity;
mod placement;
mod pose_rule;
mod preview;
mod procedure;
mod profile;
mod slice;
mod slice_support;
mod tolerance;
mod usable_region;
