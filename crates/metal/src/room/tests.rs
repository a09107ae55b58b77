//! Rooms of one and several bodies against series and fresh solves.

use super::*;
use crate::body::MetalBody;
use crate::boundary::BoundaryShape;
use crate::boundary::rings::ring;
use crate::material::Material;
use crate::shapes::{cuboid, cylinder, sphere};
use crate::sphere::SphereResponse;
use crate::sphere::rule::spherical_rule;
use crate::surface::ClosedSurface;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::pose_from_parts;
use trackwright_geometry::rotation::exp_vector;

pub(super) fn task() -> Task {
    Task::default()
}

pub(super) fn shape(mesh: &SurfaceMesh) -> MetalShape {
    let surface = ClosedSurface::new(mesh).unwrap();
    MetalShape::Surface(Arc::new(BoundaryShape::new(surface, &task()).unwrap()))
}

const FAST_HZ: f64 = 1e7;

/// A conductor whose skin is 5 µm deep.
pub(super) fn conductor(shape: MetalShape) -> Arc<MetalBody> {
    Arc::new(MetalBody::new(shape, Material::new(1e9, 1.0).unwrap(), FAST_HZ, &task()).unwrap())
}

fn magnetic(shape: MetalShape, mu: f64) -> Arc<MetalBody> {
    Arc::new(MetalBody::new(shape, Material::new(0.0, mu).unwrap(), FAST_HZ, &task()).unwrap())
}

pub(super) fn at(position_mm: [f64; 3], turn_rad: [f64; 3]) -> Pose {
    pose_from_parts(position_mm.into(), exp_vector(&turn_rad.into()))
}

pub(super) fn placed(body: &Arc<MetalBody>, tracker_from_body: Pose) -> PlacedBody {
    PlacedBody { body: Arc::clone(body), tracker_from_body }
}

pub(super) fn room(bodies: Vec<PlacedBody>) -> MetalRoom {
    MetalRoom::new(Generator::planar_nine(), None, bodies, &task()).unwrap()
}

fn fields(room: &MetalRoom, p: &Point3<f64>) -> Vec<Vector3<f64>> {
    let mut fields = vec![Vector3::zeros(); room.generator().coils.len()];
    room.disturbance(p, &mut fields).unwrap();
    fields
}

/// Largest difference of a coil's field, relative to the coils' largest field.
fn difference(one: &[Vector3<f64>], other: &[Vector3<f64>]) -> f64 {
    let largest = other.iter().map(Vector3::norm).fold(0.0, f64::max);
    one.iter().zip(other).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / largest
}

const POINTS: [[f64; 3]; 3] = [[20.0, 30.0, -180.0], [-90.0, 60.0, -260.0], [150.0, -40.0, -320.0]];

#[test]
fn a_sphere_in_a_room_is_its_series() {
    let material = Material::named("steel-416").unwrap();
    let body =
        MetalBody::new(MetalShape::Sphere { radius_mm: 40.0 }, material, 5e3, &task()).unwrap();
    let pose = at([60.0, -20.0, -120.0], [0.4, 0.2, -0.9]);
    let room = room(vec![placed(&Arc::new(body), pose)]);
    let response = SphereResponse::new(40.0, &material, 5e3).unwrap();

    for p in POINTS.map(Point3::from) {
        let coils = room.generator().coils.iter();
        let expected: Vec<Vector3<f64>> = coils
            .map(|coil| {
                let Coil::Dipole { at_mm, moment } = coil else { panic!("a dipole") };
                let shift = pose.translation.vector;
                response.field_of_dipole(&(at_mm - shift), moment, &(p - shift)).unwrap().field
            })
            .collect();
        // What the degree leaves out on the surface, less at a distance.
        let error = difference(&fields(&room, &p), &expected);
        assert!(error < 1e-7, "{error:e}");
    }
}

