//! Where sensors of the selected body may be mounted: a list of regions with their axis rules,
//! forbidden boxes and distances, and the tools that draw them in the scene.

use crate::viewport::mounting::state::MountingState;
use crate::viewport::tool::SceneTool;
use crate::widgets::basic::{
    NumberField, counted, decimal, number_ui, quiet_ui, section_ui, typed_number_ui, warning_ui,
    with_unit,
};
use crate::widgets::tooltip::{Explain, button_ui, checkbox_ui, labelled};
use crate::workspaces::design::actions::{DesignAction, MountingAction, number_edits};
use crate::workspaces::design::rows::{AXES, right_ui, row_ui, vector_ui};
use bevy_egui::egui::{self, ComboBox, Ui};
use trackwright_design::{BodyRole, Edit};
use trackwright_formats::printable::printable;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_simulation::body::Sensor;
use trackwright_simulation::{Mounting, MountingAxis, MountingRegion, new_forbidden_box};

/// Width of the menu of axis rules, and of a field where two stand in a row.
const MENU_WIDTH: f32 = 120.0;
const NARROW: f32 = 66.0;

/// What a field of a length above zero takes at least.
const LEAST_MM: f64 = 0.01;

/// What is stated first.
const NEW_RADIUS_MM: f64 = 0.5;
const NEW_GAP_MM: f64 = 9.0;

const NO_CHANNEL: &str =
    "No channel found: the body has no long round part with room for one. Draw it in the scene";

/// What the section shows.
pub struct MountingView<'a> {
    pub body: BodyRole,
    pub mounting: &'a Mounting,
    pub sensors: &'a [Sensor],
    pub mesh: Option<&'a SurfaceMesh>,
    pub state: MountingState,
    /// In hand.
    pub tool: SceneTool,
    /// Searched on request.
    pub channel_from_mesh: &'a dyn Fn() -> Option<MountingRegion>,
}

impl MountingView<'_> {
    /// The edit that changes something of the mounting.
    fn edit(&self, change: impl FnOnce(&mut Mounting)) -> Edit {
        let mut mounting = self.mounting.clone();
        change(&mut mounting);
        Edit::SetMounting { body: self.body, mounting: Box::new(mounting) }
    }

    fn apply(&self, change: impl FnOnce(&mut Mounting)) -> DesignAction {
        DesignAction::apply(self.edit(change))
    }

    fn set(&self, change: impl FnOnce(&mut MountingState)) -> DesignAction {
        let mut state = self.state;
        change(&mut state);
        DesignAction::Mounting(MountingAction::Set(state))
    }

    fn label(&self) -> String {
        format!("Change {}'s mounting regions", self.body)
    }
}

/// Draws the section.
pub fn mounting_ui(ui: &mut Ui, view: &MountingView) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    section_ui(ui, "Mounting");
    let mut is_open = view.state.is_open;
    let about =
        "Shows where sensors may be mounted, in the scene and as a list that can be changed";
    if checkbox_ui(ui, &mut is_open, "edit regions", about).changed() {
        actions.push(view.set(|state| state.is_open = is_open));
    }
    quiet_ui(ui, summary(view.mounting));
    if !is_open {
        return actions;
    }
    for (index, region) in view.mounting.regions.iter().enumerate() {
        ui.push_id(("region", index), |ui| region_ui(ui, view, index, region, &mut actions));
    }
    for (index, own) in view.mounting.keep_out.iter().enumerate() {
        ui.push_id(("forbidden box", index), |ui| box_ui(ui, view, index, own, &mut actions));
    }
    ui.add_space(4.0);
    add_ui(ui, view, &mut actions);
    draw_ui(ui, view, &mut actions);
    distances_ui(ui, view, &mut actions);
    actions
}

/// What is stated, in a line.
fn summary(mounting: &Mounting) -> String {
    let regions = match mounting.regions.len() {
        0 => "No region: the whole surface, axes as they are".to_owned(),
        count => counted(count, "region", "regions"),
    };
    match mounting.keep_out.len() {
        0 => regions,
        count => format!("{regions}, {}", counted(count, "forbidden box", "forbidden boxes")),
    }
}

/// `Patch 1`, by its place in the list.
fn region_name(index: usize, region: &MountingRegion) -> String {
    let kind = match region {
        MountingRegion::Surface { .. } => "Patch",
        MountingRegion::Channel { .. } => "Channel",
        MountingRegion::Seat { .. } => "Seat",
    };
    format!("{kind} {}", index + 1)
}

