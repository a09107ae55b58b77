//! The libraries as a Python package: arrays, tables and files in; arrays and figures out.
//!
//! Everything here reads arguments, calls a library and gives back what it found; nothing is computed.
//! What Python sees is described in `trackwright/_core.pyi`: shapes, units and frames.

mod arrays;
mod calibration;
mod choices;
mod comparison;
mod design;
mod environment;
mod errors;
mod fields;
mod fitting;
mod found;
mod frames;
mod keywords;
mod long_work;
mod measurements;
mod openigtlink;
mod optimization;
mod pose_tables;
mod recordings;
mod records;
mod rotations;
mod simulation;
mod sweeps;
mod tables;
mod tools;
mod values;

#[pyo3::pymodule(gil_used = true)]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::calibration::{
        HandEye, Pivot, Registration, Spin, hand_eye, pivot_calibration, register, spin_calibration,
    };
    #[pymodule_export]
    use super::comparison::compare;
    #[pymodule_export]
    use super::design::{Design, Sensor};
    #[pymodule_export]
    use super::environment::{Corrected, Environment, Readings};
    #[pymodule_export]
    use super::errors::{TrackwrightError, TrackwrightWarning};
    #[pymodule_export]
    use super::fields::{Generator, solid_harmonic_gradients, sphere_factor, sphere_field};
    #[pymodule_export]
    use super::found::Found;
    #[pymodule_export]
    use super::frames::{FrameFit, fit_frame, point_covariance};
    #[pymodule_export]
    use super::openigtlink::{
        IgtlDecoder, IgtlMessage, encode_status, encode_tracking, encode_transform,
    };
    #[pymodule_export]
    use super::optimization::{Places, optimize};
    #[pymodule_export]
    use super::recordings::Recording;
    #[pymodule_export]
    use super::rotations::{basis_orientations, orientation_weights, rotation_vectors};
    #[pymodule_export]
    use super::simulation::{Simulation, simulate, simulate_crf};
    #[pymodule_export]
    use super::sweeps::{Sweep, SweepTable, merge_sweep, sweep_status};
    #[pymodule_export]
    use super::tools::Tool;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
