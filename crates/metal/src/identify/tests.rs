//! Known bodies found again in simulated measurements.

use super::*;
use crate::body::{MetalBody, MetalShape};
use crate::material::Material;
use crate::room::{MetalRoom, PlacedBody};
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_field::random_models::Seeded;
use trackwright_field::samples::{Measurement, MeasurementContent, MeasurementSet};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::axis_rotation;
use trackwright_geometry::rotation::exp_vector;
use trackwright_task::Task;

/// A tracker like an Aurora.
const POSITION_NOISE_MM: f64 = 0.2;
const ROTATION_NOISE_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;

/// At 10 kHz.
struct Ball {
    material: &'static str,
    radius_mm: f64,
    center_mm: [f64; 3],
}

const ALUMINIUM: Ball =
    Ball { material: "aluminium", radius_mm: 45.0, center_mm: [210.0, 40.0, -190.0] };
const FERRITE: Ball =
    Ball { material: "ferrite", radius_mm: 30.0, center_mm: [-190.0, -90.0, -260.0] };

impl Ball {
    fn placed(&self) -> PlacedBody {
        let material = Material::named(self.material).unwrap();
        let shape = MetalShape::Sphere { radius_mm: self.radius_mm };
        let [x, y, z] = self.center_mm;
        PlacedBody {
            body: Arc::new(MetalBody::new(shape, material, 1e4).unwrap()),
            tracker_from_body: Pose::translation(x, y, z),
        }
    }

    /// `f a³`.
    fn strength_mm3(&self) -> f64 {
        let material = Material::named(self.material).unwrap();
        let factor = crate::sphere::sphere_factor(self.radius_mm, &material, 1e4).unwrap();
        factor.re * self.radius_mm.powi(3)
    }
}

/// Positions of a volume of 300 mm.
fn volume() -> Bounds {
    Bounds::from(([-150.0, -150.0, -400.0], [150.0, 150.0, -100.0]))
}

fn measured(balls: &[Ball], count: usize, content: MeasurementContent, seed: u64) -> MeasurementSet {
    let placed = balls.iter().map(Ball::placed).collect();
    let room = MetalRoom::new(Generator::planar_nine(), None, placed).unwrap();
    let mut seeded = Seeded::new(seed);
    let mut one = || loop {
        let pose = seeded.pose(&volume(), 0.0);
        let p = Point3::from(pose.translation.vector);
        let read = match content {
            MeasurementContent::SixDof => match room.read_pose(&pose) {
                Ok(read) => read.tracker_from_sensor,
                Err(_) => continue,
            },
            _ => match room.read_axis(&p, &(pose.rotation * Vector3::z_axis())) {
                Ok(read) => {
                    let axis = pose.rotation * Vector3::z_axis();
                    let turn = exp_vector(&axis_rotation(&axis, &read.axis).vector_rad);
                    pose_from_parts(read.position_mm.coords, turn * pose.rotation)
                }
                Err(_) => continue,
            },
        };
        let measured = seeded.around(&read, POSITION_NOISE_MM, ROTATION_NOISE_RAD);
        return Measurement { tracker_from_ideal: pose, tracker_from_measured: measured };
    };
    MeasurementSet { measurements: (0..count).map(|_| one()).collect(), content }
}

fn identified(set: &MeasurementSet) -> Identification {
    let settings = IdentifySettings::default();
    identify(&Task::default(), &Generator::planar_nine(), set, &settings).unwrap()
}

#[test]
fn explore() {
    let started = std::time::Instant::now();
    let set = measured(&[ALUMINIUM, FERRITE], 1000, MeasurementContent::FiveDof, 1);
    println!("simulated {:?}", started.elapsed());
    let task = Task::default();
    let generator = Generator::planar_nine();
    let rows = rows::Rows::new(&task, &generator, &set).unwrap();
    let noise = Noise { position_mm: 0.2, rotation_rad: 0.2_f64.to_radians() };
    let rows = rows.over_noise(&noise);
    let started = std::time::Instant::now();
    let truth: Vec<Source> = [ALUMINIUM, FERRITE].iter().map(|b| Source { center_mm: b.center_mm.into(), strength_mm3: b.strength_mm3() }).collect();
    for _ in 0..3 {
        let started = std::time::Instant::now();
        let room = sources::room(&rows, &truth).unwrap();
        println!("room {:?} {:?}", started.elapsed(), room.exchange());
        let started = std::time::Instant::now();
        let _ = rows.explained(|p, fields| room.disturbance(p, fields).is_ok());
        println!("fields {:?}", started.elapsed());
        let started = std::time::Instant::now();
        let _ = sources::room(&rows, &truth[..1]).unwrap();
        println!("one room {:?}", started.elapsed());
    }
    for model in [SourceModel::Dipoles, SourceModel::Spheres] {
        let started = std::time::Instant::now();
        let e = model.explained(&rows, &truth).unwrap();
        println!("explained {:?}", started.elapsed());
        let started = std::time::Instant::now();
        let _ = model.slopes(&rows, &truth, &e).unwrap();
        println!("slopes {:?}", started.elapsed());
        let left = rows.left(&e);
        println!("{:?}", Noise::of(&left, 5, 0.0));
        let l: f64 = left.iter().map(|v| v*v).sum::<f64>() / left.len() as f64;
        println!("rms {}", l.sqrt());
        for k in 0..5 { let l: f64 = left.iter().skip(k).step_by(5).map(|v| v*v).sum::<f64>() / 1000.0; println!("row {k} {}", l.sqrt()); }
        let started = std::time::Instant::now();
        let s = solve::solve(&task, &rows, model, &truth, &vec![1.0; 1000]).unwrap().unwrap();
        println!("solve {:?} {} {:?}", started.elapsed(), s.loss, s.sources);
    }
    let started = std::time::Instant::now();
    let found = search::search(&task, &rows, 3, &[]).unwrap();
    println!("search {:?}", started.elapsed());
    for f in found { println!("{:?} {} {:?} {:?}", f[0].sources, f[0].loss, f[0].model, f.len()); }
}

#[test]
fn explore_identify() {
    for (name, balls) in [("two", vec![ALUMINIUM, FERRITE]), ("none", vec![]), ("one", vec![ALUMINIUM]),
        ("far", vec![Ball { material: "aluminium", radius_mm: 60.0, center_mm: [600.0, 100.0, -300.0] }]),
        ("farther", vec![Ball { material: "aluminium", radius_mm: 80.0, center_mm: [900.0, 100.0, -300.0] }]),
    ] {
        let set = measured(&balls, 1000, MeasurementContent::FiveDof, 1);
        let started = std::time::Instant::now();
        let found = identified(&set);
        println!("{name} {:?} {:?} {:?} {:?} {}", started.elapsed(), found.verdict, found.noise, found.disturbance, found.unexplained);
        for t in &found.tried { println!("   {t:?}"); }
        for b in &found.bodies { println!("   {:?} {:.2} {:?} {:?}", b.source, b.half_length_mm, b.radius_mm, b.doubt); }
    }
}
