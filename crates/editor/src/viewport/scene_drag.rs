//! What all drags in the scene share: one undo step each, Shift that slows the pointer down, a
//! readout beside it, and Escape that takes everything back.
//!
//! What can be dragged is a [`SceneDrag`]: a component with what a press on it holds and which edit
//! a move makes of that.

use crate::document::requests::{ActiveDrag, EditRequest};
use crate::document::selection::{Selected, Selection};
use crate::schedule::EditorSystems;
use crate::shell::window::{DragReadout, DragText};
use crate::viewport::fine_pointer::{DEAD_ZONE_PX, DragKeys, FinePointer};
use bevy::ecs::system::{StaticSystemParam, SystemParam, SystemParamItem};
use bevy::picking::events::{Drag, DragEnd, DragStart, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use trackwright_design::Edit;

/// What can be dragged in the scene.
pub trait SceneDrag: Component + Sized {
    /// What a drag keeps from its start.
    type Held: Send + Sync + 'static;

    /// What a drag reads. The selection is written, so it comes apart from this.
    type Grip: SystemParam + 'static;

    /// What is held by a press at `at` in the window; `None` where nothing can be dragged.
    fn take(
        &self,
        grip: &SystemParamItem<Self::Grip>,
        selection: &Selection,
        at: Vec2,
    ) -> Option<Self::Held>;

    /// What is selected once the drag begins; `None` leaves the selection as it is.
    fn selected(&self) -> Option<Selected> {
        None
    }

    /// What undo calls the drag.
    fn label(held: &Self::Held) -> String;

    /// The edit with the pointer at `at`, and the text beside the pointer.
    fn edit(
        held: &mut Self::Held,
        grip: &SystemParamItem<Self::Grip>,
        at: Vec2,
    ) -> Option<(Edit, String)>;
}

/// What is held of one kind. It changes when a drag begins and ends, not while it goes on.
#[derive(Resource)]
pub struct Dragged<D: SceneDrag>(Option<(D::Held, FinePointer)>);

impl<D: SceneDrag> Default for Dragged<D> {
    fn default() -> Self {
        Self(None)
    }
}

impl<D: SceneDrag> Dragged<D> {
    pub fn get(&self) -> Option<&D::Held> {
        self.0.as_ref().map(|(held, _)| held)
    }
}

/// Drags one kind of entity.
pub fn plugin<D: SceneDrag>(app: &mut App) {
    app.init_resource::<Dragged<D>>()
        .add_observer(on_drag_start::<D>)
        .add_observer(on_drag::<D>)
        .add_observer(on_drag_end::<D>)
        .add_systems(
            Update,
            let_go_on_escape::<D>
                .run_if(resource_exists::<ButtonInput<KeyCode>>)
                .in_set(EditorSystems::Input),
        );
}

/// The course of a drag: `Begin`, an `Apply` for each move, then `Commit`, or `Cancel` on Escape.
#[derive(SystemParam)]
struct DragEdits<'w> {
    /// It stays after Escape, until the button is up.
    active: ResMut<'w, ActiveDrag>,
    readout: ResMut<'w, DragReadout>,
    edits: MessageWriter<'w, EditRequest>,
}

impl DragEdits<'_> {
    fn begin(&mut self, label: String) {
        self.active.set_if_neq(ActiveDrag(true));
        self.edits.write(EditRequest::Begin(label));
    }

    fn apply(&mut self, edit: Edit, at: Vec2, text: String) {
        self.edits.write(EditRequest::Apply(edit));
        let readout = DragReadout(Some(DragText { at, text }));
        self.readout.set_if_neq(readout);
    }

    /// The button is up.
    fn end(&mut self, is_held: bool) {
        if is_held {
            self.edits.write(EditRequest::Commit);
        }
        self.active.set_if_neq(ActiveDrag(false));
        self.readout.set_if_neq(DragReadout(None));
    }

    /// Everything is as it was before the drag, which goes on without an effect.
    fn cancel(&mut self) {
        self.edits.write(EditRequest::Cancel);
        self.readout.set_if_neq(DragReadout(None));
    }
}

fn on_drag_start<D: SceneDrag>(mut drag: On<Pointer<DragStart>>, things: Query<(), With<D>>) {
    // The drag begins beyond the dead zone, in `on_drag`.
    if things.contains(drag.entity) {
        drag.propagate(false);
    }
}

fn on_drag<D: SceneDrag>(
    mut drag: On<Pointer<Drag>>,
    things: Query<&D>,
    (grip, keys): (StaticSystemParam<D::Grip>, DragKeys),
    mut selection: ResMut<Selection>,
    mut dragged: ResMut<Dragged<D>>,
    mut edits: DragEdits,
) {
    let Ok(thing) = things.get(drag.entity) else {
        return;
    };
    drag.propagate(false);
    let at = drag.pointer_location.position;
    let is_short = drag.distance.length() < DEAD_ZONE_PX && !edits.active.0;
    if drag.button != PointerButton::Primary || is_short {
        return;
    }
    if dragged.0.is_none() {
        // After Escape the button is still down: that drag is over.
        if edits.active.0 {
            return;
        }
        let start = at - drag.distance;
        let Some(held) = thing.take(&grip, &selection, start) else {
            return;
        };
        edits.begin(D::label(&held));
        if let Some(selected) = thing.selected() {
            let mut after = selection.clone();
            after.take(selected);
            selection.set_if_neq(after);
        }
        dragged.0 = Some((held, FinePointer::new(start)));
    }
    let Some((held, pointer)) = &mut dragged.bypass_change_detection().0 else {
        return;
    };
    let fine_at = pointer.at(at, keys.is_fine());
    if let Some((edit, text)) = D::edit(held, &grip, fine_at) {
        edits.apply(edit, at, text);
    }
}

fn on_drag_end<D: SceneDrag>(
    mut drag: On<Pointer<DragEnd>>,
    things: Query<(), With<D>>,
    mut dragged: ResMut<Dragged<D>>,
    mut edits: DragEdits,
) {
    if !things.contains(drag.entity) || drag.button != PointerButton::Primary {
        return;
    }
    drag.propagate(false);
    edits.end(dragged.0.take().is_some());
}

fn let_go_on_escape<D: SceneDrag>(
    keys: Res<ButtonInput<KeyCode>>,
    mut dragged: ResMut<Dragged<D>>,
    mut edits: DragEdits,
) {
    if keys.just_pressed(KeyCode::Escape) && dragged.get().is_some() {
        dragged.0 = None;
        edits.cancel();
    }
}
