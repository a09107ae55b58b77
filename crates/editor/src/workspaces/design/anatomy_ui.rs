//! The design's anatomy: its rows in the outliner, and the numbers of the one that is selected.

use crate::document::commands::ADD_ANATOMY;
use crate::document::selection::Selected;
use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{Mark, Row, quiet_ui, row_ui, section_ui};
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::design::actions::DesignAction;
use crate::workspaces::design::outliner_row::OutlinerView;
use crate::workspaces::design::rows::{right_ui, rotation_ui, text_row_ui, vector_ui};
use bevy_egui::egui::{self, Color32, ComboBox, Ui};
use trackwright_design::{Anatomy, AnatomyEdit, AnatomyFrame, Design, Edit};
use trackwright_geometry::pose::pose_from_parts;
use trackwright_scene::color_of_anatomy;
use trackwright_scene::palette::Rgb;

/// A row for each mesh, and one that adds another.
pub(crate) fn anatomy_rows_ui(
    ui: &mut Ui,
    outliner: &OutlinerView,
    actions: &mut Vec<DesignAction>,
) {
    section_ui(ui, "Anatomy meshes");
    for (index, anatomy) in outliner.design.anatomy.iter().enumerate() {
        let what = Selected::Anatomy(index);
        let row = Row {
            label: &anatomy.name,
            note: match anatomy.on {
                AnatomyFrame::Crf => "on CRF",
                AnatomyFrame::Tracker => "on tracker",
            },
            mark: Some((Mark::Square, color_of_anatomy(anatomy).color32())),
            is_selected: outliner.selection.contains(what),
            is_hovered: outliner.hovered == Some(what),
            ..Row::default()
        };
        let response = row_ui(ui, &row);
        if response.hovered() {
            actions.push(DesignAction::Hover(what));
        }
        if response.clicked() {
            actions.push(DesignAction::Select(Some(what)));
        }
    }
    let add = Row {
        label: "Add anatomy…",
        indent: 1,
        mark: Some((Mark::Plus, palette::TEXT_QUIET.color32())),
        ..Row::default()
    };
    if row_ui(ui, &add).explained(ADD_ANATOMY.about).clicked() {
        actions.push(DesignAction::Run(ADD_ANATOMY.name));
    }
}

/// The numbers of one mesh.
pub fn anatomy_ui(ui: &mut Ui, design: &Design, index: usize, actions: &mut Vec<DesignAction>) {
    let Some(anatomy) = design.anatomy.get(index) else {
        return;
    };
    let set =
        |anatomy: Anatomy| Edit::Anatomy(AnatomyEdit::Set { index, anatomy: Box::new(anatomy) });
    section_ui(ui, "Anatomy");
    if let Some(name) = text_row_ui(ui, "name", &anatomy.name) {
        let named = Anatomy { name, ..anatomy.clone() };
        actions.push(DesignAction::apply(set(named)));
    }
    quiet_ui(ui, "Shown translucent; no figure depends on it");
    ui.horizontal(|ui| {
        ui.label("moves with")
            .explained("The patient goes with the CRF, what stands in the room does not");
        right_ui(ui, |ui| frame_ui(ui, design, anatomy, actions, &set));
    });
    ui.horizontal(|ui| {
        ui.label("colour");
        right_ui(ui, |ui| color_ui(ui, anatomy, actions, &set));
    });
    section_ui(
        ui,
        match anatomy.on {
            AnatomyFrame::Crf if design.crf.is_some() => "Pose in the CRF",
            _ => "Pose in the tracker frame",
        },
    );
    let pose = &anatomy.frame_from_mesh;
    let label = format!("Move anatomy {}", anatomy.name);
    let moved = |position, rotation| {
        set(Anatomy { frame_from_mesh: pose_from_parts(position, rotation), ..anatomy.clone() })
    };
    let position = &pose.translation.vector;
    vector_ui(ui, "position", position, actions, &label, |position| {
        Some(moved(position, pose.rotation))
    });
    rotation_ui(ui, &pose.rotation, actions, &label, |rotation| {
        moved(pose.translation.vector, rotation)
    });
    ui.add_space(6.0);
    let about = "Takes the mesh out of the design; no figure depends on it";
    if button_ui(ui, "Remove anatomy", about).clicked() {
        let remove = AnatomyEdit::Remove { index };
        actions.push(DesignAction::apply(Edit::Anatomy(remove)));
    }
}

/// It stays where it is when it changes hands.
fn frame_ui(
    ui: &mut Ui,
    design: &Design,
    anatomy: &Anatomy,
    actions: &mut Vec<DesignAction>,
    set: &impl Fn(Anatomy) -> Edit,
) {
    let response = ComboBox::from_id_salt("anatomy frame")
        .selected_text(anatomy.on.name())
        .show_ui(ui, |ui| {
            for on in AnatomyFrame::ALL {
                let is = anatomy.on == on;
                if ui.selectable_label(is, on.name()).clicked() && !is {
                    actions.push(DesignAction::apply(set(anatomy.put_on(on, design))));
                }
            }
        });
    let response = response.response;
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::ComboBox, true, "moves with"));
    response.explained("What the anatomy moves with: the CRF, or nothing");
}

/// Colours to choose from: bone, which is no colour of its own, and some that differ from what the
/// scene's other things are drawn in.
fn color_ui(
    ui: &mut Ui,
    anatomy: &Anatomy,
    actions: &mut Vec<DesignAction>,
    set: &impl Fn(Anatomy) -> Edit,
) {
    for (name, color) in CHOICES.into_iter().rev() {
        let own = color.map(|rgb| rgb.srgb().map(|part| f64::from(part) / 255.0));
        let is = match (own, anatomy.color) {
            (Some(own), Some(has)) => own.iter().zip(has).all(|(a, b)| (a - b).abs() < 0.5 / 255.0),
            (own, has) => own.is_none() && has.is_none(),
        };
        let fill = color.unwrap_or(palette::BONE).color32();
        let stroke = match is {
            true => palette::TEXT_STRONG.color32(),
            false => Color32::TRANSPARENT,
        };
        let button = egui::Button::new("")
            .fill(fill)
            .stroke(egui::Stroke::new(1.5, stroke))
            .min_size(egui::vec2(SWATCH, SWATCH));
        let response = ui.add(button).explained(name);
        response
            .widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, is, name));
        if response.clicked() && !is {
            actions.push(DesignAction::apply(set(Anatomy { color: own, ..anatomy.clone() })));
        }
    }
}

const SWATCH: f32 = 18.0;

const CHOICES: [(&str, Option<Rgb>); 5] = [
    ("bone", None),
    ("skin", Some(palette::SKIN)),
    ("vessel", Some(palette::VESSEL)),
    ("organ", Some(palette::ORGAN)),
    ("equipment", Some(palette::EQUIPMENT)),
];
