//! Designs as they stand in files: what is read, what is written, what is refused.

use super::*;
use crate::test_cases::assert_refused;
use trackwright_design::SlideFigure;
use trackwright_design::view::{AxisRule, CameraView, CoilDepth, Layers, Magnification};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::{Metric, Pivot};

const EXAMPLE: &str = r#"(
    version: 1,
    name: "Pointer on a head-mounted CRF",
    environment: "or-table.env.ron",
    crf: Some((
        body: "head.body.ron", pose: (position: (-50.0, 0.0, -300.0), rotation: (1.0, 0.0, 0.0, 0.0)),
        targets: [(name: "left sinus", position: (20.0, -40.0, -60.0))],
    )),
    tool: (body: "pointer.body.ron", pose: (position: (0.0, 0.0, 30.0), rotation: (2.0, 0.0, 0.0, 0.0))),
    motion: (
        x: (min: -50.0, max: 50.0, step: 50.0),
        rz: (min: -90.0, max: 90.0, step: 45.0),
    ),
    orientation_weight: 100.0,
    requirement: Some((position_rms: 1.0, angle_rms: 0.5)),
)
"#;

fn example() -> DesignFile {
    parse(EXAMPLE.as_bytes()).unwrap()
}

#[test]
fn the_example_of_the_contract_is_read() {
    let DesignFile { design, view } = example();
    let crf = design.crf.unwrap();
    assert_eq!(crf.body.reference, "head.body.ron");
    assert_eq!(design.tool.body.reference, "pointer.body.ron");
    assert_eq!(crf.tracker_from_crf.translation.vector.z, -300.0);
    assert_eq!(crf.targets[0].name, "left sinus");
    assert_eq!(design.tool.crf_from_tool, Pose::translation(0.0, 0.0, 30.0));
    assert_eq!(design.motion.unwrap().rz.unwrap().step, 45.0);
    assert_eq!(design.requirement.unwrap().bound(Metric::ANGLE_RMS), Some(0.5));
    assert_eq!(view, View::default());
}

