//! The verdict on a best layout: the gain in fields the search did not see, what binds it, how flat the
//! optimum is, and sensors that are close together.

use crate::bodies::{Bodies, Movable, Position};
use crate::crowding::Crowding;
use crate::outcome::{Binding, Flatness, RoomGain, body_key};
use crate::problem::{Goal, OverRooms, Problem};
use crate::search::Search;
use nalgebra::Point3;
use trackwright_field::Environment;
use trackwright_simulation::comparison::{self, Pair, Plan};
use trackwright_simulation::{Metric, PlacedBody, Sensor};
use trackwright_task::{Cancelled, Task};

/// A step at which a constraint is seen to bind: half of what a coil can be glued to.
const BINDING_STEP_MM: f64 = 0.5;

/// A gain that is more than round-off, as a part of the objective.
const GAIN: f64 = 1e-6;

/// How much larger the objective is at the end of the flat part.
const FLAT: f64 = 1.05;

/// Ways along which the flat part is looked for; longest and shortest step.
const LONGEST_MM: f64 = 256.0;
const SHORTEST_MM: f64 = 0.25;

/// Halvings of the last step: to a hundredth of a millimetre at 10 mm.
const HALVINGS: usize = 10;

/// Gain in an exact room that is a reason for a change, as a part of the objective.
const LEAST_GAIN: f64 = 1e-3;

/// Part of the largest distance between allowed places below which sensors are close together. The lever of their
/// building errors and jitter is as much shorter.
const CROWDED: f64 = 0.4;

/// Allowed places of each sensor that are looked at.
const PLACES: usize = 64;

/// The best layout against the start in every room, and whether the gain is one that the rooms can
/// tell.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn gain(
    problem: &Problem,
    deciding: Option<Metric>,
    (start, start_objective): (&Bodies, f64),
    (best, best_objective): (&Bodies, f64),
    seed: u64,
    task: &Task,
) -> Result<(Vec<RoomGain>, bool), Cancelled> {
    let rooms: Vec<_> = problem.scenarios.iter().map(|s| s.environment.clone()).collect();
    let pairs = problem.scenarios.iter().enumerate().flat_map(|(room, scenario)| {
        [start, best].into_iter().enumerate().map(move |(design, bodies)| Pair {
            design,
            room,
            scenario: bodies.in_room(scenario),
        })
    });
    let plan = Plan { rooms, pairs: pairs.collect(), baseline: 0 };
    let settings = comparison::Settings { seed, ..comparison::Settings::default() };
    let compared = comparison::compare(&plan, &settings, task)?;
    let rows = compared.rows.into_iter().filter(|row| row.design == 1);
    let gain: Vec<RoomGain> = rows
        .map(|row| RoomGain {
            room: problem.scenarios[row.room].environment.name.clone(),
            differences: row.against_baseline.map_or_else(Vec::new, |a| a.differences),
        })
        .collect();
    let is_less = best_objective < start_objective * (1.0 - GAIN);
    // Refused only where the interval of the gain holds zero: of the figure that decides the objective.
    let of_deciding = |room: &RoomGain| {
        let own = room.differences.iter().find(|d| Some(d.metric) == deciding);
        own.is_some_and(|difference| difference.high < 0.0)
    };
    let is_significant = match problem.rooms {
        OverRooms::Worst => gain.iter().any(of_deciding),
        OverRooms::Mean => gain.iter().all(of_deciding),
    };
    // What a room that was never measured does is exact: there is nothing else it might be.
    let is_exact = problem.scenarios.iter().all(|s| is_exact(&s.environment))
        && best_objective < start_objective * (1.0 - LEAST_GAIN);
    Ok((gain, is_less && (is_significant || is_exact)))
}

fn is_exact(environment: &Environment) -> bool {
    environment.provenance.is_none()
        && environment.fit_validity.is_none()
        && !environment.states_uncertainty()
}

/// The figures that count.
pub(crate) fn required(goal: Goal) -> Vec<Metric> {
    match goal {
        Goal::Figure(metric) => vec![metric],
        Goal::Requirement(requirement) => requirement.bounds().map(|bound| bound.0).collect(),
    }
}

/// Constraints without which a step from the best layout would be better still.
pub(crate) fn binding(search: &Search, position: &Position, best: f64) -> Vec<Binding> {
    let mut found: Vec<Binding> = Vec::new();
    for number in 0..search.movable.slots.len() {
        for direction in directions(search, position, number) {
            let way: Vec<f64> = direction.iter().map(|part| part * BINDING_STEP_MM).collect();
            let moved = search.movable.moved(position, &way);
            let Some(constraint) = search.fault_of(&moved, number) else { continue };
            let value = search.judge.few_value(&search.movable.bodies(&moved)).ok().flatten();
            if !value.is_some_and(|value| value < best * (1.0 - GAIN)) {
                continue;
            }
            let (body, sensor) = named(search, number);
            let binding = Binding { body, sensor, constraint };
            if !found.contains(&binding) {
                found.push(binding);
            }
        }
    }
    found
}

