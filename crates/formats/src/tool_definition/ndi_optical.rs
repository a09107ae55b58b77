//! NDI optical tool definitions, `.rom`: 752 bytes, little-endian, markers in mm.
//!
//! The image is kept as it is, with whatever follows it in the file. Only the first markers of the
//! twenty slots count, as many as byte 28 states: what real files hold behind them is left over
//! from other tools, in the tables of faces and firing too.

use super::super::error::FormatError;
use super::geometry::marker;
use super::ndi_image::{Checksum, IdentityAt, Image, OnMismatch, check_finite, sum};
use trackwright_simulation::body::Sensor;

pub(super) const MAGIC: &[u8] = b"NDI\0";

const SIZE: usize = 752;
const SLOTS: usize = 20;

// Where fields begin.
const CHECKSUM: usize = 4;
const SUMMED: usize = 6;
const MAX_ANGLE: usize = 24;
const COUNT: usize = 28;
const MIN_MARKERS: usize = 32;
const MAX_ERROR: usize = 36;
const UNKNOWN_TEN: usize = 64;
const POSITIONS: usize = 72;
const NORMALS: usize = 312;
const FIRING: usize = 552;
const LEDS: usize = 572;
const IN_PORT: usize = 576;
const GENERATION: usize = 612;
const FACES: usize = 613;
const GROUPS: usize = 633;
const ALGORITHM: usize = 653;
const MARKER_TYPE: usize = 655;
const FACE_NORMALS: usize = 656;
const FACE_COUNT: usize = 8;

/// An image, and what follows it in its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpticalRom {
    pub(super) image: Image,
}

/// What an image holds about one marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpticalMarker {
    /// Millimetres, tool frame.
    pub position: [f32; 3],
    /// Zero where none is given.
    pub normal: [f32; 3],
    pub firing: u8,
    /// Counted from 1.
    pub face: u8,
    pub group: u8,
}

impl OpticalRom {
    pub const MIN_MARKERS: usize = 3;
    pub const MAX_MARKERS: usize = SLOTS;

    pub(super) const IDENTITY: IdentityAt = IdentityAt {
        sub_type: 12,
        main_type: 15,
        revision: 16,
        serial: 20,
        manufacturer: 580,
        part_number: 592,
    };

    /// An image without markers and with what most real ones have elsewhere: not to be written
    /// before it has some.
    pub(super) fn blank() -> Self {
        let mut image = Image::zeros(SIZE);
        image.put(0, MAGIC);
        image.put(8, &1_u32.to_le_bytes());
        // A tool whose tip is not stated, of no special kind.
        image[Self::IDENTITY.sub_type] = 2;
        image[MAX_ANGLE] = 90;
        image[MIN_MARKERS] = 3;
        image.put(MAX_ERROR, &2_f32.to_le_bytes());
        image.put(UNKNOWN_TEN, &10_f32.to_le_bytes());
        // No tracking LED, nor any other.
        image[LEDS..LEDS + 4].fill(31);
        image[IN_PORT] = 9;
        image[GENERATION] = 9;
        // Its geometry is its own.
        image[ALGORITHM] = 0x80;
        // Passive spheres.
        image[MARKER_TYPE] = 41;
        Self { image }
    }

    /// Reads an image and what follows it.
    ///
    /// # Errors
    /// What is no such image, an impossible count, markers at no place, and a checksum that does
    /// not match unless that is accepted.
    pub fn parse(bytes: &[u8], on_mismatch: OnMismatch) -> Result<Self, FormatError> {
        if !bytes.starts_with(&MAGIC[..bytes.len().min(MAGIC.len())]) {
            let found: Vec<_> = bytes.iter().take(4).map(|b| format!("{b:02X}")).collect();
            return Err(FormatError::field(
                "beginning",
                found.join(" "),
                "4E 44 49 00 (an NDI optical ROM) or 01 00 (an Aurora ROM)",
            ));
        }
        let rom = Self { image: Image::read(bytes, SIZE, "752 bytes of an NDI optical ROM")? };
        rom.checksum().check(on_mismatch)?;
        let count = usize::from(rom.image[COUNT]);
        if !(Self::MIN_MARKERS..=Self::MAX_MARKERS).contains(&count) {
            return Err(FormatError::field("number of markers", count, "3 to 20 (byte 28)"));
        }
        for (i, marker) in rom.markers().iter().enumerate() {
            check_finite(&format!("marker {}: position", i + 1), &marker.position)?;
            check_finite(&format!("marker {}: normal", i + 1), &marker.normal)?;
        }
        Ok(rom)
    }

