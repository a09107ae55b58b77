//! What holds for any body and any bytes.

use super::*;
use nalgebra::{Unit, Vector3};
use proptest::prelude::*;

fn any_image_place() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(any::<f32>().prop_filter("a coordinate", |v| v.abs() <= 1e6))
}

fn any_axis() -> impl Strategy<Value = Unit<Vector3<f64>>> {
    prop::array::uniform3(-1.0..1.0_f64)
        .prop_filter("a direction", |v| Vector3::from(*v).norm() > 1e-3)
        .prop_map(|v| Unit::new_normalize(v.into()))
}

fn body_of(sensors: Vec<Sensor>, tip_in_body: Option<Point3<f64>>) -> BodyFile {
    BodyFile {
        rigid: RigidBody { name: "geometry 1".to_owned(), tip_in_body, sensors },
        mesh: None,
        definition: None,
        mounting: Mounting::default(),
    }
}

proptest! {
    #[test]
    fn markers_of_an_image_come_back_exactly(
        places in prop::collection::vec(any_image_place(), 3..=20),
    ) {
        let sensors = places.iter().enumerate();
        let sensors = sensors.map(|(i, p)| marker(i, p.map(f64::from).into())).collect();
        let body = body_of(sensors, None);
        let image = rom_bytes(&body);
        let back = read(&image, "rom").unwrap();
        prop_assert_eq!(&back.rigid, &body.rigid);
        prop_assert_eq!(rom_bytes(&back), image);
    }

    #[test]
    fn coils_come_back_within_angle_rounding(
        coils in prop::collection::vec((any_image_place(), any_axis()), 2..=8),
    ) {
        let sensors = coils.iter().enumerate().map(|(i, (place, axis))| {
            Sensor::five_dof(format!("coil {}", i + 1), place.map(f64::from), *axis)
        });
        let body = body_of(sensors.collect(), Some(Point3::origin()));
        let image = rom_bytes(&body);
        let back = read(&image, "rom").unwrap();
        for (found, expected) in back.rigid.sensors.iter().zip(&body.rigid.sensors) {
            prop_assert_eq!(found.position_in_body, expected.position_in_body);
            let (a, b) = (found.axis_in_body().unwrap(), expected.axis_in_body().unwrap());
            // Half a step near π of each of two angles.
            prop_assert!((a.into_inner() - b.into_inner()).norm() < 2.4e-7);
        }
        prop_assert_eq!(rom_bytes(&through_body_file(&back)), image);
    }

    #[test]
    fn text_geometries_hold_any_place_to_the_bit(
        places in prop::collection::vec(prop::array::uniform3(any::<f64>().prop_filter("a coordinate", |v| v.abs() <= 1e6)), 1..6),
        pivot in prop::option::of(prop::array::uniform3(-1e3..1e3_f64)),
    ) {
        let sensors = places.iter().enumerate();
        let sensors = sensors.map(|(i, p)| marker(i, Point3::from(*p))).collect();
        let body = body_of(sensors, pivot.map(Point3::from));
        for (format, extension) in [(DefinitionFormat::AtracsysIni, "ini"), (DefinitionFormat::SawJson, "json")] {
            let conversion = to(&body, format);
            prop_assert_eq!(&conversion.lost, &vec![]);
            let text = conversion.definition.write();
            let back = read(&text, extension).unwrap();
            prop_assert_eq!(&back.rigid, &body.rigid);
            let again = to(&back, format);
            prop_assert_eq!(again.definition.write(), text);
        }
    }

    #[test]
    fn no_bytes_whatever_make_it_panic(
        beginning in prop::sample::select(vec!["", "NDI\0", "\u{1}\0A\u{1}", "<plist>", "{\"fiducials\":[", "[geometry]\n", "/*", "//"]),
        bytes in prop::collection::vec(any::<u8>(), 0..800),
        extension in prop::sample::select(vec!["", "rom", "tool", "ini", "json", "ron"]),
    ) {
        let bytes = [beginning.as_bytes(), &bytes].concat();
        if let Ok((body, Some(_))) = read_body(&bytes, extension, OnMismatch::Accept) {
            let definition = body.definition.unwrap();
            prop_assert_eq!(&definition.bytes[..], &bytes[..]);
        }
    }

    #[test]
    fn garbled_text_is_refused_or_kept_as_it_is(at in 0..240_usize, letter in any::<u8>()) {
        for text in [INI, JSON] {
            let mut bytes = text.as_bytes().to_vec();
            let at = at % bytes.len();
            bytes[at] = letter;
            if let Ok((body, Some(_))) = read_body(&bytes, "", OnMismatch::Refuse) {
                let definition = body.definition.unwrap();
                prop_assert_eq!(&definition.bytes[..], &bytes[..]);
            }
            let _ = read_body(&text.as_bytes()[..at], "", OnMismatch::Refuse);
        }
    }
}