#[test]
fn an_empty_room_reports_true_poses() {
    let room = room(Vec::new());
    let pose = at([20.0, 30.0, -200.0], [0.1, 0.2, 0.3]);
    assert_eq!(room.read_pose(&pose).unwrap().tracker_from_sensor, pose);
    assert_eq!(room.exchange().rounds, 0);
}

#[test]
fn two_spheres_let_no_flux_in() {
    let body = conductor(MetalShape::Sphere { radius_mm: 30.0 });
    let middles = [[20.0, 0.0, -120.0], [75.0, 10.0, -150.0]];
    let room = room(middles.map(|middle| placed(&body, at(middle, [0.0; 3]))).to_vec());
    assert!((3..20).contains(&room.exchange().rounds), "{:?}", room.exchange());
    let mut empty = vec![Vector3::zeros(); 9];
    let (mut through, mut along) = (0.0_f64, 0.0_f64);
    for middle in middles {
        for (direction, _) in spherical_rule(9) {
            let p = Point3::from(middle) + direction.into_inner() * (30.0 * (1.0 + 1e-9));
            room.generator().field(&p, &mut empty);
            for (own, added) in empty.iter().zip(fields(&room, &p)) {
                through = through.max((own + added).dot(&direction).abs());
                along = along.max(own.norm());
            }
        }
    }
    // The series ends where the gap of 5 mm leaves 10⁻³ of a term; skin depth lets 0.2 % in.
    assert!(through < 5e-3 * along, "{through:e} {along:e}");
}

#[test]
fn meshed_spheres_exchange_as_series_do() {
    let (ball, mesh) = (MetalShape::Sphere { radius_mm: 30.0 }, shape(&sphere(30.0, 2).unwrap()));
    let poses = [at([20.0, 0.0, -120.0], [0.0; 3]), at([85.0, 10.0, -150.0], [0.5, 0.1, 0.3])];
    let both = |one: &Arc<MetalBody>, other: &Arc<MetalBody>| {
        room(vec![placed(one, poses[0]), placed(other, poses[1])])
    };
    for (make, most) in [
        // 1,280 triangles have a quarter of it: 0.15 and 0.3 %.
        (&conductor as &dyn Fn(MetalShape) -> Arc<MetalBody>, 0.01),
        (&|shape| magnetic(shape, 100.0), 0.016),
    ] {
        let (exact, meshed) = (make(ball.clone()), make(mesh.clone()));
        let series = both(&exact, &exact);
        let alone = [0, 1].map(|k| room(vec![placed(&exact, poses[k])]));
        for other in [both(&meshed, &meshed), both(&exact, &meshed)] {
            for p in POINTS.map(Point3::from) {
                let expected = fields(&series, &p);
                let error = difference(&fields(&other, &p), &expected);
                assert!(error < most, "{error}");
                // Without exchange it is 5 to 15 % off.
                let [one, two] = alone.each_ref().map(|room| fields(room, &p));
                let sum: Vec<_> = one.iter().zip(&two).map(|(a, b)| a + b).collect();
                let without = difference(&sum, &expected);
                assert!(without > 5.0 * error, "{without} {error}");
            }
        }
    }
}

#[test]
fn moved_with_factors_kept_is_a_fresh_solve() {
    let mesh = cuboid(&Vector3::new(120.0, 80.0, 10.0), 400).unwrap();
    let pin = conductor(shape(&cylinder(6.0, 90.0, 200).unwrap()));
    let pin_pose = at([-70.0, 30.0, -160.0], [0.2, 0.9, 0.1]);
    let first = at([60.0, 0.0, -120.0], [0.1, 0.0, 0.0]);
    let second = at([30.0, -40.0, -200.0], [0.7, -0.4, 1.1]);
    let plate = conductor(shape(&mesh));
    let moved = room(vec![placed(&plate, first), placed(&pin, pin_pose)])
        .with_pose(0, second, &task())
        .unwrap();
    // A plate whose corners are where the move puts them, with factors of its own.
    let mut there = mesh;
    there.parts[0].positions_mm.iter_mut().for_each(|p| *p = second * *p);
    let there = conductor(shape(&there));
    let fresh = room(vec![placed(&there, Pose::identity()), placed(&pin, pin_pose)]);
    let again = room(vec![placed(&plate, second), placed(&pin, pin_pose)]);
    for p in [[0.0, 60.0, -180.0], [-90.0, 60.0, -260.0], [150.0, -40.0, -320.0]] {
        let found = fields(&moved, &p.into());
        let error = difference(&found, &fields(&fresh, &p.into()));
        // Round-off decides how the quadrangles of layers are cut.
        assert!(error < 2e-3, "{error:e}");
        assert_eq!(found, fields(&again, &p.into()));
    }
}

