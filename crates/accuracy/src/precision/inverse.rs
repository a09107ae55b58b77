//! The inverse: the pose behind a reading by fixed-point steps, by the program's inverse, and by
//! the paper's shortcut, against the pose that was distorted.

use super::sampling::poses;
use super::{Bench, Row, Settings, Stop};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use trackwright_field::batch::Batch;
use trackwright_field::compensation::{Method, compensate};
use trackwright_field::inverse::{InverseState, undistort};
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;
use trackwright_result::with_separators;
use trackwright_simulation::Sensor;

/// Fixed-point steps after the first, which is the shortcut.
const FIXED_POINT_STEPS: [usize; 6] = [2, 3, 4, 6, 9, 14];

/// Readings that one core takes at a time.
const CHUNK: usize = 2048;

const OUTSIDE: OutsidePolicy = OutsidePolicy::Clamp;

/// Every way to the pose behind a reading.
pub fn measure(bench: &mut Bench) -> Result<(), Stop> {
    let (model, timing) = (bench.room(), bench.settings.timing);
    bench.family.charted = "readings of poses in the design's room".to_owned();
    bench.need_field("readings are poses")?;
    if model.map() == MapKind::Correction {
        return Err(bench.stop("the design's room is a correction map: it needs no inverse"));
    }
    bench.steps = FIXED_POINT_STEPS.len() + 3;
    let readings = Readings::new(model, bench.settings);
    let (measured, task) = (&readings.measured, bench.own_task());
    bench.next()?;
    let (seconds, solved) = timing.measure(|| undistort(model, measured, OUTSIDE, &task));
    let solved = solved?;
    let is_certain: Vec<bool> = solved.iter().map(|u| u.state == InverseState::Converged).collect();
    let certain = is_certain.iter().filter(|&&c| c).count();
    bench.family.about = format!(
        "Readings of poses in the room's box, put back, on all threads. The error is the largest \
         distance from the pose that was distorted, over the {} of {} readings whose inverse \
         converged and is not ambiguous.",
        with_separators(certain),
        with_separators(is_certain.len())
    );
    if certain == 0 {
        return Err(bench.stop("no reading has an inverse that is not ambiguous"));
    }
    let push = |bench: &mut Bench, row: Row, seconds: f64, found: &[Option<Pose>]| {
        let error = readings.worst_mm(found, &is_certain);
        bench.add(row.measured(measured.len(), seconds, error))
    };
    let found: Vec<_> = solved.iter().map(|u| u.pose).collect();
    let newton = bench.row("damped Newton").default_if(true);
    push(bench, newton, seconds, &found)?;
    let (seconds, corrected) =
        timing.measure(|| compensate(model, measured, OUTSIDE, Method::Shortcut, &task));
    let found: Vec<_> = corrected?.iter().map(|c| c.pose).collect();
    let shortcut = bench.row("the paper's shortcut");
    push(bench, shortcut, seconds, &found)?;
    for count in FIXED_POINT_STEPS {
        let (seconds, found) = timing.measure(|| fixed_point(model, measured, count));
        let found: Vec<_> = found.into_iter().map(Some).collect();
        let row = bench.row(&format!("fixed point, {count} steps")).step_of("fixed point");
        push(bench, row, seconds, &found)?;
    }
    Ok(())
}

/// Poses, and what the tracker of the room reads for them.
struct Readings {
    ideal: Vec<Pose>,
    measured: Vec<Pose>,
}

impl Readings {
    fn new(model: &DistortionModel, settings: &Settings) -> Self {
        let ideal: Vec<Pose> = poses(model.bounds(), settings.poses, settings.seed)
            .into_iter()
            .map(|(position, axis)| Sensor::five_dof("", position, axis).body_from_sensor())
            .collect();
        let measured = ideal.iter().map(|p| model.distort(p, OUTSIDE).0).collect();
        Self { ideal, measured }
    }

    fn worst_mm(&self, found: &[Option<Pose>], is_certain: &[bool]) -> f64 {
        found
            .iter()
            .zip(&self.ideal)
            .zip(is_certain)
            .filter(|&(_, &is_certain)| is_certain)
            .map(|((found, ideal), _)| {
                found.map_or(f64::INFINITY, |found| {
                    (found.translation.vector - ideal.translation.vector).norm()
                })
            })
            .fold(0.0, f64::max)
    }
}

/// `p ← p_m - e_pos(p, n)`, `n ← exp(-e_ori(p, n)) n_m`, from the reading itself: it converges
/// where the field's slopes are below 1, by that factor a step. Here to be compared.
pub fn fixed_point(model: &DistortionModel, measured: &[Pose], count: usize) -> Vec<Pose> {
    measured
        .par_chunks(CHUNK)
        .map_init(Batch::default, |batch, chunk| {
            let axes_m: Vec<_> = chunk.iter().map(|p| p.rotation * Vector3::z_axis()).collect();
            let mut positions: Vec<Point3<f64>> =
                chunk.iter().map(|p| p.translation.vector.into()).collect();
            let mut axes = axes_m.clone();
            let mut out = Vec::new();
            for _ in 0..count {
                batch.evaluate(model, &positions, &axes, OUTSIDE, &mut out);
                for (i, at) in out.iter().enumerate() {
                    positions[i] = (chunk[i].translation.vector - at.error.position_mm).into();
                    axes[i] = exp_vector(&-at.error.rotation_rad) * axes_m[i];
                }
            }
            chunk
                .iter()
                .zip(&out)
                .zip(&positions)
                .map(|((measured, at), position)| {
                    let turn = exp_vector(&-at.error.rotation_rad);
                    pose_from_parts(position.coords, turn * measured.rotation)
                })
                .collect::<Vec<_>>()
        })
        .collect::<Vec<_>>()
        .concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{What, testing};
    use trackwright_geometry::directions::{DirectionSet, Weighting};

    /// 1 mm and 0.01 rad over a box of 100 mm: slopes well below 1.
    fn gentle_model() -> DistortionModel {
        testing::model(2, DirectionSet::Fourteen, Weighting::Gnomonic)
    }

    #[test]
    fn fixed_point_steps_converge_to_newton() {
        let settings = Settings { poses: 300, ..Settings::default() };
        let scenario = testing::scenario(gentle_model());
        let family = testing::family(What::Inverse, &scenario, settings);
        let of = |method: &str| family.rows.iter().find(|r| r.method == method).unwrap().error;
        assert!(of("damped Newton") < 1e-9, "{family:?}");
        let steps = FIXED_POINT_STEPS.map(|n| of(&format!("fixed point, {n} steps")));
        // Until round-off of positions of some hundred millimetres, 6e-14 mm, is reached.
        assert!(steps.windows(2).all(|w| w[1] < (0.5 * w[0]).max(1e-12)), "{steps:?}");
        assert!(steps[5] < 1e-9, "{steps:?}");
        // One step is the shortcut; the second gains what the slopes leave of it.
        assert!(of("the paper's shortcut") > 2.0 * steps[0], "{family:?}");
    }

    #[test]
    fn the_first_fixed_point_step_is_the_shortcut() {
        let model = gentle_model();
        let settings = Settings { poses: 50, ..Settings::default() };
        let readings = Readings::new(&model, &settings);
        let stepped = fixed_point(&model, &readings.measured, 1);
        for (stepped, measured) in stepped.iter().zip(&readings.measured) {
            let (shortcut, _) = model.correct(measured, OUTSIDE);
            assert!((stepped.translation.vector - shortcut.translation.vector).norm() < 1e-12);
        }
    }
}