/// How far each sensor may move for 5 % more.
pub(crate) fn flatness(search: &Search, position: &Position, best: f64) -> Vec<Flatness> {
    let slots = 0..search.movable.slots.len();
    let each = slots.map(|number| {
        let at = |direction: &[f64], way_mm: f64| {
            let way: Vec<f64> = direction.iter().map(|part| part * way_mm).collect();
            let moved = search.movable.moved(position, &way);
            if !search.is_allowed(&moved) {
                return None;
            }
            let value = search.judge.few_value(&search.movable.bodies(&moved)).ok().flatten()?;
            let from = &position.places[number].sensor;
            Some((
                value,
                (moved.places[number].sensor.position_in_body - from.position_in_body).norm(),
            ))
        };
        let ways = directions(search, position, number).into_iter().filter_map(|direction| {
            let mut way_mm = SHORTEST_MM;
            let mut inside_mm = 0.0;
            loop {
                let (value, _) = at(&direction, way_mm)?;
                if value > FLAT * best {
                    break;
                }
                inside_mm = way_mm;
                way_mm *= 2.0;
                if way_mm > LONGEST_MM {
                    return None;
                }
            }
            let mut outside_mm = way_mm;
            for _ in 0..HALVINGS {
                let middle_mm = (inside_mm + outside_mm) / 2.0;
                match at(&direction, middle_mm) {
                    Some((value, _)) if value <= FLAT * best => inside_mm = middle_mm,
                    _ => outside_mm = middle_mm,
                }
            }
            at(&direction, inside_mm).map(|(_, moved_mm)| moved_mm)
        });
        let within_mm = ways.min_by(f64::total_cmp);
        let (body, sensor) = named(search, number);
        Flatness { body, sensor, within_mm }
    });
    each.collect()
}

fn named(search: &Search, number: usize) -> (&'static str, String) {
    let slot = search.movable.slots[number];
    let sensors = search.movable.base.body(slot.body).map(|body| &body.sensors);
    let sensor = sensors.and_then(|sensors| sensors.get(slot.index));
    (body_key(slot.body), sensor.map_or_else(String::new, |sensor: &Sensor| sensor.name.clone()))
}

/// Ways of one sensor alone: either way along its channel, or along its surface in all directions.
fn directions(search: &Search, position: &Position, number: usize) -> Vec<Vec<f64>> {
    let all = search.movable.dimensions(position);
    let own: Vec<usize> = search.movable.slot_dimensions(position).collect();
    let first: usize = own[..number].iter().sum();
    let steps = [-1.0_f64, 0.0, 1.0];
    let place = &position.places[number];
    let places = search.movable.places(search.movable.slots[number].body);
    let of_place: Vec<Vec<f64>> = match places.map_or(0, |places| places.way_dimensions(place)) {
        0 => Vec::new(),
        1 => vec![vec![-1.0], vec![1.0]],
        _ => {
            let mut all = Vec::new();
            for x in steps {
                for y in steps {
                    for z in steps {
                        let length = (x * x + y * y + z * z).sqrt();
                        if length > 0.0 {
                            all.push([x, y, z].map(|part| part / length).to_vec());
                        }
                    }
                }
            }
            all
        }
    };
    let whole = of_place.into_iter().map(|parts| {
        let mut way = vec![0.0; all];
        way[first..first + parts.len()].copy_from_slice(&parts);
        way
    });
    whole.collect()
}

/// Bodies with sensors that move and are close together.
pub(crate) fn crowded(movable: &Movable, bodies: &Bodies) -> Vec<Crowding> {
    let each = [PlacedBody::Tool, PlacedBody::Crf].into_iter();
    each.filter_map(|body| crowding(movable, bodies, body)).collect()
}

fn crowding(movable: &Movable, bodies: &Bodies, body: PlacedBody) -> Option<Crowding> {
    let (rigid, places) = (bodies.body(body)?, movable.places(body)?);
    let moved: Vec<usize> =
        movable.slots.iter().filter(|slot| slot.body == body).map(|slot| slot.index).collect();
    if moved.is_empty() || rigid.sensors.len() < 2 {
        return None;
    }
    let taken: Vec<Point3<f64>> = rigid.sensors.iter().map(|own| own.position_in_body).collect();
    let allowed = moved.iter().flat_map(|&index| {
        let grid = places.grid(&rigid.sensors[index], PLACES).places;
        grid.into_iter().map(|place| place.sensor.position_in_body)
    });
    let allowed: Vec<Point3<f64>> = allowed.chain(taken.iter().copied()).collect();
    let [span_mm, allowed_mm] = [&taken, &allowed].map(|points| span_mm(points));
    if span_mm >= CROWDED * allowed_mm {
        return None;
    }
    let from_tip_mm = rigid.tip_in_body.map(|tip| {
        let each = taken.iter().map(|place| (place - tip).norm());
        each.fold([f64::INFINITY, 0.0], |[least, most], mm| [mm.min(least), mm.max(most)])
    });
    Some(Crowding { body: body_key(body), span_mm, from_tip_mm, allowed_mm })
}

/// The largest distance between two points.
fn span_mm(points: &[Point3<f64>]) -> f64 {
    let each = points.iter().enumerate();
    let pairs = each.flat_map(|(k, a)| points[k + 1..].iter().map(move |b| (a - b).norm()));
    pairs.fold(0.0, f64::max)
}
