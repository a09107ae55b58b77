//! Bodies, `*.body.ron`: a tool or CRF with its sensors.

use super::error::{FormatError, from_base64, in_part};
use super::mounting::{self, BoxEntry, RegionEntry};
use super::ron_text::{self, RonWriter, Version};
use super::tool_definition::OnMismatch;
use super::tool_definition::definition::ToolDefinition;
use data_encoding::BASE64;
use serde::Deserialize;
use std::sync::Arc;
use trackwright_design::definition::{DefinitionFile, DefinitionKind};
use trackwright_design::{DesignBody, MAX_SENSORS};
use trackwright_geometry::limits::length_above_zero_problem;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_simulation::body::{Coil, RigidBody, Sensor, SensorOrientation};
use trackwright_simulation::mounting::Mounting;

/// What a body file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyFile {
    pub rigid: RigidBody,
    /// Its file is relative to the body's.
    pub mesh: Option<MeshReference>,
    /// The maker's file that the body came from, for what of it no body has.
    pub definition: Option<Arc<DefinitionFile>>,
    /// Where its sensors may be put.
    pub mounting: Mounting,
}

impl BodyFile {
    /// What a body's own file holds of it.
    pub fn of(body: &DesignBody) -> Self {
        Self {
            rigid: body.rigid.clone(),
            mesh: body.mesh.clone(),
            definition: body.definition.clone(),
            mounting: body.mounting.clone(),
        }
    }
}

#[derive(Deserialize)]
#[serde(rename = "Body", deny_unknown_fields)]
struct BodyEntry {
    #[serde(rename = "version")]
    _version: Version,
    name: String,
    mesh: Option<String>,
    mesh_unit: Option<MeshUnit>,
    tip: Option<[f64; 3]>,
    sensors: Vec<SensorEntry>,
    tool_definition: Option<DefinitionEntry>,
    mounting: Option<Vec<RegionEntry>>,
    keep_out: Option<Vec<BoxEntry>>,
    least_gap: Option<f64>,
    tip_clearance: Option<f64>,
}

/// A whole file of a kind, in base64.
#[derive(Deserialize)]
#[serde(rename = "ToolDefinition", deny_unknown_fields)]
struct DefinitionEntry {
    kind: DefinitionKind,
    file: String,
}

#[derive(Deserialize)]
#[serde(rename = "Sensor", deny_unknown_fields)]
struct SensorEntry {
    name: String,
    kind: SensorKind,
    position: [f64; 3],
    axis: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    coil: Option<Coil>,
}

#[derive(Deserialize)]
enum SensorKind {
    /// A position alone; an axis or a rotation has no meaning for it.
    Marker,
    FiveDof,
    SixDof,
}

/// Reads a body.
///
/// ```
/// use trackwright_formats::body::{parse, write};
///
/// let marker = "(name: \"a\", kind: Marker, position: (0, 0, 9))";
/// let text = format!("(version: 1, name: \"probe\", sensors: [{marker}])");
/// let body = parse(text.as_bytes())?;
/// assert_eq!(body.rigid.sensors[0].position_in_body.z, 9.0);
/// assert_eq!(parse(write(&body).as_bytes())?, body);
/// # Ok::<(), trackwright_formats::FormatError>(())
/// ```
///
/// # Errors
/// Anything that leaves a doubt about what the body is; see [`FormatError`].
pub fn parse(bytes: &[u8]) -> Result<BodyFile, FormatError> {
    let entry: BodyEntry = ron_text::parse(bytes)?;
    if entry.sensors.is_empty() {
        return Err(FormatError::field("sensors", "empty", "at least one sensor"));
    }
    if entry.sensors.len() > MAX_SENSORS {
        return Err(FormatError::field("sensors", entry.sensors.len(), "at most 1,000"));
    }
    ron_text::check_names("sensors", entry.sensors.iter().map(|sensor| sensor.name.as_str()))?;
    let sensors = entry.sensors.into_iter().enumerate();
    let sensors = sensors.map(|(index, sensor)| read_sensor(index, sensor));
    let sensors = sensors.collect::<Result<_, _>>()?;
    let tip_in_body = entry.tip.map(|tip| ron_text::point("tip", tip)).transpose()?;
    Ok(BodyFile {
        rigid: RigidBody { name: entry.name, tip_in_body, sensors },
        mesh: read_mesh(entry.mesh, entry.mesh_unit)?,
        definition: entry.tool_definition.map(read_definition).transpose()?,
        mounting: mounting::check(
            entry.mounting,
            entry.keep_out,
            entry.least_gap,
            entry.tip_clearance,
        )?,
    })
}

