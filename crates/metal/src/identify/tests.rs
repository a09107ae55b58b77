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
    let found = identified(&set);
    println!("{:#?} {:?}", found, started.elapsed());
    println!("{} {}", ALUMINIUM.strength_mm3(), FERRITE.strength_mm3());
}
