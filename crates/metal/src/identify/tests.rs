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

fn measured(
    balls: &[Ball],
    count: usize,
    content: MeasurementContent,
    seed: u64,
) -> MeasurementSet {
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
    let truth: Vec<Source> = [ALUMINIUM, FERRITE]
        .iter()
        .map(|b| Source { center_mm: b.center_mm.into(), strength_mm3: b.strength_mm3() })
        .collect();
    for _ in 0..3 {
        let started = std::time::Instant::now();
        let room = sources::room(&rows.generator, &truth).unwrap();
        println!("room {:?} {:?}", started.elapsed(), room.exchange());
        let started = std::time::Instant::now();
        let _ = rows.explained(|p, fields| room.disturbance(p, fields).is_ok());
        println!("fields {:?}", started.elapsed());
        let started = std::time::Instant::now();
        let _ = sources::room(&rows.generator, &truth[..1]).unwrap();
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
        let l: f64 = left.iter().map(|v| v * v).sum::<f64>() / left.len() as f64;
        println!("rms {}", l.sqrt());
        for k in 0..5 {
            let l: f64 = left.iter().skip(k).step_by(5).map(|v| v * v).sum::<f64>() / 1000.0;
            println!("row {k} {}", l.sqrt());
        }
        let started = std::time::Instant::now();
        let s = solve::solve(&task, &rows, model, &truth, &vec![1.0; 1000]).unwrap().unwrap();
        println!("solve {:?} {} {:?}", started.elapsed(), s.loss, s.sources);
    }
    let started = std::time::Instant::now();
    let found = search::search(&task, &rows, 3, &[]).unwrap();
    println!("search {:?}", started.elapsed());
    for f in found {
        println!("{:?} {} {:?} {:?}", f[0].sources, f[0].loss, f[0].model, f.len());
    }
}

#[test]
fn explore_identify() {
    for (name, balls) in [
        ("two", vec![ALUMINIUM, FERRITE]),
        ("none", vec![]),
        ("one", vec![ALUMINIUM]),
        (
            "far",
            vec![Ball {
                material: "aluminium",
                radius_mm: 60.0,
                center_mm: [600.0, 100.0, -300.0],
            }],
        ),
        (
            "farther",
            vec![Ball {
                material: "aluminium",
                radius_mm: 80.0,
                center_mm: [900.0, 100.0, -300.0],
            }],
        ),
    ] {
        let set = measured(&balls, 1000, MeasurementContent::FiveDof, 1);
        let started = std::time::Instant::now();
        let found = identified(&set);
        println!(
            "{name} {:?} {:?} {:?} {:?} {}",
            started.elapsed(),
            found.verdict,
            found.noise,
            found.disturbance,
            found.unexplained
        );
        for t in &found.tried {
            println!("   {t:?}");
        }
        for b in &found.bodies {
            println!("   {:?} {:.2} {:?} {:?}", b.source, b.half_length_mm, b.radius_mm, b.doubt);
        }
    }
}

#[test]
#[ignore = "explores"]
fn long_random() {
    let count: usize = std::env::var("COUNT").unwrap().parse().unwrap();
    let first: usize = std::env::var("FIRST").unwrap().parse().unwrap();
    for seed in first..first + count {
        let mut seeded = Seeded::new(1000 + seed as u64);
        let number = 1 + seed % 3;
        let mut balls: Vec<Ball> = Vec::new();
        while balls.len() < number {
            let c = seeded.position(&volume(), 0.6);
            let radius_mm = 15.0 + 40.0 * seeded.uniform();
            let is_in = (0..3)
                .map(|k| {
                    (volume().min_mm[k] - c[k]).max(c[k] - volume().max_mm[k]).max(0.0).powi(2)
                })
                .sum::<f64>()
                .sqrt()
                < radius_mm;
            let at_coil = c.z > -60.0 - radius_mm;
            let cuts = balls
                .iter()
                .any(|b| (Point3::from(b.center_mm) - c).norm() < b.radius_mm + radius_mm + 10.0);
            if is_in || at_coil || cuts {
                continue;
            }
            let material = if seeded.uniform() < 0.5 { "aluminium" } else { "ferrite" };
            balls.push(Ball { material, radius_mm, center_mm: c.coords.into() });
        }
        let set = measured(&balls, 1000, MeasurementContent::FiveDof, seed as u64);
        let started = std::time::Instant::now();
        let found = identified(&set);
        println!(
            "seed {seed}: {:?} {} true, {} found, {:.1} s, {:?} {:.3}",
            found.verdict,
            number,
            found.bodies.len(),
            started.elapsed().as_secs_f64(),
            found.model,
            found.unexplained
        );
        for ball in &balls {
            let c = Point3::from(ball.center_mm);
            let near = found.bodies.iter().min_by(|a, b| {
                (a.source.center_mm - c).norm().total_cmp(&(b.source.center_mm - c).norm())
            });
            let Some(near) = near else {
                println!(
                    "   {:?} {:.0} {:.0?}: nothing",
                    ball.material, ball.radius_mm, ball.center_mm
                );
                continue;
            };
            let d = near.source.center_mm - c;
            let m2 =
                near.center_cov_mm2.try_inverse().map_or(f64::NAN, |i| (d.transpose() * i * d)[0]);
            let ins: Vec<bool> = (0..3).map(|k| near.center_mm[k].contains(c[k])).collect();
            println!(
                "   {:?} {:.0} {:.0?}: off {:.1} mm, half {:.1}, m2 {:.2}, in {ins:?} strength {:.0} {:?} {} doubt {:?}",
                ball.material,
                ball.radius_mm,
                ball.center_mm,
                d.norm(),
                near.half_length_mm,
                m2,
                ball.strength_mm3(),
                near.strength_mm3,
                near.strength_mm3.contains(ball.strength_mm3()),
                near.doubt
            );
        }
    }
}
