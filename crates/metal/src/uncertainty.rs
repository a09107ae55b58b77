//! How far the computed errors of metal may be off: by what is not known of its material, and by the
//! solution.

use crate::harmonics::TOLERANCE_MM;
use crate::material::Material;
use crate::setup::{MetalObject, ObjectShape, RoomMetal};
use crate::sphere::sphere_factor;
use trackwright_field::DistortionModel;
use trackwright_field::environment::ComputedMetal;

/// Standard deviation of the logarithm of a conductivity: alloys of aluminium have 50 to 95 % of that of
/// the pure metal, other alloys vary by some 5 %, and few people know theirs.
const CONDUCTIVITY_LOG_STD: f64 = 0.15;

/// Likewise of what is above 1 of a permeability: those of ferromagnetic steels vary by a factor of several
/// with heat treatment and field strength.
const PERMEABILITY_LOG_STD: f64 = 0.7;

/// The errors of a room's metal beside the bare room.
pub(crate) fn computed(
    metal: &RoomMetal,
    bare: &DistortionModel,
    solution_std: f64,
) -> ComputedMetal {
    let each = metal.objects.iter().map(|object| material_std(object, metal.frequency_hz));
    ComputedMetal {
        bare: bare.clone(),
        material_std: each.fold(0.0, f64::max),
        solution_std,
        position_std_mm: TOLERANCE_MM,
    }
}

/// How much an object's response changes with one standard deviation of its material, as a part of it, by a
/// sphere that currents fill as they fill the object. A sphere's response depends on `σ ω µ a²`, that of a
/// plate of thickness `t` and reach `r` on `σ ω µ t r`.
fn material_std(object: &MetalObject, frequency_hz: f64) -> f64 {
    let radius_mm = equivalent_radius_mm(&object.shape);
    let material = object.material.material();
    let (conductivity, permeability) =
        (material.conductivity_s_per_m(), material.relative_permeability());
    let change = |conductivity: f64, permeability: f64| -> f64 {
        let other = Material::new(conductivity, permeability);
        let factors = [Some(material), other.ok()]
            .map(|material| material.and_then(|m| sphere_factor(radius_mm, &m, frequency_hz).ok()));
        match factors {
            [Some(own), Some(other)] if own.norm() > 0.0 => (other - own).norm() / own.norm(),
            // What has no response changes by none.
            _ => 0.0,
        }
    };
    let less = |log_std: f64| (-log_std).exp();
    change(conductivity * less(CONDUCTIVITY_LOG_STD), permeability)
        .hypot(change(conductivity, 1.0 + (permeability - 1.0) * less(PERMEABILITY_LOG_STD)))
}

fn equivalent_radius_mm(shape: &ObjectShape) -> f64 {
    let halves: [f64; 3] = match shape {
        ObjectShape::Sphere { radius_mm } => [*radius_mm; 3],
        ObjectShape::Cuboid { size_mm } => (size_mm / 2.0).into(),
        ObjectShape::Cylinder { radius_mm, length_mm } => [*radius_mm, *radius_mm, length_mm / 2.0],
        ObjectShape::Mesh(mesh) => {
            mesh.surface.body_bounds().map_or([0.0; 3], |bounds| (bounds.size_mm() / 2.0).into())
        }
    };
    let least = halves.into_iter().fold(f64::INFINITY, f64::min);
    let most = halves.into_iter().fold(0.0, f64::max);
    (least * most).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::ObjectMaterial;
    use trackwright_geometry::pose::Pose;

    fn ball(radius_mm: f64, material: Material) -> MetalObject {
        MetalObject {
            name: "ball".into(),
            shape: ObjectShape::Sphere { radius_mm },
            material: ObjectMaterial::Own(material),
            tracker_from_object: Pose::identity(),
            most_triangles: 1000,
        }
    }

    #[test]
    fn a_full_response_is_more_certain_than_a_weak_one() {
        // Far below the skin depth the response is proportional to the conductivity.
        let weak = material_std(&ball(1.0, Material::new(1e4, 1.0).unwrap()), 100.0);
        assert!((weak - (1.0 - (-CONDUCTIVITY_LOG_STD).exp())).abs() < 1e-3, "{weak}");
        // Far above it the field does not enter, whatever the conductivity.
        let full = material_std(&ball(100.0, Material::new(6e7, 1.0).unwrap()), 10e3);
        assert!(full < 0.01, "{full}");
    }

    #[test]
    fn a_large_permeability_hardly_matters() {
        let of = |permeability: f64| {
            material_std(&ball(20.0, Material::new(0.0, permeability).unwrap()), 0.0)
        };
        // (µ − 1) / (µ + 2): half of µ − 1 = 999 is 0.3 % less, half of 1e-3 is half of it.
        assert!(of(1000.0) < 0.005 && of(1.001) > 0.4, "{} {}", of(1000.0), of(1.001));
    }
}
