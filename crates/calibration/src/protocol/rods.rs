//! Rods of metal beside the sensor: what they add to its reading.

use super::plate::{Plate, PlateError, RodSite, SensorKind, Site, SiteAt};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_geometry::limits::short;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector};
use trackwright_metal::body::{BodyError, MetalBody, MetalShape};
use trackwright_metal::boundary::BoundaryShape;
use trackwright_metal::material::NamedMaterial;
use trackwright_metal::room::{MetalRoom, PlacedBody, PointError, RoomError};
use trackwright_metal::shapes::{ShapeError, cylinder};
use trackwright_metal::surface::{ClosedSurface, SurfaceError};
use trackwright_task::{Cancelled, Task};

/// Keys of the paper's four materials.
pub const PAPER_RODS: [&str; 4] = ["steel-416", "steel-303", "aluminium", "bronze"];

/// Distances of a rod's surface from the sensor; the paper names 20 mm.
pub const DISTANCES_MM: [f64; 5] = [20.0, 35.0, 50.0, 100.0, 150.0];

/// Longest rod, and its largest length in diameters: the triangles of longer ones would be larger than
/// the distance from the sensor.
const MAX_LENGTH_MM: f64 = 1000.0;
const MAX_SLENDERNESS: f64 = 100.0;

/// The rods and where they are put.
#[derive(Clone, Debug, PartialEq)]
pub struct RodSettings {
    pub materials: Vec<NamedMaterial>,
    pub diameter_mm: f64,
    pub length_mm: f64,
    pub frequency_hz: f64,
    /// From the sensor to the nearest point of the rod's surface.
    pub distances_mm: Vec<f64>,
    pub direction: RodDirection,
    pub triangles: usize,
}

/// Which way rods point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RodDirection {
    #[default]
    Any,
    /// Along the sensor's axis.
    Along,
    /// Perpendicular to it.
    Across,
}

/// What a rod adds to the reading at a site.
#[derive(Clone, Debug, PartialEq)]
pub struct RodReading {
    pub site: Site,
    pub position_error_mm: Vector3<f64>,
    /// In the tracker's axes.
    pub rotation_error: UnitQuaternion<f64>,
}

/// The readings beside rods, and how many placements gave none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RodReadings {
    pub readings: Vec<RodReading>,
    /// The rod would cut a coil of the generator.
    pub in_generator: usize,
    /// The signals determine no pose.
    pub without_pose: usize,
}

