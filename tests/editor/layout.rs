//! What is written in the window, at the sizes and scales that people have: nothing is cut, and no
//! text lies on another.

use crate::copied::Copied;
use bevy::math::Vec2;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::process::Command;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::app::picture::{self, ComparedDesigns, PictureSetup, StudyTrial};
use trackwright_editor::palette::Theme;
use trackwright_editor::shell::painted_text::PaintedText;
use trackwright_editor::shell::preferences::InterfaceScale;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces::field::state::TableRole;
use trackwright_editor::workspaces::{decide, design, field, present, study};
use trackwright_optimization::Settings;
use trackwright_simulation::SensorOrientation;

/// Width and height in pixels.
const SIZES: [[u32; 2]; 3] = [[1024, 700], [1440, 900], [3840, 2160]];

/// How large the interface is.
const SCALES: [f64; 3] = [1.0, 1.5, 2.0];

/// Letters reach beyond their line by less than this, points.
const SLACK: f32 = 1.5;

/// A window as egui lays it out, in points: a picture of that size at scale 1 has the same texts at
/// the same places, with fewer pixels to paint.
fn points(size: [u32; 2], scale: f64) -> [u32; 2] {
    let [width, height] = size;
    let shown = InterfaceScale(scale).in_window(Vec2::new(width as f32, height as f32));
    size.map(|side| (f64::from(side) / shown).round() as u32)
}

fn setups(copy: &Copied) -> Vec<(Workspace, PictureSetup)> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let data = |name: &str| root.join("assets/environments/data").join(name);
    let base = |workspace| PictureSetup {
        has_panels: true,
        theme: Theme::Dark,
        workspace,
        ..PictureSetup::default()
    };
    let tables = vec![
        (TableRole::Training, data("cube-fit.csv")),
        (TableRole::HeldOut, data("cube-holdout.csv")),
    ];
    let compared =
        ComparedDesigns { baseline: Some(copy.design.clone()), ..ComparedDesigns::default() };
    vec![
        (design::WORKSPACE, base(design::WORKSPACE)),
        (field::WORKSPACE, PictureSetup { tables, ..base(field::WORKSPACE) }),
        (
            study::WORKSPACE,
            PictureSetup { trial: Some(StudyTrial::Worst), ..base(study::WORKSPACE) },
        ),
        (decide::WORKSPACE, PictureSetup { compared, ..base(decide::WORKSPACE) }),
        (present::WORKSPACE, base(present::WORKSPACE)),
    ]
}

/// Faults of a picture, in words.
fn faults(texts: &[PaintedText], width: f32) -> Vec<String> {
    let seen: Vec<&PaintedText> = texts
        .iter()
        .filter(|text| text.seen().is_positive() && !text.text.trim().is_empty())
        .collect();
    // The table of designs is as wide as the window and scrolls sideways.
    let scrolls = |text: &PaintedText| text.clip.width() > 0.9 * width;
    let is_cut = |text: &PaintedText| {
        let (left, right) = (text.clip.left() - SLACK, text.clip.right() + SLACK);
        !scrolls(text) && (text.rect.left() < left || text.rect.right() > right)
    };
    let cut = seen.iter().filter(|text| is_cut(text));
    let mut faults: Vec<String> =
        cut.map(|text| format!("cut: {:?} at {:?}", text.text, text.rect)).collect();
    for (k, one) in seen.iter().enumerate() {
        for other in &seen[k + 1..] {
            let common = one.seen().intersect(other.seen()).shrink(SLACK);
            // A text and its shadow.
            if common.is_positive() && one.text != other.text {
                faults.push(format!("{:?} on {:?} at {:?}", other.text, one.text, common));
            }
        }
    }
    faults
}

