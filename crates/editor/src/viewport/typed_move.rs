//! Moves and turns what is selected by typed numbers: G or R, an axis, an amount, Enter.

use crate::document::requests::{ActiveDrag, EditRequest, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::document::state::{Notice, WorldGeneration};
use crate::schedule::EditorSystems;
use crate::shell::commands::{AddCommand, Command, CommandsSystems, EDIT, Situation};
use crate::shell::keys::Keys;
use crate::shell::shortcuts::{KeyboardFocus, KeysTaken, TakenKey};
use crate::shell::window::{DragReadout, DragText, ViewportRect, Workspace};
use crate::viewport::gizmo::drag::name_of;
use crate::widgets::basic::counted;
use bevy::input::keyboard::Key;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::sync::Arc;
use trackwright_design::{BodyRole, Design, Edit, HandleAxes};
use trackwright_geometry::movement::Movement;
use trackwright_geometry::pose::Pose;

pub const MOVE: Command = Command::new(
    EDIT,
    116,
    "Move by a number…",
    "Moves what is selected by what is typed then: X, Y or Z, millimetres, Enter",
)
.keys(&[Keys::plain("g")])
.available_if(is_available);
pub const TURN: Command = Command::new(
    EDIT,
    117,
    "Turn by a number…",
    "Turns what is selected by what is typed then: X, Y or Z, degrees, Enter",
)
.keys(&[Keys::plain("r")])
.available_if(is_available);

/// Longest number that is taken.
const MOST_DIGITS: usize = 12;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TypedKind {
    Move,
    Turn,
}

/// What is moved by what is being typed; `None` while nothing is.
#[derive(Resource, Default)]
pub struct TypedMove(Option<Typing>);

struct Typing {
    kind: TypedKind,
    moved: Moved,
    /// How a sentence calls it.
    name: String,
    /// 0 is x.
    axis: Option<usize>,
    axes: HandleAxes,
    text: String,
    /// The design before: every pose comes from there.
    start: Arc<Design>,
    generation: WorldGeneration,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Moved {
    Body(BodyRole),
    Tip(BodyRole),
    Sensors(BodyRole, Vec<usize>),
    Metal(usize),
}

/// What a key does while something is moved.
enum Answer {
    Changed,
    Ends { is_taken: bool },
    Nothing,
}

impl Moved {
    fn of(selection: &Selection, kind: TypedKind) -> Option<Self> {
        if let Some((role, indices)) = selection.sensors() {
            return Some(Self::Sensors(role, indices));
        }
        Some(match selection.primary()? {
            Selected::Body(role) => Self::Body(role),
            Selected::Metal(index) => Self::Metal(index),
            Selected::Tip(role) if kind == TypedKind::Move => Self::Tip(role),
            Selected::Tip(_) | Selected::Anatomy(_) | Selected::Sensor(..) => return None,
        })
    }
}

fn is_available(now: &Situation) -> bool {
    now.world.is_some() && now.workspace.edits_design
}

impl TypedMove {
    /// What is moved and by how much, for the status line.
    pub fn hint(&self) -> Option<String> {
        let typing = self.0.as_ref()?;
        let verb = typing.verb();
        Some(match typing.axis {
            None => format!("{verb} the {}: X, Y or Z · Esc ends", typing.name),
            Some(axis) => format!(
                "{verb} the {} {}: {} · {} again: {} · Enter takes it · Esc takes it back",
                typing.name,
                typing.axis_words(axis, typing.axes),
                typing.amount_words(),
                AXES[axis].to_uppercase(),
                typing.axis_words(axis, typing.axes.other()),
            ),
        })
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Typing {
    fn verb(&self) -> &'static str {
        match self.kind {
            TypedKind::Move => "Move",
            TypedKind::Turn => "Turn",
        }
    }

    fn axis_words(&self, axis: usize, axes: HandleAxes) -> String {
        let preposition = match self.kind {
            TypedKind::Move => "along",
            TypedKind::Turn => "about",
        };
        let whose = match (axes, &self.moved) {
            (HandleAxes::Tracker, _) => "the tracker's",
            (HandleAxes::Own, Moved::Sensors(..) | Moved::Tip(_)) => "its body's",
            (HandleAxes::Own, Moved::Body(_) | Moved::Metal(_)) => "its",
        };
        format!("{preposition} {whose} {}", AXES[axis])
    }

    fn amount_words(&self) -> String {
        let number = match self.text.as_str() {
            "" | "-" => format!("{}0", self.text),
            text => text.to_owned(),
        };
        let unit = match self.kind {
            TypedKind::Move => "\u{2009}mm",
            TypedKind::Turn => "°",
        };
        format!("{}{unit}", number.replace('-', "\u{2212}"))
    }

    /// Millimetres or degrees.
    fn amount(&self) -> f64 {
        self.text.parse().unwrap_or(0.0)
    }

    fn edits(&self) -> Vec<Edit> {
        let Some(axis) = self.axis else { return Vec::new() };
        let (design, amount) = (&self.start, self.amount());
        let movement = |frame: Pose| match self.kind {
            TypedKind::Move => Movement::along_axis_of(&frame, axis, amount),
            TypedKind::Turn => Movement::about_axis_of(&frame, axis, amount.to_radians()),
        };
        let edits = match &self.moved {
            Moved::Body(role) => design
                .tracker_from_body_handle(*role, self.axes)
                .and_then(|frame| design.moved_body(*role, &movement(frame)))
                .map(|edit| vec![edit]),
            Moved::Metal(index) => design
                .tracker_from_metal_handle(*index, self.axes)
                .and_then(|frame| design.moved_metal(*index, &movement(frame)))
                .map(|edit| vec![edit]),
            Moved::Sensors(role, indices) => design
                .body_from_axes(*role, self.axes)
                .map(|frame| design.moved_sensors(*role, indices, &movement(frame))),
            Moved::Tip(role) => design
                .body_from_axes(*role, self.axes)
                .and_then(|frame| design.moved_tip(*role, &movement(frame)))
                .map(|edit| vec![edit]),
        };
        edits.unwrap_or_default()
    }

    fn press(&mut self, key: &Key) -> Answer {
        match key {
            Key::Enter => Answer::Ends { is_taken: true },
            Key::Escape => Answer::Ends { is_taken: false },
            Key::Backspace => self.typed(|text| text.pop().is_some()),
            Key::Character(typed) => self.character(&typed.to_lowercase()),
            _ => Answer::Nothing,
        }
    }

    fn character(&mut self, typed: &str) -> Answer {
        if let Some(axis) = AXES.iter().position(|name| *name == typed) {
            self.axes = match self.axis == Some(axis) {
                true => self.axes.other(),
                false => HandleAxes::Own,
            };
            self.axis = Some(axis);
            return Answer::Changed;
        }
        match typed {
            // Wherever it is typed, as the number is read while it grows.
            "-" | "\u{2212}" => self.typed(|text| {
                match text.strip_prefix('-') {
                    Some(rest) => *text = rest.to_owned(),
                    None => text.insert(0, '-'),
                }
                true
            }),
            "." | "," => self.typed(|text| {
                let is_first = !text.contains('.');
                if is_first {
                    text.push_str(if text.ends_with(|c: char| c.is_ascii_digit()) {
                        "."
                    } else {
                        "0."
                    });
                }
                is_first
            }),
            digit if digit.len() == 1 && digit.as_bytes()[0].is_ascii_digit() => {
                self.typed(|text| {
                    let is_room = text.len() < MOST_DIGITS;
                    if is_room {
                        text.push_str(digit);
                    }
                    is_room
                })
            }
            _ => Answer::Nothing,
        }
    }

    fn typed(&mut self, change: impl FnOnce(&mut String) -> bool) -> Answer {
        match change(&mut self.text) {
            true => Answer::Changed,
            false => Answer::Nothing,
        }
    }
}

/// Another selection or workspace, and a text field that wants the keys, end it as Enter does; another design ends
/// it with nothing.
pub(super) fn plugin(app: &mut App) {
    app.init_resource::<TypedMove>()
        .add_command(MOVE, |params: Params| begin(TypedKind::Move, params))
        .add_command(TURN, |params: Params| begin(TypedKind::Turn, params))
        .add_systems(
            Update,
            follow_keys
                .run_if(|typed: Res<TypedMove>| typed.0.is_some())
                .in_set(EditorSystems::Input)
                .after(CommandsSystems),
        );
}

/// What typing changes.
#[derive(bevy::ecs::system::SystemParam)]
struct Params<'w> {
    typed: ResMut<'w, TypedMove>,
    taken: ResMut<'w, KeysTaken>,
    active: ResMut<'w, ActiveDrag>,
    readout: ResMut<'w, DragReadout>,
    notice: ResMut<'w, Notice>,
    world: Option<Res<'w, OpenWorld>>,
    generation: Res<'w, WorldGeneration>,
    workspace: Res<'w, Workspace>,
    selection: Res<'w, Selection>,
    viewport: Option<Res<'w, ViewportRect>>,
    edits: MessageWriter<'w, EditRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

fn begin(kind: TypedKind, mut params: Params) {
    let Some(world) = &params.world else { return };
    let Some(moved) = Moved::of(&params.selection, kind) else {
        *params.notice = Notice::Refused(match kind {
            TypedKind::Move => "select a body, sensors, a tip or a metal object to move".to_owned(),
            TypedKind::Turn => "select a body, sensors or a metal object to turn".to_owned(),
        });
        return;
    };
    let start = world.0.document.shared_design();
    let name = match (&moved, params.selection.primary()) {
        (Moved::Sensors(_, indices), _) if indices.len() > 1 => {
            counted(indices.len(), "sensor", "sensors")
        }
        (_, Some(primary)) => name_of(&start, primary),
        (_, None) => return,
    };
    let typing = Typing {
        kind,
        moved,
        name,
        axis: None,
        axes: HandleAxes::Own,
        text: String::new(),
        start,
        generation: *params.generation,
    };
    params.edits.write(EditRequest::Begin(format!("{} {}", typing.verb(), typing.name)));
    params.typed.0 = Some(typing);
    params.taken.0 = true;
    params.active.set_if_neq(ActiveDrag(true));
    params.show();
}

fn follow_keys(mut keys: MessageReader<TakenKey>, focus: Res<KeyboardFocus>, mut params: Params) {
    let is_other = params.typed.0.as_ref().is_some_and(|it| it.generation != *params.generation);
    let is_elsewhere = params.selection.is_changed() || params.workspace.is_changed();
    let is_left = (is_elsewhere && !params.typed.is_changed()) || *focus == KeyboardFocus::Text;
    if is_other || is_left {
        keys.clear();
        return params.end(!is_other);
    }
    for TakenKey(key) in keys.read() {
        let Some(typing) = &mut params.typed.0 else { return };
        match typing.press(key) {
            Answer::Nothing => {}
            Answer::Changed => {
                let edits = typing.edits();
                params.edits.write_batch(edits.into_iter().map(EditRequest::Apply));
                params.show();
            }
            Answer::Ends { is_taken } => params.end(is_taken),
        }
    }
}

impl Params<'_> {
    /// The amount stands in the middle of the scene, where the hand has no pointer.
    fn show(&mut self) {
        let text = self.typed.0.as_ref().and_then(|typing| {
            let axis = typing.axis?;
            Some(format!("{} {}", typing.axis_words(axis, typing.axes), typing.amount_words()))
        });
        let at = self.viewport.as_ref().map_or(Vec2::ZERO, |rect| rect.min + rect.size / 2.0);
        self.readout.set_if_neq(DragReadout(text.map(|text| DragText { at, text })));
        self.redraw.write(RequestRedraw);
    }

    fn end(&mut self, is_taken: bool) {
        self.typed.0 = None;
        self.taken.0 = false;
        self.edits.write(if is_taken { EditRequest::Commit } else { EditRequest::Cancel });
        self.active.set_if_neq(ActiveDrag(false));
        self.readout.set_if_neq(DragReadout(None));
        self.redraw.write(RequestRedraw);
    }
}
