//! Bodies as tool definitions: what a body owns over what its definition held, and what is lost.

use super::atracsys_ini::AtracsysIni;
use super::definition::ToolDefinition;
use super::facts::{Lost, beyond_body};
use super::geometry::{Geometry, id_of};
use super::kind::kind_of_extension;
use super::matching::{nearest_slot, slots_of};
use super::ndi_em::{EmCoil, EmRom};
use super::ndi_image::Checksum;
use super::ndi_optical::{OpticalMarker, OpticalRom};
use super::ndi_rom::NdiRom;
use super::saw_json::SawJson;
use super::tool_plist::ToolPlist;
use crate::body::BodyFile;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_design::definition::DefinitionKind;
use trackwright_simulation::body::{RigidBody, Sensor, SensorOrientation};

/// Axes that are closer than this are one to an image: half a step of its angles near π, which are
/// 32-bit numbers.
const AXIS_TOLERANCE_RAD: f64 = 1.2e-7;

/// Rounding to seven digits that is reported: a hundredth of the least jitter of a tracker.
const NOTABLE_ROUNDING_MM: f64 = 4e-4;

/// Files that a body can be written to as a definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefinitionFormat {
    /// Optical for markers, Aurora for 5-DOF sensors.
    Rom,
    ToolPlist,
    AtracsysIni,
    SawJson,
}

impl DefinitionFormat {
    /// The format of a file of this name.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Some(match kind_of_extension(extension)? {
            DefinitionKind::NdiOptical | DefinitionKind::NdiEm => Self::Rom,
            DefinitionKind::ToolPlist => Self::ToolPlist,
            DefinitionKind::AtracsysIni => Self::AtracsysIni,
            DefinitionKind::SawJson => Self::SawJson,
        })
    }

    /// Its name, without an article.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rom => "ROM",
            Self::ToolPlist => ".tool file",
            Self::AtracsysIni => "Atracsys geometry",
            Self::SawJson => "SAW geometry",
        }
    }
}

/// Everything that a body can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyFormat {
    Body,
    Definition(DefinitionFormat),
}

impl BodyFormat {
    /// The format of a file of this name.
    pub fn of_extension(extension: &str) -> Option<Self> {
        if extension.eq_ignore_ascii_case("ron") {
            return Some(Self::Body);
        }
        DefinitionFormat::of_extension(extension).map(Self::Definition)
    }
}

/// A body as a definition.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    pub definition: ToolDefinition,
    pub lost: Vec<Lost>,
    /// Whether its image is new: there was none to write over, so that it has no serial number, no
    /// date and no manufacturer.
    pub is_new_image: bool,
    /// What the checksum of the image was, where it did not match and now does.
    pub mended_checksum: Option<Checksum>,
}

impl Conversion {
    /// What whoever programs a tool with it has to know, a line each.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<_> = self.lost.iter().map(|it| format!("without {it}")).collect();
        if self.is_new_image {
            notes.push(
                "a new image: serial number, date and manufacturer are empty, what a body does not state is as in most real ones"
                    .to_owned(),
            );
        }
        let rom = self.definition.rom();
        if let (Some(was), Some(rom)) = (self.mended_checksum, rom) {
            notes.push(format!("checksum was {}, is {} now", was.stored, rom.checksum().stored));
        }
        if matches!(rom, Some(NdiRom::Em(_))) {
            notes.push(
                "writing Aurora ROMs is experimental: look at it in NDI's own software before a tool is programmed with it"
                    .to_owned(),
            );
        }
        notes
    }
}

/// Why a body cannot be such a definition.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConversionError {
    #[error("{found} {what}, expected {least} to {most} in {}", kind.name())]
    Count { kind: DefinitionKind, what: &'static str, found: usize, least: usize, most: usize },
    #[error(
        "{markers} markers, {five_dof} 5-DOF and {six_dof} 6-DOF sensors, expected markers alone \
         (an NDI optical ROM) or 5-DOF sensors alone (an NDI Aurora ROM)"
    )]
    Kinds { markers: usize, five_dof: usize, six_dof: usize },
    #[error("{sensor:?} is at ({} {} {}) mm, expected what a 32-bit number can hold", at.x, at.y, at.z)]
    TooFar { sensor: String, at: Point3<f64> },
}

