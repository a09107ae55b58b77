//! Rooms of known metal, what is found in each, and how often the intervals hold.
//!
//! The truth is independent of what is fitted: meshes are solved for at their surface, spheres by their series.

use super::rows::Rows;
use super::tests::{POSITION_NOISE_MM, ROTATION_NOISE_RAD, identified, readings};
use super::{BodyForm, Form, FoundBody, Identification, Noise, Verdict, identification};
use crate::body::{MetalBody, MetalShape};
use crate::boundary::BoundaryShape;
use crate::material::Material;
use crate::room::{MetalRoom, PlacedBody};
use crate::shapes::{cuboid, cylinder};
use crate::surface::ClosedSurface;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_field::samples::MeasurementContent;
use trackwright_field::selection::folds::Folds;
use trackwright_geometry::pose::pose_from_parts;
use trackwright_task::Task;

/// A solid; a plate is a box.
#[derive(Clone, Copy)]
enum Solid {
    Ball {
        radius_mm: f64,
    },
    Box {
        size_mm: [f64; 3],
    },
    /// Along z.
    Rod {
        radius_mm: f64,
        length_mm: f64,
    },
}

use Solid::{Ball, Box, Rod};

/// At 10 kHz.
#[derive(Clone, Copy)]
struct Piece {
    solid: Solid,
    material: &'static str,
    center_mm: [f64; 3],
    /// What its z axis is turned to.
    z_along: [f64; 3],
}

struct Case {
    name: &'static str,
    pieces: Vec<Piece>,
}

fn piece(solid: Solid, material: &'static str, center_mm: [f64; 3], z_along: [f64; 3]) -> Piece {
    Piece { solid, material, center_mm, z_along }
}

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn cases() -> Vec<Case> {
    let plate = |x: f64, y: f64, z: f64| Box { size_mm: [x, y, z] };
    let case = |name, pieces: &[Piece]| Case { name, pieces: pieces.to_vec() };
    let ball = piece(Ball { radius_mm: 45.0 }, "aluminium", [230.0, 40.0, -190.0], UP);
    let ferrite = piece(Ball { radius_mm: 30.0 }, "ferrite", [-200.0, -90.0, -260.0], UP);
    let steel = piece(plate(200.0, 200.0, 1.0), "steel-304", [270.0, 0.0, -250.0], [1.0, 0.0, 0.0]);
    let tilted =
        piece(plate(150.0, 150.0, 3.0), "aluminium", [-270.0, 60.0, -220.0], [1.0, 0.3, 0.5]);
    vec![
        case("sphere, aluminium, 45 mm", &[ball]),
        case("plate, steel 304, 200 × 200 × 1 mm", &[steel]),
        case("plate, aluminium, 150 × 150 × 3 mm, tilted", &[tilted]),
        case(
            "plate, copper, 200 × 150 × 2 mm, below",
            &[piece(plate(200.0, 150.0, 2.0), "copper", [20.0, -10.0, -480.0], UP)],
        ),
        case(
            "plate, titanium, 300 × 200 × 2 mm, below",
            &[piece(plate(300.0, 200.0, 2.0), "titanium", [-30.0, 40.0, -540.0], UP)],
        ),
        case(
            "rod, steel 304, 20 × 300 mm",
            &[piece(
                Rod { radius_mm: 10.0, length_mm: 300.0 },
                "steel-304",
                [240.0, -50.0, -250.0],
                UP,
            )],
        ),
        case(
            "rod, titanium, 30 × 200 mm",
            &[piece(
                Rod { radius_mm: 15.0, length_mm: 200.0 },
                "titanium",
                [-230.0, 30.0, -240.0],
                [0.0, 1.0, 1.0],
            )],
        ),
        case(
            "rod, steel 416, 10 × 150 mm",
            &[piece(
                Rod { radius_mm: 5.0, length_mm: 150.0 },
                "steel-416",
                [-250.0, 0.0, -250.0],
                [0.0, 1.0, 0.0],
            )],
        ),
        case(
            "box, aluminium, 100 × 80 × 60 mm",
            &[piece(plate(100.0, 80.0, 60.0), "aluminium", [260.0, 80.0, -300.0], [0.2, 0.1, 1.0])],
        ),
        case(
            "plate, ferrite, 100 × 100 × 5 mm",
            &[piece(plate(100.0, 100.0, 5.0), "ferrite", [0.0, 250.0, -250.0], [0.0, 1.0, 0.2])],
        ),
        case("two: sphere and plate", &[ball, tilted]),
        case("two: plate and ferrite", &[steel, ferrite]),
        case(
            "three: sphere, ferrite, plate below",
            &[ball, ferrite, piece(plate(200.0, 150.0, 2.0), "copper", [20.0, -10.0, -520.0], UP)],
        ),
        case(
            "table, steel 304, 1900 × 500 × 2 mm, below",
            &[piece(plate(1900.0, 500.0, 2.0), "steel-304", [200.0, 0.0, -500.0], UP)],
        ),
        case(
            "wall, aluminium, 1500 × 1500 × 5 mm",
            &[piece(
                plate(1500.0, 1500.0, 5.0),
                "aluminium",
                [400.0, 0.0, -300.0],
                [1.0, 0.0, 0.0],
            )],
        ),
        case(
            "sphere, aluminium, 60 mm, 750 mm outside",
            &[piece(Ball { radius_mm: 60.0 }, "aluminium", [900.0, 100.0, -300.0], UP)],
        ),
        case(
            "plate, steel 304, 200 × 200 × 1 mm, 250 mm outside",
            &[piece(plate(200.0, 200.0, 1.0), "steel-304", [400.0, 0.0, -250.0], [1.0, 0.0, 1.0])],
        ),
        case("no metal", &[]),
    ]
}

