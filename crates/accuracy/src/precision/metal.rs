//! Metal beside a tracker: its triangles, and harmonic functions in the place of its field.

use super::sampling::poses;
use super::{Bench, Row, Stop, What};
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
use trackwright_metal::furnished::{Furnished, Furnisher};
use trackwright_metal::room::MetalRoom;
use trackwright_metal::setup::{
    DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};
use trackwright_task::Task;

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

const VOLUME: Volume = Volume::AuroraCube;

const MOVED: &str = "a plate that is moved, and its field at 300 places of a slice";

const POSES: &str = "poses in the tracker's cube, a plate 700 mm beside its middle";

/// A plate's field by more and fewer triangles, and by harmonic functions of more and fewer degrees.
pub fn measure(bench: &mut Bench) -> Result<(), Stop> {
    bench.family.charted = POSES.to_owned();
    bench.family.about = format!(
        "A ferrite plate of 200 x 200 x 10 mm at 10 kHz among the nine dipoles of planar-nine. Moved: \
         the time of a move and of the fields at {} places, on all threads; the error is the largest \
         difference of a position that is reported there from that by {} triangles at most. Poses: \
         read on all threads, with what was sampled, fitted and solved made beforehand; the error is \
         the largest difference of a position from that by the plate's field itself.",
        SLICE[0] * SLICE[1],
        bench.settings.metal_reference
    );
    bench.steps = TRIANGLES.len() + DEGREES.count() + 3;
    moved(bench).map_err(|error| bench.stop(error))?;
    read(bench).map_err(|error| bench.stop(error))
}

/// A room that is ideal but for a plate of so many triangles.
fn furnished(most: usize, at: Pose, task: &Task) -> Result<Furnished, Box<dyn Error>> {
    let plate = MetalObject {
        name: "plate".to_owned(),
        shape: ObjectShape::Cuboid { size_mm: Vector3::new(200.0, 200.0, 10.0) },
        material: ObjectMaterial::Named("ferrite"),
        tracker_from_object: at,
        most_triangles: most,
        tolerance: MaterialTolerance::default(),
    };
    let metal = RoomMetal { objects: vec![plate], ..RoomMetal::empty(Generator::planar_nine()) };
    let ideal = DistortionModel::zero(VOLUME.bounds(), MapKind::Distortion);
    let ideal = Environment { volume: Some(VOLUME), ..Environment::of_model("ideal", ideal) };
    Ok(Furnisher::default().furnish(&Arc::new(ideal), &metal, task)?)
}

/// A row of a plate, whose field has no order and no orientations.
fn row(bench: &Bench, problem: &str, method: &str) -> Row {
    Row { order: 0, directions: 0, ..Row::new(What::Metal, bench.room(), problem, method) }
}

/// The plate moved, by its triangles.
fn moved(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let (settings, task) = (bench.settings, bench.own_task());
    // Beside the cube, within reach of a hand.
    let [from, to] = [-410.0, -400.0].map(|y| Pose::translation(0.0, y, -300.0));
    let places = slice();
    let positions = |room: &MetalRoom| -> Vec<Point3<f64>> {
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
        let read = |p: &Point3<f64>| room.read_axis(p, &axis).map(|reading| reading.position_mm);
        places.iter().map(|p| read(p).unwrap_or(Point3::new(f64::NAN, 0.0, 0.0))).collect()
    };
    let solved = |most: usize| -> Result<Arc<MetalRoom>, Box<dyn Error>> {
        Ok(furnished(most, from, &task)?.room.ok_or("a room without metal")?)
    };
    let exact = positions(&solved(settings.metal_reference)?.with_pose(0, to, &task)?);
    bench.next()?;
    for most in TRIANGLES {
        bench.next()?;
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
        let error = largest(found.iter().zip(&exact).map(|(a, b)| (a - b).norm()));
        let row = row(bench, MOVED, &format!("{most} triangles")).measured(size, seconds, error);
        bench.family.rows.push(row.default_if(most == DEFAULT_TRIANGLES).step_of("triangles"));
    }
    Ok(())
}

/// By how much a sensor at a position along an axis is read off, where it is read.
type Read<'a> = dyn Fn(&Point3<f64>, &Unit<Vector3<f64>>) -> Option<Vector3<f64>> + Sync + 'a;

/// Poses read beside the plate, by its field and by harmonic functions.
fn read(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let settings = bench.settings;
    let at = Pose::translation(0.0, -700.0, -300.0);
    let made = furnished(DEFAULT_TRIANGLES, at, &bench.own_task())?;
    let solved = made.room.ok_or("a room without metal")?;
    let bounds = VOLUME.bounds();
    let (at, axes): (Vec<_>, Vec<_>) =
        poses(&bounds, settings.poses, settings.seed).into_iter().unzip();
    let each = |read: &Read| -> Vec<Option<Vector3<f64>>> {
        at.par_iter().zip(&axes).map(|(p, n)| read(p, n)).collect()
    };
    let by_metal: &Read = &|p, n| solved.read_axis(p, n).ok().map(|read| read.position_mm - p);
    let (seconds, exact) = settings.timing.measure(|| each(by_metal));
    let measured = |row: Row, seconds: f64, found: &[Option<Vector3<f64>>]| {
        let error = largest(found.iter().zip(&exact).map(|pair| match pair {
            (Some(a), Some(b)) => (a - b).norm(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        }));
        row.measured(settings.poses, seconds, error)
    };
    bench.add(measured(row(bench, POSES, "the metal's field itself"), seconds, &exact))?;
    let model = &made.environment.model;
    let by_room: &Read = &|p, n| {
        let read = model.evaluate(p, n, OutsidePolicy::Clamp);
        read.is_inside.then_some(read.error.position_mm)
    };
    let (seconds, found) = settings.timing.measure(|| each(by_room));
    let default = row(bench, POSES, "harmonic where within 0.01 mm, else itself");
    bench.add(measured(default, seconds, &found).default_if(true))?;
    for degree in DEGREES {
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
        let row = row(bench, POSES, &format!("harmonic, degree {degree}")).step_of("harmonic");
        bench.add(Row { order: degree, ..measured(row, seconds, &found) })?;
    }
    Ok(())
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
    use crate::precision::{Settings, testing};

    #[test]
    fn errors_fall_with_degree_and_triangles() {
        let settings = Settings { poses: 100, ..Settings::quick() };
        let family = testing::family(What::Metal, &testing::built_in(), settings);
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
