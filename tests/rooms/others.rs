//! Rooms of others: generators, metals, noises and ways of measuring that the rooms beside them have not. What a
//! plain `fit` chooses is judged by what the tracker reads. What was found with some of these rooms is
//! in `docs/methods/expected-figures.md`; further seeds are further rooms.

use super::tracker::{self, Random, Room, SensorPose, dipole};
use super::{
    Case, cases_of, compared, five_dof, is_listed, judged, measurement, place, scenarios, truth,
};
use nalgebra::Vector3;
use std::sync::Arc;
use trackwright_calibration::doubts::{PairedDoubts, PoseFrame, Suspicion};
use trackwright_calibration::kind_choice::{TriedKind, Wanted, decide};
use trackwright_calibration::lag::without_lag;
use trackwright_calibration::room_choice::ModelRequest;
use trackwright_calibration::room_fit::{RoomOrder, RoomTable, fit_room};
use trackwright_calibration::room_model::{GeneratorChoice, RoomModel};
use trackwright_calibration::row_labels::{RowLabels, row_groups};
use trackwright_field::Environment;
use trackwright_field::fit::FitMethod;
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::{MapKind, MeasurementSet, SampleSet};
use trackwright_geometry::directions::Weighting;
use trackwright_simulation::METRICS;
use trackwright_task::Task;

type V = Vector3<f64>;
type Coils = Vec<Vec<(V, V)>>;

/// Places in a room that are tried for its tools.
const PLACES: usize = 200;

const GENERATORS: [&str; 6] = ["square loops", "twelve", "eight", "six", "tabletop", "ferrite"];
const METALS: [&str; 6] = ["wall", "table below", "table beside", "rods", "iron", "ball near"];
const NOISES: [&str; 6] = ["normal", "heavy", "distance", "orientation", "drift", "lag"];
const SAMPLINGS: [&str; 5] = ["box", "few", "path", "hole", "cone"];

fn square(center: V, normal: V, side_mm: f64) -> Vec<(V, V)> {
    tracker::square(center, normal, side_mm, V::new(0.31, 0.9, 0.22))
}

fn coils(name: &str, random: &mut Random) -> Coils {
    let jitter = |random: &mut Random| random.normal() * 4.0;
    let grid = |k: usize, columns: usize, pitch: f64| {
        let half = |n: usize| (n as f64 - 1.0) / 2.0;
        V::new(
            ((k % columns) as f64 - half(columns)) * pitch,
            ((k / columns) as f64 - half(columns)) * pitch,
            0.0,
        )
    };
    match name {
        // Nine loops whose normals are tilted by turns.
        "square loops" => (0..9)
            .map(|k| {
                let turn = 2.2 * k as f64;
                let tilt: f64 = 0.9;
                let normal = V::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos());
                square(grid(k, 3, 110.0) + jitter(random), normal, 70.0)
            })
            .collect(),
        "twelve" => (0..12)
            .map(|k| {
                let center = grid(k, 4, 90.0) + V::new(0.0, 40.0, -10.0) + jitter(random);
                vec![(center, random.direction())]
            })
            .collect(),
        // Flat coils on a board, in two layers.
        "eight" => (0..8)
            .map(|k| {
                let (layer, place) = (k / 4, k % 4);
                let turn = std::f64::consts::FRAC_PI_4 * layer as f64;
                let at = grid(place, 2, 130.0);
                let center = V::new(
                    at.x * turn.cos() - at.y * turn.sin(),
                    at.x * turn.sin() + at.y * turn.cos(),
                    -8.0 * layer as f64,
                );
                square(center + jitter(random) * 0.2, V::z(), 80.0)
            })
            .collect(),
        "six" => (0..6)
            .map(|k| {
                let center = V::new(if k < 3 { -110.0 } else { 110.0 }, 0.0, 0.0);
                let axes = [V::x(), V::y(), V::z()];
                vec![(center + jitter(random), (axes[k % 3] + random.normal() * 0.1).normalize())]
            })
            .collect(),
        // Wide and flat, under the patient.
        "tabletop" => (0..9)
            .map(|k| {
                let normal = (random.direction() + V::z() * 0.4).normalize();
                square(grid(k, 3, 170.0) + jitter(random), normal, 45.0)
            })
            .collect(),
        // Each core is magnetised by the other coils too.
        _ => {
            let own: Vec<(V, V)> =
                (0..9).map(|k| (grid(k, 3, 100.0) + jitter(random), random.direction())).collect();
            let each = |i: usize| {
                let (center, moment) = own[i];
                let induced = (0..own.len()).filter(|j| *j != i).map(|j| {
                    let (at, axis) = own[j];
                    let field = dipole(&center, &moment, &at);
                    (at, axis * (axis.dot(&field) * 12_000.0))
                });
                std::iter::once((center, moment)).chain(induced).collect()
            };
            (0..own.len()).map(each).collect()
        }
    }
}

