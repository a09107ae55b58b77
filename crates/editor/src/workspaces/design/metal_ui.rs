//! The metal of the room: its rows in the outliner, and the fields of the object that is selected.

use crate::document::commands::{ADD_METAL, ADD_METAL_MESH};
use crate::document::selection::Selected;
use crate::palette::{self, ThemedColor};
use crate::scene::metal::{PROBLEM, has_problem};
use crate::widgets::basic::{
    Mark, NumberField, Row, fact_ui, number_ui, quiet_ui, row_ui, section_ui,
};
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::design::actions::{DesignAction, number_edits};
use crate::workspaces::design::outliner_row::{OutlinerView, selectable_ui};
use crate::workspaces::design::rows::{
    AXES, rotation_ui, row_ui as field_row_ui, text_row_ui, vector_ui,
};
use bevy_egui::egui::{self, ComboBox, Ui};
use std::path::Path;
use trackwright_design::{Design, Edit, MetalEdit};
use trackwright_field::computed::FieldSource;
use trackwright_geometry::pose::pose_from_parts;
use trackwright_metal::material::{Material, NAMED_MATERIALS};
use trackwright_metal::setup::{
    MIN_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};
use trackwright_metal::surface::MAX_TRIANGLES;
use trackwright_project::file_name;
use trackwright_scene::look_of_metal;

fn tolerance_field(name: &str) -> NumberField<'_> {
    NumberField {
        unit: "%",
        decimals: 0,
        min: 0.0,
        max: 100.0 * MaterialTolerance::MAX,
        speed: 1.0,
        ..NumberField::plain(name)
    }
    .about("95 of 100 such parts are within this of what is stated; it is part of the intervals")
}

/// A row for each object, and some that add others; nothing in a room without metal whose coils are not
/// known.
pub(crate) fn metal_rows_ui(ui: &mut Ui, outliner: &OutlinerView, actions: &mut Vec<DesignAction>) {
    let computed = outliner.environment.model.computed();
    let has_coils = computed.is_some_and(|own| matches!(own.source(), FieldSource::Harmonic(_)));
    if outliner.design.room_metal.is_none() && !has_coils {
        return;
    }
    section_ui(ui, "Metal");
    let objects = outliner.design.room_metal.iter().flat_map(|metal| &metal.objects);
    for (index, object) in objects.enumerate() {
        let has_problem = has_problem(outliner.metal_problem, &object.name);
        let material = object.material.label();
        let color = look_of_metal(&object.material).color;
        let row = Row {
            label: &object.name,
            note: if has_problem { "not simulated" } else { &material },
            note_color: has_problem.then(|| PROBLEM.color32()),
            mark: Some((Mark::Square, color.color32())),
            ..Row::default()
        };
        selectable_ui(ui, outliner, Selected::Metal(index), row, actions);
    }
    let plate = &ADD_METAL[0].1;
    for command in [plate, &ADD_METAL_MESH] {
        let add = Row {
            label: command.name,
            indent: 1,
            mark: Some((Mark::Plus, palette::TEXT_QUIET.color32())),
            ..Row::default()
        };
        if row_ui(ui, &add).explained(command.about).clicked() {
            actions.push(DesignAction::Run(command.name));
        }
    }
}

/// The fields of one object, and of the generator that it is beside.
pub fn metal_ui(ui: &mut Ui, design: &Design, index: usize, actions: &mut Vec<DesignAction>) {
    let (Some(metal), Some(object)) = (&design.room_metal, design.metal_object(index)) else {
        return;
    };
    let fields = ObjectFields { object, index };
    section_ui(ui, "Metal");
    if let Some(name) = text_row_ui(ui, "name", &object.name) {
        let named = MetalObject { name, ..object.clone() };
        actions.push(DesignAction::apply(fields.set(named)));
    }
    fields.material_ui(ui, actions);
    fields.shape_ui(ui, actions);
    section_ui(ui, "Pose in the tracker frame");
    fields.pose_ui(ui, actions);
    generator_ui(ui, metal, actions);
    ui.add_space(6.0);
    let about = "Takes the object out of the room";
    if button_ui(ui, "Remove metal object", about).clicked() {
        actions.push(DesignAction::apply(Edit::Metal(MetalEdit::Remove { index })));
    }
}

/// A row with one number.
fn number_row_ui(
    ui: &mut Ui,
    name: &str,
    (field, value): (&NumberField, f64),
    actions: &mut Vec<DesignAction>,
    label: &str,
    edit: impl Fn(f64) -> Option<Edit>,
) {
    field_row_ui(ui, name, |ui| {
        let changes = number_ui(ui, field, value);
        number_edits(&changes, actions, label, edit);
    });
}