/// Why rods have no effect that can be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RodError {
    #[error("distance of a rod is {} mm, expected above 0 to 1000", short(*.0))]
    Distance(f64),
    #[error(
        "a rod of {} by {} mm, expected at most {MAX_LENGTH_MM} mm, and at most {MAX_SLENDERNESS} diameters long",
        short(*diameter_mm), short(*length_mm)
    )]
    Size { diameter_mm: f64, length_mm: f64 },
    #[error(
        "found no placement of the rod of {rod} that gives a reading: {in_generator} cut the generator, and in \
         {without_pose} the signals determine no pose"
    )]
    NoReading { rod: &'static str, in_generator: usize, without_pose: usize },
    #[error(transparent)]
    Plate(#[from] PlateError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("rod: {0}")]
    Shape(#[from] ShapeError),
    #[error("rod: {0}")]
    Surface(#[from] SurfaceError),
    #[error("rod of {rod}: {cause}")]
    Body { rod: &'static str, cause: BodyError },
    #[error("rod of {rod}: {cause}")]
    Room { rod: &'static str, cause: RoomError },
}

impl RodSettings {
    /// Diameter, length and frequency of the paper are not known.
    pub const DIAMETER_MM: f64 = 10.0;
    pub const LENGTH_MM: f64 = 100.0;
    pub const FREQUENCY_HZ: f64 = 10e3;

    /// Of these materials, all else by default.
    pub fn of(materials: Vec<NamedMaterial>) -> Self {
        Self {
            materials,
            diameter_mm: Self::DIAMETER_MM,
            length_mm: Self::LENGTH_MM,
            frequency_hz: Self::FREQUENCY_HZ,
            distances_mm: DISTANCES_MM.to_vec(),
            direction: RodDirection::Any,
            triangles: 300,
        }
    }
}

/// A rod's pose beside the sensor, in the tracker frame, and its name.
struct Placement {
    name: String,
    /// From the sensor to the rod's middle, unit.
    way: Vector3<f64>,
    axis: Vector3<f64>,
    /// Whether the rod points at the sensor.
    is_pointing: bool,
}

/// Five ways from the sensor, four in the plate's plane and one towards the generator, times three
/// directions of the rod: along the plate's x, y and z.
fn placements(
    plate: &Plate,
    tracker_from_sensor: &Pose,
    direction: RodDirection,
) -> Vec<Placement> {
    let turn = plate.tracker_from_plate.rotation;
    let sensor_axis = tracker_from_sensor.rotation * Vector3::z();
    // The generator is at the tracker's origin: that side of the plate faces it.
    let to_generator = -tracker_from_sensor.translation.vector;
    let up = turn * Vector3::z();
    let towards = up * if up.dot(&to_generator) < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = (turn * Vector3::x(), turn * Vector3::y());
    let ways = [("generator", towards), ("+x", x), ("-x", -x), ("+y", y), ("-y", -y)];
    let axes = [("x", x), ("y", y), ("z", up)];
    let all = ways.into_iter().flat_map(|way| axes.map(|axis| (way, axis)));
    let all = all.map(|((way_name, way), (axis_name, axis))| Placement {
        name: format!("{way_name} side, along {axis_name}"),
        way,
        axis,
        is_pointing: way.dot(&axis).abs() > 0.5,
    });
    all.filter(|placement| {
        let is_along = placement.axis.dot(&sensor_axis).abs() > 0.5;
        match direction {
            RodDirection::Any => true,
            RodDirection::Along => is_along,
            RodDirection::Across => !is_along,
        }
    })
    .collect()
}

/// What each rod adds to the reading of the sensor on the disc at 0° on the middle level: the reading of
/// a metal-blind tracker with the rod minus that without. Placements that cut the generator or determine
/// no pose are counted and left out.
///
/// # Errors
/// A plate, rods or distances that cannot be, and a rod without a single reading.
pub fn rod_readings(
    plate: &Plate,
    generator: &Generator,
    sensor: SensorKind,
    settings: &RodSettings,
    task: &Task,
) -> Result<RodReadings, RodError> {
    plate.check()?;
    if let Some(&wrong) = settings.distances_mm.iter().find(|&&d| !(d > 0.0 && d <= 1000.0)) {
        return Err(RodError::Distance(wrong));
    }
    let RodSettings { diameter_mm, length_mm, .. } = *settings;
    let is_short = diameter_mm.max(length_mm) <= MAX_LENGTH_MM;
    if !(is_short && length_mm <= MAX_SLENDERNESS * diameter_mm) {
        return Err(RodError::Size { diameter_mm, length_mm });
    }
    let radius_mm = 0.5 * diameter_mm;
    let mesh = cylinder(radius_mm, length_mm, settings.triangles)?;
    let shape = BoundaryShape::new(ClosedSurface::new(&mesh)?, task)?;
    let shape = MetalShape::Surface(Arc::new(shape));
    let site = Site::plain(plate.levels / 2, SiteAt::Disc { angle_deg: 0.0 });
    let true_pose = plate.tracker_from_sensor(&site);
    let placements = placements(plate, &true_pose, settings.direction);
    let mut found = RodReadings::default();
    for named in &settings.materials {
        let rod = named.key;
        let body = MetalBody::new(shape.clone(), named.material, settings.frequency_hz, task);
        let body = Arc::new(body.map_err(|cause| RodError::Body { rod, cause })?);
        let before = found.readings.len();
        let (mut in_generator, mut without_pose) = (0, 0);
        for &distance_mm in &settings.distances_mm {
            for placement in &placements {
                let to_middle_mm =
                    distance_mm + if placement.is_pointing { 0.5 * length_mm } else { radius_mm };
                let middle = true_pose.translation.vector + placement.way * to_middle_mm;
                let turn = UnitQuaternion::rotation_between(&Vector3::z(), &placement.axis);
                let turn = turn.unwrap_or_else(UnitQuaternion::identity);
                let tracker_from_body = pose_from_parts(middle, turn);
                let placed = PlacedBody { body: Arc::clone(&body), tracker_from_body };
                let room = match MetalRoom::new(generator.clone(), None, vec![placed], task) {
                    Ok(room) => room,
                    Err(RoomError::MetalCutsGenerator { .. }) => {
                        in_generator += 1;
                        continue;
                    }
                    Err(cause) => return Err(RodError::Room { rod, cause }),
                };
                let Ok((position_error_mm, rotation_error)) = error_of(&room, &true_pose, sensor)
                else {
                    without_pose += 1;
                    continue;
                };
                let placement = placement.name.clone();
                let beside = RodSite { rod: rod.to_owned(), distance_mm, placement };
                let site = Site { rod: Some(beside), ..site.clone() };
                found.readings.push(RodReading { site, position_error_mm, rotation_error });
            }
        }
        if found.readings.len() == before {
            return Err(RodError::NoReading { rod, in_generator, without_pose });
        }
        found.in_generator += in_generator;
        found.without_pose += without_pose;
    }
    Ok(found)
}

fn error_of(
    room: &MetalRoom,
    true_pose: &Pose,
    sensor: SensorKind,
) -> Result<(Vector3<f64>, UnitQuaternion<f64>), PointError> {
    match sensor {
        SensorKind::FiveDof => {
            let axis = true_pose.rotation * Vector3::z_axis();
            let read = room.read_axis(&true_pose.translation.vector.into(), &axis)?;
            let turn = exp_vector(&axis_rotation(&axis, &read.axis).vector_rad);
            Ok((read.position_mm.coords - true_pose.translation.vector, turn))
        }
        SensorKind::SixDof => {
            let read = room.read_pose(true_pose)?.tracker_from_sensor;
            let shift = read.translation.vector - true_pose.translation.vector;
            Ok((shift, read.rotation * true_pose.rotation.inverse()))
        }
    }
}