/// Spheres that answer like a body of metal: centers, and what the field there is multiplied by.
fn metal(name: &str, [min, max]: [V; 2], random: &mut Random) -> Vec<(V, f64)> {
    let middle = (min + max) / 2.0;
    let half = (max - min) / 2.0;
    // Points on a sheet at `at` along the axis, over a part of the volume's extent.
    let sheet = |axis: usize, at: f64, part: f64, pitch: f64, factor: f64| -> Vec<(V, f64)> {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let count = |k: usize| (part * half[k] / pitch).ceil() as i32;
        let mut all = Vec::new();
        for a in -count(i)..=count(i) {
            for b in -count(j)..=count(j) {
                let mut place = middle;
                place[axis] = at;
                place[i] += f64::from(a) * pitch;
                place[j] += f64::from(b) * pitch;
                all.push((place, factor * (0.45 * pitch).powi(3)));
            }
        }
        all
    };
    match name {
        "wall" => sheet(0, max.x + random.range(60.0, 160.0), 1.4, 50.0, -0.5),
        "table below" => sheet(2, min.z - random.range(40.0, 90.0), 1.2, 45.0, -0.5),
        "table beside" => sheet(1, max.y + random.range(30.0, 70.0), 0.7, 35.0, -0.5),
        "rods" => (0..3)
            .flat_map(|k| {
                let axis = random.direction();
                let mut center = middle;
                let out = k % 2;
                center[out] += (half[out] + random.range(30.0, 60.0)) * [1.0, -1.0][k / 2];
                (-8..=8).map(move |t| (center + axis * f64::from(t) * 22.0, -0.5 * 11_f64.powi(3)))
            })
            .filter(|(p, _)| {
                let beyond = |k: usize| (min[k] - p[k]).max(p[k] - max[k]);
                (0..3).any(|k| beyond(k) > 22.0) && p.z < -30.0
            })
            .collect(),
        // Permeability 100.
        "iron" => {
            let mut center = middle + V::new(0.4 * half.x, 0.0, 0.0);
            center.y = min.y - random.range(50.0, 110.0);
            vec![(center, 0.97 * 35_f64.powi(3)), (center + V::z() * 90.0, 0.97 * 20_f64.powi(3))]
        }
        _ => {
            let mut center = middle + V::new(0.0, 0.3 * half.y, -0.2 * half.z);
            center.x = max.x + random.range(28.0, 40.0);
            vec![(center, -0.5 * 24_f64.powi(3))]
        }
    }
}

