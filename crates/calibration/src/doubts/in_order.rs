//! What the order of a table's rows shows: readings that are late along a path, and a field that changes
//! while it is measured. The errors beside a smooth field are compared with the path's speed and with time.

use super::Suspicion;
use super::beside_field::{
    AXIS_TERMS, Effect, Estimate, PLACE_TERMS, ROWS_A_TERM, Rows, STANDARD_ERRORS, error,
    field_terms, place,
};
use crate::lag::LONGEST_STEP;
use crate::robust::median;
use nalgebra::Vector3;
use trackwright_field::samples::{Measurement, MeasurementContent};
use trackwright_geometry::bounds::Bounds;

/// Part of the RMS of what is left beside it from which a lag, or a change of the field, is reported.
const LEAST_PART: f64 = 0.1;

/// A table is a path where the median step is a smaller part of its extent: a lag is a time.
const PATH_STEP: f64 = 0.05;

/// Part of the time's square that place and axis have to leave: a grid that is measured line by line, or a path,
/// has its time in its places, and what the polynomials miss of the field looks like a change with time.
const LEAST_OWN_PART_OF_TIME: f64 = 0.3;

/// Readings of earlier rows, or of later ones; `stride` is how many rows of the table lie between two.
pub(super) fn lag(
    rows: &[Measurement],
    content: MeasurementContent,
    stride: usize,
) -> Option<Suspicion> {
    let (of_field, longest_edge_mm) = rows_of(rows, content)?;
    let last = rows.len() - 1;
    let step = |k: usize| (place(&rows[k + 1]) - place(&rows[k])).norm();
    let typical = median(&mut (0..last).map(step).collect::<Vec<f64>>())?;
    if typical > PATH_STEP * longest_edge_mm {
        return None;
    }
    // Where readings are missing the path's speed is not known.
    let goes_on = |k: usize| step(k) <= LONGEST_STEP * typical;
    let known: Vec<usize> = (1..last).filter(|k| goes_on(k - 1) && goes_on(*k)).collect();
    if known.len() < ROWS_A_TERM * of_field.terms[0].len() {
        return None;
    }
    // Without the row itself: its own jitter is in its error.
    let speed = |k: &usize| (place(&rows[k - 1]) - place(&rows[k + 1])) / 2.0;
    let effects = [known.iter().map(speed).collect()];
    let (found, left_mm) = of_field.of_rows(&known).estimates(&effects)?;
    let moved_mm = found[0].value.abs() * rms(&effects[0]);
    is_reported(&found[0], moved_mm, left_mm).then(|| Suspicion::Lag {
        rows: found[0].value * stride as f64,
        standard_error: found[0].standard_error * stride as f64,
        moved_mm,
        left_mm,
    })
}

/// A field that grows or shrinks, or an origin that moves, from the first row to the last.
pub(super) fn change(rows: &[Measurement], content: MeasurementContent) -> Option<Suspicion> {
    let (of_table, _) = rows_of(rows, content)?;
    let count = of_table.errors.len();
    let time = |k: usize| 2.0 * k as f64 / (count - 1) as f64 - 1.0;
    let of_field = of_table.weighted(&[])?.fitted(&[])?;
    let grown = |of_time: fn(f64) -> f64| -> Effect {
        of_field.iter().enumerate().map(|(k, e)| e * of_time(time(k))).collect()
    };
    let moved =
        |axis: usize| -> Effect { (0..count).map(|k| Vector3::ith(axis, time(k))).collect() };
    let curved: fn(f64) -> f64 = |t| 1.5 * t * t - 0.5;
    let mut effects = vec![grown(|t| t), grown(curved)];
    effects.extend((0..3).map(moved));
    let (found, left_mm) = of_table.estimates(&effects)?;
    // The field times the time is of a higher degree than the terms: the time itself decides.
    if found.last()?.own_part < LEAST_OWN_PART_OF_TIME {
        return None;
    }
    let size_mm = |k: usize| found[k].value.abs() * rms(&effects[k]);
    let largest = (0..found.len()).max_by(|a, b| size_mm(*a).total_cmp(&size_mm(*b)))?;
    is_reported(&found[largest], size_mm(largest), left_mm).then(|| Suspicion::Drift {
        of_field: largest < 2,
        changed_mm: size_mm(largest),
        left_mm,
    })
}

/// The rows and the length of the longest edge of their box.
fn rows_of(rows: &[Measurement], content: MeasurementContent) -> Option<(Rows, f64)> {
    let terms = field_terms(rows, content, PLACE_TERMS, true)?;
    let axis_terms = if content == MeasurementContent::PositionOnly { 1 } else { AXIS_TERMS };
    // With fewer terms a lag or a change would be what they miss.
    if terms[0].len() < PLACE_TERMS * axis_terms {
        return None;
    }
    let bounds = Bounds::around(rows.iter().map(|m| place(m).into()))?;
    Some((Rows::new(rows.iter().map(error).collect(), terms), bounds.size_mm().max()))
}