#[test]
fn a_turned_room_has_turned_fields() {
    let turn = at([30.0, -400.0, 90.0], [0.8, -1.1, 0.4]);
    let bodies = vec![
        placed(
            &magnetic(shape(&cylinder(6.0, 90.0, 200).unwrap()), 50.0),
            at([-70.0, 30.0, -160.0], [0.2, 0.9, 0.1]),
        ),
        placed(
            &conductor(MetalShape::Sphere { radius_mm: 25.0 }),
            at([50.0, 0.0, -140.0], [0.0; 3]),
        ),
    ];
    let mut generator = Generator::planar_nine();
    for coil in &mut generator.coils {
        if let Coil::Dipole { at_mm, moment } = coil {
            (*at_mm, *moment) = (turn * *at_mm, turn.rotation * *moment);
        }
    }
    let turned_bodies = bodies.iter().cloned().map(|mut placed| {
        placed.tracker_from_body = turn * placed.tracker_from_body;
        placed
    });
    let turned = MetalRoom::new(generator, None, turned_bodies.collect(), &task()).unwrap();
    let room = room(bodies);
    for p in POINTS.map(Point3::from) {
        let expected: Vec<_> = fields(&room, &p).iter().map(|f| turn.rotation * f).collect();
        // Points of a sphere's rule are others in a turned room.
        let error = difference(&fields(&turned, &(turn * p)), &expected);
        assert!(error < 1e-7, "{error:e}");
    }
}

#[test]
fn rooms_that_cannot_be_are_refused() {
    let error = |volume: Option<Volume>, bodies: Vec<PlacedBody>| {
        MetalRoom::new(Generator::anser(), volume, bodies, &task()).unwrap_err()
    };
    let ball = conductor(MetalShape::Sphere { radius_mm: 20.0 });
    let still = |p: [f64; 3]| at(p, [0.0; 3]);
    let box_of = |min: [f64; 3], max: [f64; 3]| {
        Some(Volume::Box(Bounds { min_mm: min.into(), max_mm: max.into() }))
    };
    let low = [-100.0, -100.0, -300.0];
    assert_eq!(error(box_of(low, [100.0, 100.0, 10.0]), Vec::new()), RoomError::CoilInVolume(0));
    let volume = box_of(low, [100.0, 100.0, -50.0]);
    let in_middle = vec![placed(&ball, still([0.0, 5.0, -170.0]))];
    assert_eq!(error(volume, in_middle), RoomError::MetalInVolumeCenter(0));
    // A wire of the loop at (0, 68.55), whose side is 70 mm.
    let on_wire = vec![placed(&ball, still([0.0, 33.55, -10.0]))];
    assert_eq!(error(None, on_wire), RoomError::MetalCutsGenerator { body: 0, coil: 1 });
    // Foil and a pin between the points at which wires are looked at.
    let foil = conductor(shape(&cuboid(&Vector3::new(0.5, 30.0, 30.0), 100).unwrap()));
    let pin = conductor(MetalShape::Sphere { radius_mm: 0.5 });
    for thin in [foil, pin] {
        let across = vec![placed(&thin, still([2.0, 33.55, 0.0]))];
        assert_eq!(error(None, across), RoomError::MetalCutsGenerator { body: 0, coil: 1 });
    }
    let strange = error(box_of([f64::NAN, -100.0, -300.0], [100.0; 3]), Vec::new());
    assert!(matches!(strange, RoomError::Volume(_)), "{strange}");
    let row = (0..9).map(|k| Coil::Dipole {
        at_mm: Point3::new(30.0 * f64::from(k), 0.0, 0.0),
        moment: Vector3::z(),
    });
    let row = Generator { name: "row".to_owned(), coils: row.collect() };
    let error_of_row = MetalRoom::new(row, volume, Vec::new(), &task()).unwrap_err();
    assert!(matches!(error_of_row, RoomError::Determination(_)), "{error_of_row}");
    let mut nowhere = still([0.0, 0.0, -100.0]);
    nowhere.translation.vector.y = f64::NAN;
    assert_eq!(error(None, vec![placed(&ball, nowhere)]), RoomError::Pose(0));
    let (first, second) = (0, 1);
    let plate = conductor(shape(&cuboid(&Vector3::new(100.0, 100.0, 10.0), 100).unwrap()));
    for other in [&ball, &plate] {
        for one in [&ball, &plate] {
            let overlap = vec![
                placed(one, still([0.0, 0.0, -100.0])),
                placed(other, at([30.0, 10.0, -104.0], [0.1, 0.2, 0.1])),
            ];
            assert_eq!(error(None, overlap), RoomError::BodiesTouch { first, second });
        }
    }
    let slow = MetalBody::new(ball.shape().clone(), *ball.material(), 50.0, &task()).unwrap();
    let slow = Arc::new(slow);
    let frequencies =
        vec![placed(&ball, still([0.0, 0.0, -100.0])), placed(&slow, still([90.0, 0.0, -100.0]))];
    let expected = RoomError::Frequencies { body: 1, frequency_hz: 50.0, first_hz: FAST_HZ };
    assert_eq!(error(None, frequencies), expected);
}