fn axis_name(axis: MountingAxis) -> &'static str {
    match axis {
        MountingAxis::AsItIs => "axis as it is",
        MountingAxis::Free => "any axis",
        MountingAxis::Normal => "axis along normal",
        MountingAxis::Tangent => "axis in surface",
        MountingAxis::Along => "axis along channel",
    }
}

fn region_ui(
    ui: &mut Ui,
    view: &MountingView,
    index: usize,
    region: &MountingRegion,
    actions: &mut Vec<DesignAction>,
) {
    let name = region_name(index, region);
    head_ui(ui, &name, actions, |ui, actions| {
        if remove_ui(ui, &name) {
            actions.push(view.apply(|own| {
                own.regions.remove(index);
            }));
            actions.push(view.set(|state| state.patch = None));
        }
        axis_ui(ui, view, index, region, actions);
    });
    match region {
        MountingRegion::Surface { boxes, .. } => {
            row_ui(ui, "", |ui| {
                let tool = SceneTool::PaintPatch;
                let is_chosen = view.tool == tool
                    && view.mounting.patch_to_paint(view.state.patch) == Some(index);
                if toggle_ui(ui, is_chosen, "Paint", &format!("Paint {name}"), PAINT) {
                    let tool = if is_chosen { SceneTool::Select } else { tool };
                    actions.push(view.set(|state| state.patch = Some(index)));
                    actions.push(DesignAction::Mounting(MountingAction::Take(tool)));
                }
                quiet_ui(
                    ui,
                    match boxes.len() {
                        0 => "the whole surface".to_owned(),
                        count => format!("the surface in {}", counted(count, "box", "boxes")),
                    },
                );
            });
        }
        MountingRegion::Channel { points_mm, radius_mm, .. } => {
            let length = with_unit(&decimal(region.channel_length_mm(), 1), "mm");
            let points = counted(points_mm.len(), "point", "points");
            quiet_ui(ui, format!("{points}, {length} long"));
            radius_ui(ui, view, index, &name, *radius_mm, actions);
        }
        MountingRegion::Seat { position_mm, .. } => {
            let label = view.label();
            vector_ui(ui, &name, &position_mm.coords, actions, &label, |v| {
                Some(view.edit(|own| {
                    if let MountingRegion::Seat { position_mm, .. } = &mut own.regions[index] {
                        *position_mm = v.into();
                    }
                }))
            });
        }
    }
    ui.add_space(4.0);
}

const PAINT: &str =
    "Drag over the body: each place of the brush is added to the patch; with Alt it is erased";

/// A name at the left, what is done to it at the right.
fn head_ui(
    ui: &mut Ui,
    name: &str,
    actions: &mut Vec<DesignAction>,
    add: impl FnOnce(&mut Ui, &mut Vec<DesignAction>),
) {
    row_ui(ui, name, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        add(ui, actions);
    });
}

/// Whether it is to be removed.
fn remove_ui(ui: &mut Ui, name: &str) -> bool {
    let button = button_ui(ui, "Remove", format!("Takes {name} away"));
    labelled(ui, &button, &format!("Remove {name}"));
    button.clicked()
}

/// A button that stays down; whether it was pressed.
fn toggle_ui(ui: &mut Ui, is_on: bool, text: &str, name: &str, about: &str) -> bool {
    let button = ui.add(egui::Button::selectable(is_on, text).frame_when_inactive(true));
    let button = button.explained(about);
    labelled(ui, &button, name);
    button.clicked()
}

fn axis_ui(
    ui: &mut Ui,
    view: &MountingView,
    index: usize,
    region: &MountingRegion,
    actions: &mut Vec<DesignAction>,
) {
    let (Some(kind), Some(axis)) = (region.kind(), region.axis()) else {
        let MountingRegion::Seat { axis, .. } = region else { return };
        quiet_ui(ui, if axis.is_some() { "axis of the seat" } else { "axis as it is" });
        return;
    };
    let menu = ComboBox::from_id_salt("axis rule")
        .selected_text(axis_name(axis))
        .width(MENU_WIDTH)
        .show_ui(ui, |ui| {
            for rule in kind.axes() {
                let is_own = *rule == axis;
                if ui.selectable_label(is_own, axis_name(*rule)).clicked() && !is_own {
                    actions.push(view.apply(|own| {
                        own.regions[index] = region.with_axis(*rule);
                    }));
                }
            }
        });
    let menu = menu.response.explained("How a sensor may be turned there");
    labelled(ui, &menu, &format!("Axis rule of {}", region_name(index, region)));
}

