//! Whatever is given to the writer, the file is one that readers take, or there is none.

use super::parse;
use super::write::*;
use crate::test_cases::any_text;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use serde_json::{Value, json};

fn lit(name: &str, alpha: f64) -> Material {
    Material {
        name: name.to_owned(),
        color: [0.5, 0.25, 1.0, alpha],
        light: Light::Lit { metallic: 0.5, roughness: 0.25 },
        both_faces: false,
        fades: false,
    }
}

/// A file of one shape under a node.
fn file(
    name: &str,
    shape: &Shape,
    transform: NodeTransform,
    extras: &Value,
) -> Result<Vec<u8>, super::GltfWriteError> {
    let mut writer = GlbWriter::new("test");
    let id = writer.shape(name, shape);
    let material = writer.material(&lit(name, 0.5));
    let mesh = writer.mesh(name, id.map(|shape| (shape, material)));
    let node = writer.node(Node { name: name.to_owned(), transform, mesh, ..Node::default() });
    writer.finish(name, &[node], extras)
}

const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.5]];

#[test]
fn the_own_reader_finds_what_was_written() {
    let positions = CORNERS.map(Point3::from);
    let shape = Shape {
        positions: &positions,
        normals: &[Vector3::z() * 7.0; 3],
        colors: &[],
        elements: Elements::Triangles(&[[0, 1, 2]]),
    };
    let transform = NodeTransform {
        translation: Vector3::new(0.0, 0.0, 1.0),
        scale: Vector3::repeat(2.0),
        ..NodeTransform::default()
    };
    let read = parse(&file("blade", &shape, transform, &Value::Null).unwrap(), 1000.0).unwrap();
    let [part] = &read.parts[..] else { panic!("{read:?}") };
    assert_eq!((part.name.as_str(), part.triangles.as_slice()), ("blade", &[[0, 1, 2]][..]));
    assert_eq!(part.positions_mm[2], Point3::new(0.0, 6000.0, 2000.0));
    assert_eq!(part.normals, [Vector3::z(); 3]);
    assert_eq!(part.base_color, [0.5, 0.25, 1.0, 0.5]);
    assert_eq!((part.metallic, part.roughness), (0.5, 0.25));
}

#[test]
fn indices_are_as_wide_as_their_vertices_need() {
    // 65,535 is the number that stands for no vertex in 16 bits.
    for (corners, bytes) in [(65_535_usize, 2), (65_536, 4)] {
        let positions: Vec<_> = (0..corners).map(|k| Point3::new(k as f64, 0.0, 1.0)).collect();
        let last = corners as u32 - 1;
        let triangles = [[0, 1, last]];
        let shape = Shape::unlit(&positions, &[], Elements::Triangles(&triangles));
        let glb = file("row", &shape, NodeTransform::default(), &Value::Null).unwrap();
        let read = gltf::Gltf::from_slice(&glb).unwrap();
        let indices = read.accessors().find(|a| a.count() == 3).unwrap();
        assert_eq!(indices.size(), bytes);
        assert_eq!(parse(&glb, 1.0).unwrap().parts[0].triangles, [[0, 1, last]]);
    }
}

#[test]
fn numbers_beyond_32_bits_are_refused_by_name() {
    for bad in [f64::NAN, f64::INFINITY, 1e39] {
        let mut positions = CORNERS.map(Point3::from);
        positions[1].y = bad;
        let shape = Shape::unlit(&positions, &[], Elements::Triangles(&[[0, 1, 2]]));
        let error = file("blade", &shape, NodeTransform::default(), &Value::Null).unwrap_err();
        assert!(error.to_string().starts_with("\"blade\": found a position"), "{error}");
        let transform =
            NodeTransform { translation: Vector3::new(0.0, bad, 0.0), ..NodeTransform::default() };
        let positions = CORNERS.map(Point3::from);
        let shape = Shape { positions: &positions, ..shape };
        let error = file("blade", &shape, transform, &Value::Null).unwrap_err();
        assert!(error.to_string().starts_with("\"blade\": found a place"), "{error}");
    }
    let positions = CORNERS.map(Point3::from);
    let shape = Shape {
        positions: &positions,
        normals: &[Vector3::z(); 2],
        colors: &[],
        elements: Elements::Triangles(&[[0, 1, 2]]),
    };
    let error = file("blade", &shape, NodeTransform::default(), &Value::Null).unwrap_err();
    assert_eq!(error.to_string(), "\"blade\": found 2 normals for 3 positions");
}

#[test]
fn a_scene_of_nothing_is_a_file_too() {
    let nothing =
        Shape { positions: &[], normals: &[], colors: &[], elements: Elements::Lines(&[]) };
    let glb = file("nothing", &nothing, NodeTransform::default(), &json!({"a": 1})).unwrap();
    let read = gltf::Gltf::from_slice(&glb).unwrap();
    assert_eq!((read.meshes().count(), read.nodes().count()), (0, 1));
}

proptest! {
    #[test]
    fn any_written_shape_passes_a_strict_reader(
        name in any_text(0..20),
        corners in prop::collection::vec(prop::array::uniform3(-1e6..1e6), 3..40),
        colors in prop::array::uniform4(-1.0..2.0),
        turn in prop::array::uniform3(-4.0..4.0),
        is_lines in any::<bool>(),
    ) {
        let positions: Vec<Point3<f64>> = corners.iter().map(|c| Point3::from(*c)).collect();
        let last = positions.len() as u32 - 1;
        let colors = vec![colors; positions.len()];
        let normals: Vec<_> = positions.iter().map(|p| p.coords).collect();
        let shape = Shape {
            positions: &positions,
            normals: &normals,
            colors: &colors,
            elements: match is_lines {
                true => Elements::Lines(&[[0, 1], [1, last]]),
                false => Elements::Triangles(&[[0, 1, last]]),
            },
        };
        let transform = NodeTransform {
            rotation: UnitQuaternion::from_scaled_axis(Vector3::from(turn)),
            ..NodeTransform::default()
        };
        let glb = file(&name, &shape, transform, &json!({"name": name})).unwrap();
        let read = gltf::Gltf::from_slice(&glb).unwrap();
        let node = read.nodes().next().unwrap();
        prop_assert_eq!(node.name(), Some(name.as_str()));
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        let bounds = primitive.bounding_box();
        for (corner, k) in corners.iter().flat_map(|corner| (0..3).map(move |k| (corner, k))) {
            prop_assert!(bounds.min[k] <= corner[k] as f32 && corner[k] as f32 <= bounds.max[k]);
        }
    }
}
