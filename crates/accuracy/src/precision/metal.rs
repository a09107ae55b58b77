//! Metal beside a tracker: its triangles, and harmonic functions in the place of its field.

use super::sampling::poses;
use super::{Family, Row, Settings, Steps, What};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use std::error::Error;
use std::sync::Arc;
use trackwright_field::evaluation::Coefficient;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::HarmonicModel;
use trackwright_field::harmonic::solid_harmonics::{gradients, terms};
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;
use trackwright_metal::furnished::Furnisher;
use trackwright_metal::room::MetalRoom;
use trackwright_metal::setup::{
    DEFAULT_TRIANGLES, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};
use trackwright_simulation::Scenario;
use trackwright_task::{Cancelled, Task};

/// Triangles that a plate is cut into at most, from coarse to fine.
const TRIANGLES: [usize; 5] = [100, 200, 500, 1000, 2000];

/// Degrees of the harmonic functions.
const DEGREES: std::ops::RangeInclusive<usize> = 2..=8;

/// Places that harmonic functions are fitted to: 1,200 equations for up to 80 unknowns a coil.
const FITTED: usize = 400;

/// Places of a slice that follows a hand.
const SLICE: [usize; 2] = [20, 15];

/// Poses that one core reads at a time.
const CHUNK: usize = 64;

const MOVED: &str = "a plate that is moved, and its field at 300 places of a slice";

const POSES: &str = "poses in the tracker's cube, a plate 700 mm beside its middle";

/// A plate's field by more and fewer triangles, and by harmonic functions of more and fewer degrees.
pub fn measure(
    scenario: &Scenario,
    settings: &Settings,
    steps: &Steps,
) -> Result<Family, Cancelled> {
    let about = format!(
        "An aluminium plate of 200 x 200 x 10 mm at 10 kHz among the nine dipoles of planar-nine. Moved: \
         the time of a move and of the fields at {} places, on all threads; the error is the largest \
         difference of a position that is reported there from that by {} triangles at most. Poses: \
         read on all threads, with what was sampled, fitted and solved made beforehand; the error is \
         the largest difference of a position from that by the plate's field itself.",
        SLICE[0] * SLICE[1],
        settings.metal_reference
    );
    let mut family = Family::new(What::Metal, about, POSES);
    let room = &scenario.environment.model;
    match rows(room, settings, steps) {
        Ok(rows) => family.rows = rows,
        Err(error) if error.is::<Cancelled>() || steps.task.cancel.is_cancelled() => {
            return Err(Cancelled);
        }
        Err(error) => return Ok(family.without(error.to_string())),
    }
    Ok(family)
}

fn rows(
    room: &DistortionModel,
    settings: &Settings,
    steps: &Steps,
) -> Result<Vec<Row>, Box<dyn Error>> {
    let all = TRIANGLES.len() + DEGREES.count() + 3;
    let task = Task::cancelled_by(steps.task.cancel.clone());
    let mut rows = Vec::new();
    let metal = |most: usize, at: Pose| {
        let plate = MetalObject {
            name: "plate".to_owned(),
            shape: ObjectShape::Cuboid { size_mm: Vector3::new(200.0, 200.0, 10.0) },
            material: ObjectMaterial::Named("aluminium"),
            tracker_from_object: at,
            most_triangles: most,
        };
        RoomMetal { objects: vec![plate], ..RoomMetal::empty(Generator::planar_nine()) }
    };
    let volume = Volume::AuroraCube;
    let ideal = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
    let ideal = Environment { volume: Some(volume), ..Environment::of_model("ideal", ideal) };
    let ideal = Arc::new(ideal);
    let furnished =
        |most: usize, at: Pose| Furnisher::default().furnish(&ideal, &metal(most, at), &task);

    // Beside the cube, within reach of a hand.
    let [from, to] = [-410.0, -400.0].map(|y| Pose::translation(0.0, y, -300.0));
    let places = slice();
    let positions = |room: &MetalRoom| -> Vec<Point3<f64>> {
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
        let read = |p: &Point3<f64>| room.read_axis(p, &axis).map(|reading| reading.position_mm);
        places.iter().map(|p| read(p).unwrap_or(Point3::new(f64::NAN, 0.0, 0.0))).collect()
    };
    let solved = |most: usize| -> Result<Arc<MetalRoom>, Box<dyn Error>> {
        Ok(furnished(most, from)?.room.ok_or("a room without metal")?)
    };
    let exact = positions(&solved(settings.metal_reference)?.with_pose(0, to, &task)?);
    steps.at(1, all)?;
    for (done, most) in TRIANGLES.into_iter().enumerate() {
        if 2 * most > settings.metal_reference {
            continue;
        }
        let solved = solved(most)?;
        let (seconds, moved) = settings.timing.measure(|| {
            let moved = solved.with_pose(0, to, &task)?;
            let fields = moved.disturbances(&places);
            Ok::<_, Box<dyn Error>>((moved, fields.len()))
        });
        let (moved, size) = moved?;
        let found = positions(&moved);
        let errors = found.iter().zip(&exact).map(|(a, b)| (a - b).norm());
        rows.push(Row {
            order: 0,
            directions: 0,
            size,
            seconds,
            error: largest(errors),
            is_default: most == DEFAULT_TRIANGLES,
            is_step: true,
            ..Row::new(What::Metal, room, MOVED, &format!("{most} triangles")).charted("triangles")
        });
        steps.at(2 + done, all)?;
    }

    let made = furnished(DEFAULT_TRIANGLES, Pose::translation(0.0, -700.0, -300.0))?;
    let solved = made.room.ok_or("a room without metal")?;
    let bounds = volume.bounds();
    let (at, axes): (Vec<_>, Vec<_>) =
        poses(&bounds, settings.poses, settings.seed).into_iter().unzip();
    let row = |method: &str, seconds: f64, error: f64| Row {
        order: 0,
        directions: 0,
        size: settings.poses,
        seconds,
        error,
        ..Row::new(What::Metal, room, POSES, method)
    };
    let (seconds, exact) = settings.timing.measure(|| -> Vec<Option<Vector3<f64>>> {
        let read = |(p, n): (&Point3<f64>, &Unit<Vector3<f64>>)| {
            solved.read_axis(p, n).ok().map(|reading| reading.position_mm - p)
        };
        at.par_iter().zip(&axes).map(read).collect()
    });
    rows.push(row("the metal's field itself", seconds, 0.0));
    let error_of = |found: &[Option<Vector3<f64>>]| {
        largest(found.iter().zip(&exact).map(|pair| match pair {
            (Some(a), Some(b)) => (a - b).norm(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        }))
    };
    steps.at(TRIANGLES.len() + 2, all)?;
    let model = &made.environment.model;
    let (seconds, found) = settings.timing.measure(|| -> Vec<Option<Vector3<f64>>> {
        let read = |(p, n): (&Point3<f64>, &Unit<Vector3<f64>>)| {
            let read = model.evaluate(p, n, OutsidePolicy::Clamp);
            read.is_inside.then_some(read.error.position_mm)
        };
        at.par_iter().zip(&axes).map(read).collect()
    });
    let default = row("harmonic where within 0.01 mm, else itself", seconds, error_of(&found));
    rows.push(Row { is_default: true, ..default });
    for (done, degree) in DEGREES.enumerate() {
        let model = fitted(&solved, &bounds, degree, settings.seed)?;
        let (seconds, found) = settings.timing.measure(|| -> Vec<Option<Vector3<f64>>> {
            let read = |(at, axes): (&[Point3<f64>], &[Unit<Vector3<f64>>])| {
                let mut out: Vec<Option<Coefficient>> = vec![None; at.len()];
                model.axis_errors(at, axes, &mut out);
                out.into_iter()
                    .map(|values| values.map(|v| Vector3::new(v[0], v[1], v[2])))
                    .collect::<Vec<_>>()
            };
            let chunks = at.par_chunks(CHUNK).zip(axes.par_chunks(CHUNK));
            chunks.map(read).collect::<Vec<_>>().concat()
        });
        let method = format!("harmonic, degree {degree}");
        rows.push(Row {
            order: degree,
            is_step: true,
            ..row(&method, seconds, error_of(&found)).charted("harmonic")
        });
        steps.at(TRIANGLES.len() + 3 + done, all)?;
    }
    Ok(rows)
}

/// Places across z through the cube's middle.
fn slice() -> Vec<Point3<f64>> {
    let [across, down] = SLICE;
    let place = |k: usize| {
        let (row, column) = (k / across, k % across);
        Point3::new(25.0 * column as f64 - 240.0, 25.0 * row as f64 - 180.0, -300.0)
    };
    (0..across * down).map(place).collect()
}

/// What is no number is the largest.
fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |most, error| if error.is_nan() { f64::INFINITY } else { error.max(most) })
}