fn read_definition(entry: DefinitionEntry) -> Result<Arc<DefinitionFile>, FormatError> {
    let bytes = from_base64("tool_definition.file", entry.file.as_bytes())?;
    // Whoever made the body was warned of a sum that does not match, and wanted it all the same.
    ToolDefinition::parse(entry.kind, &bytes, OnMismatch::Accept)
        .map(|definition| Arc::new(definition.file()))
        .map_err(in_part("tool_definition"))
}

fn read_mesh(
    file: Option<String>,
    unit: Option<MeshUnit>,
) -> Result<Option<MeshReference>, FormatError> {
    if file.as_deref() == Some("") {
        return Err(FormatError::field("mesh", "empty", "a file"));
    }
    if ron_text::mesh_unit("mesh_unit", unit)?.is_some() && file.is_none() {
        return Err(FormatError::field("mesh", "missing", "one with mesh_unit"));
    }
    Ok(file.map(|file| MeshReference { file, unit }))
}

fn read_sensor(index: usize, entry: SensorEntry) -> Result<Sensor, FormatError> {
    let place = format!("sensors[{index}] {:?}", entry.name);
    let orientation = match entry.kind {
        SensorKind::Marker => SensorOrientation::Marker,
        SensorKind::FiveDof => {
            let axis = entry.axis.ok_or_else(|| {
                FormatError::field(format!("{place}: axis"), "missing", "one with kind FiveDof")
            })?;
            SensorOrientation::FiveDof(ron_text::axis(&format!("{place}: axis"), axis)?)
        }
        SensorKind::SixDof => {
            let field = format!("{place}: rotation");
            let rotation = entry.rotation.ok_or_else(|| {
                FormatError::field(field.as_str(), "missing", "one with kind SixDof")
            })?;
            SensorOrientation::SixDof(ron_text::rotation(&field, rotation)?)
        }
    };
    if let Some(coil) = entry.coil {
        for (name, value) in [("diameter", coil.diameter_mm), ("length", coil.length_mm)] {
            if let Some(expected) = length_above_zero_problem(value) {
                let field = format!("{place}: coil.{name}");
                return Err(FormatError::number(field, value, expected));
            }
        }
    }
    Ok(Sensor {
        position_in_body: ron_text::point(&format!("{place}: position"), entry.position)?,
        name: entry.name,
        orientation,
        coil: entry.coil,
    })
}

/// Writes a body, one sensor a line.
pub fn write(body: &BodyFile) -> String {
    RonWriter::file(|out| {
        out.string("name", &body.rigid.name);
        if let Some(mesh) = &body.mesh {
            out.string("mesh", &mesh.file);
            out.optional("mesh_unit", mesh.unit);
        }
        if let Some(tip) = &body.rigid.tip_in_body {
            out.field("tip", ron_text::tuple(tip.coords.as_slice()));
        }
        out.lines("sensors", body.rigid.sensors.iter().map(sensor_line));
        mounting::write(out, &body.mounting);
        if let Some(definition) = &body.definition {
            let (kind, file) = (definition.kind, BASE64.encode(&definition.bytes));
            out.field("tool_definition", format_args!("(kind: {kind:?}, file: \"{file}\")"));
        }
    })
}

