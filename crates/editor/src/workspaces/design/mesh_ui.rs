//! The mesh of the selected body or anatomy: what it is, what is wrong with it, which unit it is in, another.

use crate::document::meshes::MeshLoading;
use crate::document::requests::MeshRequest;
use crate::widgets::basic::{NumberChange, NumberField, counted, decimal, number_ui, quiet_ui};
use crate::widgets::basic::{section_ui, warning_ui, with_unit};
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::design::actions::DesignAction;
use bevy_egui::egui::{self, ComboBox, RichText, Ui};
use std::path::Path;
use std::sync::Arc;
use trackwright_design::Edit;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::mesh_report::MeshReport;
use trackwright_project::{MeshOwner, World, file_name};

/// What the section shows.
pub struct MeshView<'a> {
    pub whose: MeshOwner,
    pub reference: Option<&'a MeshReference>,
    /// `None` where there is no mesh, or it could not be read.
    pub report: Option<Arc<MeshReport>>,
    /// The unit that it was read in.
    pub read_in: Option<MeshUnit>,
    /// Why it is not there.
    pub problem: Option<String>,
    /// The file that is being read for it.
    pub reading: Option<&'a Path>,
    /// Whether it is still to be read, since the design was opened.
    pub is_awaited: bool,
}

impl<'a> MeshView<'a> {
    /// `None` where there is no such body or anatomy, and of metal that is not yet there.
    pub fn of(
        world: &'a World,
        whose: impl Into<MeshOwner>,
        loading: &'a MeshLoading,
    ) -> Option<Self> {
        let whose = whose.into();
        let design = world.document.design();
        let (reference, mesh, report) = match whose {
            MeshOwner::Body(role) => {
                (design.body(role)?.mesh.as_ref(), world.mesh(role), world.mesh_report(role))
            }
            MeshOwner::Anatomy(index) => {
                let mesh = &design.anatomy.get(index?)?.mesh;
                let report = world.anatomy_report(mesh);
                (Some(mesh), world.anatomy_mesh(mesh), report)
            }
            MeshOwner::NewMetal | MeshOwner::NewTool => return None,
        };
        let problems = world.mesh_problems();
        let problem = problems.iter().find(|problem| problem.whose == whose);
        Some(Self {
            whose,
            reference,
            report,
            read_in: mesh.map(|mesh| MeshUnit::of_mm(mesh.reading.mm_per_unit)),
            problem: problem.map(|problem| problem.cause.to_string()),
            reading: loading.of().filter(|(of, _)| *of == whose).map(|(_, file)| file),
            is_awaited: world.awaited_meshes().iter().any(|mesh| mesh.whose == whose),
        })
    }
}

/// Draws the section.
pub fn mesh_ui(ui: &mut Ui, view: &MeshView) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    section_ui(ui, "Mesh");
    if let Some(reference) = view.reference {
        let name = file_name(Path::new(&reference.file));
        let label = egui::Label::new(name).truncate();
        ui.add(label).explained(&reference.file);
    } else {
        quiet_ui(ui, "none: a rod through the sensors stands in for it");
    }
    if let (Some(reference), Some(report)) = (view.reference, &view.report) {
        size_ui(ui, report);
        unit_ui(ui, view, reference, &mut actions);
        findings_ui(ui, report);
    }
    if view.is_awaited {
        quiet_ui(ui, "Being read; a rod through the sensors stands in for a body until then");
    }
    if let Some(problem) = &view.problem {
        warning_ui(ui, problem);
        quiet_ui(
            ui,
            match view.whose {
                MeshOwner::Body(_) => "A rod through the sensors stands in for it",
                MeshOwner::Anatomy(_) | MeshOwner::NewMetal | MeshOwner::NewTool => {
                    "It is not shown"
                }
            },
        );
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| buttons_ui(ui, view, &mut actions));
    actions
}

fn size_ui(ui: &mut Ui, report: &MeshReport) {
    let triangles = counted(report.triangles, "triangle", "triangles");
    let text = match &report.bounds {
        Some(bounds) => {
            // Length, width and height, whichever axes they are along.
            let mut sides = bounds.size_mm().data.0[0];
            sides.sort_by(|a, b| b.total_cmp(a));
            let [length, width, height] = sides.map(|side| decimal(side, 1));
            let sides = with_unit(&format!("{length} × {width} × {height}"), "mm");
            format!("{sides}, {triangles}")
        }
        None => triangles,
    };
    quiet_ui(ui, text).explained("Length × width × height");
}

