//! Commands for files and for what every workspace does with the document.

use crate::document::meshes::body_of_selection;
use crate::document::requests::BodyFileRequest;
use crate::document::requests::MeshRequest;
use crate::document::requests::{EditRequest, Export, FileRequest, OpenWorld, ViewRequest};
use crate::document::selection::Selection;
use crate::document::state::{Notice, WorldGeneration};
use crate::shell::commands::{AddCommand, Command, EDIT, FILE, Situation, VIEW, write};
use crate::shell::keys::Keys;
use bevy::prelude::*;
use trackwright_design::BodyRole;
use trackwright_design::view::{Magnification, View};
use trackwright_metal::new_object::NewShape;
use trackwright_project::MeshOwner;

pub const NEW: Command =
    Command::new(FILE, 0, "New design…", "Begins a design with a plain tool in the built-in room")
        .keys(&[Keys::control("n")]);
pub const OPEN: Command =
    Command::new(FILE, 1, "Open…", "Opens a design with its bodies, meshes and room")
        .keys(&[Keys::control("o")]);
pub const SAVE: Command =
    Command::new(FILE, 2, "Save", "Writes the design, and the bodies that changed")
        .keys(&[Keys::control("s")]);
pub const SAVE_AS: Command = Command::new(FILE, 3, "Save as…", "Writes the design to another file")
    .keys(&[Keys::control_shift("s")]);
pub const NEW_FROM_MESH: Command = Command::new(
    FILE,
    5,
    "New tool from a mesh…",
    "Begins a design with a tool of this shape: its tip at the thinner end, two sensors along it",
);
pub const FLIP_TOOL: Command = Command::new(
    EDIT,
    48,
    "Flip the tool's mesh",
    "Turns the tool's mesh end for end, where its tip was taken for the wrong end; tip and sensors stay",
)
.available_if(|now| {
    is_in_design(now) && now.world.is_some_and(|world| world.0.mesh(BodyRole::Tool).is_some())
});
pub const OPEN_TOOL: Command = Command::new(
    FILE,
    10,
    "Open tool definition as tool…",
    "Uses an NDI ROM, an Atracsys or SAW geometry or a body file as the tool",
)
.available_if(|now| has_body(now, BodyRole::Tool));
pub const OPEN_CRF: Command = Command::new(
    FILE,
    11,
    "Open tool definition as CRF…",
    "Uses an NDI ROM, an Atracsys or SAW geometry or a body file as the CRF; adds a CRF to a design \
     without one",
)
.labelled(|now| match has_body(now, BodyRole::Crf) {
    true => "Open tool definition as CRF…".to_owned(),
    false => "Add a CRF from a file…".to_owned(),
});
pub const SAVE_BODY: Command = Command::new(
    FILE,
    12,
    "Save tool definition as…",
    "Writes the selected body, or the tool, as a definition; what that cannot hold is listed first",
);
pub const LOAD_MESH: Command = Command::new(
    FILE,
    20,
    "Load mesh…",
    "Gives the selected body, or the tool, another shape: glTF, STL or OBJ",
);
pub const ADD_ANATOMY: Command = Command::new(
    FILE,
    21,
    "Add anatomy…",
    "Shows a mesh of the patient or of the room, translucent and part of no figure: glTF, STL or OBJ",
);
/// Metal of a shape that needs no file, in the order of menus.
pub const ADD_METAL: [(NewShape, Command); 4] = [
    (
        NewShape::Plate,
        Command::new(
            EDIT,
            60,
            "Add metal plate",
            "Puts a plate of aluminium, 200 × 200 × 10 mm, into the room beside the measurement volume",
        )
        .available_if(is_in_design),
    ),
    (
        NewShape::Box,
        Command::new(
            EDIT,
            61,
            "Add metal box",
            "Puts a box of aluminium with sides of 100 mm into the room beside the measurement volume",
        )
        .available_if(is_in_design),
    ),
    (
        NewShape::Sphere,
        Command::new(
            EDIT,
            62,
            "Add metal sphere",
            "Puts a sphere of aluminium with a radius of 50 mm into the room beside the measurement \
             volume",
        )
        .available_if(is_in_design),
    ),
    (
        NewShape::Cylinder,
        Command::new(
            EDIT,
            63,
            "Add metal cylinder",
            "Puts a cylinder of aluminium, 50 mm across and 150 mm long, into the room beside the \
             measurement volume",
        )
        .available_if(is_in_design),
    ),
];
pub const ADD_METAL_MESH: Command = Command::new(
    EDIT,
    64,
    "Add metal mesh…",
    "Puts a closed mesh of aluminium into the room, a C-arm or a table: glTF, STL or OBJ",
)
.available_if(is_in_design);
pub const REPORT: Command = Command::new(
    FILE,
    30,
    "Report…",
    "Writes the design, its figures, slides and manufacturing sheet as one page for a browser",
);
pub const OPEN_REPORT: Command = Command::new(
    FILE,
    31,
    "Open report",
    "Shows the report that was written last in the browser of this system",
);
pub const EXPORT_FIELD: Command = Command::new(
    FILE,
    32,
    "Export field…",
    "Writes the room's error on a lattice: for 3D Slicer (.nrrd, .mha), ParaView (.vti) or as a table",
);
pub const EXPORT_TIPS: Command = Command::new(
    FILE,
    33,
    "Export tips…",
    "Writes the study's tips, true and simulated: as points for 3D Slicer (.mrk.json) or as a table",
);
pub const EXPORT_SCENE: Command = Command::new(
    FILE,
    34,
    "Export 3D view…",
    "Writes bodies, sensors, errors and layers as glTF (.glb), for other programs",
);
pub const QUIT: Command = Command::new(
    FILE,
    90,
    "Quit",
    "Closes the window; offers to save first where something is not saved",
)
.keys(&[Keys::control("q")]);
pub const UNDO: Command = Command::new(EDIT, 0, "Undo", "Takes the last change of the design back")
    .keys(&[Keys::control("z")])
    .available_if(|now| now.document().is_some_and(|own| own.undo_label().is_some()))
    .labelled(|now| labelled("Undo", now.document().and_then(|own| own.undo_label())));
