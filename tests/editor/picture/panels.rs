//! The panels of every workspace in pictures: each where it belongs and written in, the 3D view
//! free of them, at the smallest size and at the usual one.

use super::render;
use crate::copied::Copied;
use crate::pixels::{Picture, is_near};
use crate::support::program::text;
use trackwright_editor::palette;
use trackwright_editor::palette::ThemedColor;
use trackwright_editor::widgets::theme;

const SIZES: [[u16; 2]; 2] = [[1280, 720], [1440, 900]];

/// A word of body text has more pixels of its colour than this.
const A_WORD_PX: usize = 60;

/// From, to: pixels.
#[derive(Clone, Copy, Debug)]
struct Area {
    x: [f32; 2],
    y: [f32; 2],
}

impl Area {
    fn count(self, picture: &Picture, is_wanted: impl Fn([u8; 3]) -> bool) -> usize {
        let inside = |range: [f32; 2], v: usize| (range[0]..range[1]).contains(&(v as f32));
        let places = picture.all(is_wanted);
        let inside = |[x, y]: &[usize; 2]| inside(self.x, *x) && inside(self.y, *y);
        places.iter().filter(|at| inside(at)).count()
    }

    fn size_px(self) -> f32 {
        (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])
    }
}

fn is_text(color: [u8; 3]) -> bool {
    [palette::TEXT, palette::TEXT_STRONG, palette::TEXT_QUIET]
        .iter()
        .any(|text| is_near(color, text.srgb(), 24))
}

/// The areas of a workspace's panels, and what is left for the 3D view.
fn areas(workspace: &str, [width, height]: [f32; 2]) -> (Vec<(&'static str, Area)>, Area) {
    let right_width = match workspace {
        "field" => theme::FIELD_WIDTH,
        _ => theme::RIGHT_WIDTH,
    };
    let status = height - theme::STATUS_BAR_HEIGHT;
    let bottom = match workspace {
        "study" => status - theme::TIMELINE_HEIGHT,
        _ => status,
    };
    let (left, right) = (theme::LEFT_WIDTH, width - right_width);
    let between = [theme::TOP_BAR_HEIGHT, bottom];
    let area = |x, y| Area { x, y };
    let mut panels = vec![
        ("top bar", area([0.0, width], [0.0, theme::TOP_BAR_HEIGHT])),
        ("status bar", area([0.0, width], [status, height])),
        ("left", area([0.0, left], between)),
        ("right", area([right, width], between)),
    ];
    if workspace == "study" {
        panels.push(("timeline", area([0.0, width], [bottom, status])));
    }
    (panels, area([left, right], between))
}

#[test]
fn every_workspace_has_readable_panels() {
    let copy = Copied::new("pointer-on-head");
    let data = |name: &str| {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        text(&root.join("assets/environments/data").join(name))
    };
    let (fit, holdout) = (data("cube-fit.csv"), data("cube-holdout.csv"));
    let more: [(&str, Vec<&str>); 3] = [
        ("design", vec![]),
        ("field", vec!["--measurements", &fit, "--holdout", &holdout]),
        ("study", vec!["--trial", "worst"]),
    ];
    for size in SIZES {
        for (workspace, more) in &more {
            let name = format!("{}x{}", size[0], size[1]);
            let window = ["--window", "--workspace", workspace, "--layers", "none"];
            let picture = render(&copy, &name, &[&window[..], more].concat());
            let (panels, view) = areas(workspace, size.map(f32::from));
            let is_panel = |color| color == palette::PANEL.srgb();
            for (panel, area) in panels {
                let written = area.count(&picture, is_text);
                assert!(written > A_WORD_PX, "{workspace} {name} {panel}: {written}");
                // Charts and fields have a ground of their own.
                let ground = area.count(&picture, is_panel) as f32;
                assert!(ground > 0.2 * area.size_px(), "{workspace} {name} {panel}: {ground}");
            }
            let covered = view.count(&picture, is_panel) as f32;
            assert!(covered < 0.05 * view.size_px(), "{workspace} {name}: {covered} of the view");
        }
    }
}

#[test]
fn each_selection_has_its_inspector_page() {
    let copy = Copied::new("pointer-on-head");
    let size = SIZES[1];
    let name = format!("{}x{}", size[0], size[1]);
    let (panels, _) = areas("design", size.map(f32::from));
    let (_, right) = panels[3];
    let pages: Vec<_> = ["tool", "crf", "tool/tip", "tool/shaft"]
        .into_iter()
        .map(|what| {
            let more = ["--window", "--layers", "none", "--select", what];
            let picture = render(&copy, &name, &more);
            let written = picture.all(is_text);
            let is_inside = |[x, _]: &[usize; 2]| *x as f32 >= right.x[0];
            written.into_iter().filter(is_inside).collect::<std::collections::BTreeSet<_>>()
        })
        .collect();
    for (k, page) in pages.iter().enumerate() {
        assert!(page.len() > 10 * A_WORD_PX, "{k}: {}", page.len());
        for other in &pages[k + 1..] {
            let different = page.symmetric_difference(other).count();
            assert!(different > 5 * A_WORD_PX, "{k}: {different}");
        }
    }
}