#[test]
fn points_without_a_field_are_refused() {
    let body = conductor(shape(&cuboid(&Vector3::repeat(40.0), 100).unwrap()));
    let room = room(vec![placed(&body, at([0.0, 0.0, -150.0], [0.0, 0.4, 0.0]))]);
    let mut fields = vec![Vector3::zeros(); 9];
    let inside = Point3::new(5.0, 0.0, -150.0);
    assert_eq!(room.disturbance(&inside, &mut fields), Err(PointError::InMetal(0)));
    assert_eq!(room.read_axis(&inside, &Vector3::x_axis()), Err(PointError::InMetal(0)));
    for strange in [f64::NAN, f64::INFINITY, 1e7] {
        let p = Point3::new(strange, 0.0, -150.0);
        assert_eq!(room.disturbance(&p, &mut fields), Err(PointError::Position));
    }
    let near = room.nearest_surface(&Point3::new(0.0, 30.0, -150.0)).unwrap();
    assert!((near.distance_mm - 10.0).abs() < 1e-12 && near.panel_mm < 15.0, "{near:?}");
    let many = room.disturbances(&[inside, Point3::new(60.0, 0.0, -150.0)]);
    assert!(many[0].is_err() && many[1].is_ok());
}

#[test]
fn poses_beside_strong_metal_are_right_or_errors() {
    // Beside iron as large as the generator signals are those of poses far away, or of none.
    let iron = magnetic(MetalShape::Sphere { radius_mm: 150.0 }, 1e4);
    let room = room(vec![placed(&iron, at([0.0, 0.0, -170.0], [0.0; 3]))]);
    let (mut errors, mut no_convergence) = (0, 0);
    for (direction, _) in spherical_rule(12) {
        let p = Point3::new(0.0, 0.0, -170.0) + direction.into_inner() * 151.0;
        let axis = Unit::new_normalize(Vector3::new(direction.y, 0.3, direction.x));
        let Ok(reading) = room.read_axis(&p, &axis) else {
            errors += 1;
            let error = room.read_axis(&p, &axis).unwrap_err();
            let not_converged =
                matches!(error, PointError::Reading(ReadingError::NoConvergence { .. }));
            no_convergence += usize::from(not_converged);
            continue;
        };
        // Where it is the nearest, no small motion makes it nearer.
        let mut disturbed = fields(&room, &p);
        room.generator().coils.iter().zip(&mut disturbed).for_each(|(c, d)| *d += c.field(&p));
        let residual = |q: Point3<f64>| -> f64 {
            let coils = room.generator().coils.iter().zip(&disturbed);
            coils.map(|(c, d)| (c.field(&q).dot(&reading.axis) - d.dot(&axis)).powi(2)).sum()
        };
        let least = residual(reading.position_mm);
        for k in 0..3 {
            for step in [0.01, -0.01] {
                let there = residual(reading.position_mm + Vector3::ith(k, step));
                assert!(there >= least * (1.0 - 1e-9), "{p} {reading:?}");
            }
        }
    }
    assert!(errors > 0 && no_convergence > 0, "{errors} {no_convergence}");
}