fn sensor_line(sensor: &Sensor) -> String {
    let position = ron_text::tuple(sensor.position_in_body.coords.as_slice());
    let (kind, turn) = match &sensor.orientation {
        SensorOrientation::Marker => ("Marker", String::new()),
        SensorOrientation::FiveDof(axis) => {
            ("FiveDof", format!(", axis: {}", ron_text::tuple(axis.as_slice())))
        }
        SensorOrientation::SixDof(rotation) => {
            let numbers = trackwright_geometry::pose::quaternion_to_array(rotation);
            ("SixDof", format!(", rotation: {}", ron_text::tuple(&numbers)))
        }
    };
    let coil = sensor.coil.map_or_else(String::new, |coil| {
        format!(", coil: (diameter: {:?}, length: {:?})", coil.diameter_mm, coil.length_mm)
    });
    let name = ron_text::string(&sensor.name);
    format!("(name: {name}, kind: {kind}, position: {position}{turn}{coil})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mounting::tests::any_mounting;
    use crate::test_cases::{any_text, assert_refused};
    use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
    use proptest::prelude::*;
    use trackwright_geometry::limits::MAX_LENGTH_MM;

    const EXAMPLE: &str = r#"(
    version: 1,
    name: "Pointer",
    mesh: Some("../../assets/meshes/pointer.glb"),     // opt
    tip: (0.0, 0.0, 0.0),
    sensors: [
        (name: "shaft", kind: FiveDof, position: (0.0, 0.0, 120.0), axis: (0, 0, 2)),
        (name: "handle", kind: SixDof, position: (12.0, 0.0, 150.0), rotation: (2.0, 0.0, 0.0, 0.0), coil: (diameter: 0.8, length: 9.0)),
    ],
)
"#;

    fn error(text: &str) -> String {
        parse(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn the_contracts_example_is_read() {
        let body = parse(EXAMPLE.as_bytes()).unwrap();
        assert_eq!(body.mesh, Some(MeshReference::new("../../assets/meshes/pointer.glb")));
        assert_eq!(body.rigid.tip_in_body, Some(Point3::origin()));
        let [shaft, handle] = &body.rigid.sensors[..] else { panic!("{:?}", body.rigid.sensors) };
        assert_eq!(shaft.orientation, SensorOrientation::FiveDof(Vector3::z_axis()));
        assert_eq!(handle.orientation, SensorOrientation::SixDof(UnitQuaternion::identity()));
        assert_eq!(handle.coil.unwrap().length_mm, 9.0);
    }

    #[test]
    fn unknown_fields_are_refused() {
        let text = EXAMPLE.replace("tip: (0.0, 0.0, 0.0),", "tip: None,");
        let body = parse(text.as_bytes()).unwrap();
        assert_eq!(body.rigid.tip_in_body, None);
        let maker = "maker: (name: \"x\", years: [1, 2], kind: Own(3)),";
        let text = EXAMPLE.replace("tip: (0.0, 0.0, 0.0),", maker);
        assert_eq!(
            error(&text),
            "line 5, column 5: found the unknown field `maker`, expected `version` or `name` or \
             `mesh` or `mesh_unit` or `tip` or `sensors` or `tool_definition` or `mounting` or \
             `keep_out` or `least_gap` or `tip_clearance`"
        );
        // A later version is reported before its fields are read, or its end.
        let later = text.replace("version: 1", "version: 9");
        let expected = "version is 9, expected 1; a newer trackwright wrote it";
        assert_eq!(error(&later), expected);
        assert_eq!(error(&later[..later.len() / 2]), expected);
    }

    #[test]
    fn a_body_has_at_most_a_thousand_sensors() {
        let sensor = |i| {
            format!("(name: \"{i}\", kind: SixDof, position: (0, 0, 0), rotation: (1, 0, 0, 0))")
        };
        let of = |count: usize| {
            let sensors: Vec<String> = (0..count).map(sensor).collect();
            parse(
                format!("(version: 1, name: \"x\", sensors: [{}])", sensors.join(", ")).as_bytes(),
            )
        };
        assert_eq!(of(1_000).unwrap().rigid.sensors.len(), 1_000);
        assert_eq!(of(1_001).unwrap_err().to_string(), "sensors is 1001, expected at most 1,000");
    }

    #[test]
    fn every_wrong_field_is_named() {
        let cases = r#"
            version: 1 => version: 0 | version is 0, expected 1
            version: 1, => | line 10, column 1: found no field `version`, expected it
            axis: (0, 0, 2) => axis: (0, 0, 0)
                | sensors[0] "shaft": axis is (0, 0, 0), expected a direction
            axis: (0, 0, 2) => axis: (0, NaN, 2)
                | sensors[0] "shaft": axis is (0, NaN, 2), expected a direction
            , axis: (0, 0, 2) =>
                | sensors[0] "shaft": axis is missing, expected one with kind FiveDof
            rotation: (2.0, 0.0, 0.0, 0.0) => rotation: (0, 0, 0, 0)
                | sensors[1] "handle": rotation is (0, 0, 0, 0), expected a quaternion (w, x, y, z)
            position: (12.0, 0.0, 150.0) => position: (inf, 0.0, 150.0)
                | sensors[1] "handle": position is (inf, 0, 150), expected finite numbers
            "handle" => "shaft"
                | sensors[1]: name is "shaft", the name of sensors[0], expected each name once
            "handle" => " " | sensors[1]: name is empty, expected a name
            diameter: 0.8 => diameter: 0
                | sensors[1] "handle": coil.diameter is 0, expected a length above zero
            tip: (0.0, 0.0, 0.0), => mesh_unit: Factor(0),
                | mesh_unit is 0 mm, expected a length above zero
            mesh: Some("../../assets/meshes/pointer.glb") => mesh_unit: Inch
                | mesh is missing, expected one with mesh_unit
            tip: (0.0, 0.0, 0.0) => tip: (0.0, 1e999, 0.0)
                | line 5, column 16: found `1e999`, expected a number of at most 1e30
            kind: FiveDof => kind: SevenDof | line 7, column …
            name: "Pointer", => name: "Pointer" | line 4, column …
            axis: (0, 0, 2) => axis: (0, 2) | line 7, column …
            position: (0.0, 0.0, 120.0) => position: (0.0, 0.0, "a") | line 7, column …
            (version: 1, name: "x", sensors: [])
                | sensors is empty, expected at least one sensor
        "#;
        assert_refused(EXAMPLE, cases, |text| {
            let message = error(text);
            assert!(message.contains(" is ") || message.contains("found "), "{message}");
            assert!(message.contains("expected "), "{message}");
            message
        });
        let message = error(&EXAMPLE[..EXAMPLE.len() / 2]);
        assert!(message.contains("found the end of the file"), "{message}");
        let message = parse(b"(\n  \xff").unwrap_err().to_string();
        assert_eq!(message, "line 2, column 3: found a byte that is not UTF-8, expected text");
    }

    fn any_coordinate() -> impl Strategy<Value = f64> {
        any::<f64>().prop_filter("a coordinate", |v| v.abs() <= MAX_LENGTH_MM)
    }

    fn sensor() -> impl Strategy<Value = Sensor> {
        let direction = prop::array::uniform4(-1.0..1.0_f64);
        let coil = prop::option::of((1e-3..1e3, 1e-3..1e3_f64));
        let position = prop::array::uniform3(any_coordinate());
        (0..3_u8, position, direction, coil).prop_map(|(kind, position, [w, x, y, z], coil)| {
            let vector = Vector3::new(x, y, z + 2.0);
            Sensor {
                name: String::new(),
                position_in_body: position.into(),
                orientation: match kind {
                    0 => SensorOrientation::Marker,
                    1 => SensorOrientation::FiveDof(Unit::new_normalize(vector)),
                    _ => {
                        let q = nalgebra::Quaternion::new(w.abs() + 1.0, x, y, z);
                        SensorOrientation::SixDof(UnitQuaternion::new_normalize(q))
                    }
                },
                coil: coil.map(|(diameter_mm, length_mm)| Coil { diameter_mm, length_mm }),
            }
        })
    }

    fn unit() -> impl Strategy<Value = MeshUnit> {
        prop_oneof![
            prop::sample::select(MeshUnit::NAMED.to_vec()),
            (1e-300..=MAX_LENGTH_MM).prop_map(MeshUnit::Factor),
        ]
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back_to_the_bit(
            name in any_text(0..20),
            mesh in prop::option::of((any_text(1..20), prop::option::of(unit()))),
            tip in prop::option::of(prop::array::uniform3(any_coordinate())),
            mut sensors in prop::collection::vec(sensor(), 1..5),
            mounting in any_mounting(),
        ) {
            for (i, sensor) in sensors.iter_mut().enumerate() {
                sensor.name = format!("sensor \"{i}\" \\ {name}");
            }
            let body = BodyFile {
                rigid: RigidBody { name, tip_in_body: tip.map(Point3::from), sensors },
                mesh: mesh.map(|(file, unit)| MeshReference { file, unit }),
                definition: None,
                mounting,
            };
            let text = write(&body);
            let back = parse(text.as_bytes()).unwrap();
            prop_assert_eq!(&back, &body);
            prop_assert_eq!(write(&back), text);
        }
    }
}
