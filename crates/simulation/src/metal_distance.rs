//! How far a metal object must be: a study at each of some places along a line, nearer to the tool's tip
//! and farther from it than the object is, and from where on the requirement holds.

use crate::figure::Figures;
use crate::judgement::Verdict;
use crate::run::StudyError;
use crate::scenario::Mode;
use crate::scenario::Scenario;
use crate::study::study;
use nalgebra::{Point3, Translation3, Unit, Vector3};
use serde::Serialize;
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_geometry::limits::length_above_zero_problem;
use trackwright_geometry::pose::Pose;
use trackwright_metal::furnished::{FurnishError, Furnisher};
use trackwright_metal::setup::RoomMetal;
use trackwright_task::{Cancelled, Task};

/// Places along the line, denser at its beginning, where the error changes fastest.
const PLACES: usize = 17;

/// The distance is found to this.
pub const RESOLUTION_MM: f64 = 1.0;

/// A search: which object is moved along which line.
#[derive(Clone, Debug)]
pub struct MetalDistanceSearch<'a> {
    /// With the environment of any metal.
    pub scenario: &'a Scenario,
    /// The room without metal.
    pub bare: &'a Arc<Environment>,
    pub metal: &'a RoomMetal,
    /// Its index in the metal.
    pub object: usize,
    /// In the tracker frame; `None` away from the tool's tip at the design's pose.
    pub direction: Option<Unit<Vector3<f64>>>,
    /// The end of the line, from where the object is. It begins where the object's origin is nearest
    /// to the tip.
    pub farthest_mm: f64,
    pub mode: &'a Mode,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct MetalDistances {
    pub direction: Unit<Vector3<f64>>,
    /// By distance.
    pub places: Vec<MetalPlace>,
    /// From where on the requirement holds, as far as the line goes; `None` where it does not at the
    /// end, and without a requirement.
    pub holds_from: Option<MetalGap>,
}

/// Where the object is on the line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MetalGap {
    /// From where it is in the design; below zero nearer to the tip.
    pub moved_mm: f64,
    /// From its surface to the tool's tip at the design's pose.
    pub from_tip_mm: f64,
}

/// The study at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct MetalPlace {
    pub gap: MetalGap,
    /// The figures, or why the object cannot be there.
    pub figures: Result<Figures, String>,
    /// The requirement's; `None` without one, and where the object cannot be.
    pub verdict: Option<Verdict>,
}

