//! Drawings show lengths that are true, and names as they are written.

use super::*;
use maud::PreEscaped;
use nalgebra::{Point3, Vector3};
use scraper::{ElementRef, Html, Selector};
use trackwright_design::BodyRole;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_simulation::{RigidBody, Sensor, SensorOrientation};

fn texts(html: &str, what: &str) -> Vec<String> {
    let page = Html::parse_fragment(html);
    let selector = Selector::parse(what).unwrap();
    page.select(&selector).map(|element| element.text().collect()).collect()
}

fn drawn(body: &RigidBody, mesh: Option<&SurfaceMesh>) -> String {
    let drawings = body_drawings(body, mesh);
    drawings.into_iter().map(PreEscaped::into_string).collect()
}

#[test]
fn crowded_sensors_are_drawn_once_more_alone() {
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap();
    let design = world.document.design();
    let count = |role| {
        let mesh = world.mesh(role).map(AsRef::as_ref);
        body_drawings(&design.body(role).unwrap().rigid, mesh).len()
    };
    assert_eq!((count(BodyRole::Tool), count(BodyRole::Crf)), (1, 2));
    let crf = &design.body(BodyRole::Crf).unwrap().rigid;
    let mesh = world.mesh(BodyRole::Crf).map(AsRef::as_ref);
    let measures = texts(&drawn(crf, mesh), "text.measure");
    // Each place once, in the drawing that is large enough.
    let times = |length: &str| measures.iter().filter(|m| *m == length).count();
    assert_eq!((times("13.5"), times("8.4"), times("5.8")), (2, 1, 1), "{measures:?}");
}

#[test]
fn a_length_has_the_digits_that_it_has() {
    assert_eq!(dimension_text(72.0), "72");
    assert_eq!(dimension_text(6.5), "6.5");
    assert_eq!(dimension_text(0.128), "0.13");
    assert_eq!(dimension_text(-4.0), "−4");
    assert_eq!(dimension_text(-0.001), "0");
    assert_eq!(dimension_text(100.0), "100");
}

#[test]
fn pointer_sensors_have_distances_from_the_tip() {
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap();
    let tool = &world.document.design().tool.body.rigid;
    let mesh = world.mesh(BodyRole::Tool).unwrap();
    let drawing = drawn(tool, Some(mesh));
    let measures = texts(&drawing, "text.measure");
    for expected in ["72", "112", "148", "5"] {
        assert!(measures.iter().any(|m| m == expected), "{expected}: {measures:?}");
    }
    let length_mm = mesh.body_bounds().unwrap().size_mm().z;
    assert!(measures.contains(&dimension_text(length_mm)), "{measures:?}");
    // Views are drawn to one scale that the bar shows.
    assert!(measures.iter().any(|m| m.ends_with("mm")));
}

/// The word is printed above what is below it.
#[test]
fn the_datums_word_covers_no_dimension() {
    for name in trackwright_project::builtin_names() {
        let world = trackwright_project::open_builtin(name).unwrap();
        for (role, body) in world.document.design().bodies() {
            let drawing = drawn(&body.rigid, world.mesh(role).map(|mesh| &**mesh));
            let page = Html::parse_fragment(&drawing);
            let x = |what: &ElementRef| what.attr("x").unwrap().parse::<f64>().unwrap();
            let [drawings, words, upright] =
                ["svg.drawing", "text.word", "text.measure[transform]"]
                    .map(|what| Selector::parse(what).unwrap());
            for drawing in page.select(&drawings) {
                let begin = drawing.select(&words).map(|word| {
                    let letters = word.text().map(str::len).sum::<usize>();
                    // They end at their x, and are 9 wide: measured in a browser.
                    x(&word) - 9.0 * letters as f64
                });
                let leftmost = begin.fold(f64::INFINITY, f64::min);
                for number in drawing.select(&upright) {
                    let at = x(&number);
                    assert!((0.0..leftmost).contains(&at), "{name}: {at} under {leftmost}");
                }
            }
        }
    }
}

#[test]
fn a_dimension_is_as_long_as_its_number() {
    let body = RigidBody {
        name: "b".to_owned(),
        tip_in_body: Some(Point3::origin()),
        sensors: [25.0, 100.0]
            .map(|z| Sensor::five_dof("s", Point3::new(0.0, 0.0, z), Vector3::x_axis()))
            .to_vec(),
    };
    let drawing = drawn(&body, None);
    let page = Html::parse_fragment(&drawing);
    let lengths: Vec<f64> = page
        .select(&Selector::parse("line.dimension").unwrap())
        .map(|line| {
            let of = |name| line.attr(name).unwrap().parse::<f64>().unwrap();
            (of("x2") - of("x1")).hypot(of("y2") - of("y1"))
        })
        .collect();
    assert_eq!(lengths.len(), 2);
    assert!((lengths[1] / lengths[0] - 4.0).abs() < 0.01, "{lengths:?}");
    let bar = page.select(&Selector::parse("line.scale-bar").unwrap()).nth(2).unwrap();
    let of = |name| bar.attr(name).unwrap().parse::<f64>().unwrap();
    let shown_mm = texts(&drawing, "text.measure")
        .into_iter()
        .find_map(|m| m.strip_suffix("\u{2009}mm").map(|m| m.parse::<f64>().unwrap()));
    let px_per_mm = (of("x2") - of("x1")) / shown_mm.unwrap();
    assert!((lengths[1] / px_per_mm - 100.0).abs() < 0.3, "{px_per_mm}");
}

#[test]
fn markup_in_names_is_text_in_a_drawing_too() {
    let mut world =
        trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap();
    let evil = "</title></svg><script>alert(1)</script><img src=x onerror=alert(2)>";
    let mut design = world.document.design().clone();
    design.tool.body.rigid.sensors[0].name = evil.to_owned();
    design.tool.body.rigid.name = evil.to_owned();
    let mesh = world.mesh(BodyRole::Tool).cloned();
    let environment = std::sync::Arc::make_mut(&mut world.environment);
    let drawings = [
        PreEscaped(drawn(&design.tool.body.rigid, mesh.as_deref())),
        setup_drawing(&SetUp {
            design: &design,
            environment,
            tool_mesh: mesh.as_deref(),
            crf_mesh: None,
            generator_mesh: None,
        }),
    ];
    for drawing in drawings.map(PreEscaped::into_string) {
        let page = Html::parse_fragment(&drawing);
        let none = Selector::parse("script, img").unwrap();
        assert_eq!(page.select(&none).count(), 0);
        assert!(texts(&drawing, "svg").concat().contains(evil));
    }
}

#[test]
fn bodies_of_extreme_sizes_are_drawn() {
    let at = |place: [f64; 3]| Sensor::new("", place, SensorOrientation::Marker);
    for sensors in [
        vec![],
        vec![at([0.0; 3])],
        vec![at([1e300, 0.0, 0.0]), at([-1e300, 0.0, 0.0])],
        vec![at([1e-300, 0.0, 0.0])],
    ] {
        let body = RigidBody { name: "b".to_owned(), tip_in_body: None, sensors };
        let drawing = drawn(&body, None);
        assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
    }
}
