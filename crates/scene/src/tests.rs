//! Scenes as another program reads them: by hand, from the file's bytes.

use super::*;
use nalgebra::{Matrix4, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;
use trackwright_design::view::{Magnification, SliceAxis};
use trackwright_design::{Document, Origin, Thing};
use trackwright_field::OutsidePolicy;
use trackwright_formats::gltf::parse;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::MeshPart;
use trackwright_simulation::simulate_pose;

fn world(name: &str) -> World {
    trackwright_project::open_builtin(name).unwrap()
}

fn with_layers(list: &str) -> SceneWish {
    SceneWish { layers: Some(Layers::named(list).unwrap()), ..SceneWish::default() }
}

fn scene(world: &World, wish: &SceneWish) -> (Scene, File) {
    let scene = glb(world, wish, &Task::default()).unwrap();
    let file = File::of(&scene.glb);
    (scene, file)
}

/// A binary glTF file, taken apart.
struct File {
    json: Value,
    data: Vec<u8>,
}

impl File {
    fn of(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let end = 20 + word(12);
        assert_eq!(
            (end % 4, &bytes[16..20], &bytes[end + 4..end + 8]),
            (0, &b"JSON"[..], &b"BIN\0"[..])
        );
        assert_eq!(end + 8 + word(end), bytes.len());
        Self {
            json: serde_json::from_slice(&bytes[20..end]).unwrap(),
            data: bytes[end + 8..].to_vec(),
        }
    }

    fn nodes(&self) -> &[Value] {
        self.json["nodes"].as_array().unwrap()
    }

    fn names(&self) -> Vec<&str> {
        let nodes = self.nodes().iter();
        nodes.map(|node| node["name"].as_str().unwrap()).collect()
    }

    /// The one node whose name begins so.
    fn node(&self, name: &str) -> usize {
        let mut found = self.names().into_iter().enumerate();
        let found: Vec<_> = found.by_ref().filter(|(_, own)| own.starts_with(name)).collect();
        assert_eq!(found.len(), 1, "{name}: {found:?}");
        found[0].0
    }

    /// Of a node, through all that it is in: glTF's metres.
    fn root_from(&self, node: usize) -> Matrix4<f64> {
        let own = &self.nodes()[node];
        let three = |key: &str, other: f64| {
            let list = own[key].as_array();
            list.map_or(Vector3::repeat(other), |list| {
                Vector3::from_fn(|k, _| list[k].as_f64().unwrap())
            })
        };
        let turn = own["rotation"].as_array().map_or(UnitQuaternion::identity(), |q| {
            let [x, y, z, w] = [0, 1, 2, 3].map(|k| q[k].as_f64().unwrap());
            UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
        });
        let place = Translation3::from(three("translation", 0.0)).to_homogeneous()
            * turn.to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&three("scale", 1.0));
        let is_child = |other: &Value| {
            let children = other["children"].as_array();
            children.is_some_and(|list| list.contains(&node.into()))
        };
        match self.nodes().iter().position(is_child) {
            Some(parent) => self.root_from(parent) * place,
            None => place,
        }
    }

    /// Numbers of an attribute of a node's only primitive, and how many make an element.
    fn attribute(&self, node: usize, name: &str) -> Vec<Vec<f64>> {
        let mesh = self.nodes()[node]["mesh"].as_u64().unwrap() as usize;
        let primitives = self.json["meshes"][mesh]["primitives"].as_array().unwrap();
        assert_eq!(primitives.len(), 1);
        let accessor = primitives[0]["attributes"][name].as_u64().unwrap() as usize;
        let accessor = &self.json["accessors"][accessor];
        let view = accessor["bufferView"].as_u64().unwrap() as usize;
        let view = &self.json["bufferViews"][view];
        let from = view["byteOffset"].as_u64().unwrap_or(0) as usize;
        assert_eq!(from % 4, 0);
        let bytes = &self.data[from..from + view["byteLength"].as_u64().unwrap() as usize];
        let width = match accessor["type"].as_str().unwrap() {
            "VEC3" => 3,
            "VEC4" => 4,
            other => panic!("{other}"),
        };
        let numbers: Vec<f64> = match accessor["componentType"].as_u64().unwrap() {
            5126 => (bytes.chunks_exact(4))
                .map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap())))
                .collect(),
            5123 if accessor["normalized"] == true => (bytes.chunks_exact(2))
                .map(|b| f64::from(u16::from_le_bytes(b.try_into().unwrap())) / 65535.0)
                .collect(),
            other => panic!("{other}"),
        };
        numbers.chunks_exact(width).map(<[f64]>::to_vec).collect()
    }

    /// Corners of a node's mesh in the tracker's frame, mm.
    fn points_mm(&self, node: usize) -> Vec<Point3<f64>> {
        let root_from_node = self.root_from(node);
        let corners = self.attribute(node, "POSITION").into_iter();
        let in_gltf =
            corners.map(|p| root_from_node.transform_point(&Point3::new(p[0], p[1], p[2])));
        in_gltf.map(tracker_mm).collect()
    }

    fn has(&self, name: &str) -> bool {
        self.names().iter().any(|own| own.starts_with(name))
    }
}

