//! What is selected: one thing, or several sensors of one body of which one is the primary.

use bevy::prelude::*;
use trackwright_design::{BodyRole, Design};

/// What the pointer is over, in the scene or in the outliner.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hovered(pub Option<Selected>);

/// A thing that can be selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Selected {
    Body(BodyRole),
    Sensor(BodyRole, usize),
    Tip(BodyRole),
    /// By its place in the design's list.
    Anatomy(usize),
    /// A metal object of the room, by its place in the list.
    Metal(usize),
}

/// What the person works on; outliner, inspector and scene agree on it.
///
/// Most of the program uses the primary thing. Several are selected together only where they
/// are sensors of one body, since that is what can be arranged together.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    primary: Option<Selected>,
    /// Beside the primary one, in the order in which they were added.
    others: Vec<Selected>,
}

/// Owns [`Selection`] and [`Hovered`].
pub struct SelectionPlugin;

impl Plugin for SelectionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Selection>().init_resource::<Hovered>();
    }
}

impl Selection {
    /// One thing, or nothing.
    pub fn of(primary: Option<Selected>) -> Self {
        Self { primary, others: Vec::new() }
    }

    /// Sensors of one body; the last one is the primary.
    pub fn of_sensors(body: BodyRole, indices: impl IntoIterator<Item = usize>) -> Self {
        let mut others: Vec<Selected> =
            indices.into_iter().map(|index| Selected::Sensor(body, index)).collect();
        Self { primary: others.pop(), others }
    }

    /// What the inspector shows, selected last.
    pub fn primary(&self) -> Option<Selected> {
        self.primary
    }

    pub fn contains(&self, what: Selected) -> bool {
        self.primary == Some(what) || self.others.contains(&what)
    }

    /// Every selected thing, the primary one last.
    pub fn all(&self) -> impl Iterator<Item = Selected> + '_ {
        self.others.iter().copied().chain(self.primary)
    }

    /// The selected sensors and their body; `None` where something else is selected.
    pub fn sensors(&self) -> Option<(BodyRole, Vec<usize>)> {
        let Some(Selected::Sensor(body, _)) = self.primary else {
            return None;
        };
        let mut indices: Vec<usize> = self
            .all()
            .filter_map(|selected| match selected {
                Selected::Sensor(_, index) => Some(index),
                _ => None,
            })
            .collect();
        indices.sort_unstable();
        Some((body, indices))
    }

    /// Adds a sensor to the others of its body as the primary one, or takes it away; anything
    /// else is selected alone.
    pub fn toggle(&mut self, what: Selected) {
        if self.contains(what) {
            self.retain(|selected| selected != what);
        } else if self.is_beside(what) {
            self.others.extend(self.primary.replace(what));
        } else {
            *self = Self::of(Some(what));
        }
    }

    /// Makes a thing the primary one: those that are selected with it stay so.
    pub fn take(&mut self, what: Selected) {
        if self.contains(what) {
            self.others.extend(self.primary.replace(what));
            self.others.retain(|other| *other != what);
        } else {
            *self = Self::of(Some(what));
        }
    }

    /// Goes with a change of the design: a sensor whose place in the list changed stays selected,
    /// and what is gone no longer is.
    pub fn follow(&mut self, before: &Design, after: &Design) {
        let followed: Vec<Selected> =
            self.all().filter_map(|selected| same_in(before, after, selected)).collect();
        if !followed.iter().copied().eq(self.all()) {
            let mut others = followed;
            self.primary = others.pop();
            self.others = others;
        }
    }

    fn is_beside(&self, what: Selected) -> bool {
        matches!(
            (self.primary, what),
            (Some(Selected::Sensor(a, _)), Selected::Sensor(b, _)) if a == b
        )
    }

    fn retain(&mut self, keep: impl Fn(Selected) -> bool) {
        self.others.retain(|other| keep(*other));
        if !self.primary.is_some_and(keep) {
            self.primary = self.others.pop();
        }
    }
}

/// What a thing of one design is in another.
fn same_in(before: &Design, after: &Design, selected: Selected) -> Option<Selected> {
    match selected {
        Selected::Body(role) => after.body(role).map(|_| selected),
        Selected::Tip(role) => after.body(role)?.rigid.tip_in_body.map(|_| selected),
        Selected::Anatomy(index) => {
            let same = same_place(&before.anatomy, &after.anatomy, index, |own| &own.name);
            same.map(Selected::Anatomy)
        }
        Selected::Metal(index) => {
            let [old, new] = [before, after].map(|design| match &design.room_metal {
                Some(metal) => &metal.objects[..],
                None => &[],
            });
            same_place(old, new, index, |object| &object.name).map(Selected::Metal)
        }
        Selected::Sensor(role, index) => {
            let [old, new] = [before.body(role)?, after.body(role)?];
            let [old, new] = [old, new].map(|body| &body.rigid.sensors);
            let same = same_place(old, new, index, |sensor| &sensor.name);
            same.map(|index| Selected::Sensor(role, index))
        }
    }
}

/// Where a thing of one list is in another: in its place where both are as long, since it may have
/// another name, or where its name is there; else by its name.
fn same_place<T>(
    before: &[T],
    after: &[T],
    index: usize,
    name: impl Fn(&T) -> &String,
) -> Option<usize> {
    let name_of = |things: &'_ [T]| things.get(index).map(|thing| name(thing).clone());
    if after.len() == before.len() || name_of(before) == name_of(after) {
        return (index < after.len()).then_some(index);
    }
    let own = name_of(before)?;
    after.iter().position(|thing| *name(thing) == own)
}

#[cfg(test)]
mod tests {
    use super::*;
    use BodyRole::{Crf, Tool};

    fn sensor(body: BodyRole, index: usize) -> Selected {
        Selected::Sensor(body, index)
    }

    #[test]
    fn toggling_selects_several_sensors_of_one_body() {
        let mut selection = Selection::of(Some(sensor(Tool, 2)));
        selection.toggle(sensor(Tool, 0));
        assert_eq!(selection.primary(), Some(sensor(Tool, 0)));
        assert_eq!(selection.sensors(), Some((Tool, vec![0, 2])));
        selection.toggle(sensor(Tool, 0));
        assert_eq!(selection, Selection::of(Some(sensor(Tool, 2))));
        selection.toggle(sensor(Tool, 2));
        assert_eq!(selection, Selection::default());
    }

    #[test]
    fn other_bodies_and_the_tip_replace_the_selection() {
        for alone in [sensor(Crf, 0), Selected::Body(Tool), Selected::Tip(Tool)] {
            let mut selection = Selection::of_sensors(Tool, [0, 1]);
            selection.toggle(alone);
            assert_eq!(selection, Selection::of(Some(alone)));
        }
    }

    #[test]
    fn taking_hold_of_one_of_several_keeps_the_others() {
        let mut selection = Selection::of_sensors(Tool, [0, 1, 2]);
        selection.take(sensor(Tool, 1));
        assert_eq!(selection.primary(), Some(sensor(Tool, 1)));
        assert_eq!(selection.sensors(), Some((Tool, vec![0, 1, 2])));
        selection.take(sensor(Tool, 3));
        assert_eq!(selection.sensors(), Some((Tool, vec![3])));
    }
}
