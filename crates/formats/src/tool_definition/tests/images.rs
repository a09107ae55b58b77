//! Images of optical and Aurora tools.

use super::*;
use nalgebra::{UnitQuaternion, Vector3};
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_simulation::body::Coil;

#[test]
fn an_unchanged_body_gives_the_image_exactly() {
    for image in [optical_image(), [optical_image(), vec![0xee, 0xfd, 0]].concat(), em_image()] {
        let body = read(&image, "rom").unwrap();
        assert_eq!(rom_bytes(&body), image);
        let again = through_body_file(&body);
        assert_eq!(again, body);
        let conversion = to(&again, DefinitionFormat::Rom);
        assert_eq!(*conversion.definition.write(), image);
        assert_eq!((conversion.lost, conversion.mended_checksum), (vec![], None));
    }
}

#[test]
fn aurora_coils_are_crossed_5_dof_sensors() {
    let body = read(&em_image(), "").unwrap().rigid;
    assert_eq!((body.name.as_str(), body.tip_in_body), ("610029", Some(Point3::origin())));
    let pair = trackwright_simulation::pairs::sensor_pairs(&body.sensors).next().unwrap();
    assert!((pair.distance_mm - 0.7).abs() < 1e-7);
    // Angles are 32-bit numbers: half a step of π in the azimuth tilts an axis by less than this.
    assert!((pair.angle_rad.unwrap().to_degrees() - 25.0).abs() < 1e-5);
    let first = body.sensors[0].axis_in_body().unwrap();
    let expected = Vector3::new(12.5_f64.to_radians().sin(), 0.0, 12.5_f64.to_radians().cos());
    assert!((first.into_inner() - expected).norm() < 1e-7);
}

#[test]
fn only_changed_fields_of_an_image_are_written() {
    let image = optical_image();
    let mut body = read(&image, "rom").unwrap();
    body.rigid.sensors[1].position_in_body.y = 30.0;
    let moved = rom_bytes(&body);
    let found = changes(&image, &moved);
    assert!(found.iter().all(|at| matches!(at, 4..6 | 88..92)), "{found:?}");
    assert!(read(&moved, "rom").is_ok(), "the checksum is made new");
    body.rigid.name = "Pointer".to_owned();
    let found = changes(&moved, &rom_bytes(&body));
    assert!(found.iter().all(|at| matches!(at, 4..6 | 592..612)), "{found:?}");

    let image = em_image();
    let mut body = read(&image, "rom").unwrap();
    body.rigid.sensors[1].orientation = SensorOrientation::FiveDof(Vector3::x_axis());
    let turned = rom_bytes(&body);
    let found = changes(&image, &turned);
    assert!(found.iter().all(|at| matches!(at, 88..96 | 325..329)), "{found:?}");
    let axis = read(&turned, "rom").unwrap().rigid.sensors[1].axis_in_body().unwrap();
    assert!((axis.into_inner() - Vector3::x()).norm() < 1.2e-7);
}

#[test]
fn a_removed_marker_leaves_nothing_behind() {
    let mut body = read(&optical_image(), "rom").unwrap();
    body.rigid.sensors.remove(0);
    let conversion = to(&body, DefinitionFormat::Rom);
    assert_eq!(codes(&conversion.lost), ["sensor_names"]);
    let Some(NdiRom::Optical(rom)) = conversion.definition.rom() else { panic!() };
    let markers = rom.markers();
    assert_eq!(markers.len(), 3);
    for (i, marker) in markers.iter().enumerate() {
        assert_eq!(marker.position, PLACES[i + 1]);
        assert_eq!(marker.normal[2], (i + 1) as f32);
        assert_eq!((marker.firing, marker.face), (i as u8, 1 + (i as u8 + 1) % 2));
    }
    let image = conversion.definition.write();
    assert!(image[72 + 36..312].iter().all(|b| *b == 0));
    assert!(image[552 + 3..572].iter().all(|b| *b == 0));
    // One beside marker 3 is like it.
    let mut new = body.rigid.sensors[1].clone();
    new.name = "new".to_owned();
    new.position_in_body.z += 5.0;
    body.rigid.sensors.push(new);
    body.rigid.sensors.push(marker(7, Point3::new(1.0, 2.0, 3.0)));
    let image = rom_bytes(&body);
    let rom = OpticalRom::parse(&image, OnMismatch::Refuse).unwrap();
    let added = rom.markers()[3];
    assert_eq!((added.normal, added.face, added.firing), ([1.0, 0.0, 2.0], 1, 3));
    assert_eq!((rom.markers().len(), rom.min_markers()), (5, 3));
}

#[test]
fn bodies_that_no_rom_holds_are_refused() {
    let mut body = read(&optical_image(), "rom").unwrap();
    let message = |body: &BodyFile| from_body(body, DefinitionFormat::Rom).unwrap_err().to_string();
    let spare = body.rigid.sensors.split_off(2);
    assert_eq!(message(&body), "2 markers, expected 3 to 20 in an NDI optical ROM");
    body.rigid.sensors = (0..21).map(|i| marker(i, Point3::new(i as f64, 0.0, 0.0))).collect();
    assert_eq!(message(&body), "21 markers, expected 3 to 20 in an NDI optical ROM");
    body.rigid.sensors = spare;
    body.rigid.sensors[0].orientation = SensorOrientation::SixDof(UnitQuaternion::identity());
    assert!(message(&body).starts_with("1 markers, 0 5-DOF and 1 6-DOF sensors, expected markers"));
    for sensor in &mut body.rigid.sensors {
        sensor.orientation = SensorOrientation::FiveDof(Vector3::z_axis());
    }
    body.rigid.sensors.truncate(1);
    assert_eq!(message(&body), "1 coils, expected 2 to 8 in an NDI Aurora ROM");
    let coil = body.rigid.sensors[0].clone();
    body.rigid.sensors = vec![coil; 9];
    assert_eq!(message(&body), "9 coils, expected 2 to 8 in an NDI Aurora ROM");
    body.rigid.sensors.truncate(2);
    body.rigid.sensors[1].position_in_body.x = 1e39;
    assert!(message(&body).contains("expected what a 32-bit number can hold"));
}

