//! What a definition states about its tool as a whole, a line each, and what of a body a file
//! cannot hold.

use super::definition::ToolDefinition;
use super::geometry::Geometry;
use super::ndi_optical::OpticalRom;
use super::ndi_rom::NdiRom;
use nalgebra::Point3;
use trackwright_design::definition::DefinitionKind;

/// Trailing bytes that are shown.
const MAX_SHOWN_BYTES: usize = 16;

/// One thing that a definition states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    pub what: &'static str,
    pub value: String,
    /// Of the value; empty where it has none.
    pub unit: &'static str,
}

impl ToolDefinition {
    /// What it states besides the sensors: which tool it is, who made it, its checksum.
    pub fn facts(&self) -> Vec<Fact> {
        match (self.rom(), self.geometry()) {
            (Some(rom), _) => rom_facts(rom),
            (None, Some(geometry)) => geometry_facts(geometry),
            // Each kind is one or the other.
            (None, None) => Vec::new(),
        }
    }

    /// What it states about its tool that no body has, in words. What every image states is named
    /// too, as it may not be what a new image states.
    pub fn beyond_body(&self) -> Vec<String> {
        match self {
            Self::Rom(rom) => beyond_body(rom),
            Self::ToolPlist(plist) => [beyond_body(plist.rom()), plist.other_keys()].concat(),
            Self::AtracsysIni(ini) => ini.beyond_geometry(),
            Self::SawJson(json) => json.beyond_geometry(),
        }
    }

    /// What is wrong with it although it was read, in words.
    pub fn doubt(&self) -> Option<String> {
        let sum = self.rom()?.checksum();
        (!sum.matches()).then(|| {
            format!(
                "read from an image whose checksum is {}, expected {}",
                sum.stored, sum.computed
            )
        })
    }
}

pub(super) fn beyond_body(rom: &NdiRom) -> Vec<String> {
    let (is_numbered, is_made) =
        (rom.serial().number() != 0, !rom.manufacturer().trim().is_empty());
    let mut what = vec![
        (is_numbered, "serial number and date"),
        (is_made, "manufacturer"),
        (true, "type and revision"),
    ];
    match rom {
        NdiRom::Optical(rom) => {
            let is_given = |normal: &[f32; 3]| *normal != [0.0; 3];
            let has_normals = rom.markers().iter().any(|marker| is_given(&marker.normal));
            let has_face_normals = rom.face_normals().iter().any(is_given);
            what.extend([
                (has_normals, "normals of markers"),
                (true, "faces, groups and firing order of markers"),
                (has_face_normals, "normals of faces"),
                (true, "marker type"),
                (true, "largest angle of a marker"),
                (true, "largest error of a marker"),
                (true, "markers that have to be seen"),
                (true, "algorithm flags"),
            ]);
        }
        NdiRom::Em(_) => what.push((true, "coils that have to be seen")),
    }
    what.push((!rom.trailing().is_empty(), "trailing bytes"));
    let there = what.into_iter().filter(|(is_there, _)| *is_there);
    there.map(|(_, what)| what.to_owned()).collect()
}

fn fact(what: &'static str, value: impl ToString, unit: &'static str) -> Fact {
    Fact { what, value: value.to_string(), unit }
}

fn geometry_facts(geometry: &Geometry) -> Vec<Fact> {
    let number = geometry.id.map_or_else(none, |id| id.to_string());
    let pivot = match &geometry.pivot {
        Some(_) => "given, as the tip",
        None => "none",
    };
    vec![
        fact("number", number, ""),
        fact("markers", geometry.fiducials.len(), ""),
        fact("pivot", pivot, ""),
    ]
}

fn rom_facts(rom: &NdiRom) -> Vec<Fact> {
    let serial = rom.serial();
    // A new image has none, nor a day.
    let is_numbered = serial.number() != 0;
    let date = match (is_numbered, serial.date()) {
        (false, _) => none(),
        (true, Some(date)) => date.to_string(),
        (true, None) => "none that is a day".to_owned(),
    };
    let kind = format!(
        "{}, {}",
        typed(rom.main_type(), rom.main_type_name()),
        typed(rom.sub_type(), rom.sub_type_name()),
    );
    let serial = match is_numbered {
        true => serial.to_string(),
        false => none(),
    };
    let mut facts = vec![
        fact("part number", or_none(rom.part_number()), ""),
        fact("manufacturer", or_none(rom.manufacturer()), ""),
        fact("serial number", serial, ""),
        fact("date", date, ""),
        fact("type", kind, ""),
        fact("revision", rom.revision(), ""),
    ];
    match rom {
        NdiRom::Optical(rom) => push_optical(&mut facts, rom),
        NdiRom::Em(rom) => {
            facts.push(fact("coils", rom.coils().len(), ""));
            facts.push(fact("coils that have to be seen", rom.min_coils(), ""));
        }
    }
    let sum = rom.checksum();
    let state = match sum.matches() {
        true => format!("{}, matches", sum.stored),
        false => format!("{}, expected {}", sum.stored, sum.computed),
    };
    facts.push(fact("checksum", state, ""));
    if let trailing @ [_, ..] = rom.trailing() {
        facts.push(fact("trailing bytes", shown_bytes(trailing), ""));
    }
    facts
}

