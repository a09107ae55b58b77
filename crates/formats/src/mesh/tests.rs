//! STL and OBJ by hand: what is read from them, and what is refused.

use super::*;
use crate::test_cases::assert_refused;
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::fmt::Write;
use trackwright_geometry::mesh::MeshPart;

const SQUARE: [[[f32; 3]; 3]; 2] =
    [[[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0]], [[0.0; 3], [2.0, 2.0, 0.0], [0.0, 2.0, -0.0]]];

fn binary(header: &str, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = header.as_bytes().to_vec();
    out.resize(80, 0);
    out.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        out.extend([0; 12]);
        out.extend(triangle.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

fn text_stl(name: &str, triangles: &[[[f32; 3]; 3]]) -> String {
    let mut out = format!("solid {name}\n");
    for triangle in triangles {
        out.push_str("  facet normal 0 0 1\n    outer loop\n");
        for [x, y, z] in triangle {
            writeln!(out, "      vertex {x:e} {y:e} {z:e}").unwrap();
        }
        out.push_str("    endloop\n  endfacet\n");
    }
    out + &format!("endsolid {name}\n")
}

const OBJ: &str = "# two faces\nmtllib x.mtl\nv 0 0 0 0.5 0.5 0.5\nv 2 0 0 1.0\nv 2 2 0\nv 0 2 0\n\
vt 0 0\no plate\nusemtl steel\nf 1/1 2/1 3/1 4/1\ng anatomy skin\nv 0 0 5\nf -1 -4 -3\n";

pub(crate) fn good_files() -> [Vec<u8>; 3] {
    [binary("solid 12", &SQUARE), text_stl("plate", &SQUARE).into_bytes(), OBJ.as_bytes().to_vec()]
}

fn only_part(bytes: &[u8], extension: &str) -> MeshPart {
    let mut mesh = read(bytes, extension, None).unwrap();
    assert_eq!(mesh.parts.len(), 1);
    mesh.parts.remove(0)
}

fn error(bytes: &[u8], extension: &str) -> String {
    read(bytes, extension, None).unwrap_err().to_string()
}

fn corners(part: &MeshPart) -> Vec<[Point3<f64>; 3]> {
    (0..part.triangles.len()).map(|t| part.corners_mm(t)).collect()
}

#[test]
fn a_square_is_the_same_in_every_format() {
    let expected = SQUARE.map(|t| t.map(|c| Point3::from(c.map(f64::from))));
    let obj = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n";
    let files = [
        (binary("made by hand", &SQUARE), "stl"),
        (text_stl("made by hand", &SQUARE).into_bytes(), "STL"),
        (obj.as_bytes().to_vec(), "obj"),
    ];
    for (bytes, extension) in files {
        for extension in [extension, ""] {
            let part = only_part(&bytes, extension);
            assert_eq!(corners(&part), expected);
            assert_eq!(part.positions_mm.len(), 4, "corners at one place are one");
            assert_eq!(part.normals, [Vector3::z(); 4]);
        }
    }
}

#[test]
fn binary_stl_may_begin_with_solid() {
    for header in ["solid", "solid thing\n facet", "SOLID"] {
        let part = only_part(&binary(header, &SQUARE), "stl");
        assert_eq!(part.triangles.len(), 2);
    }
    assert_eq!(only_part(&binary("solid hook", &SQUARE), "stl").name, "hook");
    assert_eq!(only_part(&binary("", &SQUARE), "stl").name, "part 1");
}

#[test]
fn solids_are_parts_with_their_names() {
    let text = text_stl("shaft", &SQUARE[..1]) + &text_stl("anatomy skull base", &SQUARE[1..]);
    let mesh = read(text.as_bytes(), "stl", None).unwrap();
    let names: Vec<_> = mesh.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["shaft", "anatomy skull base"]);
    assert_eq!(mesh.body_parts().count(), 1);
    assert!(mesh.reading.normals_made);
}

#[test]
fn text_is_read_in_any_case_and_spacing() {
    let text = text_stl("", &SQUARE);
    let plain = only_part(text.as_bytes(), "stl");
    let mixed: String = text
        .lines()
        .zip(["\r\n", "\n", "\r", "\n\n"].into_iter().cycle())
        .map(|(line, end)| format!("{line}{end}"))
        .collect();
    for text in [
        mixed,
        text.replace('\n', "\r"),
        text.to_uppercase(),
        text.replace("solid \n", "solid\n"),
        text.replace("0 0 1", "nan nan nan"),
        text.replace("  ", "\t"),
        format!("\u{feff}{text}"),
        // One line a facet.
        text.replace("\n    ", " ").replace("\n  endf", " endf"),
    ] {
        assert_eq!(only_part(text.as_bytes(), "stl"), plain, "{text}");
    }
    let named = text.replace("solid ", "solid m\u{f6}").into_bytes();
    let latin: Vec<u8> = named.into_iter().filter(|&b| b != 0xc3).collect();
    assert_eq!(corners(&only_part(&latin, "stl")), corners(&plain));
    let unix = only_part(OBJ.replace("g anatomy skin", "").as_bytes(), "obj");
    let windows = OBJ.replace("g anatomy skin", "").replace('\n', "\r\n");
    assert_eq!(only_part(windows.as_bytes(), "obj"), unix);
}

#[test]
fn lengths_must_fit_the_count() {
    let mut file = binary("", &SQUARE);
    assert_eq!(
        error(&file[..file.len() - 1], "stl"),
        "found an STL of 183 bytes, expected 184 for the 2 triangles announced"
    );
    file[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(
        error(&file, "stl"),
        "found an STL of 184 bytes, expected 214748364834 for the 4294967295 triangles announced"
    );
    assert_eq!(
        error(b"neither", "stl"),
        "found an STL of 7 bytes, expected 84 for the 0 triangles announced"
    );
    // A binary file that begins with solid and is cut short is no text either.
    let file = binary("solid", &SQUARE);
    assert!(error(&file[..file.len() - 1], "stl").contains("183 bytes"));
}

#[test]
fn too_many_triangles_are_refused_by_count() {
    let count = MAX_TRIANGLES as u32 + 1;
    let mut file = binary("", &[]);
    file[80..84].copy_from_slice(&count.to_le_bytes());
    file.resize(84 + 50 * count as usize, 0);
    assert_eq!(error(&file, "stl"), "found 10000001 triangles, expected at most 10000000");
}

#[test]
fn files_without_triangles_are_refused() {
    for (bytes, extension) in [
        (&b""[..], "stl"),
        (b"", "obj"),
        (b" \n", "stl"),
        (&binary("", &[]), "stl"),
        (b"solid nothing\nendsolid nothing\n", "stl"),
        (b"v 1 2 3\n", "obj"),
    ] {
        assert_eq!(error(bytes, extension), "found no triangles, expected some");
    }
    assert_eq!(
        error(b"solid x", "ply"),
        "line 1: found the end of the file, expected `endsolid`: it is cut short"
    );
    assert_eq!(
        error(b"ply\nformat", "ply"),
        "found a file of no known format named .ply, expected a mesh as .glb, .gltf, .stl or .obj"
    );
}

#[test]
fn triangles_without_numbers_are_left_out() {
    let mut triangles = SQUARE.to_vec();
    triangles.push([[f32::NAN, 0.0, 0.0], [1.0; 3], [2.0; 3]]);
    triangles.push([[0.0; 3], [f32::INFINITY; 3], [2.0; 3]]);
    for file in [binary("", &triangles), text_stl("", &triangles).into_bytes()] {
        let mesh = read(&file, "stl", None).unwrap();
        assert_eq!(mesh.parts[0].triangles.len(), 2);
        assert_eq!(mesh.reading.triangles_left_out, 2);
    }
    assert_eq!(
        error(&binary("", &triangles[2..]), "stl"),
        "found 2 triangles, all with corners that are no numbers, expected some"
    );
    let obj = "v 0 0 0\nv nan 0 0\nv 1 1 0\nv 0 1 0\nv 1e999 0 0\nf 1 2 3 4\nf 1 3 4\nf 1 3 5\n";
    let mesh = read(obj.as_bytes(), "obj", None).unwrap();
    assert_eq!(mesh.parts[0].triangles.len(), 1);
    assert_eq!(mesh.reading.triangles_left_out, 3);
}

#[test]
fn wrong_text_is_named_with_its_line() {
    let text = text_stl("x", &SQUARE);
    let cases = r#"
        2e0 0e0 0e0 => 2e0 0,5 0e0 | line 5: found `0,5`, expected a number
        2e0 0e0 0e0 => 2e0 | line 5: found the end of the line, expected a number
        endloop\n => | line 7: found `endfacet`, expected `vertex` or `endloop`
        vertex 2e0 0e0 0e0\n => | line 6: found 2 corners, expected three
        endsolid x\n =>
            | line 16: found the end of the file, expected `endsolid`: it is cut short
        endsolid x\n => endsolid x\nrubbish\n | line 17: found `rubbish`, expected `solid`
    "#;
    assert_refused(&text, cases, |text| error(text.as_bytes(), "stl"));
    let cases = r#"
        v 2 2 0 => v 2 2 | line 5: found the end of the line, expected a number
        v 2 2 0 => v 2 x 0 | line 5: found `x`, expected a number
        3/1 4/1 => 3/1 5/1 | line 10: found position `5` of 4 so far, expected one of them
        3/1 4/1 => 3/1 0/1 | line 10: found position `0` of 4 so far, expected one of them
        -1 -4 => -1 -6 | line 13: found position `-6` of 5 so far, expected one of them
        3/1 4/1 => 3/1 4//6148914691236517206
            | line 10: found normal `6148914691236517206` of 0 so far, expected one of them
        -1 -4 => -9223372036854775808 -4
            | line 13: found position `-9223372036854775808` of 5 so far, expected one of them
        f -1 -4 -3 => f -1 -4 | line 13: found a face of 2 corners, expected three or more
    "#;
    assert_refused(OBJ, cases, |text| error(text.as_bytes(), "obj"));
}

#[test]
fn a_face_of_very_many_corners_is_refused() {
    let face = |corners: usize| OBJ.replace("f -1 -4 -3", &format!("f{}", " -1".repeat(corners)));
    let message = error(face(10_001).as_bytes(), "obj");
    assert_eq!(message, "line 13: found a face of more than 10000 corners, expected fewer");
    assert!(read(face(10_000).as_bytes(), "obj", None).is_ok());
}

#[test]
fn groups_are_parts_and_indices_may_be_negative() {
    let mesh = read(OBJ.as_bytes(), "obj", None).unwrap();
    let [plate, skin] = &mesh.parts[..] else { panic!("{mesh:?}") };
    assert_eq!((plate.name.as_str(), plate.triangles.len()), ("plate", 2));
    assert!(skin.is_anatomy());
    let expected = [[0.0, 0.0, 5.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0]];
    assert_eq!(corners(skin), [expected.map(Point3::from)]);
    let continued = OBJ.replace("2/1 3/1", "2/1 \\\n 3/1");
    assert_eq!(read(continued.as_bytes(), "obj", None).unwrap(), mesh);
}

#[test]
fn obj_normals_are_kept_if_every_corner_has_one() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nvn 1 0 0\nf 1//1 2//1 3//2\nf 1//2 3//1 2//1\n";
    let mesh = read(obj.as_bytes(), "obj", None).unwrap();
    let part = &mesh.parts[0];
    let normals: Vec<_> = part.triangles[0].map(|i| part.normals[i as usize]).into();
    assert_eq!(normals, [Vector3::z(), Vector3::z(), Vector3::x()]);
    assert_eq!(part.positions_mm.len(), 5, "two places have two normals");
    assert!(!mesh.reading.normals_made);
    let without = obj.replace("3//2", "3");
    let mesh = read(without.as_bytes(), "obj", None).unwrap();
    assert!(mesh.reading.normals_made);
}

#[test]
fn a_concave_polygon_is_covered_once() {
    // A comb: a fan from any corner would cross itself.
    let comb = "v 0 0 7\nv 9 0 7\nv 9 5 7\nv 8 5 7\nv 8 1 7\nv 5 1 7\nv 5 5 7\nv 4 5 7\nv 4 1 7\n\
        v 1 1 7\nv 1 5 7\nv 0 5 7\n";
    let outline: Vec<String> = (1..=12).map(|i| i.to_string()).collect();
    for is_reversed in [false, true] {
        let mut outline = outline.clone();
        if is_reversed {
            outline.reverse();
        }
        for _ in 0..12 {
            outline.rotate_left(1);
            let obj = format!("{comb}f {}\n", outline.join(" "));
            let part = only_part(obj.as_bytes(), "obj");
            assert_eq!(part.triangles.len(), 10);
            let mut area_mm2 = 0.0;
            for [a, b, c] in corners(&part) {
                let doubled = (b - a).cross(&(c - a)).z;
                assert_eq!(doubled < 0.0, is_reversed, "all turn as the polygon does");
                area_mm2 += doubled.abs() / 2.0;
            }
            // Signs agree, so an area of the right size is one that nothing covers twice.
            assert!((area_mm2 - 21.0).abs() < 1e-9, "{area_mm2}");
        }
    }
}

#[test]
fn a_unit_overrides_that_of_the_format() {
    let size = |bytes: &[u8], unit| {
        let mesh = read(bytes, "", unit).unwrap();
        mesh.body_bounds().unwrap().size_mm().x
    };
    let stl = binary("", &SQUARE);
    assert_eq!(size(&stl, None), 2.0);
    assert_eq!(size(&stl, Some(MeshUnit::Inch)), 50.8);
    assert_eq!(size(OBJ.as_bytes(), Some(MeshUnit::Factor(0.5))), 1.0);
    let glb = include_bytes!("../../../../assets/meshes/pointer.glb");
    let in_metres = size(glb, None);
    let as_mm = size(glb, Some(MeshUnit::Millimetre));
    assert!((in_metres / as_mm - 1000.0).abs() < 1e-9);
    let read = |unit| read(&stl, "stl", Some(unit)).unwrap_err().to_string();
    assert_eq!(
        read(MeshUnit::Factor(f64::NAN)),
        "the unit is NaN mm, expected a length above zero"
    );
    assert_eq!(
        read(MeshUnit::Factor(1e300)),
        "the unit is 1e300 mm, expected a length of at most 1e6 mm"
    );
    let far = OBJ.replace("v 2 0 0", "v 1e12 0 0");
    let far = super::read(far.as_bytes(), "obj", None).unwrap_err();
    let far = far.to_string();
    assert!(far.starts_with("found a corner 1.000e12 mm from"), "{far}");
}

#[test]
fn huge_coordinates_are_refused_in_any_unit() {
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e308 0 0\nvertex 0 1 0\n\
               endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
               endloop\nendfacet\nendsolid a\n";
    let obj = "v 0 0 0\nv 1e308 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 1 4 3\n";
    for (text, extension) in [(stl, "stl"), (obj, "obj")] {
        for (unit, found) in [(MeshUnit::Millimetre, "1.000e308"), (MeshUnit::Metre, "1.798e308")] {
            let error = read(text.as_bytes(), extension, Some(unit)).unwrap_err();
            assert_eq!(
                error.to_string(),
                format!("found a corner {found} mm from the origin, expected at most 1e9")
            );
        }
    }
}

#[test]
fn parts_beyond_a_thousand_are_one() {
    let mut obj = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for i in 0..3000 {
        let name = if i % 3 == 2 { "anatomy" } else { "face" };
        writeln!(obj, "g {name} {i}\nf 1 2 3").unwrap();
    }
    let mesh = read(obj.as_bytes(), "obj", None).unwrap();
    assert_eq!(mesh.parts.len(), 1002);
    let all = mesh.parts.iter().map(|p| p.triangles.len()).sum::<usize>();
    let body = mesh.body_parts().map(|p| p.triangles.len()).sum::<usize>();
    assert_eq!((all, body), (3000, 2000));
}

#[test]
fn a_megabyte_of_garbage_is_no_mesh() {
    let mut state = 7_u32;
    let garbage: Vec<u8> = (0..1 << 20)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    for extension in ["stl", "obj", "glb", ""] {
        assert!(read(&garbage, extension, None).is_err(), "{extension}");
    }
}

/// Words that the formats are made of, in any order.
fn words() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        4 => prop::sample::select(vec![
            "v", "vn", "f", "g", "o", "solid", "facet", "normal", "outer", "loop", "vertex",
            "endloop", "endfacet", "endsolid", "\\",
        ])
        .prop_map(str::to_owned),
        4 => (-9_i64..9).prop_map(|n| n.to_string()),
        1 => any::<f64>().prop_map(|n| n.to_string()),
        1 => (any::<i64>(), any::<i64>()).prop_map(|(a, b)| format!("{a}//{b}")),
        4 => Just("\n".to_owned()),
    ];
    prop::collection::vec(word, 0..80).prop_map(|words| words.join(" "))
}

