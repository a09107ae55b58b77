//! What the layers of a scene show, computed.

use super::field_arrows::arrow_plan;
use super::{SceneError, Stage};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_design::BodyRole;
use trackwright_design::view::SliceView;
use trackwright_field::Environment;
use trackwright_simulation::uncertainty::{TipUncertainty, first_order};
use trackwright_simulation::{
    ArrowOutcome, PlacedBody, PlacementOutcome, PlacementPlan, PoseDetail, RegionBasis, Scenario,
    SliceOutcome, SlicePlan, SupportedRegion, UsableRegion, place, sample_arrows, sample_slice,
    simulate_pose, slice_support, supported_region, usable_region,
};
use trackwright_task::Task;

/// Points along each side of the lattice that a region is found on, as the editor's fine picture.
const REGION_POINTS: usize = 33;

/// Points of the slice along the longer side of the model's box.
pub const SLICE_POINTS: usize = 81;

/// Results for a scene; what no layer shows is not computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampled {
    /// The design's own pose.
    pub pose: PoseDetail,
    pub slice: Option<SliceOutcome>,
    pub arrows: Option<ArrowOutcome>,
    pub placement: Option<PaintedBody>,
    pub region: Option<UsableRegion>,
    pub support: Option<SupportedRegion>,
    pub scatter: Option<TipUncertainty>,
    /// Layers that are on and have nothing to show, and why.
    pub missing: Vec<String>,
}

/// A body painted by the error with a sensor at each vertex of its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintedBody {
    pub body: BodyRole,
    pub sensor: usize,
    pub outcome: PlacementOutcome,
}

impl Stage<'_> {
    /// Computes what the layers show. A layer that cannot be computed is reported, not an error.
    ///
    /// # Errors
    /// [`SceneError::Cancelled`].
    pub fn sample(&self, task: &Task) -> Result<Sampled, SceneError> {
        let (view, environment) = (&self.view, &self.world.environment);
        let layers = view.layers;
        let scenario = trackwright_project::resolve(self.design(), environment);
        let mut missing = Vec::new();
        // The one error that is not about the layer: somebody stopped the work.
        let mut why = |layer: &str, error: &dyn std::fmt::Display| {
            missing.push(format!("{layer}: {error}"));
        };
        let pose = simulate_pose(&scenario);
        task.step(1, 10)?;
        let slice = layers
            .slice
            .then(|| self.slice(&scenario, task))
            .and_then(|slice| slice.map_err(|error| why("slice", &error)).ok())
            .flatten();
        task.step(2, 10)?;
        let arrows = layers.arrows.then(|| {
            sample_arrows(&scenario, &arrow_plan(view), &task.cancel)
                .map_err(|error| why("arrows", &error))
                .ok()
        });
        task.step(3, 10)?;
        let scatter = (layers.tip_scatter && environment.jitter.is_some()).then(|| {
            let found = first_order(&scenario);
            found.map_err(|error| why("tip-scatter", &error)).ok()
        });
        let support = (layers.support && environment.has_validity()).then(|| {
            let axis = slice_plan(environment, &view.slice).sensor_axis;
            let part = task.subtask(0.3, 0.5);
            supported_region(environment, &axis, REGION_POINTS, &part)
                .map_err(|error| why("support", &error))
                .ok()
        });
        task.step(5, 10)?;
        let region = layers.region.then(|| {
            let part = task.subtask(0.5, 0.75);
            usable_region(&scenario, [REGION_POINTS; 3], RegionBasis::Interval, &part)
                .map_err(|error| why("region", &error))
                .ok()
        });
        task.step(3, 4)?;
        let placement = layers.placement.then(|| {
            let part = task.subtask(0.75, 1.0);
            let found = self.placement(&scenario, &part);
            found.map_err(|error| why("placement", &error)).ok()
        });
        task.step(1, 1)?;
        Ok(Sampled {
            pose,
            slice,
            arrows: arrows.flatten(),
            placement: placement.flatten(),
            region: region.flatten(),
            support: support.flatten(),
            scatter: scatter.flatten(),
            missing,
        })
    }

    fn slice(&self, scenario: &Scenario, task: &Task) -> Result<Option<SliceOutcome>, String> {
        let (view, environment) = (&self.view, &self.world.environment);
        let (plan, quantity) = (slice_plan(environment, &view.slice), view.slice.quantity);
        let found = sample_slice(scenario, quantity, &plan, &task.cancel);
        let Some(mut slice) = found.map_err(|error| error.to_string())? else {
            return Err(format!(
                "the room {:?} has no model validity, so there is no {}",
                environment.name,
                quantity.label()
            ));
        };
        if view.layers.support {
            let is_supported = slice_support(scenario, quantity, &plan, &task.cancel);
            let is_supported = is_supported.map_err(|error| error.to_string())?;
            slice.is_supported = is_supported.unwrap_or_default();
        }
        Ok(Some(slice))
    }

    fn placement(&self, scenario: &Scenario, task: &Task) -> Result<PaintedBody, String> {
        let (body, sensor) = self.wish.painted.unwrap_or((BodyRole::Tool, 0));
        let mesh = self.mesh(body).ok_or("the design has no CRF")?;
        let own = self.design().body(body).and_then(|body| body.rigid.sensors.get(sensor));
        let own_mm = own.map_or_else(Point3::origin, |own| own.position_in_body);
        let plan = PlacementPlan {
            body: match body {
                BodyRole::Tool => PlacedBody::Tool,
                BodyRole::Crf => PlacedBody::Crf,
            },
            sensor,
            rule: self.view.placement_rule,
            candidates: self.view.placement_depth.places(mesh, &own_mm).into(),
            depth: self.view.placement_depth,
            // For the best place, which is not exported.
            surface: None,
        };
        let outcome = place(scenario, &plan, task, &mut |_| ());
        Ok(PaintedBody { body, sensor, outcome: outcome.map_err(|error| error.to_string())? })
    }
}

/// The lattice of a slice: over the model's box, its cells as square as the counts allow.
pub fn slice_plan(environment: &Environment, slice: &SliceView) -> SlicePlan {
    let plane = slice.plane(environment.model.bounds());
    SlicePlan {
        plane,
        sensor_axis: Unit::try_new(Vector3::from(slice.sensor_axis), 1e-12)
            .unwrap_or_else(Vector3::z_axis),
        counts: plane.square_counts(SLICE_POINTS),
    }
}