fn push_optical(facts: &mut Vec<Fact>, rom: &OpticalRom) {
    facts.push(fact("markers", rom.markers().len(), ""));
    facts.push(fact("markers that have to be seen", rom.min_markers(), ""));
    let marker_type = match rom.marker_type() {
        41 => "passive spheres",
        49 => "passive discs",
        57 => "Radix lenses",
        _ => "not known here",
    };
    facts.push(fact("marker type", typed(rom.marker_type(), marker_type), ""));
    let angle = rom.max_angle_deg();
    facts.push(fact("largest angle of a marker", angle, "deg"));
    let error = rom.max_error_mm();
    facts.push(fact("largest error of a marker", error, "mm"));
    let is_unique = rom.algorithm_flags() & 0x80 != 0;
    let unique = if is_unique { "yes" } else { "no" };
    facts.push(fact("geometry of its own", unique, ""));
}

/// `8: EE FD FF FF FD FD FF FF`.
fn shown_bytes(trailing: &[u8]) -> String {
    let mut shown: Vec<_> =
        trailing.iter().take(MAX_SHOWN_BYTES).map(|byte| format!("{byte:02X}")).collect();
    if trailing.len() > MAX_SHOWN_BYTES {
        shown.push("…".to_owned());
    }
    format!("{}: {}", trailing.len(), shown.join(" "))
}

fn typed(number: u8, name: &str) -> String {
    format!("{number} {name}")
}

fn or_none(text: String) -> String {
    match text.trim().is_empty() {
        true => none(),
        false => text,
    }
}

fn none() -> String {
    "none".to_owned()
}

/// One thing that is not in the file that was written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Lost {
    /// A ROM has no tip: it stands for the origin, or is found by a pivot calibration.
    #[error("the tip ({} {} {} mm): a ROM's own is its origin", .tip_in_body.x, .tip_in_body.y, .tip_in_body.z)]
    Tip { tip_in_body: Point3<f64> },
    #[error("the mesh {file}")]
    Mesh { file: String },
    /// Longer than the part number, or not ASCII; or no number where only one is kept.
    #[error("the name {name:?}: the file has {kept:?}")]
    BodyName { name: String, kept: String },
    /// Markers and coils have numbers.
    #[error("{}", sensor_names(*count, first))]
    SensorNames { count: usize, first: String },
    /// Diameters and lengths.
    #[error("the coil sizes of {}", sensors(*count))]
    CoilSizes { count: usize },
    /// Mounting regions, forbidden boxes and least distances.
    #[error("where sensors may be put")]
    Mounting,
    /// Of 5-DOF sensors, in a format of markers.
    #[error("the axes of {}: they are markers there", sensors(*count))]
    Axes { count: usize },
    /// Of 6-DOF sensors, in a format of markers.
    #[error("the rotations of {}: they are markers there", sensors(*count))]
    Rotations { count: usize },
    /// Numbers of seven digits are that far off.
    #[error("digits: positions are up to {greatest_mm:.1e} mm off, as the file keeps seven")]
    Digits { greatest_mm: f64 },
    /// What else a definition states that the body carries, item by item.
    #[error("what else {} states: {}", kind.name(), what.join(", "))]
    Definition { kind: DefinitionKind, what: Vec<String> },
    /// Of a text that is written anew.
    #[error("comments: the text is written anew")]
    Comments,
}

impl Lost {
    /// Its name for a program.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Tip { .. } => "tip",
            Self::Mesh { .. } => "mesh",
            Self::BodyName { .. } => "body_name",
            Self::SensorNames { .. } => "sensor_names",
            Self::CoilSizes { .. } => "coil_sizes",
            Self::Mounting => "mounting",
            Self::Axes { .. } => "axes",
            Self::Rotations { .. } => "rotations",
            Self::Digits { .. } => "digits",
            Self::Definition { .. } => "definition",
            Self::Comments => "comments",
        }
    }
}

fn sensor_names(count: usize, first: &str) -> String {
    match count {
        1 => format!("the name of a sensor, {first:?}: it has a number"),
        _ => format!("the names of {count} sensors, {first:?} the first: they have numbers"),
    }
}

fn sensors(count: usize) -> String {
    match count {
        1 => "one sensor".to_owned(),
        _ => format!("{count} sensors"),
    }
}
