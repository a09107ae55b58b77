//! Makers' files for tools: NDI images, `.tool` lists, Atracsys and SAW geometries.

use super::read;
use trackwright_design::definition::DefinitionKind;
use trackwright_formats::body::{self, BodyFile};
use trackwright_formats::tool_definition::{
    DefinitionFormat, OnMismatch, ToolDefinition, from_body, read_body,
};
use trackwright_simulation::{RigidBody, Sensor};

const FORMATS: [DefinitionFormat; 4] = [
    DefinitionFormat::Rom,
    DefinitionFormat::ToolPlist,
    DefinitionFormat::AtracsysIni,
    DefinitionFormat::SawJson,
];

/// Two axes that an image's angles of 32 bits have both been through: half a step near π of each.
const AXIS_TOLERANCE: f64 = 2.4e-7;

/// A definition of any kind, recognised by how it begins: it is kept to the byte, also within a
/// body's own file; a body that was changed is what is read from the changed definition; and what
/// it becomes in other formats is read as the same.
pub fn tool_definition(bytes: &[u8]) -> bool {
    // An unchecked sum lets the bytes of images be anything.
    let Some((file, Some(kind))) = read(read_body(bytes, "", OnMismatch::Accept)) else {
        return false;
    };
    let definition = file.definition.as_deref().expect("it was read from one");
    assert_eq!(definition.bytes, bytes);
    assert_eq!(body::parse(body::write(&file).as_bytes()), Ok(file.clone()));

    let own = format_of(kind);
    let unchanged = from_body(&file, own).expect("it was such a definition");
    match unchanged.mended_checksum {
        None => assert_eq!(*unchanged.definition.write(), *bytes),
        Some(_) => assert_same(&reread(&unchanged.definition), &file.rigid),
    }
    let changed = changed(&file);
    let written = from_body(&changed, own).expect("it has as many sensors as one may");
    assert_same(&reread(&written.definition), &changed.rigid);

    for format in FORMATS {
        if let Some(conversion) = read(from_body(&file, format)) {
            let definition = conversion.definition;
            let again =
                ToolDefinition::parse(definition.kind(), &definition.write(), OnMismatch::Refuse);
            assert_eq!(again.as_ref(), Ok(&definition));
        }
    }
    true
}

fn format_of(kind: DefinitionKind) -> DefinitionFormat {
    match kind {
        DefinitionKind::NdiOptical | DefinitionKind::NdiEm => DefinitionFormat::Rom,
        DefinitionKind::ToolPlist => DefinitionFormat::ToolPlist,
        DefinitionKind::AtracsysIni => DefinitionFormat::AtracsysIni,
        DefinitionKind::SawJson => DefinitionFormat::SawJson,
    }
}

/// With a sensor elsewhere and, where there are enough, one less.
fn changed(file: &BodyFile) -> BodyFile {
    let mut changed = file.clone();
    let sensors = &mut changed.rigid.sensors;
    if let Some(first) = sensors.first_mut() {
        // Numbers that 32 bits hold.
        first.position_in_body = [1.5, -2.25, 1024.0].into();
    }
    if sensors.len() > 3 {
        sensors.pop();
    }
    changed
}

fn reread(definition: &ToolDefinition) -> RigidBody {
    let written = definition.write();
    let (file, _) = read_body(&written, "", OnMismatch::Refuse).expect("it was written here");
    file.rigid
}

fn assert_same(found: &RigidBody, expected: &RigidBody) {
    assert_eq!(found.name, expected.name);
    assert_eq!(found.tip_in_body, expected.tip_in_body);
    let places = |body: &RigidBody| -> Vec<_> {
        let place = |sensor: &Sensor| (sensor.name.clone(), sensor.position_in_body);
        body.sensors.iter().map(place).collect()
    };
    assert_eq!(places(found), places(expected));
    for (a, b) in found.sensors.iter().zip(&expected.sensors) {
        if let (Some(a), Some(b)) = (a.axis_in_body(), b.axis_in_body()) {
            assert!((a.into_inner() - b.into_inner()).norm() < AXIS_TOLERANCE);
        }
    }
}
