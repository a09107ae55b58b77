//! The best of the places, with what the study comes to there and not an estimate of it.

use super::depth::CoilDepth;
use super::outcome::{
    Basis, Candidates, ExpectedTip, PlacedBody, Placement, PlacementOutcome, PlacementPlan,
};
use crate::body::Sensor;
use crate::coil_fit::{coil_fits, is_embedded, is_within};
use crate::expected::{ExpectedError, expected};
use crate::metric::Metric;
use crate::run::{StudyError, run};
use crate::scenario::{Mode, Scenario};
use crate::work::Work;
use rayon::prelude::*;
use std::sync::OnceLock;
use trackwright_task::{Cancelled, Task};

/// How often the place that seems the best is studied. Each time it may turn out to be worse than the
/// next one's estimate.
const ROUNDS: usize = 8;

/// The place of least tip error that was found among those where the coil fits.
#[derive(Clone, Debug, PartialEq)]
pub struct BestPlace {
    /// Among the candidates.
    pub candidate: usize,
    /// The sensor as it is there.
    pub sensor: Sensor,
    /// What the study of the design comes to with it there.
    pub placement: Placement,
}

/// The scenario with a sensor like this in the place of the plan's own.
pub(super) fn with_sensor(scenario: &Scenario, plan: &PlacementPlan, own: &Sensor) -> Scenario {
    let mut moved = scenario.clone();
    let body = match (plan.body, &mut moved.crf) {
        (PlacedBody::Crf, Some(crf)) => &mut crf.body,
        _ => &mut moved.tool,
    };
    if let Some(sensor) = body.sensors.get_mut(plan.sensor) {
        let name = std::mem::take(&mut sensor.name);
        *sensor = Sensor { name, ..own.clone() };
    }
    moved
}

/// The trials that the design is judged by.
pub(super) fn whole_mode(scenario: &Scenario) -> Mode {
    match scenario.motion {
        Some(_) => Mode::Motion,
        None => Mode::Single,
    }
}

/// Where a coil fits: in its body and beside the body's other coils. Each place is checked once, when it
/// is the best of those that are left.
struct CoilPlaces<'a> {
    plan: &'a PlacementPlan,
    candidates: &'a Candidates,
    others: Vec<&'a Sensor>,
    /// Of a coil in the body whose places are as deep as it is: it is not laid on the surface.
    stays_inside: bool,
    fits: Vec<OnceLock<bool>>,
}

impl<'a> CoilPlaces<'a> {
    fn new(scenario: &'a Scenario, plan: &'a PlacementPlan, candidates: &'a Candidates) -> Self {
        let body = match (plan.body, &scenario.crf) {
            (PlacedBody::Crf, Some(crf)) => &crf.body,
            _ => &scenario.tool,
        };
        let others = body.sensors.iter().enumerate();
        let own = body.sensors.get(plan.sensor).filter(|_| plan.depth == CoilDepth::Own);
        let surface = plan.surface.as_deref();
        let stays_inside = own.zip(surface).is_some_and(|(own, surface)| is_embedded(own, surface));
        Self {
            plan,
            candidates,
            others: others.filter(|(i, _)| *i != plan.sensor).map(|(_, other)| other).collect(),
            stays_inside,
            fits: vec![OnceLock::new(); candidates.sensors.len()],
        }
    }

    fn fits(&self, candidate: usize) -> bool {
        let place = self.candidates.place_of[candidate];
        *self.fits[place].get_or_init(|| {
            let (sensor, surface) = (&self.candidates.sensors[place], self.plan.surface.as_deref());
            // What is within does not stick out.
            let (surface, whole) = match self.stays_inside {
                true => (None, surface),
                false => (surface, None),
            };
            // Other coils are the cheaper check.
            coil_fits(sensor, self.others.iter().copied(), surface)
                && whole.is_none_or(|whole| is_within(sensor, whole))
        })
    }

    /// The candidate of least error, of those at which the coil fits; `None` where it fits at none.
    fn least(&self, outcome: &PlacementOutcome, task: &Task) -> Result<Option<usize>, Cancelled> {
        let all = outcome.places.iter().enumerate().filter(|(_, place)| !place.is_outside);
        let mut values: Vec<(usize, f64)> =
            all.filter_map(|(i, place)| Some((i, place.shown_mm()?))).collect();
        values.sort_by(|a, b| a.1.total_cmp(&b.1));
        let is_cancelled = || task.cancel.is_cancelled();
        let found = values.par_iter().find_first(|(i, _)| is_cancelled() || self.fits(*i));
        match is_cancelled() {
            true => Err(Cancelled),
            false => Ok(found.map(|(candidate, _)| *candidate)),
        }
    }
}

