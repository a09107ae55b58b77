//! Environments, `*.env.ron`: a room's distortion model, its volume, and where it came from.

use super::computed_model::{self, HarmonicEntry, KrigingEntry};
use super::error::FormatError;
use super::process::{self, ProcessEntry};
use super::ron_text::{self, RonWriter, Version};
use super::room_metal::{self, RoomMetalEntry};
use super::validity::{self, ValidityEntry};
use serde::Deserialize;
use std::sync::Arc;
use trackwright_field::bernstein::coefficient_count;
use trackwright_field::environment::{Jitter, Provenance};
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::volume::Volume;
use trackwright_metal::setup::RoomMetal;

/// What an environment's file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentFile {
    /// The room without the metal.
    pub environment: Environment,
    /// What is added to the room. Its meshes have no surface yet.
    pub metal: Option<RoomMetal>,
}

impl EnvironmentFile {
    /// Room and metal, with the surfaces that `mesh` has for the references of the metal's meshes.
    ///
    /// # Errors
    /// Those of `mesh`.
    pub fn into_room<E>(
        self,
        mesh: impl FnMut(&MeshReference) -> Result<Arc<SurfaceMesh>, E>,
    ) -> Result<(Environment, Option<RoomMetal>), E> {
        let metal = self.metal.map(|metal| metal.with_surfaces(mesh)).transpose()?;
        Ok((self.environment, metal))
    }
}

#[derive(Deserialize)]
#[serde(rename = "Environment", deny_unknown_fields)]
struct EnvironmentEntry {
    #[serde(rename = "version")]
    _version: Version,
    name: String,
    volume: Option<Volume>,
    jitter: Option<Jitter>,
    provenance: Option<Provenance>,
    model: Option<DistortionModel>,
    support: Option<ValidityEntry>,
    process: Option<ProcessEntry>,
    kriging: Option<KrigingEntry>,
    harmonic: Option<HarmonicEntry>,
    metal: Option<RoomMetalEntry>,
}

/// Reads an environment.
///
/// # Errors
/// Anything that leaves a doubt about what the room is; see [`FormatError`].
pub fn parse(bytes: &[u8]) -> Result<EnvironmentFile, FormatError> {
    let entry: EnvironmentEntry = ron_text::parse(bytes)?;
    if let Some(Volume::Box(bounds)) = &entry.volume {
        bounds.check().map_err(FormatError::Volume)?;
    }
    if let Some((name, found, expected)) = entry.jitter.as_ref().and_then(Jitter::problem) {
        return Err(FormatError::number(name, found, expected));
    }
    if let Some(provenance) = &entry.provenance {
        check_provenance(provenance)?;
    }
    let metal = entry.metal.map(RoomMetalEntry::check).transpose()?;
    let model = match (entry.model, &entry.volume, &metal) {
        (Some(model), ..) => model,
        (None, Some(volume), Some(_)) => {
            DistortionModel::zero(volume.bounds(), MapKind::Distortion)
        }
        _ => {
            return Err(FormatError::field("model", "missing", "a model, or a volume with metal"));
        }
    };
    let support = entry.support.map(|s| s.check(&model)).transpose()?;
    let process = entry.process.map(ProcessEntry::check).transpose()?;
    let model = computed_model::check(model, entry.kriging, entry.harmonic, process.as_ref())?;
    let environment = Environment {
        name: entry.name,
        model,
        volume: entry.volume,
        jitter: entry.jitter,
        provenance: entry.provenance,
        fit_validity: support,
        process,
        metal: None,
    };
    Ok(EnvironmentFile { environment, metal })
}