#[test]
fn unknown_layers_are_kept_and_bad_slides_named() {
    let with = |slides: &str| {
        EXAMPLE.replace("    motion: (", &format!("    slides: {slides},\n    motion: ("))
    };
    let gone = with(
        r#"[(title: "new"), Slide(title: "old", view: View(layers: Layers(ghost: false, halo: true, glow: (strength: 0.5, of: ["tip"]), rim: false)))]"#,
    );
    let mut design = parse(gone.as_bytes()).unwrap();
    let [new, old] = &mut design.design.slides[..] else {
        panic!("{design:?}");
    };
    assert!(!old.view.layers.ghost);
    assert_eq!(std::mem::take(&mut old.view.unknown_layers), ["halo", "glow"]);
    assert_eq!((&new.view, &design.view), (&View::default(), &View::default()));
    // It is not written, so it is reported once.
    assert_eq!(parse(write(&design).as_bytes()).unwrap(), design);
    let broken = with(r#"[(title: "a"), (title: "b", view: (arrows: (range_mm: 0.0)))]"#);
    let error = parse(broken.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("slides[1].view.arrows.range_mm is 0"), "{error}");
}

#[test]
fn options_may_be_bare_wrapped_none_or_absent() {
    let bare = EXAMPLE
        .replace("Some((", "((")
        .replace("crf: ((", "crf: (")
        .replace("    )),\n    tool", "    ),\n    tool")
        .replace(
            "requirement: ((position_rms: 1.0, angle_rms: 0.5))",
            "requirement: (position_rms: 1.0, angle_rms: 0.5)",
        );
    assert_eq!(parse(bare.as_bytes()).unwrap(), example());
    let without = EXAMPLE.replace("orientation_weight: 100.0", "orientation_weight: None");
    assert_eq!(parse(without.as_bytes()).unwrap().design.orientation_weight_mm, None);
}

#[test]
fn what_is_written_reads_back() {
    let mut design = example();
    assert_eq!(parse(write(&design).as_bytes()).unwrap(), design);
    design.view.camera = Some(CameraView {
        focus_mm: [0.1, -2.0, 1e-9],
        distance_mm: 300.0,
        azimuth_rad: 0.1 + 0.2,
        elevation_rad: -1.0,
        is_orthographic: true,
    });
    design.view.magnification = Magnification::Times(50.0);
    design.view.layers.ghost = false;
    design.view.slice.range_mm = Some(2.5);
    design.design.slides = vec![
        Slide {
            title: "A \"title\" of\ntwo lines, </script>".into(),
            caption: "ü".into(),
            figures: SlideFigure::ALL.to_vec(),
            view: design.view.clone(),
        },
        Slide::default(),
    ];
    if let Some(crf) = &mut design.design.crf {
        crf.motion = design.design.motion;
        crf.requirement = design.design.requirement;
        crf.targets.clear();
    }
    let text = write(&design);
    assert_eq!(parse(text.as_bytes()).unwrap(), design, "{text}");
    assert!(!text.contains("Some(") && !text.contains("pivot"), "{text}");
    for pivot in [Pivot::Tip, Pivot::Body([0.1, -2.0, 3.5]), Pivot::Reference([1e-3, 0.0, -9.0])] {
        design.design.motion.as_mut().unwrap().pivot = pivot;
        assert_eq!(parse(write(&design).as_bytes()).unwrap(), design);
    }
    design.design.crf = None;
    design.design.motion = None;
    design.design.requirement = None;
    design.design.orientation_weight_mm = None;
    design.design.slides.clear();
    design.view = View::default();
    let text = write(&design);
    assert_eq!(parse(text.as_bytes()).unwrap(), design);
    assert_eq!(text.lines().count(), 9, "{text}");
}

#[test]
fn views_without_newer_fields_read_as_before() {
    // As written before cameras had a projection, placement a depth, requirement and mounting a layer.
    let older = EXAMPLE.replace(
        "    motion: (",
        "    view: (
        camera: (focus_mm: (1.0, 2.0, 3.0), distance_mm: 900.0, azimuth_rad: 0.7, elevation_rad: 0.3),
        layers: (volume: true, generator: false, anatomy: false, ghost: true),
        placement_rule: Normal,
        placement_range_mm: 4.0,
    ),
    motion: (",
    );
    let read = parse(older.as_bytes()).unwrap();
    let camera = CameraView {
        focus_mm: [1.0, 2.0, 3.0],
        distance_mm: 900.0,
        azimuth_rad: 0.7,
        elevation_rad: 0.3,
        is_orthographic: false,
    };
    let expected = View {
        camera: Some(camera),
        layers: Layers { volume: true, anatomy: false, ..Layers::default() },
        placement_rule: AxisRule::Normal,
        placement_depth: CoilDepth::Surface,
        placement_range_mm: Some(4.0),
        ..View::default()
    };
    assert_eq!(read.view, expected);
    // What has its default is not written: older versions open the file.
    let text = write(&read);
    for newer in ["is_orthographic", "placement_depth"] {
        assert!(!text.contains(newer), "{newer}: {text}");
    }
}

#[test]
fn every_wrong_field_is_named() {
    let cases = r#"
        rotation: (2.0, 0.0, 0.0, 0.0) => rotation: (0, 0, 0, 0)
            | tool.pose.rotation is (0, 0, 0, 0), expected a quaternion (w, x, y, z)
        position: (-50.0, 0.0, -300.0) => position: (-50.0, NaN, -300.0)
            | crf.pose.position is (-50, NaN, -300), expected finite numbers
        position: (20.0, -40.0, -60.0) => position: (20.0, -40.0, -inf)
            | crf.targets[0] "left sinus": position is (20, -40, -inf), expected finite numbers
        orientation_weight: 100.0 => orientation_weight: -1
            | orientation_weight is -1, expected zero or more
        position_rms: 1.0 => position_rms: NaN
            | requirement.position_rms is NaN, expected zero or more
        "or-table.env.ron" => "" | environment is empty, expected a file
        x: (min: -50.0, max: 50.0, step: 50.0) => x: (min: -50.0, max: 50.0, step: -50.0)
            | motion.x: step is -50, expected zero or more
        orientation_weight => view: (magnification: Times(-3)), orientation_weight
            | view.magnification is -3, expected a number above zero
    "#;
    assert_refused(EXAMPLE, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
}

#[test]
fn too_many_poses_are_refused_with_their_count() {
    let text = EXAMPLE
        .replace("(min: -50.0, max: 50.0, step: 50.0)", "(min: 0, max: 999999, step: 1)")
        .replace("(min: -90.0, max: 90.0, step: 45.0)", "(min: 0, max: 3600, step: 0.0036)");
    let message = parse(text.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("1.0000e12 poses"), "{message}");
}