#[test]
fn a_room_can_be_cancelled() {
    let plate = conductor(shape(&cuboid(&Vector3::new(100.0, 100.0, 10.0), 100).unwrap()));
    let task = task();
    task.cancel.cancel();
    let bodies = vec![placed(&plate, at([0.0, 0.0, -100.0], [0.0; 3]))];
    let error = MetalRoom::new(Generator::anser(), None, bodies, &task).unwrap_err();
    assert_eq!(error, RoomError::Cancelled(Cancelled));
}

#[test]
fn nearer_spheres_take_more_rounds() {
    let ball = magnetic(MetalShape::Sphere { radius_mm: 20.0 }, 1000.0);
    let rounds = [20.0, 5.0, 1.0].map(|gap_mm: f64| {
        let middles = [-20.0 - 0.5 * gap_mm, 20.0 + 0.5 * gap_mm];
        let poses = middles.map(|x| at([x, 0.0, -150.0], [0.0; 3]));
        room(poses.map(|pose| placed(&ball, pose)).to_vec()).exchange().rounds
    });
    // Measured: 5, 6 and 9.
    assert!(rounds.is_sorted() && rounds[0] < 7 && rounds[2] < 12, "{rounds:?}");
}

/// Errors of a meshed sphere of 60 mm at distances from its surface, relative to the exact field there.
fn meshed_errors<const N: usize>(
    mesh: &MetalShape,
    material: Material,
    frequency_hz: f64,
    gaps_mm: [f64; N],
) -> [f64; N] {
    let pose = at([30.0, -20.0, -140.0], [0.0; 3]);
    let [exact, meshed] = [MetalShape::Sphere { radius_mm: 60.0 }, mesh.clone()].map(|shape| {
        let body = MetalBody::new(shape, material, frequency_hz, &task()).unwrap();
        room(vec![placed(&Arc::new(body), pose)])
    });
    gaps_mm.map(|gap_mm| {
        let (mut wrong, mut whole) = (0.0, 0.0);
        for (direction, weight) in spherical_rule(9) {
            let p = pose * Point3::from(direction.into_inner() * (60.0 + gap_mm));
            for (found, expected) in fields(&meshed, &p).iter().zip(fields(&exact, &p)) {
                wrong += weight * (found - expected).norm_squared();
                whole += weight * expected.norm_squared();
            }
        }
        (wrong / whole).sqrt()
    })
}

#[test]
fn fields_near_metal_are_within_a_percent() {
    let mesh = shape(&sphere(60.0, 3).unwrap());
    let ideal = Material::new(1e9, 1.0).unwrap();
    let iron = Material::new(0.0, 100.0).unwrap();
    for material in [ideal, iron] {
        let errors = meshed_errors(&mesh, material, FAST_HZ, [5.0, 1.0]);
        // Panels of 5.4 mm: one size off 0.4 and 0.8 %, a fifth of that 3 %.
        assert!(errors[0] < 0.01 && errors[1] < 0.04, "{material:?} {errors:?}");
    }
}