/// How one such room was made.
pub struct Made {
    pub room: Room,
    pub table: SampleSet,
    pub names: [&'static str; 4],
}

/// The room of a seed, its table of measurements and what both were made of.
pub fn made(seed: u64) -> Made {
    let mut random = Random::new(50_000 + seed);
    let pick = |names: &[&'static str], by: u64| names[(by % names.len() as u64) as usize];
    let generator = pick(&GENERATORS, seed);
    let metals = pick(&METALS, seed / 2 + seed);
    let noise = pick(&NOISES, 5 * seed + seed / 6);
    let sampling = pick(&SAMPLINGS, 2 * seed + seed / 5);
    let coils = coils(generator, &mut random);
    let bounds = match generator {
        "tabletop" => [V::new(-190.0, -230.0, -480.0), V::new(190.0, 230.0, -130.0)],
        _ => {
            let half = random.range(130.0, 210.0);
            [V::new(-half, -half, -80.0 - 2.0 * half), V::new(half, half, -80.0)]
        }
    };
    let spheres = metal(metals, bounds, &mut random);
    let errors = (random.range(1.0, 4.0), random.range(0.05, 0.3));
    let room = Room::of_parts(coils, &spheres, bounds, errors);
    let table = table(&room, noise, sampling, &mut random);
    Made { room, table, names: [generator, metals, noise, sampling] }
}

fn rows_of(sampling: &str, random: &mut Random) -> usize {
    match sampling {
        "few" => random.range(60.0, 200.0) as usize,
        "path" => random.range(800.0, 3_000.0) as usize,
        _ => random.range(300.0, 2_000.0) as usize,
    }
}

fn table(room: &Room, noise: &str, sampling: &str, random: &mut Random) -> SampleSet {
    let rows = rows_of(sampling, random);
    let poses = poses(room, sampling, rows, random);
    let middle = (room.min_mm + room.max_mm) / 2.0;
    let half = (room.max_mm - room.min_mm) / 2.0;
    let phase = random.range(0.0, 6.0);
    let each = (0..poses.len()).filter_map(|k| {
        let (p, n) = poses[k];
        let t = k as f64 / poses.len() as f64;
        let noisy = |factor: f64| room.with_noise(factor);
        let reading = match noise {
            // Student's with three degrees of freedom: a normal number over the length of three.
            "heavy" => {
                let by = 1.7 / random.normal().norm();
                noisy(by).measure(&(p, n), random)
            }
            "distance" => {
                let by = (-(p.z - middle.z) / half.z).exp();
                noisy(by).measure(&(p, n), random)
            }
            "orientation" => {
                let by = 0.4 + 2.0 * n.z * n.z;
                noisy(by).measure(&(p, n), random)
            }
            // A body of metal is moved while it is measured.
            "drift" => {
                let by = 1.0 + 0.15 * (4.0 * t + phase).sin();
                room.with_gain(by).measure(&(p, n), random)
            }
            // The reading is of a moment before; beside a path that is a random step.
            "lag" => {
                let before = match sampling {
                    "path" => poses[k.saturating_sub(1)],
                    _ => (p + random.normal() * 0.15, n),
                };
                room.measure(&before, random)
            }
            _ => room.measure(&(p, n), random),
        };
        Some(measurement(&(p, n), &reading?))
    });
    five_dof(each).samples(MapKind::Distortion)
}

pub fn poses(room: &Room, sampling: &str, rows: usize, random: &mut Random) -> Vec<SensorPose> {
    let middle = (room.min_mm + room.max_mm) / 2.0;
    let half = (room.max_mm - room.min_mm) / 2.0;
    let mut poses = Vec::new();
    // Sums of sines: a hand that sweeps through the volume.
    let waves: Vec<(V, V)> = (0..4)
        .map(|_| (random.normal() * 0.5, V::from_fn(|_, _| random.range(0.0, 6.3))))
        .collect();
    while poses.len() < rows {
        let t = poses.len() as f64 / rows as f64;
        let (mut p, mut n) = (room.position(random), random.direction());
        match sampling {
            "path" => {
                let wave = |k: usize, j: usize| {
                    let (amplitude, phase) = &waves[j];
                    amplitude[k] * ((4.0 + 9.0 * j as f64 + 2.0 * k as f64) * t + phase[k]).sin()
                };
                p = V::from_fn(|k, _| {
                    let sum: f64 = (0..4).map(|j| wave(k, j)).sum();
                    middle[k] + half[k] * (1.1 * sum).clamp(-1.0, 1.0) * 0.999_999
                });
                let turn = |j: usize| V::from_fn(|k, _| wave((k + 1) % 3, (j + 2) % 4));
                n = (V::new(0.2, 0.1, 0.8) + turn(0) * 1.2 + turn(1)).normalize();
            }
            "hole" if (p - middle - half * 0.2).norm() < 0.45 * half.x => continue,
            "cone" => {
                let tilt = random.range(0.0, 0.7);
                let side = n.cross(&V::z()).normalize();
                n = (V::z() * tilt.cos() + side * tilt.sin()).normalize();
            }
            _ => {}
        }
        if room.contains(&p) {
            poses.push((p, n));
        }
    }
    poses
}

const REQUEST: ModelRequest = ModelRequest {
    order: None,
    directions: None,
    ridge: None,
    method: FitMethod::PerDirection,
    map: MapKind::Distortion,
    weighting: Weighting::Area,
    rcond: 1e-10,
};

/// What warnings name of a table.
fn suspicions(set: &MeasurementSet) -> Vec<Suspicion> {
    PairedDoubts::of(&set.measurements, set.content, PoseFrame::Tracker)
}

/// The table as a person hands it in once the warnings were read: without the rows that are called outliers, and
/// without the lag that is named, as `fit --lag` reads it.
fn as_warned(table: &SampleSet) -> SampleSet {
    let mut set = table.measurements();
    let limit = |suspicion| match suspicion {
        Suspicion::Outliers { limit, .. } => Some(limit),
        _ => None,
    };
    while let Some(limit) = suspicions(&set).into_iter().find_map(limit) {
        set.measurements.retain(|m| {
            let [ideal, measured] = [m.tracker_from_ideal, m.tracker_from_measured];
            (measured.translation.vector - ideal.translation.vector).norm() <= limit
        });
    }
    let lag = suspicions(&set).into_iter().find_map(|suspicion| match suspicion {
        Suspicion::Lag { rows, .. } => Some(rows),
        _ => None,
    });
    if let Some(lag) = lag {
        set.measurements = without_lag(&set.measurements, set.content, lag);
    }
    set.samples(MapKind::Distortion)
}

/// What a plain `fit` makes of a table, or a kind that is forced; with it the chosen kind's label, and what
/// each kind left of rows held out.
pub fn fitted(
    table: &SampleSet,
    forced: Option<&str>,
) -> Option<(Arc<Environment>, String, String)> {
    let mut kinds = TriedKind::all(table, MapKind::Distortion);
    kinds.retain(|kind| forced.is_none_or(|name| kind.label() == name));
    let wanted = Wanted::Best(kinds);
    let task = Task::default();
    let table = &as_warned(table);
    let grouping = row_groups(table, None).ok()?;
    let labels = RowLabels { grouping, ..RowLabels::default() };
    let decided = decide(table, (&wanted, &REQUEST), false, labels, &task).ok()?;
    let order = RoomOrder {
        name: "room",
        table: RoomTable { name: "table", samples: table },
        held_out: None,
        model: &decided.model,
        settings: decided.settings,
        bounds: None,
        volume: None,
        jitter: None,
        registration: None,
        with_support: true,
        sensors: None,
    };
    let room = fit_room(&order, |_| task.clone()).ok()?;
    let kinds = decided.kinds.as_ref()?;
    let each = kinds.kinds.iter().map(|kind| {
        let overall = &kind.deciding().overall;
        let angle = overall.angle_rms_rad.unwrap_or(0.0).to_degrees();
        format!("{} {:.3} mm {angle:.3}°", kind.label(), overall.position_rms_mm)
    });
    let each = each.collect::<Vec<_>>().join(", ");
    Some((Arc::new(room.environment), kinds.best().label(), each))
}

/// The tools of one room.
fn room_cases(seed: u64, made: &Made, environment: &Arc<Environment>) -> Vec<Case> {
    let room = &made.room;
    let mut random = Random::new(70_000 + seed);
    // Where the tracker follows most of them.
    let mut best = (0, Vec::new());
    for _ in 0..PLACES {
        let Some(all) = scenarios(room, environment, place(room, &mut random)) else { continue };
        let followed = all.iter().filter(|scenario| truth(room, scenario).is_some()).count();
        if followed == all.len() {
            return cases_of(room, [environment, environment], all);
        }
        if followed > best.0 {
            best = (followed, all);
        }
    }
    cases_of(room, [environment, environment], best.1)
}

fn line(name: &str, cases: &[Case]) -> String {
    let each = METRICS.into_iter().filter(is_listed).map(|figure| {
        let (ratio, holding, width) = judged(cases, figure);
        let compared = compared(cases, figure);
        format!(
            "{ratio:.2} {:3.0}% {width:.2} d{:3.0}% w{}/{}",
            100.0 * holding as f64 / cases.len() as f64,
            100.0 * compared.holding as f64 / compared.all.max(1) as f64,
            compared.wrong,
            compared.named
        )
    });
    format!("{name:<28} {:3} | {}", cases.len(), each.collect::<Vec<_>>().join(" | "))
}

#[test]
fn rows_along_a_path_choose_a_larger_ridge() {
    // The coils' fields at axes that the path does not have are not in its rows.
    let path = made(33).table;
    let rows: Vec<usize> = (0..path.samples.len()).step_by(3).collect();
    let path = path.of_rows(&rows);
    let (loss, generator) = (Loss::Huber, GeneratorChoice::Learned(None));
    let kind = TriedKind::Harmonic { generator, degrees: vec![3], loss };
    let labels = RowLabels { grouping: row_groups(&path, None).unwrap(), ..RowLabels::default() };
    let wanted = Wanted::Best(vec![kind]);
    let decided = decide(&path, (&wanted, &REQUEST), false, labels, &Task::default()).unwrap();
    let RoomModel::Harmonic(order) = &decided.model else { panic!("{:?}", decided.model) };
    assert!(order.ridge.unwrap() >= 1e-2, "{:?}", order.ridge);
}

/// `cargo test --release --no-default-features --test main -- --ignored --nocapture rooms_of_others_page`,
/// with `ROOMS=0..36`, `KIND=kriging` and `SAMPLING=few`.
#[test]
#[ignore = "prints the figures of the method page, minutes of work"]
#[expect(clippy::print_stdout, reason = "its figures are what it is run for")]
fn rooms_of_others_page() {
    use rayon::prelude::*;
    let range = std::env::var("ROOMS").unwrap_or_else(|_| "0..36".to_owned());
    let (from, to) = range.split_once("..").unwrap();
    let seeds: Vec<u64> = (from.parse().unwrap()..to.parse().unwrap()).collect();
    let forced = std::env::var("KIND").ok();
    let sampling = std::env::var("SAMPLING").ok();
    let found: Vec<_> = seeds
        .into_par_iter()
        .filter_map(|seed| {
            let made = made(seed);
            if sampling.as_ref().is_some_and(|only| made.names[3] != only) {
                return None;
            }
            let start = std::time::Instant::now();
            let Some((environment, kind, each)) = fitted(&made.table, forced.as_deref()) else {
                println!("{seed} {:?}: not fitted", made.names);
                return None;
            };
            let time = start.elapsed().as_secs_f64();
            let cases = room_cases(seed, &made, &environment);
            if cases.is_empty() {
                println!("{seed} {:?}: no tool that is inside and followed", made.names);
                return None;
            }
            let rows = made.table.samples.len();
            let names = made.names.join(", ");
            println!("{seed} {names}: {each}");
            println!("{}", line(&format!("{seed} {names} {rows} {kind} {time:.0}s"), &cases));
            Some((made.names, kind, cases))
        })
        .collect();
    let mut groups: Vec<String> = Vec::new();
    for (names, kind, _) in &found {
        for name in names.iter().map(|name| (*name).to_owned()).chain([kind.clone()]) {
            if !groups.contains(&name) {
                groups.push(name);
            }
        }
    }
    groups.sort();
    groups.push("all".to_owned());
    for group in groups {
        let is_in = |names: &[&str; 4], kind: &String| {
            group == "all" || names.contains(&&*group) || *kind == group
        };
        let cases: Vec<Case> = found
            .iter()
            .filter(|(names, kind, _)| is_in(names, kind))
            .flat_map(|(_, _, cases)| cases.iter().cloned())
            .collect();
        if !cases.is_empty() {
            println!("{}", line(&group, &cases));
        }
    }
}