fn radius_ui(
    ui: &mut Ui,
    view: &MountingView,
    index: usize,
    name: &str,
    radius_mm: Option<f64>,
    actions: &mut Vec<DesignAction>,
) {
    let with = |radius: Option<f64>| {
        view.edit(|own| {
            if let MountingRegion::Channel { radius_mm, .. } = &mut own.regions[index] {
                *radius_mm = radius;
            }
        })
    };
    ui.horizontal(|ui| {
        let mut is_known = radius_mm.is_some();
        let about = "The radius inside the channel, which a coil has to fit";
        if checkbox_ui(ui, &mut is_known, "inner radius", about).changed() {
            actions.push(DesignAction::apply(with(is_known.then_some(NEW_RADIUS_MM))));
        }
        let Some(radius_mm) = radius_mm else { return };
        let field_name = format!("inner radius of {name} in mm");
        let field = NumberField { min: LEAST_MM, speed: 0.01, ..NumberField::length(&field_name) };
        let changes = right_ui(ui, |ui| number_ui(ui, &field, radius_mm));
        number_edits(&changes, actions, &view.label(), |v| Some(with(Some(v))));
    });
}

/// The corners of a forbidden box.
fn box_ui(
    ui: &mut Ui,
    view: &MountingView,
    index: usize,
    own: &Bounds,
    actions: &mut Vec<DesignAction>,
) {
    let name = format!("Forbidden box {}", index + 1);
    head_ui(ui, &name, actions, |ui, actions| {
        if remove_ui(ui, &name) {
            actions.push(view.apply(|mounting| {
                mounting.keep_out.remove(index);
            }));
        }
    });
    for (k, axis) in AXES.into_iter().enumerate() {
        row_ui(ui, &format!("{axis} from, to"), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            // What stands at the right is drawn first.
            for is_max in [true, false] {
                let end = if is_max { "to" } else { "from" };
                let field_name = format!("{name} {axis} {end} in mm");
                let field = NumberField::length(&field_name).width(NARROW);
                // The ends never meet.
                let (field, value) = match is_max {
                    true => (NumberField { min: own.min_mm[k] + LEAST_MM, ..field }, own.max_mm[k]),
                    false => {
                        (NumberField { max: own.max_mm[k] - LEAST_MM, ..field }, own.min_mm[k])
                    }
                };
                let changes = number_ui(ui, &field, value);
                number_edits(&changes, actions, &view.label(), |v| {
                    Some(view.edit(|mounting| {
                        let own = &mut mounting.keep_out[index];
                        let corner = if is_max { &mut own.max_mm } else { &mut own.min_mm };
                        corner[k] = v;
                    }))
                });
            }
        });
    }
    ui.add_space(4.0);
}

/// What is added without the pointer.
fn add_ui(ui: &mut Ui, view: &MountingView, actions: &mut Vec<DesignAction>) {
    ui.horizontal_wrapped(|ui| {
        let about = "Adds a patch: the whole surface, until a part of it is painted";
        if button_ui(ui, "Add patch", about).clicked() {
            let new = MountingRegion::whole_surface();
            actions.push(view.apply(|own| own.regions.push(new)));
            let index = view.mounting.regions.len();
            actions.push(view.set(|state| state.patch = Some(index)));
        }
        let about = "Adds the bore of the body, or the middle of a long round one";
        let button = ui.add_enabled(view.mesh.is_some(), egui::Button::new("Channel from mesh"));
        if button.explained(about).clicked() {
            actions.push(match (view.channel_from_mesh)() {
                Some(channel) => view.apply(|own| own.regions.push(channel)),
                None => DesignAction::Mounting(MountingAction::Refuse(NO_CHANNEL)),
            });
        }
        let menu = ui.menu_button("Add seat at…", |ui| {
            for sensor in view.sensors {
                if ui.button(printable(&sensor.name)).clicked() {
                    actions.push(view.apply(|own| {
                        own.regions.push(MountingRegion::seat_of(sensor));
                    }));
                    ui.close();
                }
            }
        });
        let _ = menu.response.explained("Adds the place and the axis of a sensor as a fixed seat");
        let about = "Adds a box that no coil may reach into, in the middle of the body";
        if button_ui(ui, "Forbidden box", about).clicked() {
            let new = new_forbidden_box(view.mesh);
            actions.push(view.apply(|own| own.keep_out.push(new)));
        }
    });
}

