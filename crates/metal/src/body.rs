//! A metal body at a frequency: which model answers for it, and whether that is an estimate.

use crate::boundary::{BoundaryBody, BoundaryError, BoundaryShape, SurfaceLimit};
use crate::currents::{CurrentBody, CurrentShape};
use crate::material::{Material, MaterialError, check_frequency};
use crate::sphere::{SphereError, SphereResponse, sphere_factor};
use std::sync::Arc;
use trackwright_task::Task;

/// Up to this part by which finite skin depth weakens the response, a body counts as one that no flux
/// enters rather than as an estimate. It is what a sphere of 75 skin depths lacks.
pub const NEGLIGIBLE_SKIN: f64 = 0.02;

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
    /// No flux enters the surface: exact as the skin depth goes to 0.
    NoFlux { skin_depth_mm: f64 },
    /// The currents in a conductor of one piece that is not hollow and hardly magnetic.
    Currents { skin_depth_mm: f64 },
    /// No currents flow: exact for a magnetic material that does not conduct.
    Permeable { relative_permeability: f64 },
    /// An estimate: the skin depth is not small. The response of the surface in one of its limits times
    /// what the sphere of the surface's mean radius has at this frequency relative to that limit. Of a sphere whose
    /// skin is 7 % of the radius that is 4 % off one radius away and 10 % near the surface, at 22 % it
    /// is 17 and 41 %; of other shapes it may be more.
    ScaledBySphere { limit: SurfaceLimit, factor: f64, mean_radius_mm: f64, skin_depth_mm: f64 },
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

/// A conductor up to this permeability counts as not magnetic: stainless steels have 1.008. Magnetisation adds
/// `(μ − 1)/3` of a sphere's field to that of the currents.
pub const HARDLY_MAGNETIC: f64 = 1.05;

/// A body is flat or long where one extent or two are below this part of the next one. The loops of currents about
/// the axes of others would answer a field that varies over them more than once.
pub const SLENDER: f64 = 0.3;

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
    Surface { body: Arc<BoundaryBody>, factor: f64 },
    Currents(Arc<CurrentBody>),
}

impl ResponseModel {
    /// Whether the response is estimated rather than solved for.
    pub fn is_estimate(&self) -> bool {
        matches!(self, Self::ScaledBySphere { .. })
    }
}