/// Writes a body over the definition that it carries, or as a new one.
///
/// What the body owns (places, axes, their number, its name, a pivot) is written only where it
/// differs from what the definition holds, so that an unchanged body gives its very bytes; all
/// else stays. The checksum is made new.
pub fn from_body(body: &BodyFile, format: DefinitionFormat) -> Result<Conversion, ConversionError> {
    let carried = ToolDefinition::carried(body.definition.as_deref());
    let carried = carried.as_ref();
    let mut lost = Losses::default();
    if let Some(mesh) = &body.mesh {
        lost.push(Lost::Mesh { file: mesh.file.clone() });
    }
    let sized = body.rigid.sensors.iter().filter(|s| s.coil.is_some());
    match sized.count() {
        0 => {}
        count => lost.push(Lost::CoilSizes { count }),
    }
    if !body.mounting.is_empty() {
        lost.push(Lost::Mounting);
    }
    match format {
        DefinitionFormat::Rom | DefinitionFormat::ToolPlist => rom_of(body, carried, format, lost),
        DefinitionFormat::AtracsysIni | DefinitionFormat::SawJson => {
            geometry_of(body, carried, format, lost)
        }
    }
}

/// What was lost so far, in the order of finding it.
#[derive(Default)]
struct Losses(Vec<Lost>);

impl Losses {
    fn push(&mut self, lost: Lost) {
        self.0.push(lost);
    }

    /// What a definition holds that is not written.
    fn push_definition(&mut self, carried: Option<&ToolDefinition>, what: Vec<String>) {
        if let (Some(carried), false) = (carried, what.is_empty()) {
            let kind = carried.kind();
            self.push(Lost::Definition { kind, what });
        }
    }

    /// Names that are not those which the slots give.
    fn push_names(&mut self, sensors: &[Sensor], names: &[Sensor]) {
        let differ = |(a, b): &(&Sensor, &Sensor)| a.name != b.name;
        let mut lost = sensors.iter().zip(names).filter(differ);
        if let Some((first, _)) = lost.next() {
            self.push(Lost::SensorNames { count: 1 + lost.count(), first: first.name.clone() });
        }
    }
}

fn rom_of(
    body: &BodyFile,
    carried: Option<&ToolDefinition>,
    format: DefinitionFormat,
    mut lost: Losses,
) -> Result<Conversion, ConversionError> {
    let rigid = &body.rigid;
    let blank = match kinds(rigid) {
        (markers, 0, 0) if markers > 0 => NdiRom::Optical(OpticalRom::blank()),
        (0, five_dof, 0) if five_dof > 0 => NdiRom::Em(EmRom::blank()),
        (markers, five_dof, six_dof) => {
            return Err(ConversionError::Kinds { markers, five_dof, six_dof });
        }
    };
    let carried_rom = carried.and_then(ToolDefinition::rom);
    let of_same_kind =
        carried_rom.filter(|rom| std::mem::discriminant(*rom) == std::mem::discriminant(&blank));
    let is_new_image = of_same_kind.is_none();
    let not_written = match (format, carried) {
        // The list stays around whichever image.
        (DefinitionFormat::ToolPlist, Some(ToolDefinition::ToolPlist(list))) if is_new_image => {
            beyond_body(list.rom())
        }
        (_, Some(carried)) if is_new_image => carried.beyond_body(),
        (DefinitionFormat::Rom, Some(ToolDefinition::ToolPlist(list))) => list.other_keys(),
        _ => Vec::new(),
    };
    lost.push_definition(carried, not_written);
    let before = of_same_kind.map(NdiRom::checksum);
    let mut rom = of_same_kind.cloned().unwrap_or(blank);
    let mut rounding = Rounding::default();
    match &mut rom {
        NdiRom::Optical(rom) => write_markers(rom, &rigid.sensors, &mut rounding)?,
        NdiRom::Em(rom) => write_coils(rom, &rigid.sensors, &mut rounding)?,
    }
    if rounding.greatest_mm > NOTABLE_ROUNDING_MM {
        lost.push(Lost::Digits { greatest_mm: rounding.greatest_mm });
    }
    if (is_new_image || rom.name() != rigid.name) && !rom.set_part_number(&rigid.name) {
        lost.push(Lost::BodyName { name: rigid.name.clone(), kept: rom.part_number() });
    }
    let tip_in_body = rigid.judged_tip_in_body();
    if tip_in_body != Point3::origin() {
        lost.push(Lost::Tip { tip_in_body });
    }
    lost.push_names(&rigid.sensors, &rom.sensors());
    rom.set_checksum();
    let definition = match (format, carried) {
        (DefinitionFormat::ToolPlist, Some(ToolDefinition::ToolPlist(old))) => {
            ToolDefinition::ToolPlist(old.with_rom(rom))
        }
        (DefinitionFormat::ToolPlist, _) => ToolDefinition::ToolPlist(ToolPlist::of(rom)),
        _ => ToolDefinition::Rom(rom),
    };
    Ok(Conversion {
        definition,
        lost: lost.0,
        is_new_image,
        mended_checksum: before.filter(|sum| !sum.matches()),
    })
}

