//! What is written in the window, at the sizes and scales that people have: nothing is cut, and no
//! text lies on another.

use crate::copied::Copied;
use trackwright_editor::app::picture::{self, ComparedDesigns, PictureSetup, StudyTrial};
use trackwright_editor::palette::Theme;
use trackwright_editor::shell::painted_text::PaintedText;
use trackwright_editor::shell::preferences::InterfaceScale;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces::field::state::TableRole;
use trackwright_editor::workspaces::{decide, design, field, present, study};

/// Width and height in pixels, and how large the interface is.
const SIZES: [([u32; 2], f64); 2] = [([1024, 700], 1.0), ([1440, 900], 1.5)];

/// Letters reach beyond their line by less than this, points.
const SLACK: f32 = 1.5;

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

#[test]
fn no_text_is_cut_or_lies_on_another() {
    let copy = Copied::new("pointer-on-head");
    let mut found = Vec::new();
    for (size, scale) in SIZES {
        for (workspace, setup) in setups(&copy) {
            let world = trackwright_project::open_design(&copy.design).unwrap();
            let setup = PictureSetup { scale: InterfaceScale(scale), ..setup };
            let texts = picture::texts(world, size, setup).unwrap();
            assert!(texts.len() > 4, "{}: {} texts", workspace.name, texts.len());
            let at = format!("{} {}x{} {scale}", workspace.name, size[0], size[1]);
            let width = size[0] as f32 / scale as f32;
            found.extend(faults(&texts, width).into_iter().map(|fault| format!("{at}: {fault}")));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