/// Studies the candidates that seem the best, until the one that does is one that was studied. What
/// they and those at the same place come to is then that study. Those at which the coil does not fit
/// are left out.
pub(super) fn find_best(
    scenario: &Scenario,
    plan: &PlacementPlan,
    candidates: &Candidates,
    outcome: &mut PlacementOutcome,
    task: &Task,
) -> Result<Option<BestPlace>, Cancelled> {
    let coil_places = CoilPlaces::new(scenario, plan, candidates);
    let mut studied: Vec<usize> = Vec::new();
    for _ in 0..ROUNDS {
        let Some(candidate) = coil_places.least(outcome, task)? else {
            let is_any = |place: &Placement| !place.is_outside && place.shown_mm().is_some();
            outcome.fits_nowhere = studied.is_empty() && outcome.places.iter().any(is_any);
            break;
        };
        if studied.contains(&candidate) {
            break;
        }
        let place = candidates.place_of[candidate];
        let moved = with_sensor(scenario, plan, &candidates.sensors[place]);
        let (own, work) = study(&moved, outcome.places[candidate], task)?;
        outcome.work += work;
        for (other, of) in outcome.places.iter_mut().zip(&candidates.place_of) {
            if *of == place {
                outcome.full += usize::from(other.basis != Basis::Full);
                *other = own;
            }
        }
        studied.push(candidate);
    }
    let value = |candidate: &usize| outcome.places[*candidate].shown_mm();
    let known = studied.iter().filter_map(|candidate| Some((*candidate, value(candidate)?)));
    let Some((candidate, _)) = known.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(None);
    };
    let moved = with_sensor(scenario, plan, &candidates.sensors[candidates.place_of[candidate]]);
    let body = match (plan.body, moved.crf) {
        (PlacedBody::Crf, Some(crf)) => crf.body,
        _ => moved.tool,
    };
    let sensor = body.sensors.into_iter().nth(plan.sensor);
    let placement = outcome.places[candidate];
    Ok(sensor.map(|sensor| BestPlace { candidate, sensor, placement }))
}

/// What the design comes to, from what is known of it.
fn study(moved: &Scenario, known: Placement, task: &Task) -> Result<(Placement, Work), Cancelled> {
    let mode = whole_mode(moved);
    let (mut placement, mut work) = (known, Work::default());
    if known.basis != Basis::Full {
        placement.tip_rms_mm = match run(moved, &mode, &task.cancel, None) {
            Ok(outcome) => {
                let placement_evaluations = outcome.work.study_evaluations;
                work = Work { placement_evaluations, study_evaluations: 0, ..outcome.work };
                Some(outcome.room_field.position_mm.rms())
            }
            Err(StudyError::Cancelled) => return Err(Cancelled),
            Err(_) => None,
        };
        placement.basis = Basis::Full;
    }
    placement.expected = match moved.environment.states_uncertainty() {
        true => expected_tip(moved, &mode, task)?.map(|found| found.0),
        false => None,
    };
    Ok((placement, work))
}