/// From glTF's metres, +y up and +z to the front, to the tracker: up is -z, the front is y.
fn tracker_mm(gltf: Point3<f64>) -> Point3<f64> {
    Point3::new(gltf.x, gltf.z, -gltf.y) * 1000.0
}

/// Eight bits of an sRGB channel, by the standard's formula.
fn srgb8(light: f64) -> u8 {
    let channel = match light <= 0.0031308 {
        true => 12.92 * light,
        false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    };
    (channel * 255.0).round() as u8
}

/// As far apart as 32-bit numbers of a metre's size may be in mm, through three nodes.
const CLOSE_MM: f64 = 1e-3;

#[test]
fn parts_read_back_where_their_bodies_are() {
    let world = world("pointer-on-head");
    let (scene, _) = scene(&world, &with_layers("anatomy"));
    let read = parse(&scene.glb, 1000.0).unwrap();
    let design = world.document.design();
    for role in BodyRole::ALL {
        let pose = design.tracker_from_body(role).unwrap();
        for part in &world.mesh(role).unwrap().parts {
            let expected = Bounds::around(part.positions_mm.iter().map(|p| pose * p)).unwrap();
            let own = read.parts.iter().find(|own| own.name == part.name).unwrap();
            // What the reader takes for mm of a body are the file's metres.
            let points = own.positions_mm.iter().map(|p| tracker_mm(*p / 1000.0));
            let found = Bounds::around(points).unwrap();
            let off = (found.min_mm - expected.min_mm)
                .amax()
                .max((found.max_mm - expected.max_mm).amax());
            assert!(off < CLOSE_MM, "{}: {off}", part.name);
            assert_eq!(own.triangles.len(), part.triangles.len());
        }
    }
}

#[test]
fn slice_colors_are_those_of_the_field() {
    let world = world("pointer-on-head");
    let wish = with_layers("slice");
    let stage = Stage::new(&world, &wish);
    let sampled = stage.sample(&Task::default()).unwrap();
    let slice = sampled.slice.as_ref().unwrap();
    let file = File::of(&stage.draw(&sampled).unwrap().glb);
    let node = file.node("slice, position error");
    let max = file.nodes()[node]["extras"]["to"].as_f64().unwrap();
    let (view, model) = (&world.document.view().slice, &world.environment.model);
    let axis = nalgebra::Unit::new_normalize(Vector3::from(view.sensor_axis));
    let points = file.points_mm(node);
    let colors = file.attribute(node, "COLOR_0");
    assert!(points.len() > 5000, "{}", points.len());
    let mut seen = std::collections::HashSet::new();
    for (point, color) in points.iter().zip(&colors).step_by(37) {
        // What was sampled at this point of the lattice is the model's value there.
        let [u, v] = slice.plan.place_of(point).map(|at| at.round() as usize);
        let value = slice.values[v * slice.plan.counts[0] + u];
        let at = model.evaluate(point, &axis, OutsidePolicy::Clamp);
        let error_mm = at.error.position_mm.norm();
        assert!((value - error_mm).abs() < 1e-4, "{point}: {value} for {error_mm}");
        let found = [0, 1, 2].map(|k| srgb8(color[k]));
        assert_eq!(found, view.color_map.srgb(value / max), "{point}: {value} of {max}");
        assert_eq!(color[3], 1.0);
        seen.insert(found);
    }
    assert!(seen.len() > 20, "{}", seen.len());
}