/// Faults of every workspace.
fn faults_of_all(copy: &Copied, size: [u32; 2], scale: f64, theme: Theme) -> Vec<String> {
    let mut found = Vec::new();
    let [width, height] = size;
    let shown = InterfaceScale(scale).in_window(Vec2::new(width as f32, height as f32));
    for (workspace, setup) in setups(copy) {
        let world = trackwright_project::open_design(&copy.design).unwrap();
        let setup = PictureSetup { scale: InterfaceScale(scale), theme, ..setup };
        let texts = picture::texts(world, size, setup).unwrap();
        assert!(texts.len() > 4, "{}: {} texts", workspace.name, texts.len());
        let at = format!("{} {width}x{height} {scale} {theme:?}", workspace.name);
        let faults = faults(&texts, width as f32 / shown as f32);
        found.extend(faults.into_iter().map(|fault| format!("{at}: {fault}")));
    }
    found
}

#[test]
fn no_text_is_cut_or_lies_on_another() {
    let copy = Copied::new("pointer-on-head");
    // What is the same window in points is laid out once.
    let all = SIZES.iter().flat_map(|size| SCALES.map(|scale| points(*size, scale)));
    let windows: BTreeSet<[u32; 2]> = all.collect();
    assert_eq!(windows.len(), 7, "{windows:?}");
    let found: Vec<String> = (windows.into_iter())
        .flat_map(|window| faults_of_all(&copy, window, 1.0, Theme::Dark))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A built-in tool with two coils in line and long names, in a file with a long name.
fn long_names(name: &str) -> Copied {
    let mut copy = Copied::new(name);
    let mut world = trackwright_project::open_design(&copy.design).unwrap();
    let document = &mut world.document;
    // Its field scrolls what is longer.
    document.apply(Edit::SetName("biopsy needle, second draft".to_owned())).unwrap();
    for index in [0, 1] {
        let mut sensor = document.design().tool.body.rigid.sensors[index].clone();
        sensor.name = format!("coil {index} at the end of the narrow part");
        sensor.orientation = SensorOrientation::FiveDof(Vector3::z_axis());
        let body = BodyRole::Tool;
        document.apply(Edit::SetSensor { body, index, sensor }).unwrap();
    }
    trackwright_project::save(&mut world).unwrap();
    let long = "biopsy-needle-for-the-liver-second-draft-with-a-wider-bore.design.ron";
    let design = copy.design.with_file_name(long);
    std::fs::rename(&copy.design, &design).unwrap();
    copy.design = design;
    copy
}

#[test]
fn long_names_and_warnings_find_room() {
    let copy = long_names("new-tool-on-crf");
    let found: Vec<String> = [[960, 600], [1024, 700], [1440, 900]]
        .into_iter()
        .flat_map(|window| faults_of_all(&copy, window, 1.0, Theme::Dark))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn found_places_have_room_in_the_panel() {
    let copy = long_names("pointer-on-head");
    let search = Settings { most_fits: 300_000, ..Settings::default() };
    // The side scrolls in a low window; a high one shows all of it.
    for size in [[960, 600], [960, 2400]] {
        let world = trackwright_project::open_design(&copy.design).unwrap();
        let setup = PictureSetup {
            has_panels: true,
            workspace: design::WORKSPACE,
            placement_search: Some((BodyRole::Tool, search)),
            ..PictureSetup::default()
        };
        let texts = picture::texts(world, size, setup).unwrap();
        for wanted in ["Find better places", "Show settings", "Result"] {
            assert!(texts.iter().any(|text| text.text == wanted), "{wanted}: {texts:?}");
        }
        let has_result = texts.iter().any(|text| text.text == "Take this one");
        assert!(has_result || size[1] < 1000, "{texts:?}");
        let found = faults(&texts, size[0] as f32);
        assert!(found.is_empty(), "{size:?}\n{}", found.join("\n"));
    }
}

/// The theme is the whole process's: this runs alone, started by the test below.
#[test]
#[ignore = "changes the theme of tests beside it"]
fn no_text_is_cut_in_this_light_process() {
    let copy = Copied::new("pointer-on-head");
    let found = faults_of_all(&copy, SIZES[0], SCALES[2], Theme::Light);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// The themes differ in colours only: light is laid out where room is least.
#[test]
fn no_text_is_cut_in_the_light_theme() {
    let own = std::env::current_exe().unwrap();
    let alone = ["--exact", "layout::no_text_is_cut_in_this_light_process", "--ignored"];
    let output = Command::new(own).args(alone).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("1 passed"), "{text}");
}
