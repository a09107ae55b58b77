//! Effects in all rows that move readings by as little as a field does: one side scaled, or of another point or
//! another axis of the sensor.

use super::beside_field::{
    Effect, Estimate, PLACE_TERMS, Rows, STANDARD_ERRORS, error, field_terms, place,
};
use super::mistake::Mistake;
use super::{Explained, Suspicion};
use crate::robust::median;
use nalgebra::{DVector, Vector3};
use trackwright_field::samples::{
    MapKind, Measurement, MeasurementContent, MeasurementSet, PoseError,
};

/// Part of what the sides differ by in the first degree of place that a scale has to explain, and what it moves
/// positions by, RMS: good tables have up to 1.94 mm, those beyond 1.1 mm with a third of it at most.
const SCALE_PART: f64 = 0.6;
const LEAST_SCALED_MM: f64 = 3.0;

/// Offsets and angles of a sensor from which one is reported: good tables have 0.12 mm and 0.1° at most.
const LEAST_OFFSET_MM: f64 = 0.5;
const LEAST_TILT_RAD: f64 = 0.01;

/// Part of a sensor's axes that the field's terms have to leave: within a cone they look alike.
const LEAST_OWN_PART: f64 = 0.1;

/// Positions that are so many times as far from the origin, where that is nearly all that the sides differ by in
/// the first degree of place.
pub(super) fn scale(rows: &[Measurement]) -> Option<Suspicion> {
    let terms = rows.iter().map(|m| {
        let p = place(m);
        DVector::from_column_slice(&[100.0, p.x, p.y, p.z]) / 100.0
    });
    let all = Rows::new(rows.iter().map(error).collect(), terms.collect());
    let linear = all.weighted(&[])?.fitted(&[])?;
    let squares = |by: f64| -> f64 {
        rows.iter().zip(&linear).map(|(m, of)| (of - place(m) * by).norm_squared()).sum()
    };
    let of_places: f64 = rows.iter().map(|m| place(m).norm_squared()).sum();
    let by = rows.iter().zip(&linear).map(|(m, of)| of.dot(&place(m))).sum::<f64>() / of_places;
    let part = 1.0 - squares(by) / squares(0.0);
    let moved_mm = by.abs() * (of_places / rows.len() as f64).sqrt();
    let apart = |by: f64| {
        median(&mut rows.iter().map(|m| (error(m) - place(m) * by).norm()).collect::<Vec<_>>())
    };
    let explained = Explained { before: apart(0.0)?, after: apart(by)?, is_certain: false };
    let is_it =
        part > SCALE_PART && moved_mm > LEAST_SCALED_MM && explained.after < explained.before;
    is_it.then_some(Suspicion::Mistake { mistake: Mistake::Scale(1.0 + by), part: None, explained })
}

/// Another point or another axis of the sensor on one side.
pub(super) fn of_sensor(rows: &[Measurement], content: MeasurementContent) -> Option<Suspicion> {
    if content == MeasurementContent::PositionOnly {
        return None;
    }
    let terms = field_terms(rows, content, PLACE_TERMS, false)?;
    let along = |axis: usize| -> Effect {
        rows.iter().map(|m| m.tracker_from_ideal.rotation * Vector3::ith(axis, 1.0)).collect()
    };
    let set = MeasurementSet { measurements: rows.to_vec(), content };
    let errors: Vec<PoseError> =
        set.samples(MapKind::Distortion).samples.iter().map(|sample| sample.error).collect();
    let of = |errors: Effect| Rows::new(errors, terms.clone());
    let axes = if content == MeasurementContent::SixDof { vec![0, 1, 2] } else { vec![2] };
    let effects: Vec<Effect> = axes.iter().map(|axis| along(*axis)).collect();
    let positions = of(errors.iter().map(|e| e.position_mm).collect());
    let (found, _) = positions.estimates(&effects)?;
    let offset = Vector3::from_fn(|k, _| {
        axes.iter().position(|axis| *axis == k).map_or(0.0, |at| found[at].value)
    });
    let standard_error_mm = found.iter().map(|e| e.standard_error.powi(2)).sum::<f64>().sqrt();
    let own = found.iter().map(|e| e.own_part).fold(1.0, f64::min);
    let apart = |errors: &Effect, effects: &[Effect], by: &[f64]| {
        let each = (0..rows.len()).map(|i| {
            effects.iter().zip(by).fold(errors[i], |left, (of, by)| left - of[i] * *by).norm()
        });
        median(&mut each.collect::<Vec<_>>())
    };
    let explained = |errors: &Effect, effects: &[Effect], found: &[Estimate]| {
        let by: Vec<f64> = found.iter().map(|e| e.value).collect();
        let [before, after] = [apart(errors, effects, &[])?, apart(errors, effects, &by)?];
        Some(Explained { before, after, is_certain: false })
    };
    if offset.norm() > STANDARD_ERRORS * standard_error_mm
        && offset.norm() > LEAST_OFFSET_MM
        && own > LEAST_OWN_PART
    {
        let mistake = Mistake::SensorOffset {
            offset_mm: offset.into(),
            standard_error_mm: Some(standard_error_mm),
        };
        let explained = explained(&positions.errors, &effects, &found)?;
        return Some(Suspicion::Mistake { mistake, part: None, explained });
    }
    let rotations = of(errors.iter().map(|e| e.rotation_rad).collect());
    let effects = [along(0), along(1)];
    let (found, _) = rotations.estimates(&effects)?;
    let angle_rad = found[0].value.hypot(found[1].value);
    let error_rad = found[0].standard_error.hypot(found[1].standard_error);
    if angle_rad > STANDARD_ERRORS * error_rad
        && angle_rad > LEAST_TILT_RAD
        && found.iter().all(|e| e.own_part > LEAST_OWN_PART)
    {
        let explained = explained(&rotations.errors, &effects, &found)?;
        let mistake = Mistake::SensorTilt { angle_rad };
        return Some(Suspicion::Mistake { mistake, part: None, explained });
    }
    None
}
