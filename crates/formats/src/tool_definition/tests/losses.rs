//! What any format holds and another does not is named, pair by pair.

use super::super::facts::beyond_body;
use super::*;
use std::collections::BTreeMap;

const FORMATS: [DefinitionFormat; 4] = [
    DefinitionFormat::Rom,
    DefinitionFormat::ToolPlist,
    DefinitionFormat::AtracsysIni,
    DefinitionFormat::SawJson,
];

/// All that a file holds about its tool: by the words that name it where it is lost, its value.
fn held(body: &BodyFile) -> BTreeMap<String, String> {
    let mut held = BTreeMap::new();
    let mut add = |what: &str, value: String| {
        held.insert(what.to_owned(), value);
    };
    let rigid = &body.rigid;
    add("name", rigid.name.clone());
    let tip = rigid.judged_tip_in_body();
    add("the tip (", format!("{tip:?}"));
    add("where sensors may be put", format!("{:?}", body.mounting));
    let sensors = rigid.sensors.iter().enumerate();
    for (number, sensor) in sensors {
        // To what seven digits keep.
        let place = sensor.position_in_body.map(|v| v as f32);
        add(&format!("position {number}"), format!("{place:?}"));
        if let SensorOrientation::FiveDof(axis) = &sensor.orientation {
            add("the axes of 2 sensors", format!("{axis:?}"));
        }
    }
    let Some(definition) = ToolDefinition::carried(body.definition.as_deref()) else {
        return held;
    };
    if let Some(rom) = definition.rom() {
        let all = [
            ("serial number and date", format!("{:?}", rom.serial())),
            ("manufacturer", rom.manufacturer()),
            (
                "type and revision",
                format!("{} {} {}", rom.main_type(), rom.sub_type(), rom.revision()),
            ),
            ("trailing bytes", format!("{:?}", rom.trailing())),
        ];
        let beyond = beyond_body(rom);
        let is_held = |what: &str| beyond.iter().any(|held| held == what);
        all.into_iter()
            .filter(|(what, _)| is_held(what))
            .for_each(|(what, value)| add(what, value));
    }
    match definition.rom() {
        Some(NdiRom::Optical(rom)) => {
            let markers = rom.markers();
            let of = |part: fn(&OpticalMarker) -> String| -> String {
                markers.iter().map(part).collect::<Vec<_>>().join(" ")
            };
            add("normals of markers", of(|m| format!("{:?}", m.normal)));
            add(
                "faces, groups and firing order of markers",
                of(|m| format!("{} {} {}", m.face, m.group, m.firing)),
            );
            add("normals of faces", format!("{:?}", rom.face_normals()));
            add("marker type", rom.marker_type().to_string());
            add("largest angle of a marker", rom.max_angle_deg().to_string());
            add("largest error of a marker", rom.max_error_mm().to_string());
            add("markers that have to be seen", rom.min_markers().to_string());
            add("algorithm flags", rom.algorithm_flags().to_string());
        }
        Some(NdiRom::Em(rom)) => add("coils that have to be seen", rom.min_coils().to_string()),
        None => {}
    }
    let text = match definition {
        ToolDefinition::Rom(_) => String::new(),
        other => String::from_utf8_lossy(&other.write()).into_owned(),
    };
    for (sign, what) in [
        ("; by hand", "comments"),
        ("// seven", "comments"),
        ("[divot0]", "[divot0]"),
        ("version=1", "version"),
        ("normalX=1", "normalx"),
        ("\"disc // flat\"", "type"),
        ("<key>Name</key>", "key Name"),
    ] {
        if text.contains(sign) {
            add(what, sign.to_owned());
        }
    }
    held
}

#[test]
fn what_another_format_does_not_hold_is_named() {
    let mut optical = optical_image();
    optical.extend(b"behind");
    let mut coils = em_image();
    coils.extend(b"behind");
    let ini = format!("{INI}[divot0]\r\nx=1\r\n");
    let sources: [(&str, Vec<u8>); 6] = [
        ("rom", optical.clone()),
        ("rom", coils.clone()),
        ("tool", super::texts::plist_of(&optical).into_bytes()),
        ("tool", super::texts::plist_of(&coils).into_bytes()),
        ("ini", ini.into_bytes()),
        ("json", JSON.as_bytes().to_vec()),
    ];
    let mut lost_once = BTreeMap::new();
    for (extension, bytes) in &sources {
        let mut body = read(bytes, extension).unwrap();
        // A tip that the maker's file may not have room for.
        body.rigid.tip_in_body = Some(Point3::new(0.5, -9.0, 3.0));
        body.mounting.tip_clearance_mm = 5.0;
        for format in FORMATS {
            let written = to(&body, format);
            let back = read(&written.definition.write(), "").unwrap();
            let (before, after) = (held(&body), held(&back));
            let words: Vec<String> = written.lost.iter().map(ToString::to_string).collect();
            for (what, value) in &before {
                let is_named = words.iter().any(|line| line.contains(what));
                let is_carried = after.get(what) == Some(value);
                let place = format!("{extension} to {format:?}, {what}: {value} of {words:?}");
                assert!(is_carried || is_named, "lost in silence: {place}");
                if !is_carried {
                    *lost_once.entry(what.clone()).or_insert(0) += 1;
                }
            }
        }
    }
    // The test finds losses at all: of each kind that some format has no room for.
    for what in [
        "name",
        "the tip (",
        "where sensors may be put",
        "the axes of 2 sensors",
        "serial number and date",
        "normals of markers",
        "normals of faces",
        "largest angle of a marker",
        "trailing bytes",
        "comments",
        "[divot0]",
        "normalx",
        "type",
        "key Name",
    ] {
        assert!(lost_once.contains_key(what), "{what}: {lost_once:?}");
    }
}

#[test]
fn what_is_not_there_is_not_reported_as_lost() {
    let plain = "[geometry]\ncount=1\nid=7\n[fiducial0]\nx=0\ny=1\nz=2\n";
    let body = read(plain.as_bytes(), "ini").unwrap();
    assert_eq!(to(&body, DefinitionFormat::SawJson).lost, []);
    let list = super::texts::plist_of(&optical_image());
    let list = list.replace("<key>Name</key><string>&b;</string>\n", "");
    let list = list.replace("<key>data</key><data>AA==</data>", "");
    let body = read(list.as_bytes(), "tool").unwrap();
    assert_eq!(to(&body, DefinitionFormat::Rom).lost, []);
}