fn is_reported(found: &Estimate, size_mm: f64, left_mm: f64) -> bool {
    found.value.abs() > STANDARD_ERRORS * found.standard_error && size_mm > LEAST_PART * left_mm
}

fn rms(vectors: &[Vector3<f64>]) -> f64 {
    (vectors.iter().map(Vector3::norm_squared).sum::<f64>() / vectors.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use trackwright_geometry::pose::{Pose, pose_from_parts};

    const ROWS: usize = 1_500;

    /// Where a hand is at a row: some sines.
    fn hand(row: f64) -> Pose {
        let t = row / ROWS as f64;
        let wave = |a: f64, b: f64| (a * t).sin() + 0.4 * (b * t + a).cos();
        let position = Vector3::new(wave(13.0, 51.0), wave(17.0, 37.0), wave(22.0, 43.0)) * 90.0;
        let turn = Vector3::new(wave(11.0, 29.0), wave(19.0, 31.0), 0.3);
        pose_from_parts(position, UnitQuaternion::from_scaled_axis(turn))
    }

    /// A smooth field of 2 mm that no polynomial of the second degree has, and noise of 0.1 mm.
    fn readings(
        ideal: impl Fn(usize) -> Pose,
        read_at: impl Fn(usize) -> Pose,
        gain: impl Fn(f64) -> f64,
    ) -> Vec<Suspicion> {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let row = |k: usize| {
            let at = read_at(k);
            let (p, n) = (at.translation.vector / 150.0, at.rotation * Vector3::z());
            let field = Vector3::new(p.x.sin() * p.z, n.z * n.x + p.y, (1.0 + p.x * p.y).ln_1p());
            let noise = Vector3::from_fn(|_, _| 0.1 * normal());
            let moved = field * (2.0 * gain(k as f64 / ROWS as f64)) + noise;
            Measurement {
                tracker_from_ideal: ideal(k),
                tracker_from_measured: pose_from_parts(at.translation.vector + moved, at.rotation),
            }
        };
        let rows: Vec<Measurement> = (0..ROWS).map(row).collect();
        let content = MeasurementContent::FiveDof;
        lag(&rows, content, 1).into_iter().chain(change(&rows, content)).collect()
    }

    #[test]
    fn a_lag_is_found_with_its_sign_and_size() {
        for lag in [0.7, 2.0, -1.3] {
            let ideal = |k: usize| hand(k as f64);
            let found = readings(ideal, |k| hand(k as f64 - lag), |_| 1.0);
            let Some(Suspicion::Lag { rows, standard_error, .. }) = found.first() else {
                panic!("{lag}: {found:?}");
            };
            // Within four standard errors, beside what a lag of some rows is not linear in.
            assert!((rows - lag).abs() < 4.0 * standard_error + 0.02, "{lag}: {found:?}");
        }
    }

    #[test]
    fn a_lag_is_found_beside_another_solution() {
        // Some 80 mm off, as where the tracker's equations have two solutions.
        let gain = |t: f64| if (0.2..0.23).contains(&t) { 40.0 } else { 1.0 };
        let found = readings(|k| hand(k as f64), |k| hand(k as f64 - 1.0), gain);
        let [Suspicion::Lag { rows, standard_error, left_mm, .. }] = found[..] else {
            panic!("{found:?}");
        };
        assert!((rows - 1.0).abs() < 4.0 * standard_error && left_mm < 1.0, "{found:?}");
    }

    #[test]
    fn a_table_that_agrees_in_time_has_no_suspicion() {
        let ideal = |k: usize| hand(k as f64);
        assert_eq!(readings(ideal, ideal, |_| 1.0), []);
        // Rows in no order: from one to the next is nothing that a lag could be of.
        let mixed = |k: usize| hand(((k * 739) % ROWS) as f64);
        assert_eq!(readings(mixed, mixed, |_| 1.0), []);
    }

    #[test]
    fn a_field_that_changes_is_reported() {
        let mixed = |k: usize| hand(((k * 739) % ROWS) as f64);
        let found = readings(mixed, mixed, |t| 0.8 + 0.4 * t);
        let [Suspicion::Drift { of_field: true, changed_mm, .. }] = found[..] else {
            panic!("{found:?}");
        };
        // A fifth of 2 mm times the field, over the root of three.
        assert!((0.1..0.4).contains(&changed_mm), "{changed_mm}");
    }
}