impl Piece {
    fn placed(&self, task: &Task) -> PlacedBody {
        let meshed = |mesh| {
            let surface = ClosedSurface::new(&mesh).unwrap();
            MetalShape::Surface(Arc::new(BoundaryShape::new(surface, task).unwrap()))
        };
        let shape = match self.solid {
            Ball { radius_mm } => MetalShape::Sphere { radius_mm },
            Box { size_mm } => meshed(cuboid(&Vector3::from(size_mm), 400).unwrap()),
            Rod { radius_mm, length_mm } => meshed(cylinder(radius_mm, length_mm, 240).unwrap()),
        };
        let material = Material::named(self.material).unwrap();
        let z = Vector3::from(self.z_along);
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &z).unwrap();
        PlacedBody {
            body: Arc::new(MetalBody::new(shape, material, 1e4, task).unwrap()),
            tracker_from_body: pose_from_parts(self.center_mm.into(), turn),
        }
    }
}

impl Case {
    fn room(&self) -> MetalRoom {
        let task = Task::default();
        let placed = self.pieces.iter().map(|piece| piece.placed(&task)).collect();
        MetalRoom::new(Generator::planar_nine(), None, placed, &task).unwrap()
    }
}

/// Numbers that are in their 95 % intervals, of all.
#[derive(Clone, Copy, Default)]
struct Covered {
    inside: usize,
    all: usize,
}

impl Covered {
    fn count(&mut self, is_inside: bool) {
        self.inside += usize::from(is_inside);
        self.all += 1;
    }
}

impl Case {
    fn found(&self, room: &MetalRoom, seed: u64) -> Identification {
        identified(&readings(room, 350, MeasurementContent::FiveDof, seed))
    }

    fn nearest(&self, body: &FoundBody) -> Option<&Piece> {
        let off_mm = |piece: &&Piece| off_mm(body, piece);
        self.pieces.iter().min_by(|a, b| off_mm(a).total_cmp(&off_mm(b)))
    }

    /// Counts x, y and z of each body that is determined, and its axis. A body that is nothing counts as four outside.
    fn count(&self, found: &Identification, centers: &mut Covered, axes: &mut Covered) {
        for body in found.determined() {
            let known = body.known.as_ref().unwrap();
            for k in 0..3 {
                let truth = self.nearest(body).map_or(f64::NAN, |piece| piece.center_mm[k]);
                centers.count(known.center_mm[k].contains(truth));
            }
            if let (Some(form), Some(piece)) = (&known.form, self.nearest(body)) {
                axes.count(piece.off_axis_rad(form) < form.axis_within95_rad);
            }
        }
    }

    /// A body for the page.
    fn answer(&self, body: &FoundBody) -> String {
        let known = match &body.known {
            Err(doubt) => return format!("{:?}: cannot tell, {doubt}", body.kind),
            Ok(known) => known,
        };
        let Some(piece) = self.nearest(body) else { return format!("no such body: {body:?}") };
        let form = known.form.map_or_else(String::new, |form| {
            let [off, within] = [piece.off_axis_rad(&form), form.axis_within95_rad];
            let [off, within] = [off.to_degrees(), within.to_degrees()];
            format!(", {:?}, axis {off:.0}° off ± {within:.0}°", form.form)
        });
        let (off, half) = (off_mm(body, piece), known.half_length_mm);
        format!("{:?} {off:.1} mm off, ± {half:.1} mm{form}", body.kind)
    }
}