/// Harmonic functions that are nearest to the metal's field at places spread over a box.
fn fitted(
    room: &MetalRoom,
    bounds: &Bounds,
    degree: usize,
    seed: u64,
) -> Result<HarmonicModel, Box<dyn Error>> {
    let (center_mm, scale_mm) = (bounds.center_mm(), 0.5 * bounds.diagonal_mm());
    let places: Vec<Point3<f64>> =
        poses(bounds, FITTED, seed + 1).into_iter().map(|(p, _)| p).collect();
    let fields: Vec<Vec<Vector3<f64>>> =
        room.disturbances(&places).into_iter().collect::<Result<_, _>>()?;
    let slopes: Vec<Vec<Vector3<f64>>> = places
        .iter()
        .map(|p| {
            let mut slopes = vec![Vector3::zeros(); terms(degree)];
            gradients(degree, &((p - center_mm) / scale_mm), &mut slopes);
            slopes
        })
        .collect();
    let coils = room.generator().coils.len();
    let matrix = Mat::from_fn(3 * FITTED, terms(degree), |i, j| slopes[i / 3][j][i % 3]);
    let right = Mat::from_fn(3 * FITTED, coils, |i, coil| fields[i / 3][coil][i % 3]);
    let found = matrix.qr().solve_lstsq(&right);
    let coefficients = (0..coils).flat_map(|coil| found.col_as_slice(coil).to_vec()).collect();
    let generator = room.generator().clone();
    Ok(HarmonicModel::new(generator, center_mm, scale_mm, degree, coefficients)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Timing, testing};

    #[test]
    fn errors_fall_with_degree_and_triangles() {
        let settings = Settings { timing: Timing::ONCE, poses: 100, ..Settings::quick() };
        let task = Task::default();
        let family = measure(&testing::built_in(), &settings, &Steps::whole(&task)).unwrap();
        assert_eq!(family.left_out, None);
        let errors = |series: &str| -> Vec<f64> {
            family.rows.iter().filter(|r| r.series == series).map(|r| r.error).collect()
        };
        let (degrees, triangles) = (errors("harmonic"), errors("triangles"));
        assert_eq!((degrees.len(), triangles.len()), (7, 3));
        // The plate is 1.4 of the box's half diagonals away; the largest error is that of one corner.
        assert!(degrees.windows(3).all(|w| w[2] < 0.9 * w[0]), "{degrees:?}");
        assert!(triangles.windows(2).all(|w| w[1] < w[0]), "{triangles:?}");
        let default = family.rows.iter().find(|r| r.is_default && r.problem == POSES).unwrap();
        assert!(default.error < 0.01, "{default:?}");
    }
}