proptest! {
    #[test]
    fn any_words_in_any_order_never_panic(text in words()) {
        let _ = read(text.as_bytes(), "obj", None);
        let _ = read(format!("solid {text}").as_bytes(), "stl", None);
    }

    /// Whatever corners a polygon has, its triangles are its own and cover its area.
    #[test]
    fn any_polygon_becomes_triangles_of_its_corners(
        corners in prop::collection::vec((-3_i32..4, -3_i32..4, 0_i32..2), 3..14),
    ) {
        let mut obj = String::new();
        for (x, y, z) in &corners {
            writeln!(obj, "v {x} {y} {z}").unwrap();
        }
        let outline: Vec<String> = (1..=corners.len()).map(|i| i.to_string()).collect();
        writeln!(obj, "f {}", outline.join(" ")).unwrap();
        let mesh = read(obj.as_bytes(), "obj", None).unwrap();
        prop_assert_eq!(mesh.parts[0].triangles.len(), corners.len() - 2);
        let points: Vec<Point3<f64>> = corners
            .iter()
            .map(|&(x, y, z)| Point3::new(f64::from(x), f64::from(y), f64::from(z)))
            .collect();
        let doubled = |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a));
        let expected: Vector3<f64> = (2..points.len())
            .map(|i| doubled([points[0], points[i - 1], points[i]]))
            .sum();
        let found: Vector3<f64> = mesh.parts[0]
            .triangles
            .iter()
            .map(|t| doubled(t.map(|i| mesh.parts[0].positions_mm[i as usize])))
            .sum();
        prop_assert!((found - expected).norm() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn any_triangles_come_back_from_a_binary_file(
        numbers in prop::collection::vec(prop::array::uniform9(-1e6_f32..1e6), 1..30),
    ) {
        let triangles: Vec<[[f32; 3]; 3]> = numbers
            .iter()
            .map(|n| [[n[0], n[1], n[2]], [n[3], n[4], n[5]], [n[6], n[7], n[8]]])
            .collect();
        let mesh = read(&binary("", &triangles), "stl", None).unwrap();
        let part = &mesh.parts[0];
        let expected: Vec<_> = triangles
            .iter()
            .map(|t| t.map(|c| Point3::from(c.map(f64::from))))
            .collect();
        prop_assert_eq!(corners(part), expected);
        prop_assert!(part.normals.iter().all(|n| (n.norm() - 1.0).abs() < 1e-9));
        let text = text_stl("", &triangles);
        let from_text = read(text.as_bytes(), "stl", None).unwrap();
        prop_assert_eq!(from_text.parts.len(), 1);
    }
}
