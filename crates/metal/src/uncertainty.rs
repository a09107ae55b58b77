//! How far the computed errors of metal may be off: by what is not known of its material, and by the
//! solution.

use crate::body::{BodyError, MetalBody, MetalShape};
use crate::harmonics::TOLERANCE_MM;
use crate::material::Material;
use crate::setup::MaterialTolerance;
use nalgebra::Matrix3;
use trackwright_field::DistortionModel;
use trackwright_field::environment::{ComputedMetal, OtherSolution};
use trackwright_task::Task;

/// A response whose part in phase is nearly none, between that of a magnetic body and that of a conductor,
/// changes by more than itself: errors of such a body may be several times as large, and nothing more is stated.
const MOST: f64 = 1.0;

/// The errors of a room's metal beside the bare room.
pub(crate) fn computed(
    bare: &DistortionModel,
    material_std: f64,
    other: Option<OtherSolution>,
    solution_std: f64,
) -> ComputedMetal {
    let bare = bare.clone();
    ComputedMetal { bare, material_std, other, solution_std, position_std_mm: TOLERANCE_MM }
}

/// How much a body's response in phase changes with one standard deviation of its material, as a part of it:
/// by the moments in even fields along three axes.
///
/// # Errors
/// What the body of the other material is refused for.
pub(crate) fn material_std(
    shape: &MetalShape,
    material: &Material,
    tolerance: &MaterialTolerance,
    frequency_hz: f64,
    task: &Task,
) -> Result<f64, BodyError> {
    let own = moments(shape, *material, frequency_hz, task)?;
    let (sigma, mu) = (material.conductivity_s_per_m(), material.relative_permeability());
    let mut squares = 0.0;
    let less = |log_std: f64| (-log_std).exp();
    if material.is_conductor() {
        let other = Material::new(sigma * less(tolerance.conductivity_log_std()), mu)?;
        squares += (moments(shape, other, frequency_hz, task)? - own).norm_squared();
    }
    if material.is_magnetic() {
        let other =
            Material::new(sigma, 1.0 + (mu - 1.0) * less(tolerance.permeability_log_std()))?;
        squares += (moments(shape, other, frequency_hz, task)? - own).norm_squared();
    }
    // What has no response changes by none.
    Ok(if squares == 0.0 { 0.0 } else { (squares.sqrt() / own.norm()).min(MOST) })
}

fn moments(
    shape: &MetalShape,
    material: Material,
    frequency_hz: f64,
    task: &Task,
) -> Result<Matrix3<f64>, BodyError> {
    let [in_phase, _] = MetalBody::new(shape.clone(), material, frequency_hz, task)?.moments_mm3();
    Ok(in_phase)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::BoundaryShape;
    use crate::shapes::cuboid;
    use crate::surface::ClosedSurface;
    use nalgebra::Vector3;
    use std::sync::Arc;

    fn std_of(shape: &MetalShape, conductivity: f64, permeability: f64, hz: f64) -> f64 {
        let material = Material::new(conductivity, permeability).unwrap();
        material_std(shape, &material, &MaterialTolerance::default(), hz, &Task::default()).unwrap()
    }

    fn ball(radius_mm: f64) -> MetalShape {
        MetalShape::Sphere { radius_mm }
    }

    #[test]
    fn a_full_response_is_more_certain_than_a_weak_one() {
        // Far below the skin depth the part in phase is proportional to the square of the conductivity.
        let weak = std_of(&ball(1.0), 1e4, 1.0, 100.0);
        let log_std = MaterialTolerance::default().conductivity_log_std();
        assert!((weak - (1.0 - (-2.0 * log_std).exp())).abs() < 1e-3, "{weak}");
        // Far above it the field does not enter, whatever the conductivity.
        let full = std_of(&ball(100.0), 6e7, 1.0, 10e3);
        assert!(full < 0.01, "{full}");
    }

    #[test]
    fn a_large_permeability_hardly_matters() {
        let of = |permeability: f64| std_of(&ball(20.0), 0.0, permeability, 0.0);
        // (µ − 1) / (µ + 2): half of µ − 1 = 999 is 0.3 % less, half of 0.1 is nearly half of it.
        assert!(of(1000.0) < 0.005 && of(1.1) > 0.4, "{} {}", of(1000.0), of(1.1));
    }

    #[test]
    fn a_plate_changes_as_a_sheet_does() {
        // A sheet of 200 by 200 by 1 mm of steel 304, its currents solved for by themselves: d ln m / d ln σ is 0.455.
        let mesh = cuboid(&Vector3::new(200.0, 200.0, 1.0), 150).unwrap();
        let shape = BoundaryShape::new(ClosedSurface::new(&mesh).unwrap(), &Task::default());
        let found = std_of(&MetalShape::Surface(Arc::new(shape.unwrap())), 1.39e6, 1.0, 1e4);
        let log_std = MaterialTolerance::default().conductivity_log_std();
        let expected = 0.455 * log_std;
        assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
    }

    #[test]
    fn a_body_between_magnet_and_conductor_is_uncertain() {
        // The part in phase of a ball of permeability 10 changes its sign near a skin depth of 6 % of its radius.
        let at = |hz: f64| std_of(&ball(20.0), 1e6, 10.0, hz);
        let worst = (0..40).map(|k| at(1e3 * 1.15_f64.powi(k))).fold(0.0, f64::max);
        assert_eq!(worst, MOST);
    }
}
