//! The field's error vectors as arrows: how much larger than life, and what an arrow looks like.

use nalgebra::{Point3, Unit, Vector3};
use trackwright_design::view::View;
use trackwright_geometry::number::round_below;
use trackwright_geometry::rotation::perpendicular;
use trackwright_simulation::{ArrowOutcome, ArrowPlan, ArrowSensor};

/// Of an arrow's length: the head's, and half the width of head and shaft, each within bounds in
/// millimetres, so that long arrows stay slim and short ones are seen.
const HEAD_SHARE: f64 = 0.35;
const HEAD_WIDTH_SHARE: f64 = 0.14;
const HEAD_WIDTH_MM: [f64; 2] = [0.8, 4.0];
const SHAFT_TO_HEAD: f64 = 0.4;

/// In cells of the lattice; longer arrows are cut, and have the last colour.
const LONGEST: f64 = 1.5;

/// Sides of shaft and head: many arrows are many triangles.
const SIDES: usize = 4;

/// What a view's arrows are of, and where.
pub fn arrow_plan(view: &View) -> ArrowPlan {
    let axis = Vector3::from(view.slice.sensor_axis);
    ArrowPlan {
        sensor: match view.arrows.of_tool {
            true => ArrowSensor::OfTool,
            false => ArrowSensor::Along(Unit::try_new(axis, 1e-12).unwrap_or_else(Vector3::z_axis)),
        },
        counts: [view.arrows.per_side(); 3],
    }
}

/// How errors become arrows.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Larger than life: 1, 2 or 5 times a power of ten, such that all but the longest twentieth
    /// stay within a cell of the lattice.
    pub times: f64,
    /// Longer arrows are cut.
    pub longest_mm: f64,
}

impl Scale {
    /// The scale of sampled errors.
    pub fn of(found: &ArrowOutcome) -> Self {
        let spacing_mm = spacing_mm(found);
        let wanted = spacing_mm / found.p95_mm;
        Self {
            times: match wanted.is_finite() && wanted > 0.0 {
                true => round_below(wanted),
                false => 1.0,
            },
            longest_mm: LONGEST * spacing_mm,
        }
    }

    /// An error as it is drawn: magnified, and cut where it is too long.
    pub fn drawn(&self, error_mm: &Vector3<f64>) -> Vector3<f64> {
        (error_mm * self.times).cap_magnitude(self.longest_mm)
    }
}

/// Half the width of an arrow's head.
pub fn head_mm(length_mm: f64) -> f64 {
    (length_mm * HEAD_WIDTH_SHARE).clamp(HEAD_WIDTH_MM[0], HEAD_WIDTH_MM[1])
}

/// Between neighbours of the lattice, along its closest side.
fn spacing_mm(found: &ArrowOutcome) -> f64 {
    found.bounds.map_or(0.0, |bounds| {
        let sizes = bounds.size_mm();
        (0..3)
            .map(|k| sizes[k] / (found.plan.counts[k].max(2) - 1) as f64)
            .fold(f64::INFINITY, f64::min)
    })
}

/// A shaft and a head with flat sides: their triangles one by one, each with its normal.
pub fn arrow_triangles(
    from: &Point3<f64>,
    arrow: &Vector3<f64>,
    mut triangle: impl FnMut([Point3<f64>; 3], &Vector3<f64>),
) {
    let Some(along) = arrow.try_normalize(1e-9) else {
        return;
    };
    let length_mm = arrow.norm();
    let across = perpendicular(&Unit::new_unchecked(along));
    let other = along.cross(&across);
    let head_mm = head_mm(length_mm);
    let neck = from + along * (length_mm * (1.0 - HEAD_SHARE));
    let tip = from + arrow;
    for side in 0..SIDES {
        let turn = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / SIDES as f64;
            across.into_inner() * angle.cos() + other * angle.sin()
        };
        let (a, b) = (turn(side), turn(side + 1));
        let normal = (a + b).normalize();
        let shaft_mm = head_mm * SHAFT_TO_HEAD;
        let ring =
            |center: &Point3<f64>, out: &Vector3<f64>, radius_mm: f64| center + out * radius_mm;
        let [foot_a, foot_b] = [ring(from, &a, shaft_mm), ring(from, &b, shaft_mm)];
        let [neck_a, neck_b] = [ring(&neck, &a, shaft_mm), ring(&neck, &b, shaft_mm)];
        triangle([foot_a, foot_b, neck_b], &normal);
        triangle([foot_a, neck_b, neck_a], &normal);
        let slope = (normal + along * HEAD_WIDTH_SHARE / HEAD_SHARE).normalize();
        triangle([ring(&neck, &a, head_mm), ring(&neck, &b, head_mm), tip], &slope);
        // Seen from behind: the head's floor.
        triangle([ring(&neck, &b, head_mm), ring(&neck, &a, head_mm), neck], &-along);
    }
}