pub const REDO: Command = Command::new(EDIT, 1, "Redo", "Does again what was undone last")
    .keys(&[Keys::control_shift("z"), Keys::control("y")])
    .available_if(|now| now.document().is_some_and(|own| own.redo_label().is_some()))
    .labelled(|now| labelled("Redo", now.document().and_then(|own| own.redo_label())));
pub const CANCEL_DRAG: Command =
    Command::new(EDIT, 100, "Take the drag back", "Ends a drag as if it had never been")
        .keys(&[Keys::plain("escape")])
        .for_drags();
pub const MAGNIFY: Command =
    Command::new(VIEW, 10, "Errors at true size", "Draws errors at true size, or magnified again")
        .keys(&[Keys::plain("m")])
        .labelled(|now| {
            let view = now.document().map(|own| own.view());
            match view.is_some_and(|view| view.magnification == Magnification::Times(1.0)) {
                true => "Magnify errors".to_owned(),
                false => "Errors at true size".to_owned(),
            }
        });

/// Registers the commands.
pub struct DocumentCommandsPlugin;

impl Plugin for DocumentCommandsPlugin {
    fn build(&self, app: &mut App) {
        app.add_command(NEW, write(FileRequest::ShowNew))
            .add_command(NEW_FROM_MESH, write(MeshRequest::ShowLoad(MeshOwner::NewTool)))
            .add_command(FLIP_TOOL, flip_tool)
            .add_command(OPEN, write(FileRequest::ShowOpen))
            .add_command(SAVE, write(FileRequest::Save))
            .add_command(SAVE_AS, write(FileRequest::ShowSaveAs))
            .add_command(OPEN_TOOL, write(BodyFileRequest::ShowOpen(BodyRole::Tool)))
            .add_command(OPEN_CRF, write(BodyFileRequest::ShowOpen(BodyRole::Crf)))
            .add_command(SAVE_BODY, save_body)
            .add_command(LOAD_MESH, load_mesh)
            .add_command(ADD_ANATOMY, write(MeshRequest::ShowLoad(MeshOwner::Anatomy(None))))
            .add_command(REPORT, write(FileRequest::ShowWriteReport))
            .add_command(OPEN_REPORT, write(FileRequest::OpenReport))
            .add_command(EXPORT_FIELD, write(FileRequest::ShowExport(Export::Field)))
            .add_command(EXPORT_TIPS, write(FileRequest::ShowExport(Export::Tips)))
            .add_command(EXPORT_SCENE, write(FileRequest::ShowExport(Export::Scene)))
            .add_command(QUIT, write(FileRequest::Quit))
            .add_command(UNDO, write(EditRequest::Undo))
            .add_command(REDO, write(EditRequest::Redo))
            .add_command(CANCEL_DRAG, write(EditRequest::Cancel))
            .add_command(MAGNIFY, magnify)
            .add_command(ADD_METAL_MESH, write(MeshRequest::ShowLoad(MeshOwner::NewMetal)));
        for (shape, command) in ADD_METAL {
            app.add_command(command, add_metal(shape));
        }
    }
}

