//! The slice's resolution: a coarse slice, filled in between its points, against a fine one.

use super::{Bench, Stop};
use nalgebra::{Unit, Vector3};
use trackwright_simulation::{Quantity, SliceOutcome, SlicePlan, SlicePlane, sample_slice};
use trackwright_task::Cancelled;

/// The axis that the slice lies across.
const NORMAL_AXIS: usize = 2;

/// Cells along the longer side of a slice by default: the editor's.
const CELLS: usize = 80;

/// Coarser and finer than the program's own, in cells along a side.
const FACTORS: [(usize, usize); 7] = [(1, 8), (1, 4), (1, 2), (3, 4), (1, 1), (2, 1), (4, 1)];

/// Slices of more and fewer points.
pub fn measure(bench: &mut Bench) -> Result<(), Stop> {
    let (model, scenario, settings) = (bench.room(), bench.scenario, bench.settings);
    bench.family.charted = "a slice through the middle of the room".to_owned();
    bench.family.about = format!(
        "Position error on a slice across z through the middle of the room's box, on all \
         threads; size is the number of its points. The error is the largest difference \
         between the slice filled in bilinearly and one of {0} x {0} points.",
        settings.slice_reference
    );
    bench.need_field("a slice shows nothing")?;
    let cancel = &bench.task.cancel;
    let sample = |points: usize| {
        let plan = SlicePlan {
            plane: SlicePlane::Across {
                normal_axis: NORMAL_AXIS,
                position_mm: model.bounds().center_mm()[NORMAL_AXIS],
                bounds: *model.bounds(),
            },
            sensor_axis: Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8)),
            counts: [points; 2],
        };
        // A slice of the position error, which every room has, fails in no other way.
        let slice = sample_slice(scenario, Quantity::PositionErrorMm, &plan, cancel);
        slice.ok().flatten().ok_or(Cancelled)
    };
    let reference = sample(settings.slice_reference)?;
    bench.steps = FACTORS.len() + 1;
    bench.next()?;
    for (up, down) in FACTORS {
        let points = CELLS * up / down + 1;
        let (seconds, slice) = settings.timing.measure(|| sample(points));
        let error = largest_difference_mm(&slice?, &reference);
        let row = bench.row(&format!("{points} x {points} points"));
        let row = row.measured(points * points, seconds, error).default_if(up == down);
        bench.add(row.step_of("slice, filled in between its points"))?;
    }
    Ok(())
}

/// Largest difference of a slice, bilinear between its points, from a finer one of the same place.
fn largest_difference_mm(slice: &SliceOutcome, fine: &SliceOutcome) -> f64 {
    let ([nu, nv], [fu, fv]) = (slice.plan.counts, fine.plan.counts);
    let mut largest: f64 = 0.0;
    for v in 0..fv {
        for u in 0..fu {
            let x = u as f64 / (fu - 1) as f64 * (nu - 1) as f64;
            let y = v as f64 / (fv - 1) as f64 * (nv - 1) as f64;
            let (i, j) = ((x as usize).min(nu - 2), (y as usize).min(nv - 2));
            let (a, b) = (x - i as f64, y - j as f64);
            let at = |i: usize, j: usize| slice.values[j * nu + i];
            let between = (1.0 - b) * ((1.0 - a) * at(i, j) + a * at(i + 1, j))
                + b * ((1.0 - a) * at(i, j + 1) + a * at(i + 1, j + 1));
            largest = largest.max((between - fine.values[v * fu + u]).abs());
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use crate::precision::{Settings, What, testing};
    use trackwright_field::DistortionModel;

    fn errors(model: DistortionModel) -> Vec<(usize, f64)> {
        let family = testing::family(What::Heatmap, &testing::scenario(model), Settings::quick());
        family.rows.iter().map(|r| (r.size, r.error)).collect()
    }

    /// A field of one orientation whose only component has these coefficients.
    fn along_x(order: usize, coefficients: impl Iterator<Item = f64>) -> DistortionModel {
        DistortionModel::of_position(
            order,
            testing::bounds(),
            coefficients.map(|x| [x, 0.0, 0.0, 0.0, 0.0, 0.0]).collect(),
        )
        .unwrap()
    }

    #[test]
    fn a_linear_slice_needs_no_points() {
        // |e| of one component that is nowhere negative is that component: linear.
        let model = along_x(1, (0..8).map(|i| f64::from(i / 4)));
        assert!(errors(model).iter().all(|&(_, e)| e < 1e-14));
    }

    #[test]
    fn error_falls_with_the_squared_spacing() {
        // An offset keeps the norm away from its kink at zero.
        let model = along_x(3, (0..64).map(|i| 20.0 + (1.3 * f64::from(i)).sin()));
        let errors = errors(model);
        let of = |points: usize| errors.iter().find(|e| e.0 == points * points).unwrap().1;
        for (coarse, fine) in [(11, 21), (21, 41), (41, 81)] {
            let ratio = of(coarse) / of(fine);
            assert!((3.2..4.8).contains(&ratio), "{coarse}: {ratio}");
        }
    }
}
