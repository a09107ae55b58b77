//! Mistakes that move readings by as little as a field does, as effects on the errors of a table's rows.

use super::beside_field::Effect;
use super::mistake::Mistake;
use nalgebra::Vector3;
use trackwright_field::samples::{
    MapKind, Measurement, MeasurementContent, MeasurementSet, PoseError,
};

/// Effects of a part of the rows that move all rows by less in the mean are not reported: a few rows that differ by
/// little are outliers, and change no room.
pub(super) const LEAST_MM: f64 = 0.2;
pub(super) const LEAST_RAD: f64 = 0.008;

/// A mistake, by what a unit of each of its parameters moves the errors by.
pub(super) struct Effects {
    /// Of the errors of orientations, not of positions.
    pub of_angles: bool,
    pub each: Vec<Effect>,
    pub mistake: fn(&[f64]) -> Mistake,
}

/// Errors of positions in mm and of orientations in radians.
pub(super) fn errors(rows: &[Measurement], content: MeasurementContent) -> [Effect; 2] {
    let set = MeasurementSet { measurements: rows.to_vec(), content };
    let samples = set.samples(MapKind::Distortion).samples;
    let of =
        |error: fn(&PoseError) -> Vector3<f64>| samples.iter().map(|s| error(&s.error)).collect();
    [of(|error| error.position_mm), of(|error| error.rotation_rad)]
}

/// Those that rows of this content may show.
pub(super) fn effects(rows: &[Measurement], content: MeasurementContent) -> Vec<Effects> {
    let of = |direction: &dyn Fn(&Measurement) -> Vector3<f64>| -> Effect {
        rows.iter().map(direction).collect()
    };
    let along = |axis: usize| of(&move |m| m.tracker_from_ideal.rotation * Vector3::ith(axis, 1.0));
    let constant = |axis: usize| of(&move |_| Vector3::ith(axis, 1.0));
    let mut all = vec![
        Effects {
            of_angles: false,
            each: vec![of(&|m| m.tracker_from_ideal.translation.vector)],
            mistake: |by| Mistake::Scale(1.0 + by[0]),
        },
        Effects {
            of_angles: false,
            each: [0, 1, 2].map(constant).to_vec(),
            mistake: |by| {
                let shift = Vector3::from_column_slice(by).norm();
                Mistake::Frame { angle_rad: 0.0, shift }
            },
        },
    ];
    if content != MeasurementContent::PositionOnly {
        all.push(Effects {
            of_angles: false,
            each: vec![along(2)],
            mistake: |by| {
                let offset_mm = [0.0, 0.0, by[0]];
                Mistake::SensorOffset { offset_mm, standard_error_mm: None }
            },
        });
        all.push(Effects {
            of_angles: true,
            each: vec![along(0), along(1)],
            mistake: |by| Mistake::SensorTilt { angle_rad: by[0].hypot(by[1]) },
        });
    }
    all
}