/// The expected tip RMS, and that by the room's model alone; `None` where there is none to be found.
pub(super) fn expected_tip(
    moved: &Scenario,
    mode: &Mode,
    task: &Task,
) -> Result<Option<(ExpectedTip, f64)>, Cancelled> {
    match expected(moved, mode, &task.cancel) {
        Ok(found) => {
            let rms_mm = found.of(Metric::TIP_RMS).0;
            let interval_mm = found.continued[Metric::TIP_RMS.index()];
            Ok(Some((ExpectedTip { rms_mm, interval_mm }, found.own_of(Metric::TIP_RMS))))
        }
        Err(ExpectedError::Study(StudyError::Cancelled)) => Err(Cancelled),
        Err(_) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Coil, RigidBody};
    use crate::coil_fit::coil_findings;
    use crate::placement::{AxisRule, place, placement_mesh};
    use nalgebra::{Point3, UnitQuaternion, Vector3};
    use std::sync::Arc;
    use trackwright_field::random_models::room;
    use trackwright_field::samples::MapKind;
    use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
    use trackwright_geometry::directions::{DirectionSet, Weighting};
    use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
    use trackwright_geometry::pose::Pose;
    use trackwright_geometry::solid::Solid;
    use trackwright_geometry::surface::Surface;

    const LENGTH_MM: f64 = 100.0;
    const COIL: Coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };
    const TIP_Z_MM: f64 = -300.0;

    /// 2 mm across along z from its tip at the origin, with vertices all along it.
    fn needle() -> SurfaceMesh {
        let outline = [[0.0, 0.0], [1.0, 0.0], [1.0, LENGTH_MM], [0.0, LENGTH_MM]];
        let Solid { positions_mm, normals, triangles } = Solid::turned(&outline);
        let part = MeshPart { positions_mm, normals, triangles, ..MeshPart::default() };
        let mesh = SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() };
        placement_mesh(&mesh).unwrap()
    }

    /// Nothing is off at the tip, and the more the farther from it along the needle: a sensor is the
    /// better the nearer to the tip it is.
    fn scenario(other_z_mm: f64, coil: Coil) -> Scenario {
        let bounds = room();
        // Of the corners the last index is z's.
        let corner = |k: usize| {
            let z_mm = if k % 2 == 1 { bounds.max_mm.z } else { bounds.min_mm.z };
            [0.01 * (z_mm - TIP_Z_MM), 0.0, 0.0, 0.0, 0.0, 0.0]
        };
        let coefficients = (0..8).map(corner).collect();
        let (one, area) = (DirectionSet::One, Weighting::Area);
        let map = MapKind::Distortion;
        let model = DistortionModel::new(1, one, area, map, bounds, coefficients).unwrap();
        let at = |z_mm: f64| Point3::new(0.0, 0.0, z_mm);
        let other = Sensor::six_dof("other", at(other_z_mm), UnitQuaternion::identity());
        let own = Sensor::five_dof("own", at(50.0), Vector3::z_axis());
        Scenario {
            environment: Arc::new(Environment::of_model("room", model)),
            tool: RigidBody {
                name: "needle".into(),
                tip_in_body: Some(Point3::origin()),
                sensors: vec![
                    Sensor { coil: Some(COIL), ..other },
                    Sensor { coil: Some(coil), ..own },
                ],
            },
            crf: None,
            crf_from_tool: Pose::translation(0.0, 0.0, TIP_Z_MM),
            motion: None,
            orientation_weight_mm: 100.0,
            requirement: None,
            outside: OutsidePolicy::Clamp,
        }
    }

    fn placed(scenario: &Scenario, is_fitted: bool) -> (PlacementOutcome, PlacementPlan) {
        let mesh = needle();
        let own_mm = scenario.tool.sensors[1].position_in_body;
        let surface = Surface::new(&mesh).filter(|_| is_fitted).map(Arc::new);
        let plan = PlacementPlan {
            body: PlacedBody::Tool,
            sensor: 1,
            rule: AxisRule::Keep,
            candidates: CoilDepth::Own.places(&mesh, &own_mm).into(),
            depth: CoilDepth::Own,
            surface,
        };
        let outcome = place(scenario, &plan, &Task::default(), &mut |_| {}).unwrap();
        (outcome, plan)
    }

    /// The least z of the candidates where that is allowed.
    fn least_z_mm(plan: &PlacementPlan, is_allowed: impl Fn(f64) -> bool) -> f64 {
        let all = plan.candidates.iter().map(|at| at.position_mm.z);
        all.filter(|z_mm| is_allowed(*z_mm)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_coil_at_the_best_place_is_in_the_needle() {
        let scenario = scenario(80.0, COIL);
        let (free, _) = placed(&scenario, false);
        let free_z_mm = free.best.unwrap().sensor.position_in_body.z;
        assert!(free_z_mm < 2.0, "at the end: {free_z_mm}");
        let (outcome, plan) = placed(&scenario, true);
        let best = outcome.best.unwrap();
        assert!(!outcome.fits_nowhere);
        // Half of the coil behind the tip's face, but for what is not reported.
        let expected_mm = least_z_mm(&plan, |z_mm| z_mm >= 4.45);
        assert!((best.sensor.position_in_body.z - expected_mm).abs() < 1e-6, "{best:?}");
        let sensors = [scenario.tool.sensors[0].clone(), best.sensor];
        assert_eq!(coil_findings("tool", &sensors, plan.surface.as_deref()), []);
    }

    #[test]
    fn the_best_place_is_in_no_other_coil() {
        let scenario = scenario(8.0, COIL);
        let (outcome, plan) = placed(&scenario, true);
        let best = outcome.best.unwrap();
        // End to end with the other one: rounded ends overlap by less than is reported.
        let expected_mm = least_z_mm(&plan, |z_mm| z_mm >= 8.0 + 8.95);
        assert!((best.sensor.position_in_body.z - expected_mm).abs() < 1e-6, "{best:?}");
        let sensors = [scenario.tool.sensors[0].clone(), best.sensor];
        assert_eq!(coil_findings("tool", &sensors, plan.surface.as_deref()), []);
        // Places are left out, not the values that the map shows.
        assert!(outcome.places.iter().all(|place| place.shown_mm().is_some()));
    }

    #[test]
    fn a_coil_that_fits_nowhere_has_no_best_place() {
        let thick = Coil { diameter_mm: 3.0, length_mm: 9.0 };
        let (outcome, _) = placed(&scenario(80.0, thick), true);
        assert_eq!((outcome.best, outcome.fits_nowhere), (None, true));
    }
}