/// A tool, its text on a button, its name, what it does.
pub(crate) type ToolButton = (SceneTool, &'static str, &'static str, &'static str);

/// The brush.
pub(crate) const PATCH_TOOLS: &[ToolButton] = &[
    (SceneTool::PaintPatch, "Patch", "Paint a patch", PAINT),
    (
        SceneTool::ErasePatch,
        "Erase",
        "Erase a patch",
        "Drag over the body: each place of the brush is taken out of the patch that is painted",
    ),
];

const OTHER_TOOLS: &[ToolButton] = &[
    (
        SceneTool::DrawChannel,
        "Channel",
        "Draw a channel",
        "Each click puts a point in the middle of the body; Enter or a double click finishes it",
    ),
    (
        SceneTool::DrawBox,
        "Box",
        "Draw a forbidden box",
        "Drag over the body: the box is around both ends, by half the brush",
    ),
];

/// What is drawn with the pointer.
fn draw_ui(ui: &mut Ui, view: &MountingView, actions: &mut Vec<DesignAction>) {
    let tools = [PATCH_TOOLS, OTHER_TOOLS].concat();
    tools_ui(ui, &tools, view.tool, view.mesh.is_some(), actions);
    if view.mesh.is_none() {
        warning_ui(ui, "The body has no mesh to draw on");
    }
    brush_ui(ui, view.state, actions);
}

/// Tools that are taken in hand and put back.
pub(crate) fn tools_ui(
    ui: &mut Ui,
    tools: &[ToolButton],
    in_hand: SceneTool,
    has_mesh: bool,
    actions: &mut Vec<DesignAction>,
) {
    row_ui(ui, "draw", |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for &(tool, text, name, about) in tools.iter().rev() {
            let is_on = in_hand == tool;
            let button = ui.add_enabled_ui(has_mesh, |ui| toggle_ui(ui, is_on, text, name, about));
            if button.inner {
                let taken = in_hand.toggled(tool);
                actions.push(DesignAction::Mounting(MountingAction::Take(taken)));
            }
        }
    });
}

pub(crate) fn brush_ui(ui: &mut Ui, state: MountingState, actions: &mut Vec<DesignAction>) {
    row_ui(ui, "brush", |ui| {
        let field = NumberField { min: 0.5, max: 100.0, ..NumberField::length("brush size in mm") };
        let field = field.about("Edge of the cube that the brush adds or takes away");
        if let Some(brush_mm) = typed_number_ui(ui, &field, state.brush_mm) {
            let state = MountingState { brush_mm, ..state };
            actions.push(DesignAction::Mounting(MountingAction::Set(state)));
        }
    });
}

/// Distances that coils keep.
fn distances_ui(ui: &mut Ui, view: &MountingView, actions: &mut Vec<DesignAction>) {
    let gap_mm = view.mounting.least_gap_mm;
    let with_gap = |gap: Option<f64>| view.edit(|own| own.least_gap_mm = gap);
    ui.horizontal(|ui| {
        let mut is_stated = gap_mm.is_some();
        let about = "Least distance between two coils; not stated, the length of the longer one";
        if checkbox_ui(ui, &mut is_stated, "least gap", about).changed() {
            actions.push(DesignAction::apply(with_gap(is_stated.then_some(NEW_GAP_MM))));
        }
        right_ui(ui, |ui| {
            let Some(gap_mm) = gap_mm else {
                quiet_ui(ui, "one coil length");
                return;
            };
            let field = NumberField::length("least gap in mm").about(about).positive();
            let changes = number_ui(ui, &field, gap_mm);
            number_edits(&changes, actions, &view.label(), |v| Some(with_gap(Some(v))));
        });
    });
    row_ui(ui, "tip clearance", |ui| {
        let field = NumberField::length("tip clearance in mm").positive();
        let field = field.about("Least distance of a coil from the tip");
        let changes = number_ui(ui, &field, view.mounting.tip_clearance_mm);
        number_edits(&changes, actions, &view.label(), |v| {
            Some(view.edit(|own| own.tip_clearance_mm = v))
        });
    });
}