/// What a fit was like is only shown, but numbers that no fit has are none to show.
fn check_provenance(provenance: &Provenance) -> Result<(), FormatError> {
    let Provenance { ridge, train_before, train_after, holdout, .. } = provenance;
    let mut figures = vec![("train_before", *train_before), ("train_after", *train_after)];
    if let Some(holdout) = holdout {
        figures.extend([("holdout.before", holdout.before), ("holdout.after", holdout.after)]);
    }
    let mut numbers = vec![("ridge".to_owned(), *ridge)];
    for (name, figures) in figures {
        numbers.push((format!("{name}.position_rms_mm"), figures.position_rms_mm));
        let angle = figures.angle_rms_rad;
        numbers.extend(angle.map(|angle| (format!("{name}.angle_rms_rad"), angle)));
    }
    let is_wrong = |value: f64| !(value.is_finite() && value >= 0.0);
    match numbers.into_iter().find(|(_, value)| is_wrong(*value)) {
        None => Ok(()),
        Some((name, value)) => {
            let name = format!("provenance.{name}");
            Err(FormatError::number(name, value, "zero or more"))
        }
    }
}

/// Writes an environment and the metal that is added to it, a coefficient's six values a line.
pub fn write(environment: &Environment, metal: Option<&RoomMetal>) -> String {
    let is_bare = |volume: &Volume| {
        environment.model == DistortionModel::zero(volume.bounds(), MapKind::Distortion)
    };
    let is_model_left_out = metal.is_some() && environment.volume.as_ref().is_some_and(is_bare);
    RonWriter::file(|out| {
        out.string("name", &environment.name);
        if let Some(volume) = &environment.volume {
            out.value("volume", volume, 0);
        }
        if let Some(jitter) = &environment.jitter {
            out.value("jitter", jitter, 0);
        }
        if let Some(provenance) = &environment.provenance {
            out.value("provenance", provenance, 1);
        }
        if !is_model_left_out {
            out.fields("model", |out| write_model(out, &environment.model));
        }
        if let Some(validity) = &environment.fit_validity {
            validity::write(out, validity.parts());
        }
        if let Some(process) = &environment.process {
            process::write(out, process);
        }
        computed_model::write(out, &environment.model);
        if let Some(metal) = metal {
            out.fields("metal", |out| room_metal::write(out, metal));
        }
    })
}