/// The coils and their frequency are those of all objects.
fn generator_ui(ui: &mut Ui, metal: &RoomMetal, actions: &mut Vec<DesignAction>) {
    section_ui(ui, "Field generator");
    fact_ui(ui, "coils", &metal.generator.name);
    let field = NumberField {
        unit: "kHz",
        decimals: 3,
        speed: 0.05,
        max: MOST_KHZ,
        ..NumberField::length("frequency in kHz").positive()
    }
    .about("Of the generator's coils; currents flow nearer the surface the higher it is");
    let value = (&field, metal.frequency_hz / HZ_PER_KHZ);
    number_row_ui(ui, "frequency", value, actions, "Change frequency", |khz| {
        Some(Edit::Metal(MetalEdit::SetFrequency(khz * HZ_PER_KHZ)))
    });
}

pub(crate) const HZ_PER_KHZ: f64 = 1e3;
const MOST_KHZ: f64 = 1e4;
const S_PER_MS: f64 = 1e6;

/// One object, whose fields these are.
struct ObjectFields<'a> {
    object: &'a MetalObject,
    index: usize,
}

impl ObjectFields<'_> {
    fn set(&self, object: MetalObject) -> Edit {
        Edit::Metal(MetalEdit::Set { index: self.index, object: Box::new(object) })
    }

    fn with_material(&self, material: ObjectMaterial) -> Edit {
        self.set(MetalObject { material, ..self.object.clone() })
    }

    fn material_ui(&self, ui: &mut Ui, actions: &mut Vec<DesignAction>) {
        let own = self.object.material;
        let material = own.material();
        let shown = match own {
            ObjectMaterial::Named(_) => own.label(),
            ObjectMaterial::Own(_) => OTHER.to_owned(),
        };
        field_row_ui(ui, "material", |ui| {
            let combo = ComboBox::from_id_salt("metal material").selected_text(shown);
            let response = combo.width(MATERIAL_WIDTH).show_ui(ui, |ui| {
                let mut choice = |ui: &mut Ui, text: &str, wanted: ObjectMaterial, is: bool| {
                    if ui.selectable_label(is, text).clicked() && !is {
                        actions.push(DesignAction::apply(self.with_material(wanted)));
                    }
                };
                for named in &NAMED_MATERIALS {
                    let wanted = ObjectMaterial::Named(named.key);
                    choice(ui, named.label, wanted, own == wanted);
                }
                // Begins as what it is now.
                let is_own = matches!(own, ObjectMaterial::Own(_));
                choice(ui, OTHER, ObjectMaterial::Own(material), is_own);
            });
            let response = response.response;
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::WidgetType::ComboBox, true, "material")
            });
            response.explained("What the object is made of");
        });
        match own {
            ObjectMaterial::Own(_) => self.numbers_ui(ui, &material, actions),
            ObjectMaterial::Named(key) => {
                let named = NAMED_MATERIALS.iter().find(|named| named.key == key);
                let source = named.map_or("", |named| named.source);
                quiet_ui(ui, own_numbers(&material)).explained(source);
            }
        }
        let MaterialTolerance { conductivity, permeability } = self.object.tolerance;
        let set = |tolerance| Some(self.set(MetalObject { tolerance, ..self.object.clone() }));
        if material.is_conductor() {
            let label = format!("Change tolerance of {}", self.object.name);
            let field = tolerance_field("tolerance of the conductivity in %");
            let value = (&field, conductivity * 100.0);
            number_row_ui(ui, "conductivity ±", value, actions, &label, |value| {
                set(MaterialTolerance { conductivity: value / 100.0, ..self.object.tolerance })
            });
        }
        if material.is_magnetic() {
            let label = format!("Change tolerance of {}", self.object.name);
            let field = tolerance_field("tolerance of the permeability in %");
            let value = (&field, permeability * 100.0);
            number_row_ui(ui, "permeability ±", value, actions, &label, |value| {
                set(MaterialTolerance { permeability: value / 100.0, ..self.object.tolerance })
            });
        }
    }

    fn numbers_ui(&self, ui: &mut Ui, material: &Material, actions: &mut Vec<DesignAction>) {
        let (conductivity, permeability) =
            (material.conductivity_s_per_m(), material.relative_permeability());
        let label = format!("Change material of {}", self.object.name);
        let of = |conductivity, permeability| {
            let material = Material::new(conductivity, permeability).ok()?;
            Some(self.with_material(ObjectMaterial::Own(material)))
        };
        let field = NumberField {
            unit: "MS/m",
            decimals: 4,
            max: 1e3,
            ..NumberField::length("conductivity in MS/m").positive()
        };
        let value = (&field, conductivity / S_PER_MS);
        number_row_ui(ui, "conductivity", value, actions, &label, |value| {
            of(value * S_PER_MS, permeability)
        });
        let field = NumberField {
            min: 1.0,
            max: 1e6,
            speed: 1.0,
            ..NumberField::plain("relative permeability")
        };
        let value = (&field, permeability);
        number_row_ui(ui, "permeability", value, actions, &label, |value| of(conductivity, value));
    }

    fn shape_ui(&self, ui: &mut Ui, actions: &mut Vec<DesignAction>) {
        section_ui(ui, &format!("Shape: {}", self.object.shape.label()));
        let label = format!("Change shape of {}", self.object.name);
        let set = |shape| Some(self.set(MetalObject { shape, ..self.object.clone() }));
        let mut length_ui =
            |ui: &mut Ui, name: &str, value: f64, edit: &dyn Fn(f64) -> Option<Edit>| {
                let full = format!("{name} in mm");
                let field = NumberField { min: LEAST_MM, ..NumberField::length(&full) };
                number_row_ui(ui, name, (&field, value), actions, &label, edit);
            };
        match &self.object.shape {
            ObjectShape::Sphere { radius_mm } => {
                length_ui(ui, "radius", *radius_mm, &|radius_mm| {
                    set(ObjectShape::Sphere { radius_mm })
                });
                return;
            }
            ObjectShape::Cuboid { size_mm } => {
                for (k, axis) in AXES.into_iter().enumerate() {
                    length_ui(ui, &format!("size {axis}"), size_mm[k], &|value| {
                        let mut size_mm = *size_mm;
                        size_mm[k] = value;
                        set(ObjectShape::Cuboid { size_mm })
                    });
                }
            }
            ObjectShape::Cylinder { radius_mm, length_mm } => {
                length_ui(ui, "radius", *radius_mm, &|radius_mm| {
                    set(ObjectShape::Cylinder { radius_mm, length_mm: *length_mm })
                });
                length_ui(ui, "length", *length_mm, &|length_mm| {
                    set(ObjectShape::Cylinder { radius_mm: *radius_mm, length_mm })
                });
            }
            ObjectShape::Mesh(mesh) => {
                let name = file_name(Path::new(&mesh.reference.file));
                fact_ui(ui, "file", &name);
            }
        }
        let field = NumberField {
            min: MIN_TRIANGLES as f64,
            max: MAX_TRIANGLES as f64,
            decimals: 0,
            speed: 5.0,
            ..NumberField::plain("most triangles")
        }
        .about(
            "Triangles that the surface is cut into at most: more are slower and nearer the truth",
        );
        let label = format!("Change triangles of {}", self.object.name);
        let value = (&field, self.object.most_triangles as f64);
        number_row_ui(ui, "triangles", value, actions, &label, |value| {
            let most_triangles = value.round() as usize;
            Some(self.set(MetalObject { most_triangles, ..self.object.clone() }))
        });
    }

    fn pose_ui(&self, ui: &mut Ui, actions: &mut Vec<DesignAction>) {
        let pose = &self.object.tracker_from_object;
        let label = format!("Move {}", self.object.name);
        let moved = |position, rotation| {
            let tracker_from_object = pose_from_parts(position, rotation);
            Edit::Metal(MetalEdit::SetPose { index: self.index, tracker_from_object })
        };
        let position = &pose.translation.vector;
        vector_ui(ui, "position", position, actions, &label, |position| {
            Some(moved(position, pose.rotation))
        });
        rotation_ui(ui, &pose.rotation, actions, &label, |rotation| {
            moved(pose.translation.vector, rotation)
        });
    }
}

/// `37.7 MS/m, relative permeability 1`.
fn own_numbers(material: &Material) -> String {
    // Three digits: no alloy is known better.
    let ms_per_m = material.conductivity_s_per_m() / S_PER_MS;
    let conductivity = match ms_per_m >= 0.01 {
        true => format!("{ms_per_m:.2}\u{2009}MS/m"),
        false => format!("{}\u{2009}S/m", material.conductivity_s_per_m()),
    };
    format!("{conductivity}, relative permeability {}", material.relative_permeability())
}

const OTHER: &str = "Other";
const MATERIAL_WIDTH: f32 = 150.0;
const LEAST_MM: f64 = 0.01;
