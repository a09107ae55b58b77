//! How long a plate that is dragged takes: right sides, back substitution, and fields where they are shown.
//!
//! `cargo run --release -p trackwright-metal --example drag [TRIANGLES] [POINTS]`

use nalgebra::{Point3, Vector3};
use std::error::Error;
use std::io::{Write, stdout};
use std::sync::Arc;
use std::time::Instant;
use trackwright_field::generator::Generator;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;
use trackwright_metal::body::{MetalBody, MetalShape};
use trackwright_metal::boundary::BoundaryShape;
use trackwright_metal::material::Material;
use trackwright_metal::room::{MetalRoom, PlacedBody};
use trackwright_metal::shapes::cuboid;
use trackwright_metal::surface::ClosedSurface;
use trackwright_task::Task;

/// Moves of the hand.
const MOVES: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().skip(1).map(|text| text.parse::<usize>());
    let triangles = numbers.next().transpose()?.unwrap_or(1000);
    let count = numbers.next().transpose()?.unwrap_or(300);
    let mut out = stdout().lock();
    let task = Task::default();

    let start = Instant::now();
    let mesh = cuboid(&Vector3::new(200.0, 200.0, 10.0), triangles)?;
    let shape = BoundaryShape::new(ClosedSurface::new(&mesh)?, &task)?;
    writeln!(out, "{} triangles", shape.surface().panels().len())?;
    writeln!(out, "check and integrate: {:.1?}", start.elapsed())?;
    let start = Instant::now();
    let aluminium = Material::named("aluminium").ok_or("no aluminium")?;
    let body = MetalBody::new(MetalShape::Surface(Arc::new(shape)), aluminium, 10e3, &task)?;
    writeln!(out, "factor: {:.1?}", start.elapsed())?;

    let points: Vec<Point3<f64>> = (0..count)
        .map(|k| {
            let (row, column) = (k / 20, k % 20);
            Point3::new(25.0 * column as f64 - 240.0, 25.0 * row as f64 - 180.0, -300.0)
        })
        .collect();
    let body = Arc::new(body);
    for (name, others) in [("one plate", 0), ("two plates", 1)] {
        for generator in [Generator::planar_nine(), Generator::anser()] {
            let coils = generator.name.clone();
            let placed =
                |pose: Pose| PlacedBody { body: Arc::clone(&body), tracker_from_body: pose };
            let mut bodies = vec![placed(Pose::translation(0.0, 0.0, -120.0))];
            if others == 1 {
                bodies.push(placed(Pose::translation(0.0, 260.0, -200.0)));
            }
            let mut room = MetalRoom::new(generator, None, bodies, &task)?;
            // The least of all moves: other programs may run.
            let (mut solving, mut sampling) = (f64::INFINITY, f64::INFINITY);
            for step in 0..MOVES {
                let turn = Vector3::new(0.01, 0.02, 0.0) * step as f64;
                let pose =
                    pose_from_parts(Vector3::new(step as f64, 0.0, -120.0), exp_vector(&turn));
                let start = Instant::now();
                room = room.with_pose(0, pose, &task)?;
                solving = start.elapsed().as_secs_f64().min(solving);
                let start = Instant::now();
                let failed =
                    room.disturbances(&points).iter().filter(|field| field.is_err()).count();
                assert_eq!(failed, 0, "all points are outside");
                sampling = start.elapsed().as_secs_f64().min(sampling);
            }
            let [solving_ms, sampling_ms] = [solving, sampling].map(|t| 1e3 * t);
            let rounds = room.exchange().rounds;
            writeln!(
                out,
                "{name}, {coils}: a move {solving_ms:.1} ms ({rounds} rounds), {count} points {sampling_ms:.1} ms"
            )?;
        }
    }
    Ok(())
}