impl MetalBody {
    /// Chooses the model and factors what has to be factored: nothing for a sphere.
    ///
    /// A surface in between, whose skin depth is neither far below nor far above its thickness, is
    /// estimated: its response in the limit of the sign that the sphere of its mean radius
    /// ([`mean_radius_mm`](crate::surface::ClosedSurface::mean_radius_mm)) has at this frequency, times that sphere's response in phase relative to its own limit.
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
        Self::with_factors_of(shape, material, frequency_hz, None, task)
    }

    /// The same body at another frequency; what was factored is used again where the limit is the same.
    ///
    /// # Errors
    /// As [`MetalBody::new`].
    pub fn at_frequency(&self, frequency_hz: f64, task: &Task) -> Result<Self, BodyError> {
        self.of(self.material, frequency_hz, task)
    }

    /// The same body of another material; what was computed of its shape is used again.
    ///
    /// # Errors
    /// As [`MetalBody::new`].
    pub fn of(
        &self,
        material: Material,
        frequency_hz: f64,
        task: &Task,
    ) -> Result<Self, BodyError> {
        let before = Some(&self.solver);
        Self::with_factors_of(self.shape.clone(), material, frequency_hz, before, task)
    }

    fn with_factors_of(
        shape: MetalShape,
        material: Material,
        frequency_hz: f64,
        before: Option<&Solver>,
        task: &Task,
    ) -> Result<Self, BodyError> {
        check_frequency(frequency_hz)?;
        if frequency_hz == 0.0 && material.is_conductor() {
            let conductivity_s_per_m = material.conductivity_s_per_m();
            return Err(BodyError::ConductorAtRest { conductivity_s_per_m });
        }
        let mu = material.relative_permeability();
        let shape_of_body = shape.clone();
        let (model, solver) = match &shape {
            MetalShape::Sphere { radius_mm } => {
                let response = SphereResponse::new(*radius_mm, &material, frequency_hz)?;
                (ResponseModel::SphereSeries, Solver::Sphere(response))
            }
            MetalShape::Surface(_) if mu == 1.0 && !material.is_conductor() => {
                (ResponseModel::None, Solver::None)
            }
            MetalShape::Surface(shape) => {
                let mean_radius_mm = shape.surface().mean_radius_mm();
                let skin_depth_mm = material.skin_depth_mm(frequency_hz);
                let in_phase = match sphere_factor(mean_radius_mm, &material, frequency_hz) {
                    Ok(factor) => factor.re,
                    Err(SphereError::ThinSkin { .. }) => -0.5,
                    Err(error) => return Err(error.into()),
                };
                let has_currents = mu <= HARDLY_MAGNETIC && material.is_conductor();
                if has_currents && let Some(of_shape) = current_shape(shape, before, task)? {
                    let body = CurrentBody::new(of_shape, skin_depth_mm, task)
                        .map_err(BoundaryError::from)?;
                    let solver = Solver::Currents(Arc::new(body));
                    let model = ResponseModel::Currents { skin_depth_mm };
                    return Ok(Self {
                        shape: shape_of_body,
                        material,
                        frequency_hz,
                        model,
                        solver,
                    });
                }
                let (limit, whole) = match in_phase < 0.0 || mu == 1.0 {
                    true => (SurfaceLimit::NoFlux, -0.5),
                    false => (SurfaceLimit::Permeable(mu), (mu - 1.0) / (mu + 2.0)),
                };
                let factor = in_phase / whole;
                let model = match limit {
                    SurfaceLimit::NoFlux if (1.0 - factor).abs() <= NEGLIGIBLE_SKIN => {
                        ResponseModel::NoFlux { skin_depth_mm }
                    }
                    SurfaceLimit::Permeable(relative_permeability) if !material.is_conductor() => {
                        ResponseModel::Permeable { relative_permeability }
                    }
                    limit => ResponseModel::ScaledBySphere {
                        limit,
                        factor,
                        mean_radius_mm,
                        skin_depth_mm,
                    },
                };
                let factored = match before {
                    Some(Solver::Surface { body, .. }) => Some(body),
                    _ => None,
                };
                let kept = factored
                    .filter(|body| body.limit() == limit && Arc::ptr_eq(body.shape(), shape));
                let body = match kept {
                    Some(body) => Arc::clone(body),
                    None => Arc::new(BoundaryBody::new(Arc::clone(shape), limit, task)?),
                };
                (model, Solver::Surface { body, factor })
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

    pub(crate) fn solver(&self) -> &Solver {
        &self.solver
    }
}

/// Loops of currents of a surface: those of before, where they are of the same surface.
fn current_shape(
    shape: &Arc<BoundaryShape>,
    before: Option<&Solver>,
    task: &Task,
) -> Result<Option<Arc<CurrentShape>>, BodyError> {
    if let Some(Solver::Currents(body)) = before {
        return Ok(Some(Arc::clone(body.shape())));
    }
    let Some([least, middle, most]) = crate::currents::extents_mm(shape.surface()) else {
        return Ok(None);
    };
    if least > SLENDER * middle && middle > SLENDER * most {
        return Ok(None);
    }
    let made = CurrentShape::new(shape.surface(), task).map_err(BoundaryError::from)?;
    Ok(made.map(Arc::new))
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
    fn models_follow_the_skin_depth() {
        let plate = shape(&cuboid(&Vector3::new(200.0, 200.0, 10.0), 100).unwrap());
        let model = |key: &str, frequency_hz: f64| {
            *MetalBody::new(plate.clone(), named(key), frequency_hz, &Task::default())
                .unwrap()
                .model()
        };
        assert!(matches!(model("copper", 1e5), ResponseModel::Currents { .. }));
        let steel = model("steel-304", 1e4);
        assert!(matches!(steel, ResponseModel::Currents { .. }) && !steel.is_estimate());
        assert!(model("steel-416", 1e4).is_estimate());
    }

    #[test]
    fn a_compact_body_is_estimated_by_a_sphere() {
        let block = shape(&cuboid(&Vector3::new(80.0, 80.0, 40.0), 100).unwrap());
        let body = |key: &str, frequency_hz: f64| {
            MetalBody::new(block.clone(), named(key), frequency_hz, &Task::default()).unwrap()
        };
        let model = |key: &str, frequency_hz: f64| *body(key, frequency_hz).model();
        assert!(matches!(model("copper", 1e5), ResponseModel::NoFlux { .. }));
        assert!(matches!(model("ferrite", 0.1), ResponseModel::ScaledBySphere { .. }));
        let ResponseModel::ScaledBySphere { limit, factor, mean_radius_mm, skin_depth_mm } =
            model("steel-304", 1e4)
        else {
            panic!("an estimate")
        };
        assert_eq!(limit, SurfaceLimit::NoFlux);
        // 256 cm³ over a diagonal of 120 mm.
        assert!((mean_radius_mm - 31.92).abs() < 0.01 && (skin_depth_mm - 4.25).abs() < 0.01);
        let of_sphere = sphere_factor(mean_radius_mm, &named("steel-304"), 1e4).unwrap();
        assert_eq!(factor, of_sphere.re / -0.5);
        let slow = model("steel-416", 1.0);
        let ResponseModel::ScaledBySphere { limit: SurfaceLimit::Permeable(mu), factor, .. } = slow
        else {
            panic!("{slow:?}")
        };
        assert_eq!(mu, 700.0);
        assert!(0.9 < factor && factor < 1.0);
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

    #[test]
    fn factors_are_kept_between_frequencies() {
        let ball = shape(&sphere(10.0, 1).unwrap());
        let body = MetalBody::new(ball, named("copper"), 1e3, &Task::default()).unwrap();
        let other = body.at_frequency(1e4, &Task::default()).unwrap();
        let factored = |body: &MetalBody| match &body.solver {
            Solver::Surface { body, .. } => Arc::clone(body),
            Solver::None | Solver::Sphere(_) | Solver::Currents(_) => panic!("a surface"),
        };
        assert!(Arc::ptr_eq(&factored(&body), &factored(&other)));
        assert!(body.model() != other.model());
    }
}
