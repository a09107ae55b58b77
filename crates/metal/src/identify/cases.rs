//! Rooms of known metal, what is found in each, and how often the intervals hold.
//!
//! The truth is independent of what is fitted: meshes are solved for at their surface, spheres by their series.

use super::tests::{POSITION_NOISE_MM, ROTATION_NOISE_RAD, identified, readings};
use super::{FoundBody, Noise};
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

impl Case {
    /// A body beside the nearest piece.
    fn answer(&self, body: &FoundBody) -> String {
        let off = |piece: &&Piece| (body.source.center_mm - Point3::from(piece.center_mm)).norm();
        let Some(piece) = self.pieces.iter().min_by(|a, b| off(a).total_cmp(&off(b))) else {
            return format!("no such body: {body:?}");
        };
        let head = format!(
            "{:?} off {:.1} at {:.0?}",
            body.kind,
            off(&piece),
            body.source.center_mm.coords.as_slice()
        );
        match &body.known {
            Err(doubt) => format!("{head}: {doubt} {doubt:?}"),
            Ok(known) => {
                let inside =
                    (0..3).filter(|&k| known.center_mm[k].contains(piece.center_mm[k])).count();
                let form = known.form.map(|form| {
                    let truth = Vector3::from(piece.z_along).normalize();
                    let angle = form.axis.dot(&truth).abs().min(1.0).acos().to_degrees();
                    format!(
                        "{:?} axis off {angle:.1} ± {:.1}",
                        form.form,
                        form.axis_within95_rad.to_degrees()
                    )
                });
                format!(
                    "{head} ± {:.1}: {inside} of 3, {form:?} {:.0?}",
                    known.half_length_mm, known.strengths_mm3
                )
            }
        }
    }
}

/// Every case, some draws of its noise: `CASE=3 DRAWS=4`.
#[test]
#[ignore = "minutes; prints the table of the documentation"]
fn page_cases() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<usize>().ok());
    let draws = number("DRAWS").unwrap_or(3) as u64;
    for (index, case) in cases().iter().enumerate() {
        if number("CASE").is_some_and(|only| only != index) {
            continue;
        }
        let room = case.room();
        println!("{index}: {}", case.name);
        for seed in 0..draws {
            let set =
                readings(&room, 350, MeasurementContent::FiveDof, 1000 * (index as u64 + 1) + seed);
            let start = std::time::Instant::now();
            let found = identified(&set);
            println!(
                "  {:?} left {:.2} disturbance {:.2} mm noise {:.3} {:.3} {:.1} s {:?} {:?}",
                found.verdict,
                found.unexplained,
                found.disturbance.position_mm,
                found.noise.position_mm / POSITION_NOISE_MM,
                found.noise.rotation_rad / ROTATION_NOISE_RAD,
                start.elapsed().as_secs_f64(),
                found.model,
                found
                    .tried
                    .iter()
                    .map(|t| format!(
                        "{} {:?} {:.3} {:.3}",
                        t.bodies, t.model, t.held_out_loss, t.left
                    ))
                    .collect::<Vec<_>>(),
            );
            if std::env::var("TRUTH").is_ok() {
                let task = Task::default();
                let noise =
                    Noise { position_mm: POSITION_NOISE_MM, rotation_rad: ROTATION_NOISE_RAD };
                let rows = super::rows::Rows::new(&task, &Generator::planar_nine(), &set).unwrap();
                let rows = rows.over_noise(&noise);
                let centers: Vec<_> = case.pieces.iter().map(|p| p.center_mm.into()).collect();
                let w = vec![1.0; rows.len()];
                for known in [false] {
                    let start = super::extended::solve_tensors(&task, &rows, &centers, &w).unwrap();
                    let Some(start) = start else {
                        println!("no tensors");
                        continue;
                    };
                    println!("   tensors {:.1} {:.0?}", start.loss, start.sources);
                    if let Some(s) =
                        super::extended::solve_extended(&task, &rows, &start.extended, &w, known)
                            .unwrap()
                    {
                        println!(
                            "   all {:.1} {:.0?} extent {:.0}",
                            s.loss, s.sources, s.extended[0].extent_mm
                        );
                    }
                }
            }
            for body in &found.bodies {
                println!("    {}", case.answer(body));
            }
        }
    }
}
