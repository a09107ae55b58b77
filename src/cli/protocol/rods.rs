//! Rods of metal as they are stated on the command line.

use super::super::numbers::{above_zero, length_above_zero};
use super::super::prelude::*;
use trackwright_calibration::protocol::plate::{Plate, SensorKind};
use trackwright_calibration::protocol::rods::{
    PAPER_RODS, RodDirection, RodReadings, RodSettings, rod_readings,
};
use trackwright_field::generator::Generator;
use trackwright_metal::material::{Material, NAMED_MATERIALS, NamedMaterial};
use trackwright_result::{Section, data};

/// Repeated for each argument: a heading for the group would go on to whatever follows it.
const HEADING: &str = "Rods of metal";

#[derive(Debug, Args)]
pub struct RodArgs {
    /// Materials of the rods, comma-separated: aluminium, copper, titanium, steel-303, steel-304,
    /// steel-316, steel-416, bronze, ferrite; steel-416, steel-303, aluminium and bronze where left out
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "LIST",
        value_delimiter = ',',
        conflicts_with_all = ["no_rods", "recording"]
    )]
    rods: Vec<String>,

    /// Leave the rods out
    #[arg(long, help_heading = HEADING, conflicts_with = "recording")]
    no_rods: bool,

    /// Distances of a rod's surface from the sensor, comma-separated [default: 20,35,50,100,150]
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "MM",
        value_delimiter = ',',
        value_parser = length_above_zero,
        conflicts_with_all = ["no_rods", "recording"]
    )]
    rod_distances: Vec<f64>,

    /// Diameter of the rods
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "MM",
        default_value_t = RodSettings::DIAMETER_MM,
        value_parser = length_above_zero,
        conflicts_with_all = ["no_rods", "recording"]
    )]
    rod_diameter_mm: f64,

    /// Length of the rods
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "MM",
        default_value_t = RodSettings::LENGTH_MM,
        value_parser = length_above_zero,
        conflicts_with_all = ["no_rods", "recording"]
    )]
    rod_length_mm: f64,

    /// Which way rods point
    #[arg(
        long,
        help_heading = HEADING,
        value_parser = DIRECTION,
        default_value = "any",
        conflicts_with_all = ["no_rods", "recording"]
    )]
    rod_direction: RodDirection,

    /// Relative permeability of all rods, in place of their materials'
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "MU",
        value_parser = above_zero,
        conflicts_with_all = ["no_rods", "recording"]
    )]
    permeability: Option<f64>,

    /// Frequency of the tracker's field
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "HZ",
        default_value_t = RodSettings::FREQUENCY_HZ,
        value_parser = above_zero,
        conflicts_with_all = ["no_rods", "recording"]
    )]
    frequency: f64,

    /// Field generator: planar-nine, anser, or a file (*.generator.ron)
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "GENERATOR",
        default_value = "planar-nine",
        conflicts_with_all = ["no_rods", "recording"]
    )]
    generator: String,
}

const DIRECTION: Choice<RodDirection> = Choice(&[
    ("any", "Along the plate's x, y and z", RodDirection::Any),
    ("along", "Along the sensor's axis", RodDirection::Along),
    ("across", "Perpendicular to it", RodDirection::Across),
]);

/// Readings beside rods, and what they were computed with.
pub(super) struct Rods {
    pub found: RodReadings,
    settings: RodSettings,
    generator: String,
}

impl RodArgs {
    /// The readings beside the rods; `None` where there are none.
    ///
    /// # Errors
    /// A material or generator that is not known, rods that cannot be computed.
    pub(super) fn readings(
        &self,
        files: &Files,
        plate: &Plate,
        sensor: SensorKind,
    ) -> anyhow::Result<Option<Rods>> {
        if self.no_rods {
            return Ok(None);
        }
        let generator = match Generator::built_in(&self.generator) {
            Some(generator) => generator,
            None => files.read_generator(Path::new(&self.generator))?,
        };
        let settings = self.settings()?;
        let found =
            rod_readings(plate, &generator, sensor, &settings, &trackwright_task::Task::default())?;
        Ok(Some(Rods { found, settings, generator: generator.name }))
    }

    fn settings(&self) -> anyhow::Result<RodSettings> {
        let keys: Vec<&str> = match self.rods.as_slice() {
            [] => PAPER_RODS.to_vec(),
            named => named.iter().map(|key| key.trim()).collect(),
        };
        let mut materials: Vec<NamedMaterial> = Vec::new();
        for key in keys {
            let Some(named) = NAMED_MATERIALS.iter().find(|named| named.key == key) else {
                let known = NAMED_MATERIALS.map(|named| named.key).join(", ");
                bail!("--rods: found {key:?}, expected one of {known}");
            };
            if materials.iter().any(|other| other.key == key) {
                bail!("--rods: found {key} twice, expected it once");
            }
            let material = match self.permeability {
                Some(mu) => Material::new(named.material.conductivity_s_per_m(), mu)
                    .context("--permeability")?,
                None => named.material,
            };
            materials.push(NamedMaterial { material, ..*named });
        }
        let defaults = RodSettings::of(materials);
        Ok(RodSettings {
            diameter_mm: self.rod_diameter_mm,
            length_mm: self.rod_length_mm,
            frequency_hz: self.frequency,
            distances_mm: match self.rod_distances.as_slice() {
                [] => defaults.distances_mm,
                stated => stated.to_vec(),
            },
            direction: self.rod_direction,
            ..defaults
        })
    }
}

impl Rods {
    pub(super) fn section(&self) -> Section {
        Section::of([
            data("generator", &self.generator),
            data("frequency_hz", self.settings.frequency_hz),
            data("diameter_mm", self.settings.diameter_mm),
            data("length_mm", self.settings.length_mm),
            data("in_generator", self.found.in_generator),
            data("without_pose", self.found.without_pose),
        ])
    }

    /// What a reader of the table has to know of its rods.
    pub(super) fn lines(&self) -> Vec<String> {
        let RodSettings { diameter_mm, length_mm, frequency_hz, .. } = self.settings;
        let mut lines = vec![format!(
            "rods of {diameter_mm} by {length_mm} mm at {frequency_hz} Hz beside the middle of the plate, generator \
             {}: first order, each by itself",
            self.generator
        )];
        for (count, what) in [
            (self.found.in_generator, "would cut the generator"),
            (self.found.without_pose, "leave signals that determine no pose"),
        ] {
            if count > 0 {
                lines.push(format!("{count} placements of rods {what} and are left out"));
            }
        }
        lines
    }
}