fn findings_ui(ui: &mut Ui, report: &MeshReport) {
    for finding in report.findings() {
        match finding.is_fault {
            true => warning_ui(ui, &finding.text),
            false => quiet_ui(ui, finding.text),
        };
    }
}

/// The unit in which the file's numbers are.
fn unit_ui(
    ui: &mut Ui,
    view: &MeshView,
    reference: &MeshReference,
    actions: &mut Vec<DesignAction>,
) {
    let Some(read_in) = view.read_in else { return };
    let set = |unit| DesignAction::Mesh(MeshRequest::SetUnit { whose: view.whose, unit });
    let is_other = matches!(reference.unit, Some(MeshUnit::Factor(_)));
    ui.horizontal(|ui| {
        ui.label("unit").explained(
            "The unit of the numbers in the file; glTF is in metres, STL and OBJ state no unit \
             and are taken for millimetres",
        );
        crate::workspaces::design::rows::right_ui(ui, |ui| {
            let shown = match reference.unit {
                None => format!("{read_in}, by its format"),
                Some(MeshUnit::Factor(_)) => OTHER.to_owned(),
                Some(unit) => unit.to_string(),
            };
            let choice = ComboBox::from_id_salt("mesh unit")
                .selected_text(shown)
                .width(UNIT_WIDTH)
                .show_ui(ui, |ui| {
                    let mut choice = |ui: &mut Ui, text: &str, unit: Option<MeshUnit>, is: bool| {
                        if ui.selectable_label(is, text).clicked() && !is {
                            actions.push(set(unit));
                        }
                    };
                    let is_format = reference.unit.is_none();
                    choice(ui, "by its format", None, is_format);
                    for unit in MeshUnit::NAMED {
                        let is = reference.unit == Some(unit);
                        choice(ui, &unit.to_string(), Some(unit), is);
                    }
                    // Begins as what it is now.
                    let other = MeshUnit::Factor(read_in.mm_per_unit());
                    choice(ui, OTHER, Some(other), is_other);
                });
            choice.response.explained("The unit of the numbers in the file");
        });
    });
    if is_other {
        ui.horizontal(|ui| {
            ui.label("one unit is");
            let field = NumberField {
                min: 1e-6,
                max: 1e6,
                decimals: 6,
                // Each value is a reading of the file: typed, not dragged.
                speed: 0.0,
                ..NumberField::length("length of one unit in mm")
            };
            let changes = crate::workspaces::design::rows::right_ui(ui, |ui| {
                number_ui(ui, &field, read_in.mm_per_unit())
            });
            for change in changes {
                if let NumberChange::Set(mm) = change {
                    actions.push(set(Some(MeshUnit::Factor(mm))));
                }
            }
        });
    }
}

const OTHER: &str = "another length";
const UNIT_WIDTH: f32 = 130.0;

fn buttons_ui(ui: &mut Ui, view: &MeshView, actions: &mut Vec<DesignAction>) {
    if let Some(file) = view.reading {
        ui.label(RichText::new(format!("Reading {}…", file_name(file))));
        if button_ui(ui, "Cancel", "Stops reading the mesh").clicked() {
            actions.push(DesignAction::Mesh(MeshRequest::GiveUp));
        }
        return;
    }
    let load = match view.problem {
        Some(_) => "Find it…",
        None => "Load mesh…",
    };
    let load =
        ui.button(load).explained("glTF, STL or OBJ; a file can also be dropped onto the window");
    if load.clicked() {
        let show = MeshRequest::ShowLoad(view.whose);
        actions.push(DesignAction::Mesh(show));
    }
    if let MeshOwner::Body(body) = view.whose
        && view.reference.is_some()
        && button_ui(ui, "No mesh", "Takes the mesh off the body; no figure depends on it")
            .clicked()
    {
        actions.push(DesignAction::apply(Edit::SetMesh { body, mesh: None }));
    }
}