fn is_in_design(now: &Situation) -> bool {
    now.world.is_some() && now.workspace.edits_design
}

fn add_metal(shape: NewShape) -> impl FnMut(Option<Res<OpenWorld>>, MessageWriter<EditRequest>) {
    move |world: Option<Res<OpenWorld>>, mut edits: MessageWriter<EditRequest>| {
        let Some(world) = world else { return };
        let shape = shape.shape();
        let label = shape.label();
        edits.write(EditRequest::Apply(world.0.added_metal(shape, label)));
    }
}

fn flip_tool(
    world: Option<Res<OpenWorld>>,
    mut edits: MessageWriter<EditRequest>,
    mut notice: ResMut<Notice>,
) {
    match world.and_then(|world| trackwright_project::flipped_tool(&world.0)) {
        Some(flipped) => drop(edits.write_batch(EditRequest::step(FLIP_TOOL.name, flipped))),
        None => *notice = Notice::Refused("the tool's mesh has no two ends".to_owned()),
    }
}

fn has_body(now: &Situation, role: BodyRole) -> bool {
    now.document().is_some_and(|document| document.design().body(role).is_some())
}

/// `Undo move sensor`.
fn labelled(verb: &str, label: Option<&str>) -> String {
    let Some(label) = label else { return verb.to_owned() };
    let mut chars = label.chars();
    let first = chars.next().map(char::to_lowercase);
    format!("{verb} {}", first.into_iter().flatten().chain(chars).collect::<String>())
}

fn save_body(selection: Res<Selection>, mut requests: MessageWriter<BodyFileRequest>) {
    requests.write(BodyFileRequest::ShowSave(body_of_selection(&selection)));
}

fn load_mesh(selection: Res<Selection>, mut requests: MessageWriter<MeshRequest>) {
    requests.write(MeshRequest::ShowLoad(body_of_selection(&selection).into()));
}

/// Errors at true size, or magnified again as they were before in this design.
fn magnify(
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    mut requests: MessageWriter<ViewRequest>,
    mut before: Local<(WorldGeneration, Magnification)>,
) {
    let Some(world) = world else { return };
    let view = world.0.document.view();
    let magnification = match view.magnification {
        Magnification::Times(1.0) if before.0 == *generation => before.1,
        Magnification::Times(1.0) => Magnification::Auto,
        other => {
            *before = (*generation, other);
            Magnification::Times(1.0)
        }
    };
    requests.write(ViewRequest::Set(View { magnification, ..view.clone() }));
}
