//! Sensors near metal, and metal that nearly touches: boundary elements against series and multipoles.

use super::prelude::*;
use nalgebra::Vector3;
use std::sync::Arc;
use trackwright_field::generator::{Coil, Generator};
use trackwright_metal::body::{MetalBody, MetalShape};
use trackwright_metal::boundary::BoundaryShape;
use trackwright_metal::material::Material;
use trackwright_metal::room::{MetalRoom, PlacedBody};
use trackwright_metal::shapes;
use trackwright_metal::sphere::SphereResponse;
use trackwright_metal::surface::ClosedSurface;
use trackwright_task::Task;

const FIELD: &str = "field, root mean square relative to it";

/// Relative permeability of what is not a conductor.
const MU: f64 = 100.0;

/// What a sphere's multipoles leave out of the field on its surface.
const MULTIPOLES: f64 = 1e-6;

/// A frequency at which a good conductor lets no flux in.
const FAST_HZ: f64 = 1e7;

/// A body or room, or why there is none.
type Metal<T> = Result<T, Box<dyn std::error::Error>>;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Conductor,
    Permeable,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Conductor => "no flux",
            Self::Permeable => "permeability 100",
        }
    }

    fn material(self) -> Metal<Material> {
        Ok(match self {
            Self::Conductor => Material::new(1e9, 1.0)?,
            Self::Permeable => Material::new(0.0, MU)?,
        })
    }

    fn body(self, shape: MetalShape) -> Metal<Arc<MetalBody>> {
        Ok(Arc::new(MetalBody::new(shape, self.material()?, FAST_HZ, &Task::default())?))
    }
}

/// What field is compared.
#[derive(Clone, Copy)]
enum Compared {
    /// Beside a sphere of triangles, with its series.
    Mesh,
    /// Beside a sphere by its multipoles, with its series.
    Multipoles,
    /// Between two meshed spheres, with that of two spheres.
    Pair,
}

pub(super) fn family(extent: Extent) -> Family {
    // Triangles of 5.4 and 11 mm; bounds as far from the surface as that, a fifth as far, and of pairs.
    let (subdivisions, size_mm, bounds) =
        extent.of((3, 5.0, [0.012, 0.05, 0.02]), (2, 10.0, [0.03, 0.09, 0.04]));
    let meshed = |gap_mm: f64| {
        format!("a sphere of {} triangles, {gap_mm} mm off it", 20 << (2 * subdivisions))
    };
    let pair = |gap_mm: f64| format!("two meshed spheres {gap_mm} mm apart");
    let multipoles = "a sphere by its multipoles, 5 mm off it".to_owned();
    let near_mm = 0.2 * size_mm;
    let beside = [Kind::Conductor, Kind::Permeable].into_iter().flat_map(|kind| {
        [
            (meshed(size_mm), Compared::Mesh, size_mm, bounds[0]),
            (meshed(near_mm), Compared::Mesh, near_mm, bounds[1]),
            (multipoles.clone(), Compared::Multipoles, 5.0, MULTIPOLES),
            (pair(10.0), Compared::Pair, 10.0, bounds[2]),
            (pair(5.0), Compared::Pair, 5.0, bounds[2]),
            (pair(2.0), Compared::Pair, 2.0, bounds[2]),
        ]
        .map(|(name, what, gap_mm, most)| {
            (format!("{name}, {}", kind.name()), (kind, what, gap_mm, most))
        })
    });
    let touching = [
        ("two spheres that touch", 0.0),
        ("two spheres that overlap by 1e-9 mm", -1e-9),
        ("two spheres that overlap", -5.0),
    ];
    let close = [3, 6, 9, 12]
        .map(|exponent| (format!("two spheres 1e-{exponent} mm apart"), 10.0_f64.powi(-exponent)));
    Family::new(
        "metal",
        "Fields that metal adds to those of nine dipoles. Beside one sphere they are compared \
            with its whole series, summed to round-off. As far from a surface as its triangles are \
            large boundary elements of 1,280 triangles may err by 1.2 %, a fifth as far by 5 % (of 320 \
            triangles by 3 and 9 %). Two meshed spheres are compared with spheres that exchange \
            multipoles up to degree 40, 30 mm beside the gap, to 2 % (4 %).",
        &[],
    )
    .with(beside, move |_, &(kind, what, gap_mm, most)| {
        let error = match what {
            Compared::Mesh => {
                mesh(60.0, subdivisions).and_then(|shape| near_error(kind, shape, gap_mm))
            }
            Compared::Multipoles => {
                near_error(kind, MetalShape::Sphere { radius_mm: 60.0 }, gap_mm)
            }
            Compared::Pair => exchange_error(kind, subdivisions, gap_mm),
        };
        Ok(vec![Row::within(FIELD, error.unwrap_or(f64::NAN), most)])
    })
    .with(touching, |_, &gap_mm| {
        let made = two(Kind::Conductor, MetalShape::Sphere { radius_mm: 30.0 }, gap_mm);
        Ok(vec![must("is refused", made.is_err())])
    })
    .with(close, |_, &gap_mm| {
        let made = two(Kind::Permeable, MetalShape::Sphere { radius_mm: 30.0 }, gap_mm);
        let is_finite = made.map_or(true, |room| {
            let field = fields(&room, &Point3::new(0.0, 40.0, -150.0));
            field.is_some_and(|field| field.iter().all(|v| v.norm().is_finite()))
        });
        Ok(vec![must("a field of numbers, or an error", is_finite)])
    })
}

