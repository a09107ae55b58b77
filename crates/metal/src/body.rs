//! A metal body at a frequency: what answers for it.

use crate::boundary::{BoundaryBody, BoundaryError, BoundaryShape};
use crate::material::{Material, MaterialError, check_frequency};
use crate::panel::FULL_ANGLE;
use crate::sphere::{SphereError, SphereResponse};
use nalgebra::Matrix3;
use std::sync::Arc;
use trackwright_task::Task;

/// The form of a body, about its own frame.
#[derive(Clone, Debug)]
pub enum MetalShape {
    /// About the origin, answered in closed form.
    Sphere { radius_mm: f64 },
    /// Answered by boundary elements.
    Surface(Arc<BoundaryShape>),
}

/// What a body's response was computed from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResponseModel {
    /// Neither magnetic nor conducting: no response.
    None,
    /// A sphere's own series at this frequency: exact for a sphere by itself.
    SphereSeries,
    /// No currents flow: exact for a magnetic material that does not conduct.
    Permeable { relative_permeability: f64 },
    /// Currents flow in it.
    Conductor { skin_depth_mm: f64 },
}

/// Why a body has no response.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyError {
    #[error(
        "frequency is 0 Hz and the conductivity {conductivity_s_per_m} S/m: a conductor needs a frequency above 0"
    )]
    ConductorAtRest { conductivity_s_per_m: f64 },
    #[error(transparent)]
    Material(#[from] MaterialError),
    #[error(transparent)]
    Sphere(#[from] SphereError),
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
}

/// A body of a material at a frequency, its equations factored.
#[derive(Clone, Debug)]
pub struct MetalBody {
    shape: MetalShape,
    material: Material,
    frequency_hz: f64,
    model: ResponseModel,
    solver: Solver,
}

/// What computes a body's response.
#[derive(Clone, Debug)]
pub(crate) enum Solver {
    None,
    Sphere(SphereResponse),
    Surface(Arc<BoundaryBody>),
}

impl MetalBody {
    /// Chooses the model and solves what has to be solved: nothing for a sphere.
    ///
    /// # Errors
    /// A conductor at frequency 0, what spheres, materials and boundary elements refuse, and
    /// [`BoundaryError::Cancelled`].
    pub fn new(
        shape: MetalShape,
        material: Material,
        frequency_hz: f64,
        task: &Task,
    ) -> Result<Self, BodyError> {
        check_frequency(frequency_hz)?;
        if frequency_hz == 0.0 && material.is_conductor() {
            let conductivity_s_per_m = material.conductivity_s_per_m();
            return Err(BodyError::ConductorAtRest { conductivity_s_per_m });
        }
        let relative_permeability = material.relative_permeability();
        let (model, solver) = match &shape {
            MetalShape::Sphere { radius_mm } => {
                let response = SphereResponse::new(*radius_mm, &material, frequency_hz)?;
                (ResponseModel::SphereSeries, Solver::Sphere(response))
            }
            MetalShape::Surface(_) if relative_permeability == 1.0 && !material.is_conductor() => {
                (ResponseModel::None, Solver::None)
            }
            MetalShape::Surface(shape) => {
                let skin_depth_mm = material.skin_depth_mm(frequency_hz);
                let model = match material.is_conductor() {
                    true => ResponseModel::Conductor { skin_depth_mm },
                    false => ResponseModel::Permeable { relative_permeability },
                };
                let shape = Arc::clone(shape);
                let body = BoundaryBody::new(shape, skin_depth_mm, relative_permeability, task)?;
                (model, Solver::Surface(Arc::new(body)))
            }
        };
        Ok(Self { shape, material, frequency_hz, model, solver })
    }

    pub fn shape(&self) -> &MetalShape {
        &self.shape
    }

    pub fn material(&self) -> &Material {
        &self.material
    }

    pub fn frequency_hz(&self) -> f64 {
        self.frequency_hz
    }

    pub fn model(&self) -> &ResponseModel {
        &self.model
    }

    /// The moments that even fields of unit strength along x, y and z bring about, a column each, in the body's
    /// frame; in phase, and what lags where fields go as `e^(iωt)`.
    pub fn moments_mm3(&self) -> [Matrix3<f64>; 2] {
        match &self.solver {
            Solver::None => [Matrix3::zeros(); 2],
            Solver::Sphere(sphere) => {
                let ratio = sphere.complex_ratio(1);
                let by = -FULL_ANGLE * sphere.radius_mm().powi(3);
                [ratio.re, ratio.im].map(|part| Matrix3::from_diagonal_element(part * by))
            }
            Solver::Surface(body) => body.moments_mm3(),
        }
    }

    pub(crate) fn solver(&self) -> &Solver {
        &self.solver
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{cuboid, sphere};
    use crate::surface::ClosedSurface;
    use nalgebra::Vector3;
    use trackwright_geometry::mesh::SurfaceMesh;

    fn shape(mesh: &SurfaceMesh) -> MetalShape {
        let surface = ClosedSurface::new(mesh).unwrap();
        MetalShape::Surface(Arc::new(BoundaryShape::new(surface, &Task::default()).unwrap()))
    }

    fn named(key: &str) -> Material {
        Material::named(key).unwrap()
    }

    #[test]
    fn models_follow_the_material() {
        let plate = shape(&cuboid(&Vector3::new(200.0, 200.0, 10.0), 60).unwrap());
        let model = |key: &str| {
            *MetalBody::new(plate.clone(), named(key), 1e4, &Task::default()).unwrap().model()
        };
        for (key, depth_mm) in [("copper", 0.661), ("steel-304", 4.27), ("steel-416", 0.144)] {
            let ResponseModel::Conductor { skin_depth_mm } = model(key) else {
                panic!("{key}: a conductor")
            };
            assert!((skin_depth_mm / depth_mm - 1.0).abs() < 0.01, "{key} {skin_depth_mm}");
        }
    }

    #[test]
    fn no_currents_are_no_estimate() {
        let ball = shape(&sphere(10.0, 1).unwrap());
        let model = |conductivity: f64, mu: f64| {
            let material = Material::new(conductivity, mu).unwrap();
            *MetalBody::new(ball.clone(), material, 0.0, &Task::default()).unwrap().model()
        };
        let relative_permeability = 30.0;
        assert_eq!(model(0.0, 30.0), ResponseModel::Permeable { relative_permeability });
        assert_eq!(model(0.0, 1.0), ResponseModel::None);
    }

    #[test]
    fn a_conductor_at_rest_is_refused() {
        let task = Task::default();
        for shape in [shape(&sphere(10.0, 0).unwrap()), MetalShape::Sphere { radius_mm: 10.0 }] {
            let error = MetalBody::new(shape.clone(), named("copper"), 0.0, &task).unwrap_err();
            assert_eq!(
                error.to_string(),
                "frequency is 0 Hz and the conductivity 58000000 S/m: a conductor needs a frequency above 0"
            );
            assert!(MetalBody::new(shape.clone(), named("copper"), f64::NAN, &task).is_err());
            assert!(MetalBody::new(shape, named("copper"), -1.0, &task).is_err());
        }
    }
}
