//! Meshes by hand: what is read from them, and what is refused.

use super::*;
use crate::test_cases::assert_refused;
use nalgebra::{Point3, Vector3};
use trackwright_geometry::mesh::SurfaceMesh;

/// Metres, as the specification has it.
fn parse(bytes: &[u8]) -> Result<SurfaceMesh, GltfError> {
    super::parse(bytes, 1000.0)
}

const JSON: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"children":[1],"translation":[0,0,1]},{"mesh":0,"name":"anatomy-face","scale":[2,2,2]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"metallicFactor":0.5,"roughnessFactor":0.25}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"buffers":[{"byteLength":44}]}"#;

fn glb(json: &str, positions: [f32; 9], indices: [u16; 3]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut data: Vec<u8> = positions.iter().flat_map(|v| v.to_le_bytes()).collect();
    data.extend(indices.iter().flat_map(|v| v.to_le_bytes()));
    data.resize(44, 0);
    let mut out = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + data.len();
    for word in [2, total as u32, json.len() as u32] {
        out.extend(word.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(data);
    out
}

const CORNERS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

pub(crate) fn triangle() -> Vec<u8> {
    glb(JSON, CORNERS, [0, 1, 2])
}

#[test]
fn nested_metres_become_body_millimetres() {
    let mesh = parse(&triangle()).unwrap();
    let [part] = &mesh.parts[..] else { panic!("{mesh:?}") };
    assert!(part.is_anatomy());
    assert_eq!(part.triangles, [[0, 1, 2]]);
    assert_eq!(part.positions_mm[1], Point3::new(2000.0, 0.0, 1000.0));
    assert_eq!(part.normals, [Vector3::z(); 3]);
    assert_eq!((part.metallic, part.roughness), (0.5, 0.25));
    assert_eq!(part.base_color, [0.5, 0.25, 1.0, 1.0]);
}

#[test]
fn mirrored_triangles_still_face_outward() {
    let file = glb(&JSON.replace("[2,2,2]", "[2,2,-2]"), CORNERS, [0, 1, 2]);
    let part = parse(&file).unwrap().parts.remove(0);
    assert_eq!(part.triangles, [[0, 2, 1]]);
    assert_eq!(part.normals, [-Vector3::z(); 3]);
}

#[test]
fn meshes_that_cannot_be_are_refused() {
    let index = parse(&glb(JSON, CORNERS, [0, 1, 3])).unwrap_err();
    assert_eq!(
        index.to_string(),
        "mesh \"anatomy-face\": found index 3 of 3 positions, expected one of them"
    );
    let mut corners = CORNERS;
    corners[4] = f32::NAN;
    let not_finite = parse(&glb(JSON, corners, [0, 1, 2])).unwrap_err();
    assert!(not_finite.to_string().contains("found (1, NaN, 0), expected finite"));
    let cases = r#"
        "scenes":[{"nodes":[0]}] => "scenes":[{"nodes":[]}] | found no triangles…
        "children":[1] => "children":[1,1] | …found it twice in the scene…
        "scale":[2,2,2] => "children":[0] | …found it twice in the scene…
        "scale":[2,2,2] => "scale":[2,0,2] | …a transform without inverse…
        "byteLength":44 => "byteLength":44,"uri":"x.bin"
            | found buffer 0 in a file of its own, "x.bin"…
        "byteLength":36 => "byteLength":4000000000 | …data beyond the end…
        "count":3,"type":"VEC3" => "count":4000000000,"type":"VEC3"
            | found 4000000000 vertices, expected at most 10000000…
        "count":3,"type":"VEC3" => "count":9000000,"type":"VEC3" | …data beyond the end…
        "count":3,"type":"SCALAR" => "count":3000000000,"type":"SCALAR"
            | found 1000000000 triangles, expected at most 10000000…
        "count":3,"type":"SCALAR" => "count":2,"type":"SCALAR" | …found 2 indices…
        "indices":1 => "indices":1,"mode":1 | …found Lines, expected triangles…
        5123 => 5126 | …found F32 indices, expected unsigned integers…
        "POSITION":0 => "POSITION":7
            | found no glTF (accessor 7 of 2), expected a mesh in glTF 2.0
        {"POSITION":0} => {"NORMAL":0} | …expected…
    "#;
    assert_refused(JSON, cases, |json| {
        parse(&glb(json, CORNERS, [0, 1, 2])).unwrap_err().to_string()
    });
}

/// The same triangle as a text with its numbers in base64.
fn embedded() -> String {
    let data = &triangle()[triangle().len() - 44..];
    let uri = format!(
        "\"byteLength\":44,\"uri\":\"data:application/octet-stream;base64,{}\"",
        data_encoding::BASE64.encode(data)
    );
    JSON.replace("\"byteLength\":44", &uri)
}

#[test]
fn data_in_base64_reads_as_that_of_a_binary_file() {
    assert_eq!(parse(embedded().as_bytes()), parse(&triangle()));
    let cases = r#"
        ;base64, => , | …a data URI without ";base64,"…
        ;base64, => ;base64,? | buffer 0: found invalid…
        data:app => app | …in a file of its own, "app…
    "#;
    assert_refused(&embedded(), cases, |json| parse(json.as_bytes()).unwrap_err().to_string());
}

/// The triangle at so many nodes, each in its place along x.
fn instances(count: usize) -> String {
    let nodes = (0..count).map(|k| format!("{{\"mesh\":0,\"translation\":[{k},0,0]}}"));
    let nodes = nodes.collect::<Vec<_>>().join(",");
    let roots = (0..count).map(|k| k.to_string());
    let roots = roots.collect::<Vec<_>>().join(",");
    let [from, to] = ["\"scenes\"", "\"materials\""].map(|key| JSON.find(key).unwrap());
    format!(
        "{}\"scenes\":[{{\"nodes\":[{roots}]}}],\"nodes\":[{nodes}],\n{}",
        &JSON[..from],
        &JSON[to..]
    )
}

#[test]
fn a_mesh_placed_often_is_few_parts() {
    let mesh = parse(&glb(&instances(30_000), CORNERS, [0, 1, 2])).unwrap();
    assert_eq!(mesh.parts.len(), 1001);
    let rest = &mesh.parts[1000];
    assert_eq!(rest.name, "other parts");
    assert_eq!(rest.triangles.len(), 29_000);
    let corners = |part: &trackwright_geometry::mesh::MeshPart, t| part.corners_mm(t).map(|p| p.x);
    assert_eq!(corners(&mesh.parts[999], 0), [999e3, 1000e3, 999e3]);
    assert_eq!(corners(rest, 28_999), [29_999e3, 30_000e3, 29_999e3]);
    assert_eq!(rest.base_color, [0.5, 0.25, 1.0, 1.0]);
}

#[test]
fn instances_are_counted_before_they_are_made() {
    // The file does not have the 60,000 indices: were one instance made, that would be the error.
    let [from, to] = [3, 60_000].map(|n| format!("\"count\":{n},\"type\":\"SCALAR\""));
    let file = glb(&instances(1000).replace(&from, &to), CORNERS, [0, 1, 2]);
    assert_eq!(
        parse(&file).unwrap_err(),
        GltfError::TooLarge { found: 20_000_000, what: "triangles", most: 10_000_000 }
    );
}

#[test]
fn nodes_may_nest_as_deep_as_a_file_is_long() {
    let depth = 50_000;
    let inner = (1..depth).map(|k| format!("{{\"children\":[{k}]}}"));
    let nodes: Vec<String> = inner.chain(["{\"mesh\":0}".to_owned()]).collect();
    let [from, to] = ["\"nodes\":[{", "\"materials\""].map(|key| JSON.find(key).unwrap());
    let json = format!("{}\"nodes\":[{}],{}", &JSON[..from], nodes.join(","), &JSON[to..]);
    let mesh = parse(&glb(&json, CORNERS, [0, 1, 2])).unwrap();
    assert_eq!(mesh.parts[0].positions_mm[1], Point3::new(1000.0, 0.0, 0.0));
}

#[test]
fn lengths_that_do_not_fit_the_bytes_are_refused() {
    for cut in [4, 11, 12, 19, 40, triangle().len() - 1] {
        assert!(parse(&triangle()[..cut]).is_err(), "{cut}");
    }
    let mut file = triangle();
    file[8] = 3;
    file[9] = 0;
    file[10] = 0;
    assert!(parse(&file).unwrap_err().to_string().contains("3 bytes announced"));
}