#[test]
fn what_a_format_cannot_hold_is_listed() {
    let mut body = read(&em_image(), "rom").unwrap();
    body.mesh = Some(MeshReference::new("sensor.glb"));
    body.rigid.name = "a name that is too long for it".to_owned();
    body.rigid.tip_in_body = Some(Point3::new(0.0, 0.0, 9.0));
    body.rigid.sensors[0].name = "left".to_owned();
    body.rigid.sensors[0].position_in_body.x = 123_456.785;
    body.rigid.sensors[0].coil = Some(Coil { diameter_mm: 0.8, length_mm: 9.0 });
    let rom = to(&body, DefinitionFormat::Rom);
    assert_eq!(
        codes(&rom.lost),
        ["mesh", "coil_sizes", "digits", "body_name", "tip", "sensor_names"]
    );
    let ini = to(&body, DefinitionFormat::AtracsysIni);
    assert_eq!(
        codes(&ini.lost),
        ["mesh", "coil_sizes", "axes", "definition", "body_name", "sensor_names"]
    );
    let pivot = ini.definition.geometry().unwrap().pivot;
    assert_eq!(pivot, body.rigid.tip_in_body, "a tip is a pivot there");
    // The kept name of a name that does not fit is the one in the image.
    assert!(rom.lost[3].to_string().contains("\"610029\""), "{}", rom.lost[3]);
}

#[test]
fn a_wrong_checksum_is_refused_or_mended() {
    for (image, at) in [(optical_image(), 700), (em_image(), 100)] {
        let mut bad = image.clone();
        bad[at] ^= 0x10;
        let message = read(&bad, "rom").unwrap_err();
        let sum = carried(&read(&image, "rom").unwrap()).rom().unwrap().checksum();
        let expected = if bad[at] & 0x10 == 0 { sum.stored - 16 } else { sum.stored + 16 };
        assert!(
            message.starts_with(&format!("checksum is {}, expected {expected}", sum.stored)),
            "{message}"
        );
        let (body, _) = read_body(&bad, "rom", OnMismatch::Accept).unwrap();
        assert_eq!(body.definition.as_ref().unwrap().bytes, bad);
        // A body file keeps it as it was; what is written as a ROM is right.
        let conversion = to(&through_body_file(&body), DefinitionFormat::Rom);
        assert_eq!(conversion.mended_checksum.unwrap().stored, sum.stored);
        assert!(conversion.definition.rom().unwrap().checksum().matches());
    }
}

#[test]
fn every_changed_byte_of_an_image_is_found() {
    for image in [optical_image(), em_image()] {
        for at in 0..image.len() {
            assert!(read(&image[..at], "rom").is_err(), "cut at {at}");
            let mut bad = image.clone();
            bad[at] ^= 0x81;
            assert!(read(&bad, "rom").is_err(), "changed at {at}");
            // Whoever accepts it gets it back as it is, or an error for what else is wrong.
            if let Ok((body, _)) = read_body(&bad, "rom", OnMismatch::Accept) {
                assert_eq!(body.definition.unwrap().bytes, bad);
            }
        }
    }
}

#[test]
fn wrong_counts_and_numbers_are_named() {
    for count in [0, 2, 21, 255] {
        let mut image = optical_image();
        image[28] = count;
        let message = read(&with_sum(image), "rom").unwrap_err();
        assert_eq!(message, format!("number of markers is {count}, expected 3 to 20 (byte 28)"));
    }
    for count in [0, 1, 9, u32::MAX] {
        let mut image = em_image();
        put(&mut image, 16, &count.to_le_bytes());
        let message = read(&with_em_sum(image), "rom").unwrap_err();
        assert_eq!(message, format!("number of coils is {count}, expected 2 to 8 (byte 16)"));
    }
    let mut image = optical_image();
    put_floats(&mut image, 76, &[f32::NAN]);
    let message = read(&with_sum(image), "rom").unwrap_err();
    assert_eq!(message, "marker 1: position is (0, NaN, 0), expected finite numbers");
    let mut image = em_image();
    put_floats(&mut image, 92, &[f32::INFINITY]);
    let message = read(&with_em_sum(image), "rom").unwrap_err();
    assert!(message.starts_with("coil 2: azimuth and polar angle is ("), "{message}");
    let mut image = em_image();
    image[2] = 0x42;
    let message = read(&with_em_sum(image), "rom").unwrap_err();
    assert_eq!(message, "payload's length is 322, expected 321 (bytes 2 and 3)");
    let message = read(b"\x89PNG", "rom").unwrap_err();
    assert!(message.starts_with("beginning is 89 50 4E 47, expected 4E 44 49 00"), "{message}");
}