/// Markers, 5-DOF and 6-DOF sensors of a body.
fn kinds(rigid: &RigidBody) -> (usize, usize, usize) {
    let mut count = (0, 0, 0);
    for sensor in &rigid.sensors {
        match sensor.orientation {
            SensorOrientation::Marker => count.0 += 1,
            SensorOrientation::FiveDof(_) => count.1 += 1,
            SensorOrientation::SixDof(_) => count.2 += 1,
        }
    }
    count
}

/// How far places were moved by being rounded.
#[derive(Default)]
struct Rounding {
    greatest_mm: f64,
}

impl Rounding {
    /// A sensor's place over the one that its slot has, where they are not the same.
    fn place(&mut self, sensor: &Sensor, old: [f32; 3]) -> Result<[f32; 3], ConversionError> {
        let mut place = old;
        for (i, old) in place.iter_mut().enumerate() {
            let exact = sensor.position_in_body[i];
            let rounded = exact as f32;
            if !rounded.is_finite() {
                return Err(ConversionError::TooFar {
                    sensor: sensor.name.clone(),
                    at: sensor.position_in_body,
                });
            }
            self.greatest_mm = self.greatest_mm.max((exact - f64::from(rounded)).abs());
            // Zeros are equal whatever their signs, and the image's stays.
            if rounded != *old {
                *old = rounded;
            }
        }
        Ok(place)
    }
}

/// Whether an image has one place for both.
fn is_same_f32(a: &Point3<f64>, b: &Point3<f64>) -> bool {
    a.iter().zip(b.iter()).all(|(a, b)| *a as f32 == *b as f32)
}

/// What the image had in each sensor's slot, else in the nearest one; `first` where it had none.
fn likes<T: Copy>(sensors: &[Sensor], slots: &[Sensor], old: &[T], first: T) -> Vec<T> {
    let like = |(sensor, own): (&Sensor, Option<usize>)| {
        let slot = own.or_else(|| nearest_slot(&sensor.position_in_body, slots));
        slot.and_then(|slot| old.get(slot)).copied().unwrap_or(first)
    };
    let own = slots_of(sensors, slots, is_same_f32);
    sensors.iter().zip(own).map(like).collect()
}

fn write_markers(
    rom: &mut OpticalRom,
    sensors: &[Sensor],
    rounding: &mut Rounding,
) -> Result<(), ConversionError> {
    check_count(
        DefinitionKind::NdiOptical,
        "markers",
        sensors.len(),
        OpticalRom::MIN_MARKERS,
        OpticalRom::MAX_MARKERS,
    )?;
    let (old, slots) = (rom.markers(), rom.sensors());
    let likes = likes(sensors, &slots, &old, OpticalMarker::FIRST);
    let mut markers = Vec::with_capacity(sensors.len());
    for (sensor, like) in sensors.iter().zip(likes) {
        markers.push(OpticalMarker { position: rounding.place(sensor, like.position)?, ..like });
    }
    rom.set_markers(&markers);
    Ok(())
}