impl Piece {
    fn off_axis_rad(&self, form: &BodyForm) -> f64 {
        form.axis.dot(&Vector3::from(self.z_along).normalize()).abs().min(1.0).acos()
    }
}

fn off_mm(body: &FoundBody, piece: &Piece) -> f64 {
    (body.source.center_mm - Point3::from(piece.center_mm)).norm()
}

#[test]
fn intervals_hold_for_plates_and_boxes() {
    let (mut centers, mut axes) = (Covered::default(), Covered::default());
    for name in ["sphere, aluminium, 45 mm", "plate, ferrite", "plate, copper", "box"] {
        let case = cases().into_iter().find(|case| case.name.starts_with(name)).unwrap();
        let found = case.found(&case.room(), 7);
        assert_eq!(found.determined().count(), 1, "{name}: {found:?}");
        let body = &found.bodies[0];
        // A sphere and a box are no plates.
        let form = body.known.as_ref().unwrap().form.map(|form| form.form);
        assert_eq!(form, name.starts_with("plate").then_some(Form::Plate), "{name}: {body:?}");
        assert!(off_mm(body, &case.pieces[0]) < 30.0, "{name}: {body:?}");
        case.count(&found, &mut centers, &mut axes);
    }
    // 95 % of 12 are 11; of two axes both but for one time in ten.
    assert!(centers.inside >= 10, "{} of {}", centers.inside, centers.all);
    assert!(axes.inside >= 1, "{} of {}", axes.inside, axes.all);
}

#[test]
fn a_table_and_a_wall_are_not_determined() {
    for name in ["table", "wall"] {
        let case = cases().into_iter().find(|case| case.name.starts_with(name)).unwrap();
        let found = case.found(&case.room(), 7);
        assert!(matches!(found.verdict, Verdict::CannotTell | Verdict::NotCompact), "{found:?}");
        assert_eq!(found.determined().count(), 0, "{found:?}");
    }
}

/// What decides between *nothing found* and *cannot tell* where no bodies explain anything.
#[test]
fn a_wall_disturbs_and_an_empty_room_does_not() {
    let (task, generator) = (Task::default(), Generator::planar_nine());
    for (name, is_disturbed) in [("wall", true), ("no metal", false)] {
        let case = cases().into_iter().find(|case| case.name.starts_with(name)).unwrap();
        let set = readings(&case.room(), 120, MeasurementContent::FiveDof, 7);
        let noise = Noise { position_mm: POSITION_NOISE_MM, rotation_rad: ROTATION_NOISE_RAD };
        let rows = Rows::new(&task, &generator, &set).unwrap().over_noise(&noise);
        let folds = Folds::of_rows(rows.len(), 5, 1);
        let found = identification::is_disturbed(&task, &generator, &set, &rows, &folds).unwrap();
        assert_eq!(found, is_disturbed, "{name}");
    }
}

/// Every case, some draws of its noise, as a table in the file `PAGE`: `PAGE=cases.md CASE=3 DRAWS=4`.
#[test]
#[ignore = "minutes; writes the table of the documentation"]
fn page_cases() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<usize>().ok());
    let draws = number("DRAWS").unwrap_or(3) as u64;
    let (mut centers, mut axes) = (Covered::default(), Covered::default());
    let mut page = String::new();
    for (index, case) in cases().iter().enumerate() {
        if number("CASE").is_some_and(|only| only != index) {
            continue;
        }
        let room = case.room();
        for seed in 0..draws {
            let start = std::time::Instant::now();
            let found = case.found(&room, 1000 * (index as u64 + 1) + seed);
            case.count(&found, &mut centers, &mut axes);
            let answers: Vec<String> = found.bodies.iter().map(|b| case.answer(b)).collect();
            page += &format!(
                "| {} | {:.2} | {:?} | {} | {:.1} |\n",
                case.name,
                found.disturbance.position_mm,
                found.verdict,
                answers.join("; "),
                start.elapsed().as_secs_f64(),
            );
        }
    }
    page += &format!("in 95 % intervals: x, y, z {} of {}\n", centers.inside, centers.all);
    page += &format!("axes {} of {}\n", axes.inside, axes.all);
    std::fs::write(std::env::var_os("PAGE").expect("a file of the name PAGE"), page).unwrap();
}