#[test]
fn errors_are_drawn_times_the_magnification() {
    let mut world = world("pointer-on-head");
    let mut view = world.document.view().clone();
    view.magnification = Magnification::Times(10.0);
    world.document.set_view(view);
    let (scene, file) = scene(&world, &with_layers("sensor-errors,tip-error,ghost"));
    assert_eq!(scene.magnification, 10.0);
    let detail =
        simulate_pose(&trackwright_project::resolve(world.document.design(), &world.environment));
    let crf = world.document.design().tracker_from_body(BodyRole::Crf).unwrap();
    let tip = world.document.design().tool.body.rigid.judged_tip_in_body();
    let is = crf * detail.trial.crf_from_tool * tip;
    let reported = crf * detail.trial.crf_from_tool_simulated * tip;
    let arrow = file.points_mm(file.node("error of the tip, × 10"));
    let farthest = arrow.iter().map(|p| (p - is).norm()).fold(0.0, f64::max);
    assert!((farthest - 10.0 * (reported - is).norm()).abs() < CLOSE_MM, "{farthest}");
    for sensor in detail.crf.iter().flat_map(|body| &body.sensors) {
        let error = sensor.tracker_from_measured.translation.vector
            - sensor.tracker_from_sensor.translation.vector;
        let end = sensor.tracker_from_sensor.translation.vector + error * 10.0;
        let names = file.names().into_iter().enumerate();
        let arrows = names.filter(|(_, name)| name.starts_with("error of the CRF's sensor"));
        let nearest = arrows
            .flat_map(|(node, _)| file.points_mm(node))
            .map(|p| (p.coords - end).norm())
            .fold(f64::MAX, f64::min);
        assert!(nearest < CLOSE_MM, "{nearest}");
    }
    // The ghost's tip is where the tip's vector ends.
    let ghost = file.root_from(file.node("ghost: "));
    let end = tracker_mm(ghost.transform_point(&tip));
    assert!((end - (is + (reported - is) * 10.0)).norm() < CLOSE_MM);
}

#[test]
fn names_of_any_letters_stay_as_they_are() {
    let odd = "<script>\"x\\\" & \u{202e}\u{0000}\u{1F9B4} '\n</script>";
    let world = world("endoscope");
    let mut design = world.document.design().clone();
    design.name = odd.to_owned();
    design.tool.body.rigid.name = odd.to_owned();
    design.tool.body.rigid.sensors[0].name = odd.to_owned();
    let mesh = world.mesh(BodyRole::Tool).cloned();
    let view = world.document.view().clone();
    let document = Document::new(design, view, Origin::BuiltIn("endoscope"));
    let world = World::new(document, Arc::clone(&world.environment), mesh, None);
    let (_, file) = scene(&world, &SceneWish::default());
    assert_eq!(file.json["scenes"][0]["name"], odd);
    assert_eq!(file.json["asset"]["extras"]["design"], odd);
    assert!(file.has(&format!("sensor {odd}")) && file.has(&format!("tool {odd}")));
}

/// All layers but those that take seconds.
const MOST: &str = "volume,generator,grid,anatomy,sensor-errors,tip-error,requirement,ghost,motion,tip-scatter,slice,arrows,\
                    support";

#[test]
fn layers_and_hidden_things_decide_what_is_there() {
    let mut world = world("shaver-on-head");
    let (_, file) = scene(&world, &with_layers("none"));
    let others = ["slice", "ghost", "error", "anatomy", "measurement", "field", "ground", "range"];
    for other in others {
        assert!(!file.has(other), "{other}");
    }
    assert!(file.has("tool ") && file.has("CRF ") && file.has("sensor "));
    let (_, file) = scene(&world, &with_layers(MOST));
    for layer in others.iter().chain(&["requirement", "region where the room"]) {
        assert!(file.has(layer), "{layer}");
    }
    let mut view = world.document.view().clone();
    view.hidden.toggle(Thing::Crf);
    world.document.set_view(view);
    let (_, file) = scene(&world, &with_layers("anatomy,sensor-errors"));
    assert!(!file.has("anatomy") && !file.has("error of the CRF") && file.has("error of the tool"));
}

#[test]
fn the_legend_names_what_is_drawn() {
    let world = world(trackwright_project::DEFAULT_BUILTIN);
    let texts = |list: &str| -> Vec<String> {
        let (scene, _) = scene(&world, &with_layers(list));
        scene.legend.into_iter().map(|key| key.text).collect()
    };
    let with = texts("tip-error,ghost");
    assert!(with.contains(&"error vectors, two heads: longer than drawn".to_owned()), "{with:?}");
    assert!(with.contains(&"the tool as the tracker reports it".to_owned()), "{with:?}");
    let without = texts("volume");
    assert!(without.iter().all(|text| !text.starts_with("errors")), "{without:?}");
    assert_ne!(with, without);
}

#[test]
fn placements_paint_their_body() {
    let world = world("pointer-on-head");
    let wish = SceneWish { painted: Some((BodyRole::Crf, 1)), ..with_layers("placement") };
    let stage = Stage::new(&world, &wish);
    let sampled = stage.sample(&Task::default()).unwrap();
    let file = File::of(&stage.draw(&sampled).unwrap().glb);
    let found = &sampled.placement.as_ref().unwrap().outcome;
    let mesh = stage.mesh(BodyRole::Crf).unwrap();
    let mut first = 0;
    for part in mesh.body_parts() {
        let colors = file.attribute(file.node(&part.name), "COLOR_0");
        assert_eq!(colors.len(), part.positions_mm.len());
        for k in (0..colors.len()).step_by(101) {
            let value = found.places[first + k].shown_mm().unwrap();
            let [min, max] = painted::placement_range(found, None).unwrap();
            let map = world.document.view().slice.color_map;
            let expected = map.srgb((value - min) / (max - min));
            assert_eq!([0, 1, 2].map(|c| srgb8(colors[k][c])), expected);
        }
        first += part.positions_mm.len();
    }
    assert_eq!(first, found.places.len());
}