    pub fn checksum(&self) -> Checksum {
        Checksum {
            stored: u32::from(self.image.u16(CHECKSUM)),
            computed: sum(&self.image[SUMMED..]) & 0xffff,
        }
    }

    pub(super) fn set_checksum(&mut self) {
        let sum = self.checksum().computed.to_le_bytes();
        self.image.put(CHECKSUM, &sum[..2]);
    }

    pub fn markers(&self) -> Vec<OpticalMarker> {
        let count = usize::from(self.image[COUNT]).min(SLOTS);
        (0..count).map(|slot| self.slot(slot)).collect()
    }

    fn slot(&self, slot: usize) -> OpticalMarker {
        OpticalMarker {
            position: self.image.vector(POSITIONS + 12 * slot),
            normal: self.image.vector(NORMALS + 12 * slot),
            firing: self.image[FIRING + slot],
            face: self.image[FACES + slot],
            group: self.image[GROUPS + slot],
        }
    }

    fn set_slot(&mut self, slot: usize, marker: &OpticalMarker) {
        self.image.put_vector(POSITIONS + 12 * slot, marker.position);
        self.image.put_vector(NORMALS + 12 * slot, marker.normal);
        self.image[FIRING + slot] = marker.firing;
        self.image[FACES + slot] = marker.face;
        self.image[GROUPS + slot] = marker.group;
    }

    /// Gives it these markers, 3 to 20 of them. While their number stays what it is, what lies
    /// behind them stays too; otherwise they fire in order and nothing is left behind them.
    pub(super) fn set_markers(&mut self, markers: &[OpticalMarker]) {
        let is_other_count = markers.len() != usize::from(self.image[COUNT]);
        for (slot, marker) in markers.iter().take(SLOTS).enumerate() {
            let mut marker = *marker;
            if is_other_count {
                marker.firing = slot as u8;
            }
            self.set_slot(slot, &marker);
        }
        if is_other_count {
            for slot in markers.len()..SLOTS {
                self.set_slot(slot, &OpticalMarker::NONE);
            }
            let count = markers.len().min(SLOTS) as u8;
            self.image[COUNT] = count;
            self.image[MIN_MARKERS] = self.image[MIN_MARKERS].min(count);
        }
    }

    /// Degrees between a marker's normal and the tracker beyond which it does not count.
    pub fn max_angle_deg(&self) -> u8 {
        self.image[MAX_ANGLE]
    }

    /// How many markers have to be seen.
    pub fn min_markers(&self) -> u8 {
        self.image[MIN_MARKERS]
    }

    /// Of a marker, mm.
    pub fn max_error_mm(&self) -> f32 {
        self.image.f32(MAX_ERROR)
    }

    /// 41 passive sphere, 49 passive disc, 57 Radix lens.
    pub fn marker_type(&self) -> u8 {
        self.image[MARKER_TYPE]
    }

    /// Bit 7: the tool's geometry is its own.
    pub fn algorithm_flags(&self) -> u8 {
        self.image[ALGORITHM]
    }

    /// Zero where a face has none. They need not agree with the markers' normals.
    pub fn face_normals(&self) -> [[f32; 3]; FACE_COUNT] {
        std::array::from_fn(|face| self.image.vector(FACE_NORMALS + 12 * face))
    }

    pub(super) fn sensors(&self) -> Vec<Sensor> {
        let markers = self.markers().into_iter().enumerate();
        markers.map(|(slot, m)| marker(slot, m.position.map(f64::from).into())).collect()
    }
}

impl OpticalMarker {
    /// What a slot without marker holds.
    const NONE: Self = Self { position: [0.0; 3], normal: [0.0; 3], firing: 0, face: 0, group: 0 };

    /// A marker of a tool that has none yet: on the first face, with no normal.
    pub(super) const FIRST: Self = Self { face: 1, group: 1, ..Self::NONE };
}
