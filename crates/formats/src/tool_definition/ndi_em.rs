//! NDI Aurora tool definitions, `.rom`: 329 bytes, little-endian, two to eight coils in mm.
//!
//! Read off one real image; what is not understood of it is kept verbatim, with whatever follows
//! it in the file. Each coil is a 5-DOF sensor whose axis is given by azimuth and polar angle.

use super::super::error::FormatError;
use super::ndi_image::{Checksum, IdentityAt, Image, OnMismatch, check_finite, sum};
use nalgebra::{Unit, Vector3};
use trackwright_simulation::body::Sensor;

/// Version 1; the other kind of image begins with letters, every text too.
pub(super) const MAGIC: &[u8] = &[1, 0];

const SIZE: usize = 329;
const SLOTS: usize = 8;

// Where fields begin.
const PAYLOAD: usize = 2;
/// Bytes of a file that are not payload.
const FRAME: usize = 8;
const COUNT: usize = 16;
const MIN_COILS: usize = 20;
const UNKNOWN_THIRD: usize = 48;
const CAPACITY: usize = 52;
const COILS: usize = 56;
const STRIDE: usize = 20;
const VALUES: usize = 216;
const CHECKSUM: usize = 325;
/// What the sum begins with; it ends before the checksum.
const SUMMED: usize = 4;

/// An image, and what follows it in its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EmRom {
    pub(super) image: Image,
}

/// What an image holds about one coil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmCoil {
    /// Millimetres, tool frame.
    pub position: [f32; 3],
    /// Of the axis about z, from x, radians.
    pub azimuth: f32,
    /// Of the axis from z, radians.
    pub polar: f32,
    /// 18 in the one real image, and not understood.
    pub value: f32,
}

impl EmCoil {
    pub fn axis(&self) -> Unit<Vector3<f64>> {
        let (azimuth, polar) = (f64::from(self.azimuth), f64::from(self.polar));
        let across = polar.sin();
        Unit::new_normalize(Vector3::new(
            across * azimuth.cos(),
            across * azimuth.sin(),
            polar.cos(),
        ))
    }

    /// Turns it to an axis.
    pub(super) fn set_axis(&mut self, axis: &Unit<Vector3<f64>>) {
        self.azimuth = axis.y.atan2(axis.x) as f32;
        self.polar = axis.x.hypot(axis.y).atan2(axis.z) as f32;
    }

    /// A coil of a tool that has none yet.
    pub(super) const FIRST: Self = Self { value: 18.0, ..Self::NONE };

    const NONE: Self = Self { position: [0.0; 3], azimuth: 0.0, polar: 0.0, value: 0.0 };
}

impl EmRom {
    pub const MIN_COILS: usize = 2;
    pub const MAX_COILS: usize = SLOTS;

    pub(super) const IDENTITY: IdentityAt = IdentityAt {
        sub_type: 4,
        main_type: 7,
        revision: 8,
        serial: 12,
        manufacturer: 292,
        part_number: 304,
    };

    /// An image without coils and with what the one real one has elsewhere: not to be written
    /// before it has some.
    pub(super) fn blank() -> Self {
        let mut image = Image::zeros(SIZE);
        image.put(0, MAGIC);
        image.put(PAYLOAD, &((SIZE - FRAME) as u16).to_le_bytes());
        // User defined.
        image[Self::IDENTITY.main_type] = 4;
        image.put(MIN_COILS, &2_u32.to_le_bytes());
        image.put(UNKNOWN_THIRD, &0x3eaa_aa9f_u32.to_le_bytes());
        image.put(CAPACITY, &(SLOTS as u32).to_le_bytes());
        Self { image }
    }

    /// Reads an image and what follows it.
    ///
    /// # Errors
    /// What is no such image, an impossible count, coils at no place, and a checksum that does not
    /// match unless that is accepted.
    pub fn parse(bytes: &[u8], on_mismatch: OnMismatch) -> Result<Self, FormatError> {
        let rom = Self { image: Image::read(bytes, SIZE, "329 bytes of an NDI Aurora ROM")? };
        let payload = rom.image.u16(PAYLOAD);
        if usize::from(payload) != SIZE - FRAME {
            return Err(FormatError::field("payload's length", payload, "321 (bytes 2 and 3)"));
        }
        rom.checksum().check(on_mismatch)?;
        let count = rom.image.u32(COUNT);
        if !(Self::MIN_COILS as u32..=Self::MAX_COILS as u32).contains(&count) {
            return Err(FormatError::field("number of coils", count, "2 to 8 (byte 16)"));
        }
        for (i, coil) in rom.coils().iter().enumerate() {
            check_finite(&format!("coil {}: position", i + 1), &coil.position)?;
            check_finite(
                &format!("coil {}: azimuth and polar angle", i + 1),
                &[coil.azimuth, coil.polar],
            )?;
        }
        Ok(rom)
    }

    pub fn checksum(&self) -> Checksum {
        Checksum { stored: self.image.u32(CHECKSUM), computed: sum(&self.image[SUMMED..CHECKSUM]) }
    }

    pub(super) fn set_checksum(&mut self) {
        let sum = self.checksum().computed;
        self.image.put(CHECKSUM, &sum.to_le_bytes());
    }

    pub fn coils(&self) -> Vec<EmCoil> {
        let count = self.image.u32(COUNT).min(SLOTS as u32);
        (0..count as usize).map(|slot| self.slot(slot)).collect()
    }

    fn slot(&self, slot: usize) -> EmCoil {
        let at = COILS + STRIDE * slot;
        EmCoil {
            position: self.image.vector(at),
            azimuth: self.image.f32(at + 12),
            polar: self.image.f32(at + 16),
            value: self.image.f32(VALUES + 4 * slot),
        }
    }

    fn set_slot(&mut self, slot: usize, coil: &EmCoil) {
        let at = COILS + STRIDE * slot;
        self.image.put_vector(at, coil.position);
        self.image.put(at + 12, &coil.azimuth.to_le_bytes());
        self.image.put(at + 16, &coil.polar.to_le_bytes());
        self.image.put(VALUES + 4 * slot, &coil.value.to_le_bytes());
    }

    /// Gives it these coils, 2 to 8 of them. While their number stays what it is, what lies behind
    /// them stays too; otherwise nothing is left behind them.
    pub(super) fn set_coils(&mut self, coils: &[EmCoil]) {
        let before = self.image.u32(COUNT);
        for (slot, coil) in coils.iter().take(SLOTS).enumerate() {
            self.set_slot(slot, coil);
        }
        let count = coils.len().min(SLOTS) as u32;
        if count != before {
            for slot in coils.len()..SLOTS {
                self.set_slot(slot, &EmCoil::NONE);
            }
            let min = self.image.u32(MIN_COILS).min(count);
            self.image.put(COUNT, &count.to_le_bytes());
            self.image.put(MIN_COILS, &min.to_le_bytes());
        }
    }

    /// How many coils have to be seen.
    pub fn min_coils(&self) -> u32 {
        self.image.u32(MIN_COILS)
    }

    pub(super) fn sensors(&self) -> Vec<Sensor> {
        let sensor = |(slot, coil): (usize, EmCoil)| {
            let place = coil.position.map(f64::from);
            Sensor::five_dof(format!("coil {}", slot + 1), place, coil.axis())
        };
        self.coils().into_iter().enumerate().map(sensor).collect()
    }
}