fn write_model(out: &mut RonWriter, model: &DistortionModel) {
    let bounds = model.bounds();
    let [min, max] = [bounds.min_mm, bounds.max_mm].map(|p| ron_text::tuple(p.coords.as_slice()));
    let directions = model.directions().directions();
    out.field("order", model.order());
    out.field("directions", directions.len());
    out.value("weighting", &model.weighting(), 0);
    out.value("map", &model.map(), 0);
    out.field("box", format_args!("({min}, {max})"));
    out.list("coefficients", |out| {
        let each = coefficient_count(model.order());
        let (count, coefficients) = (directions.len(), model.coefficients().chunks(each));
        for ((number, axis), coefficients) in (1..).zip(directions).zip(coefficients) {
            out.line(format_args!(
                "// {number} of {count}: axis ({:.4}, {:.4}, {:.4})",
                axis.x, axis.y, axis.z
            ));
            coefficients.iter().for_each(|c| out.line(ron_text::tuple(c) + ","));
        }
    });
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::test_cases::assert_refused;
    use nalgebra::{Point3, Unit, Vector3};
    use trackwright_field::environment::{HoldoutProvenance, JitterGrowth};
    use trackwright_field::fit::{FitMethod, Residuals};
    use trackwright_field::gaussian::{
        Amplitude, GaussianField, Kernel, KernelScale, Registration, Row, Trend,
    };
    use trackwright_field::generator::Generator;
    use trackwright_field::harmonic::HarmonicModel;
    use trackwright_field::validity::{Cell, Cells, FitValidityParts};
    use trackwright_field::{FieldPoint, FitValidity};
    use trackwright_geometry::bounds::Bounds;
    use trackwright_geometry::directions::{DirectionSet, Weighting};

    pub(crate) fn parse(bytes: &[u8]) -> Result<Environment, FormatError> {
        super::parse(bytes).map(|file| file.environment)
    }

    pub(crate) fn write(environment: &Environment) -> String {
        super::write(environment, None)
    }

    /// A room without distortion.
    pub(crate) fn ideal(volume: Volume) -> Environment {
        let model = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
        Environment { volume: Some(volume), ..Environment::of_model("ideal", model) }
    }

    pub(crate) fn room() -> Environment {
        let coefficients = (0..6 * 8)
            .map(|i| std::array::from_fn(|k| f64::from(i * 7 + k as i32) / 3.0 - 40.0))
            .collect();
        let model = DistortionModel::new(
            1,
            DirectionSet::Six,
            Weighting::Gnomonic,
            MapKind::Distortion,
            Bounds::from(([-1.0, -2.0, -300.5], [1.0, 2.0, -0.1])),
            coefficients,
        );
        let residuals =
            |position_rms_mm, angle_rms_rad| Residuals { position_rms_mm, angle_rms_rad };
        Environment {
            volume: Some(Volume::AuroraCube),
            jitter: Some(Jitter {
                growth: Some(JitterGrowth::dipole(250.0)),
                ..Jitter::uniform(0.1, 0.001)
            }),
            provenance: Some(Provenance {
                data: "data.csv".to_owned(),
                samples: 12,
                method: FitMethod::Joint,
                ridge: 1e-7,
                train_before: residuals(2.5, Some(0.01)),
                train_after: residuals(1.0 / 3.0, None),
                holdout: Some(HoldoutProvenance {
                    data: "other.csv".to_owned(),
                    samples: 3,
                    before: residuals(2.0, None),
                    after: residuals(1.5, None),
                }),
            }),
            ..Environment::of_model("A \"room\"", model.unwrap())
        }
    }

    fn error(text: &str) -> String {
        parse(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_reads_back_to_the_bit() {
        let room = room();
        let in_volume = |volume| Environment { volume: Some(volume), ..room.clone() };
        let with_validity = |fit_validity| Environment { fit_validity, ..room.clone() };
        let with_process = |has_rotations| {
            let process = Some(Arc::new(process(has_rotations)));
            Environment { process, ..room.clone() }
        };
        for volume in Volume::NAMED {
            assert!(write(&in_volume(volume)).contains(&format!("    volume: {volume:?},\n")));
        }
        let mut parts = support(&room).parts().clone();
        parts.angle_std_rad = None;
        parts.undetermined.clear();
        let without_angles = FitValidity::from_parts(parts, &room.model).unwrap();
        // Without coefficients.
        let ideal = DistortionModel::zero(*room.model.bounds(), MapKind::Distortion);
        let others = [
            in_volume(Volume::Box(Bounds::from(([0.0; 3], [1.0; 3])))),
            Environment { jitter: Some(Jitter::uniform(0.2, 0.0)), ..room.clone() },
            Environment { volume: None, jitter: None, provenance: None, ..room.clone() },
            with_validity(Some(support(&room))),
            with_validity(Some(without_angles)),
            with_process(true),
            with_process(false),
            Environment { model: ideal, ..room.clone() },
        ];
        for room in Volume::NAMED.map(in_volume).into_iter().chain(others) {
            let text = write(&room);
            assert_eq!(parse(text.as_bytes()).unwrap(), room, "{text}");
        }
    }

    /// Numbers that need all their digits, an unknown deviation, a form that is zero.
    pub(crate) fn support(room: &Environment) -> FitValidity {
        let form = |i: usize| (0..27).map(|k| (i * 27 + k) as f64 / 3.0 - 9.0).collect();
        let parts = FitValidityParts {
            position_std_mm: vec![Some(0.1), None, Some(1.0 / 3.0), Some(1e-300), None, None],
            angle_std_rad: Some(vec![Some(0.0); 6]),
            greatest_leverage: vec![0.7; 6],
            greatest_undetermined: vec![1e-17; 6],
            variance: (0..18).map(form).collect(),
            leverage: (0..6).map(form).collect(),
            undetermined: vec![Vec::new(), form(1), Vec::new(), form(3), form(4), form(5)],
            cells: Cells::new(
                [-0.1, 1.0 / 3.0, -300.0].into(),
                0.125,
                vec![Cell { index: [0, 4095, 7], directions: 63 }; 20],
            ),
        };
        FitValidity::from_parts(parts, &room.model).unwrap()
    }

    fn refit(size: f64) -> HarmonicModel {
        let generator = Generator::planar_nine();
        let numbers = (0..3 * generator.coils.len()).map(|k| size / (1.0 + k as f64)).collect();
        HarmonicModel::new(generator, Point3::new(0.0, 1.0 / 3.0, -300.0), 400.0, 1, numbers)
            .unwrap()
    }

    /// Rows as they are kept, an outlier, a kernel without axes.
    pub(crate) fn process(has_rotations: bool) -> GaussianField {
        let row = |i: i32| Row {
            point: FieldPoint {
                position_mm: [f64::from(i) / 8.0, -1e-6, -300.123_456].into(),
                axis: Unit::new_unchecked(Vector3::new(0.6, 0.0, -0.8)),
                x_axis: has_rotations.then(Vector3::y_axis),
            },
            error: std::array::from_fn(|k| f64::from(i + k as i32) * 1e-9),
            noise_factor: if i == 1 { 1e6 } else { 1.0 },
        };
        let scale = |length_mm| KernelScale {
            length_mm,
            axis_sine: if has_rotations { 1.0 / 3.0 } else { f64::INFINITY },
            x_axis_sine: if has_rotations { 2.0 / 3.0 } else { f64::INFINITY },
            variance: 0.1,
        };
        GaussianField {
            trend: if has_rotations { Trend::Model } else { Trend::None },
            kernel: Kernel { scales: [scale(100.0 / 3.0), scale(11.0)], nugget: 1e-6 },
            amplitude: Amplitude {
                log_variance: [0.1; 10],
                ..Amplitude::flat(&Bounds::from(([0.0; 3], [1.0 / 3.0; 3])))
            },
            component_covariance: std::array::from_fn(|a| {
                std::array::from_fn(|b| if a == b { 1.0 / 7.0 } else { -1e-300 })
            }),
            rows: (0..3).map(row).collect(),
            has_rotations,
            measured_rows: 5_000,
            left_out_rms_mm: 2.0 / 3.0,
            sensor_variance: has_rotations.then_some([0.1, 0.0, 1.0 / 7.0, 1e-6, 1e-300, 0.0]),
            refits: if has_rotations { vec![refit(0.1), refit(1.0 / 3.0)] } else { Vec::new() },
            registration: has_rotations.then_some(Registration {
                position_std_mm: 1.0 / 3.0,
                angle_std_rad: 1e-3,
                center_mm: [0.1, 0.0, -1.0 / 7.0],
            }),
        }
    }

    #[test]
    fn processes_that_cannot_be_are_refused() {
        let mut room = room();
        room.process = Some(Arc::new(process(true)));
        let text = write(&room);
        let cases = r#"
            nugget: 1e-6 => nugget: 0 | …process.kernel.nugget is 0…
            length_mm: 11 => length_mm: -11 | …length_mm is -11…
            (0.6, 0.0, -0.8) => (0.6, 0.0, 0.9) | …process.rows[0]…
            1000000, => NaN, | …process.rows[1]…
            Some((0.0, 1.0, 0.0)) => Some((0.0, 2.0, 0.0)) | …process.rows[0] is an axis of length 2…
            x_axis_sine: 0.6 => x_axis_sine: -0.6 | …process.kernel.scales.x_axis_sine is -0.6…
            trend: Model => trend: Mean | …`None` or `Model`…
        "#;
        assert_refused(&text, cases, error);
    }

    #[test]
    fn supports_that_cannot_be_are_refused() {
        let mut room = room();
        room.fit_validity = Some(support(&room));
        let text = write(&room);
        let cases = r#"
            std_mm: [0.1, => std_mm: [-0.1, | …position_std_mm holds -0.1…
            std_mm: [0.1, => std_mm: [NaN, | …position_std_mm holds NaN…
            std_mm: [0.1, => std_mm: [ | …position_std_mm has 5 entries, expected 6…
            std_rad: [0, => std_rad: [ | …angle_std_rad has 5 entries, expected 6…
            leverage: [0.7, => leverage: [inf, | …greatest_leverage holds inf…
            undetermined: [1e-17, => undetermined: [ | …greatest_undetermined has 5…
            variance: [\n            [-9, => variance: [\n            [NaN, | …variance holds NaN…
            variance: [\n            [-9, => variance: [\n            [ | …variance has 26 entries…
            variance: [ => variance: [[], | …variance has 19 entries, expected 18…
            leverage: [\n => leverage: [[],\n | …leverage has 7 entries, expected 6…
            undetermined: [\n => undetermined: [[1],\n | …undetermined has 7 entries…
            origin: (-0.1, => origin: (NaN, | …support.samples.origin is (NaN,…
            edge: 0.125 => edge: -0.125 | …cells holds -0.125, expected an edge in mm…
            (0,4095,7,63) => (0,4095,7,64) | …cells holds 64, expected bits…
            (0,4095,7,63) => (0,-1,7,63) | …integer is out of bounds…
        "#;
        assert_refused(&text, cases, error);
        let crowded =
            text.replacen("cells: [", &format!("cells: [{}", "(0,0,0,1),".repeat(4096)), 1);
        let message = error(&crowded);
        assert!(message.contains("cells has 4116 entries, expected 4096"), "{message}");
        room.model = DistortionModel::zero(*room.model.bounds(), MapKind::Distortion);
        let message = error(&write(&room));
        assert!(message.contains("support: a model of order 0 has none"), "{message}");
    }

    #[test]
    fn jitter_growth_defaults_to_none_or_a_dipole() {
        let text = write(&room());
        let (start, end) = (text.find("jitter: ").unwrap(), text.find("    provenance").unwrap());
        let with = |jitter: &str| {
            let text = format!("{}jitter: {jitter},\n{}", &text[..start], &text[end..]);
            parse(text.as_bytes()).unwrap().jitter.unwrap()
        };
        assert_eq!(with("(position_mm: 0.2, angle_rad: 0.003)"), Jitter::uniform(0.2, 0.003));
        assert_eq!(
            with("(position_mm: 0.2, angle_rad: 0.003, growth: (distance_mm: 300))").growth,
            Some(JitterGrowth::dipole(300.0))
        );
    }

    #[test]
    fn a_coefficient_is_one_line() {
        assert_eq!(write(&room()).matches("            (").count(), 48);
    }

    #[test]
    fn rooms_that_cannot_be_are_refused() {
        let text = write(&room());
        let cases = r#"
            directions: 6 => directions: 12 | …48 coefficients, expected 96…
            directions: 6 => directions: 7 | …no set of 7 basis orientations…
            order: 1 => order: 99 | …order is 99, expected 0 to…
            order: 1 => order: 99999999999 | …order is 99999999999…
            (-40.0, => (NaN, | …coefficient 0 is not finite…
            -300.5 => 300.5
                | …box: min z is 300.5, max z is -0.1, expected min at most max…
            position_mm: 0.1 => position_mm: -0.1 | …jitter.position_mm is -0.1…
            distance_mm: 250.0 => distance_mm: 0
                | …jitter.growth.distance_mm is 0, expected a length above zero…
            angle_exponent: 3.0 => angle_exponent: -1
                | …jitter.growth.angle_exponent is -1, expected 0 to 8…
            position_exponent: 4.0 => position_exponent: NaN
                | …jitter.growth.position_exponent is NaN…
            volume: AuroraCube => volume: AuroraBall
                | …`AuroraDome` or `AuroraTabletop` or `AuroraCompact` or `Box`…
            volume: AuroraCube => volume: AuroraDome(480.0) | …found `(`…
        "#;
        assert_refused(&text, cases, error);
    }
}