fn mesh(radius_mm: f64, subdivisions: u32) -> Metal<MetalShape> {
    let surface = ClosedSurface::new(&shapes::sphere(radius_mm, subdivisions)?)?;
    Ok(MetalShape::Surface(Arc::new(BoundaryShape::new(surface, &Task::default())?)))
}

fn fields(room: &MetalRoom, p: &Point3<f64>) -> Option<Vec<Vector3<f64>>> {
    let mut fields = vec![Vector3::zeros(); room.generator().coils.len()];
    room.disturbance(p, &mut fields).ok().map(|()| fields)
}

/// Over directions from the middle of a sphere of 60 mm, against its series.
fn near_error(kind: Kind, shape: MetalShape, gap_mm: f64) -> Metal<f64> {
    let middle = Vector3::new(30.0, -20.0, -140.0);
    let body = kind.body(shape)?;
    let tracker_from_body = Pose::translation(middle.x, middle.y, middle.z);
    let bodies = vec![PlacedBody { body, tracker_from_body }];
    let room = MetalRoom::new(Generator::planar_nine(), None, bodies, &Task::default())?;
    let exact = SphereResponse::new(60.0, &kind.material()?, FAST_HZ)?;
    let mut sequence = Sequence::new(3);
    let (mut wrong, mut whole) = (0.0, 0.0);
    for _ in 0..40 {
        let p = Point3::from(middle + sequence.axis().into_inner() * (60.0 + gap_mm));
        let found = fields(&room, &p).ok_or("no field")?;
        for (coil, found) in room.generator().coils.iter().zip(found) {
            let Coil::Dipole { at_mm, moment } = coil else { continue };
            let expected = exact.field_of_dipole(&(at_mm - middle), moment, &(p - middle))?.field;
            wrong += (found - expected).norm_squared();
            whole += expected.norm_squared();
        }
    }
    Ok((wrong / whole).sqrt())
}

/// Two bodies of 30 mm beside each other below the coils.
fn two(kind: Kind, shape: MetalShape, gap_mm: f64) -> Metal<MetalRoom> {
    let body = kind.body(shape)?;
    let place = |x: f64| PlacedBody {
        body: Arc::clone(&body),
        tracker_from_body: Pose::translation(x, 0.0, -150.0),
    };
    let half_mm = 30.0 + 0.5 * gap_mm;
    let bodies = vec![place(-half_mm), place(half_mm)];
    Ok(MetalRoom::new(Generator::planar_nine(), None, bodies, &Task::default())?)
}

/// Of meshed spheres beside spheres, at places around the gap.
fn exchange_error(kind: Kind, subdivisions: u32, gap_mm: f64) -> Metal<f64> {
    let exact = two(kind, MetalShape::Sphere { radius_mm: 30.0 }, gap_mm)?;
    // Corners of a mesh are outside of the sphere: within it, a gap of their own.
    let meshed = two(kind, mesh(30.0, subdivisions)?, gap_mm)?;
    let (mut wrong, mut whole) = (0.0, 0.0);
    for k in 0..24 {
        let (sine, cosine) = (0.2618 * f64::from(k)).sin_cos();
        let p = Point3::new(0.0, 30.0 * sine, -150.0 + 30.0 * cosine);
        let (found, expected) = fields(&meshed, &p).zip(fields(&exact, &p)).ok_or("no field")?;
        for (found, expected) in found.iter().zip(&expected) {
            wrong += (found - expected).norm_squared();
            whole += expected.norm_squared();
        }
    }
    Ok((wrong / whole).sqrt())
}