#[test]
fn fields_at_any_skin_depth_are_within_a_percent() {
    let mesh = shape(&sphere(60.0, 2).unwrap());
    let of = |key: &str| Material::named(key).unwrap();
    // Skins of 7, 22 and 0.2 % of the radius, panels of 11 mm: half a size off, and one radius.
    for (material, frequency_hz) in
        [(of("steel-304"), 1e4), (of("steel-304"), 1e3), (of("steel-416"), 1e4)]
    {
        let errors = meshed_errors(&mesh, material, frequency_hz, [60.0, 5.0]);
        assert!(errors[0] < 0.01 && errors[1] < 0.05, "{frequency_hz} {errors:?}");
    }
}

#[test]
fn rings_beside_each_other_answer_as_one_body() {
    let copper = Material::named("copper").unwrap();
    let [lower, upper] = [-20.0, 20.0].map(|z_mm| {
        let mut mesh = ring([40.0, 60.0, 12.0], 14, [2, 1]);
        mesh.parts[0].positions_mm.iter_mut().for_each(|p| p.z += z_mm);
        mesh
    });
    let mut joined = lower.clone();
    joined.parts.extend(upper.parts.clone());
    let [lower, upper, joined] = [lower, upper, joined].map(|mesh| {
        let body = MetalBody::new(shape(&mesh), copper, 1e4, &task()).unwrap();
        placed(&Arc::new(body), at([30.0, 20.0, -150.0], [0.3, -0.2, 0.0]))
    });
    let alone = room(vec![lower.clone()]);
    let (apart, joined) = (room(vec![lower, upper]), room(vec![joined]));
    for p in [[20.0, 30.0, -250.0], [40.0, 10.0, -150.0]].map(Point3::from) {
        let [alone, apart, joined] = [&alone, &apart, &joined].map(|room| fields(room, &p));
        let off = difference(&apart, &joined);
        assert!(off < 0.01 && difference(&alone, &joined) > 0.1, "{p} {off}");
    }
}

#[test]
fn nothing_may_be_in_a_hole() {
    let conductor = |mesh: &SurfaceMesh| conductor(shape(mesh));
    let still = |p: [f64; 3]| at(p, [0.0; 3]);
    let around = conductor(&ring([40.0, 60.0, 10.0], 14, [1, 1]));
    let rod = conductor(&cylinder(5.0, 60.0, 60).unwrap());
    let error = |bodies: Vec<PlacedBody>| {
        MetalRoom::new(Generator::planar_nine(), None, bodies, &task()).unwrap_err()
    };
    let through =
        vec![placed(&rod, still([0.0, 0.0, -200.0])), placed(&around, still([0.0, 0.0, -200.0]))];
    assert_eq!(error(through), RoomError::BodyInHole { body: 1, other: 0 });
    let ball = Arc::new(
        MetalBody::new(
            MetalShape::Sphere { radius_mm: 9.0 },
            Material::new(1e9, 1.0).unwrap(),
            FAST_HZ,
            &task(),
        )
        .unwrap(),
    );
    let with_ball =
        vec![placed(&around, still([0.0, 0.0, -200.0])), placed(&ball, still([0.0, 5.0, -203.0]))];
    assert_eq!(error(with_ball), RoomError::BodyInHole { body: 0, other: 1 });
    // A square loop of 70 mm whose sides go up through the ring, one by one.
    let coils = (0..6).map(|k| Coil::SquareLoop {
        center_mm: Point3::new(35.0 + 200.0 * f64::from(k), 0.0, 0.0),
        normal: Vector3::y_axis(),
        side_mm: 70.0,
    });
    let generator = Generator { name: "upright".to_owned(), coils: coils.collect() };
    let bodies = vec![placed(&around, still([0.0, 0.0, -10.0]))];
    let error = MetalRoom::new(generator, None, bodies, &task()).unwrap_err();
    assert_eq!(error, RoomError::CoilInHole { body: 0, coil: 0 });
}