#[test]
fn a_slice_outside_the_room_is_grey_or_refused() {
    let mut world = world("endoscope");
    let mut view = world.document.view().clone();
    view.slice.axis = SliceAxis::Z;
    view.slice.position_mm = 4000.0;
    world.document.set_view(view.clone());
    let (_, file) = scene(&world, &with_layers("slice"));
    assert!(!file.has("slice, position error"));
    let colors = file.attribute(file.node("slice, no value"), "COLOR_0");
    let grey = trackwright_geometry::colormap::NO_VALUE_SRGB;
    assert!(colors.iter().all(|c| [0, 1, 2].map(|k| srgb8(c[k])) == grey));
    view.slice.position_mm = 1e300;
    world.document.set_view(view);
    let error = glb(&world, &with_layers("slice"), &Task::default()).unwrap_err();
    assert!(error.to_string().contains("32-bit numbers cannot hold"), "{error}");
}

#[test]
fn a_body_without_a_mesh_has_a_placeholder() {
    let world = world("endoscope");
    let mut design = world.document.design().clone();
    design.tool.body.mesh = None;
    let document = |design| Document::new(design, View::default(), Origin::BuiltIn("endoscope"));
    let bare = |design| World::new(document(design), Arc::clone(&world.environment), None, None);
    let (found, file) = scene(&bare(design.clone()), &with_layers("all"));
    assert!(file.has("stand-in") && file.has("sensor "), "{:?}", file.names());
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    design.tool.body.rigid.sensors.clear();
    let (found, file) = scene(&bare(design), &with_layers("all"));
    assert!(!file.has("sensor "));
    assert!(found.notes.iter().any(|note| note.starts_with("placement: ")), "{:?}", found.notes);
}

/// A sheet of so many squares a side.
fn sheet(squares: u32) -> SurfaceMesh {
    let row = squares + 1;
    let places = (0..row).flat_map(|v| (0..row).map(move |u| (u, v)));
    let positions_mm: Vec<_> = places
        .map(|(u, v)| {
            let [x, y] = [u, v].map(|k| f64::from(k) / f64::from(squares) * 100.0);
            Point3::new(x, y, 3.0 * (x / 20.0).sin() * (y / 15.0).cos())
        })
        .collect();
    let cells = (0..squares).flat_map(|v| (0..squares).map(move |u| v * row + u));
    SurfaceMesh {
        parts: vec![MeshPart {
            name: "sheet".to_owned(),
            normals: vec![Vector3::z(); positions_mm.len()],
            positions_mm,
            triangles: cells
                .flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]])
                .collect(),
            base_color: [0.5, 0.5, 0.5, 1.0],
            metallic: 0.0,
            roughness: 0.5,
        }],
        ..SurfaceMesh::default()
    }
}

#[test]
fn a_mesh_of_a_million_triangles_is_coarser() {
    let own = world("endoscope");
    let document = own.document.clone();
    let mesh = Some(Arc::new(sheet(710)));
    let world = World::new(document, Arc::clone(&own.environment), mesh, None);
    let (found, file) = scene(&world, &with_layers("ghost"));
    let [note] = &found.notes[..] else { panic!("{:?}", found.notes) };
    assert!(note.ends_with("of its 1008200 triangles"), "{note}");
    // A vertex takes 24 bytes and counts for two triangles of 12, once for body and ghost together.
    assert!(found.glb.len() < MOST_TRIANGLES * 26, "{}", found.glb.len());
    let corners = file.attribute(file.node("sheet"), "POSITION").into_iter();
    let bounds = Bounds::around(corners.map(|p| Point3::new(p[0], p[1], p[2]))).unwrap();
    // Cells of a lattice take a millimetre off each side at most.
    assert!((bounds.size_mm().xy().amax() - 100.0).abs() < 2.0, "{bounds:?}");
    let all = SceneWish { most_triangles: usize::MAX, ..with_layers("none") };
    let (found, _) = scene(&world, &all);
    assert!(found.notes.is_empty() && found.glb.len() > 24_000_000);
}

#[test]
fn work_that_nobody_wants_any_more_ends() {
    let cancel = trackwright_task::CancelToken::default();
    cancel.cancel();
    let task = Task::cancelled_by(cancel);
    let stopped = glb(&world("endoscope"), &SceneWish::default(), &task);
    assert!(matches!(stopped, Err(SceneError::Cancelled)));
}