/// Why there is nothing to find.
#[derive(Clone, Debug, thiserror::Error)]
pub enum MetalDistanceError {
    #[error("the room has no metal object {object}, it has {count}")]
    NoSuchObject { object: usize, count: usize },
    #[error("the farthest distance is {found} mm, expected {expected}")]
    Farthest { found: f64, expected: &'static str },
    #[error("the object is at the tool's tip: expected a direction to move it in")]
    NoDirection,
    #[error("the object can be nowhere on the line: {0}")]
    Nowhere(String),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Studies the places of the line, and those between which the requirement begins to hold.
///
/// # Errors
/// See [`MetalDistanceError`].
pub fn metal_distances(
    search: &MetalDistanceSearch<'_>,
    furnisher: &mut Furnisher,
    task: &Task,
) -> Result<MetalDistances, MetalDistanceError> {
    let count = search.metal.objects.len();
    let Some(object) = search.metal.objects.get(search.object) else {
        return Err(MetalDistanceError::NoSuchObject { object: search.object, count });
    };
    if let Some(expected) = length_above_zero_problem(search.farthest_mm) {
        return Err(MetalDistanceError::Farthest { found: search.farthest_mm, expected });
    }
    let from_tip = object.tracker_from_object.translation.vector - search.tip_in_tracker().coords;
    let direction = search
        .direction
        .or_else(|| Unit::try_new(from_tip, 1e-3))
        .ok_or(MetalDistanceError::NoDirection)?;
    let nearer_mm = from_tip.dot(&direction).max(0.0);
    // Halving finds the distance to the resolution between two places.
    let halvings = ((nearer_mm + search.farthest_mm) / RESOLUTION_MM).log2().ceil();
    let steps = PLACES + halvings.max(0.0) as usize;
    let mut places = Vec::with_capacity(steps);
    for (step, moved_mm) in first_places(nearer_mm, search.farthest_mm).into_iter().enumerate() {
        task.step(step, steps)?;
        places.push(search.place(&direction, moved_mm, furnisher, task)?);
    }
    if let Some(Err(why)) = places.last().map(|place| &place.figures)
        && places.iter().all(|place| place.figures.is_err())
    {
        return Err(MetalDistanceError::Nowhere(why.clone()));
    }
    let holds = |place: &MetalPlace| place.verdict == Some(Verdict::Met);
    let mut step = PLACES;
    while let Some(last) = places.iter().rposition(|place| !holds(place)) {
        let (low, high) = match (places.get(last), places.get(last + 1)) {
            (Some(low), Some(high)) => (low.gap.moved_mm, high.gap.moved_mm),
            // It does not hold at the end of the line.
            _ => break,
        };
        if high - low <= RESOLUTION_MM {
            break;
        }
        task.step(step.min(steps - 1), steps)?;
        step += 1;
        places.insert(last + 1, search.place(&direction, 0.5 * (low + high), furnisher, task)?);
    }
    let first = places.iter().rposition(|place| !holds(place)).map_or(0, |last| last + 1);
    let holds_from = places.get(first).map(|place| place.gap);
    Ok(MetalDistances { direction, places, holds_from })
}

/// From where the line is nearest to the tip to its end, by their distance from where the object is,
/// which is one of them.
fn first_places(nearer_mm: f64, farthest_mm: f64) -> [f64; PLACES] {
    let mut places = std::array::from_fn(|step| {
        let part = step as f64 / (PLACES - 1) as f64;
        (nearer_mm + farthest_mm) * part * part - nearer_mm
    });
    let own = places.iter_mut().min_by(|a, b| a.abs().total_cmp(&b.abs()));
    own.into_iter().for_each(|own| *own = 0.0);
    places
}

/// An object on the line, `tracker_from_object`.
fn moved(direction: &Unit<Vector3<f64>>, moved_mm: f64, own: &Pose) -> Pose {
    Translation3::from(direction.into_inner() * moved_mm) * own
}

impl MetalDistances {
    /// Where the object is at its least distance, `tracker_from_object`, from where it is in the design;
    /// nothing where it is there already, and where the requirement does not begin to hold.
    pub fn least(&self, own: &Pose) -> Option<Pose> {
        let moved_mm = self.holds_from?.moved_mm;
        (moved_mm.abs() > RESOLUTION_MM).then(|| moved(&self.direction, moved_mm, own))
    }

    /// From how far away the object, by its name, lets a design meet its requirement.
    pub fn statement(&self, name: &str, has_requirement: bool) -> String {
        let farthest = self.places.last();
        match (has_requirement, &self.holds_from) {
            (false, _) => "the design has no requirement that could hold".to_owned(),
            (true, Some(gap)) if gap.moved_mm == 0.0 => {
                format!("the requirement holds with {name} where it is and farther away")
            }
            (true, Some(gap)) if gap.moved_mm < 0.0 => format!(
                "the requirement holds with {name} where it is, and up to {:.0} mm nearer: from \
                 {:.0} mm from {name} to the tip",
                -gap.moved_mm, gap.from_tip_mm
            ),
            (true, Some(gap)) => format!(
                "the requirement holds from {:.0} mm away, {:.0} mm from {name} to the tip",
                gap.moved_mm, gap.from_tip_mm
            ),
            (true, None) => {
                let what = match farthest.and_then(|place| place.verdict) {
                    Some(Verdict::CannotTell) => "it is not decided whether the requirement holds",
                    _ => "the requirement does not hold",
                };
                let moved_mm = farthest.map_or(0.0, |place| place.gap.moved_mm);
                format!("{what} {moved_mm:.0} mm away in this direction")
            }
        }
    }
}

impl MetalDistanceSearch<'_> {
    /// The tool's tip at the design's pose.
    fn tip_in_tracker(&self) -> Point3<f64> {
        let tracker_from_tool = self.scenario.tracker_from_crf() * self.scenario.crf_from_tool;
        tracker_from_tool * self.scenario.tool.judged_tip_in_body()
    }

    fn place(
        &self,
        direction: &Unit<Vector3<f64>>,
        moved_mm: f64,
        furnisher: &mut Furnisher,
        task: &Task,
    ) -> Result<MetalPlace, MetalDistanceError> {
        let mut metal = self.metal.clone();
        let object = &mut metal.objects[self.object];
        object.tracker_from_object = moved(direction, moved_mm, &object.tracker_from_object);
        let tip = self.tip_in_tracker();
        let origin_from_tip_mm =
            (object.tracker_from_object.translation.vector - tip.coords).norm();
        let furnished = match furnisher.furnish(self.bare, &metal, task) {
            Ok(furnished) => furnished,
            Err(FurnishError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(problem) => {
                // It is where it cannot be: how far its surface is from the tip is not known.
                let gap = MetalGap { moved_mm, from_tip_mm: origin_from_tip_mm };
                return Ok(MetalPlace { gap, figures: Err(problem.to_string()), verdict: None });
            }
        };
        let from_tip_mm = furnished
            .room
            .as_ref()
            .map_or(origin_from_tip_mm, |room| room.body_distance_mm(self.object, &tip));
        let scenario = Scenario { environment: furnished.environment, ..self.scenario.clone() };
        let figures = study(&scenario, self.mode, &task.cancel, None)?.figures;
        let judgement = figures.requirement.as_ref();
        Ok(MetalPlace {
            gap: MetalGap { moved_mm, from_tip_mm },
            verdict: judgement.map(|judgement| judgement.verdict),
            figures: Ok(figures),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{RigidBody, Sensor};
    use crate::metric::Metric;
    use crate::requirement::Requirement;
    use trackwright_field::generator::Generator;
    use trackwright_field::samples::MapKind;
    use trackwright_field::{DistortionModel, OutsidePolicy};
    use trackwright_geometry::volume::Volume;
    use trackwright_metal::setup::{
        DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape,
    };

    fn ideal() -> Arc<Environment> {
        let volume = Volume::AuroraCube;
        let model = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
        Arc::new(Environment { volume: Some(volume), ..Environment::of_model("ideal", model) })
    }

    fn scenario(requirement: Option<Requirement>) -> Scenario {
        let sensors = [("a", Vector3::z_axis()), ("b", Vector3::x_axis())]
            .map(|(name, axis)| Sensor::five_dof(name, Point3::new(0.0, 0.0, 40.0), axis));
        Scenario {
            environment: ideal(),
            tool: RigidBody {
                name: "probe".to_owned(),
                tip_in_body: Some(Point3::origin()),
                sensors: sensors.to_vec(),
            },
            crf: None,
            crf_from_tool: Pose::translation(0.0, 0.0, -300.0),
            motion: None,
            orientation_weight_mm: 100.0,
            requirement,
            outside: OutsidePolicy::Clamp,
        }
    }

    fn ball(y_mm: f64) -> RoomMetal {
        let ball = MetalObject {
            name: "ball".to_owned(),
            shape: ObjectShape::Sphere { radius_mm: 50.0 },
            material: ObjectMaterial::Named("copper"),
            tracker_from_object: Pose::translation(0.0, y_mm, -300.0),
            most_triangles: DEFAULT_TRIANGLES,
            tolerance: MaterialTolerance::default(),
        };
        RoomMetal { objects: vec![ball], ..RoomMetal::empty(Generator::planar_nine()) }
    }

    fn search(
        scenario: &Scenario,
        metal: &RoomMetal,
        change: impl FnOnce(&mut MetalDistanceSearch<'_>),
    ) -> Result<MetalDistances, MetalDistanceError> {
        let mut search = MetalDistanceSearch {
            scenario,
            bare: &ideal(),
            metal,
            object: 0,
            direction: None,
            farthest_mm: 400.0,
            mode: &Mode::Single,
        };
        change(&mut search);
        metal_distances(&search, &mut Furnisher::default(), &Task::default())
    }

    #[test]
    fn the_requirement_holds_from_where_it_is_met() {
        let metal = ball(-150.0);
        let tip_mm = |y_mm: f64| {
            let furnished =
                Furnisher::default().furnish(&ideal(), &ball(y_mm), &Task::default()).unwrap();
            let scenario = Scenario { environment: furnished.environment, ..scenario(None) };
            let cancel = Task::default().cancel;
            let figures = study(&scenario, &Mode::Single, &cancel, None).unwrap().figures;
            figures.get(Metric::TIP_RMS).unwrap().high.unwrap()
        };
        // The limit is the interval's end at a place of one's own choice, which has to be found again.
        let limit_mm = tip_mm(-230.0);
        assert!(tip_mm(-150.0) > 2.0 * limit_mm);
        let limited = scenario(Some(Requirement::at_most([(Metric::TIP_RMS, limit_mm)])));
        let found = search(&limited, &metal, |_| {}).unwrap();
        assert!((found.direction.into_inner() + Vector3::y()).norm() < 1e-12);
        let from = found.holds_from.unwrap();
        assert!((80.0..=80.0 + RESOLUTION_MM).contains(&from.moved_mm), "{from:?}");
        assert!((from.from_tip_mm - (from.moved_mm + 100.0)).abs() < 1e-9, "{from:?}");
        let is_sorted = found.places.is_sorted_by_key(|place| place.gap.moved_mm);
        assert!(is_sorted && found.places.len() > PLACES);
        // From farther away the same distance to the tip is found, the other way.
        let far = search(&limited, &ball(-330.0), |_| {}).unwrap();
        let far_from = far.holds_from.unwrap();
        assert!((-100.0..=-100.0 + RESOLUTION_MM).contains(&far_from.moved_mm), "{far_from:?}");
        assert!((far_from.from_tip_mm - (far_from.moved_mm + 280.0)).abs() < 1e-9);
        let nearer = far.statement("ball", true);
        assert!(nearer.contains("mm nearer: from 18"), "{nearer}");
    }

    #[test]
    fn where_the_object_is_is_a_place_of_the_line() {
        for (nearer_mm, farthest_mm) in [(0.0, 500.0), (150.0, 400.0), (2000.0, 1.0), (0.3, 7.0)] {
            let places = first_places(nearer_mm, farthest_mm);
            assert!(places.contains(&0.0) && places.is_sorted(), "{places:?}");
            assert_eq!(places[0].min(0.0), -nearer_mm);
        }
    }

    #[test]
    fn a_requirement_that_never_holds_has_no_distance() {
        let limited = scenario(Some(Requirement::at_most([(Metric::TIP_RMS, 1e-6)])));
        let found = search(&limited, &ball(-150.0), |_| {}).unwrap();
        assert_eq!((found.holds_from, found.places.len()), (None, PLACES));
        // Without a requirement there is a curve, and no distance.
        let found = search(&scenario(None), &ball(-150.0), |_| {}).unwrap();
        assert!(found.holds_from.is_none() && found.places.iter().all(|p| p.verdict.is_none()));
        let first = found.places.iter().find_map(|place| place.figures.as_ref().ok()).unwrap();
        let last = found.places.last().and_then(|p| p.figures.as_ref().ok()).unwrap();
        let [first, last] = [first, last].map(|f| f.get(Metric::TIP_RMS).unwrap().value);
        assert!(first > 20.0 * last);
    }

    #[test]
    fn one_that_always_holds_does_so_up_to_the_tip() {
        let limited = scenario(Some(Requirement::at_most([(Metric::TIP_RMS, 1e4)])));
        let found = search(&limited, &ball(-150.0), |_| {}).unwrap();
        let from = found.holds_from.unwrap();
        assert!((-100.0..=-100.0 + RESOLUTION_MM).contains(&from.moved_mm), "{from:?}");
        // One that is as near as the line leads can only be farther away.
        let back = Vector3::y_axis();
        let found = search(&limited, &ball(150.0), |search| search.direction = Some(-back));
        assert!(found.unwrap().holds_from.unwrap().moved_mm > 0.0);
    }

    #[test]
    fn where_the_object_cannot_be_the_place_states_why() {
        // On its way to the volume's middle and out of it again.
        let limited = scenario(Some(Requirement::at_most([(Metric::TIP_RMS, 100.0)])));
        let found =
            search(&limited, &ball(-150.0), |search| search.direction = Some(Vector3::y_axis()));
        let found = found.unwrap();
        let why = found.places.iter().find_map(|place| place.figures.as_ref().err()).unwrap();
        assert_eq!(why, "ball is in the middle of the measurement volume");
        assert!(found.holds_from.unwrap().moved_mm > 150.0);
    }

    #[test]
    fn impossible_searches_are_refused() {
        let (scenario, metal) = (scenario(None), ball(-150.0));
        let error = |change: fn(&mut MetalDistanceSearch<'_>)| {
            search(&scenario, &metal, change).unwrap_err().to_string()
        };
        assert_eq!(error(|s| s.object = 1), "the room has no metal object 1, it has 1");
        assert_eq!(
            error(|s| s.farthest_mm = f64::NAN),
            "the farthest distance is NaN mm, expected a length above zero"
        );
    }
}