fn write_coils(
    rom: &mut EmRom,
    sensors: &[Sensor],
    rounding: &mut Rounding,
) -> Result<(), ConversionError> {
    check_count(DefinitionKind::NdiEm, "coils", sensors.len(), EmRom::MIN_COILS, EmRom::MAX_COILS)?;
    let (old, slots) = (rom.coils(), rom.sensors());
    let likes = likes(sensors, &slots, &old, EmCoil::FIRST);
    let mut coils = Vec::with_capacity(sensors.len());
    for (sensor, mut coil) in sensors.iter().zip(likes) {
        coil.position = rounding.place(sensor, coil.position)?;
        if let SensorOrientation::FiveDof(axis) = &sensor.orientation
            && angle_between(axis, &coil.axis()) > AXIS_TOLERANCE_RAD
        {
            coil.set_axis(axis);
        }
        coils.push(coil);
    }
    rom.set_coils(&coils);
    Ok(())
}

/// Radians; exact for small angles, where the arc cosine is not.
fn angle_between(a: &Unit<Vector3<f64>>, b: &Unit<Vector3<f64>>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

fn check_count(
    kind: DefinitionKind,
    what: &'static str,
    found: usize,
    least: usize,
    most: usize,
) -> Result<(), ConversionError> {
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(ConversionError::Count { kind, what, found, least, most })
}

fn geometry_of(
    body: &BodyFile,
    carried: Option<&ToolDefinition>,
    format: DefinitionFormat,
    mut lost: Losses,
) -> Result<Conversion, ConversionError> {
    let rigid = &body.rigid;
    let kind = match format {
        DefinitionFormat::AtracsysIni => DefinitionKind::AtracsysIni,
        _ => DefinitionKind::SawJson,
    };
    let count = rigid.sensors.len();
    check_count(kind, "sensors", count, 1, Geometry::MAX_FIDUCIALS)?;
    let (_, five_dof, six_dof) = kinds(rigid);
    if five_dof > 0 {
        lost.push(Lost::Axes { count: five_dof });
    }
    if six_dof > 0 {
        lost.push(Lost::Rotations { count: six_dof });
    }
    // The number is kept from one text format to the other.
    let carried_geometry = carried.and_then(ToolDefinition::geometry);
    let old_id = carried_geometry.and_then(|geometry| geometry.id);
    let geometry = Geometry {
        id: id_of(&rigid.name).or(old_id).or(Some(1)),
        fiducials: rigid.sensors.iter().map(|s| s.position_in_body).collect(),
        pivot: rigid.tip_in_body,
    };
    let geometry = match carried_geometry {
        Some(old) if old.name() == rigid.name => Geometry { id: old.id, ..geometry },
        _ => geometry,
    };
    let slots = carried_geometry.map_or_else(Vec::new, |old| old.to_body().sensors);
    let sources = slots_of(&rigid.sensors, &slots, |a, b| a == b);
    let definition = match (format, carried) {
        (DefinitionFormat::AtracsysIni, Some(ToolDefinition::AtracsysIni(old))) => {
            ToolDefinition::AtracsysIni(old.with_geometry(&geometry, &sources))
        }
        (DefinitionFormat::SawJson, Some(ToolDefinition::SawJson(old))) => {
            if geometry != *old.geometry() && old.has_comments() {
                lost.push(Lost::Comments);
            }
            ToolDefinition::SawJson(old.with_geometry(&geometry, &sources))
        }
        (_, carried) => {
            let not_written = carried.map(ToolDefinition::beyond_body);
            lost.push_definition(carried, not_written.unwrap_or_default());
            match format {
                DefinitionFormat::AtracsysIni => {
                    ToolDefinition::AtracsysIni(AtracsysIni::of(&geometry))
                }
                _ => ToolDefinition::SawJson(SawJson::of(&geometry)),
            }
        }
    };
    if geometry.name() != rigid.name {
        lost.push(Lost::BodyName { name: rigid.name.clone(), kept: geometry.name() });
    }
    lost.push_names(&rigid.sensors, &geometry.to_body().sensors);
    Ok(Conversion { definition, lost: lost.0, is_new_image: false, mended_checksum: None })
}
