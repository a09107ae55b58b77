//! Edits of the metal in a design's room.

use super::content::Design;
use super::edit_error::EditError;
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_geometry::pose::Pose;
use trackwright_metal::setup::{MetalObject, RoomMetal};

/// A change of the metal.
#[derive(Clone, Debug, PartialEq)]
pub enum MetalEdit {
    /// All of it, generator and frequency with it; `None` takes all of it out of the room.
    Replace(Option<Arc<RoomMetal>>),
    /// At the end of the list, of a room with metal.
    Add(Box<MetalObject>),
    /// In the place of the one at `index`.
    Set { index: usize, object: Box<MetalObject> },
    /// Where the one at `index` is.
    SetPose { index: usize, tracker_from_object: Pose },
    /// Those behind it move up.
    Remove { index: usize },
    /// Of the generator's coils.
    SetFrequency(f64),
    /// The coils whose fields the metal disturbs.
    SetGenerator(Box<Generator>),
}

impl MetalEdit {
    /// Changes the metal, or leaves it as it is.
    pub(super) fn apply_to(self, design: &mut Design) -> Result<(), EditError> {
        let edit = match self {
            Self::Replace(metal) => {
                metal.as_ref().map_or(Ok(()), |metal| metal.check())?;
                design.room_metal = metal;
                return Ok(());
            }
            edit => edit,
        };
        let Some(before) = &design.room_metal else {
            return Err(EditError::NoMetal);
        };
        let mut metal = RoomMetal::clone(before);
        let count = metal.objects.len();
        let check = |index: usize| match index < count {
            true => Ok(()),
            false => Err(EditError::NoSuchMetal { index, count }),
        };
        match edit {
            Self::Replace(_) => {}
            Self::Add(object) => metal.objects.push(*object),
            Self::Set { index, object } => {
                check(index)?;
                metal.objects[index] = *object;
            }
            Self::SetPose { index, tracker_from_object } => {
                check(index)?;
                metal.objects[index].tracker_from_object = tracker_from_object;
            }
            Self::Remove { index } => {
                check(index)?;
                metal.objects.remove(index);
            }
            Self::SetFrequency(frequency_hz) => metal.frequency_hz = frequency_hz,
            Self::SetGenerator(generator) => metal.generator = *generator,
        }
        metal.check()?;
        if metal != **before {
            design.room_metal = Some(Arc::new(metal));
        }
        Ok(())
    }

    /// What undo calls it, knowing what it changes.
    pub(super) fn label_for(&self, metal: Option<&RoomMetal>) -> String {
        let name_at = |index: usize| {
            let object = metal.and_then(|metal| metal.objects.get(index));
            object.map_or("metal", |object| object.name.as_str())
        };
        match self {
            Self::Replace(after) => match (metal, after.as_deref().map(|m| &m.objects[..])) {
                (None, Some([object])) => format!("Add {}", object.name),
                (_, None) => "Remove all metal".to_owned(),
                _ => "Change metal".to_owned(),
            },
            Self::Add(object) => format!("Add {}", object.name),
            Self::SetPose { index, .. } => format!("Move {}", name_at(*index)),
            Self::Remove { index } => format!("Remove {}", name_at(*index)),
            Self::SetFrequency(_) => "Change frequency".to_owned(),
            Self::SetGenerator(_) => "Change generator".to_owned(),
            Self::Set { index, object } => {
                let before = metal.and_then(|metal| metal.objects.get(*index));
                let name = name_at(*index);
                match before {
                    Some(before) if before.name != object.name => format!("Rename {name}"),
                    Some(before) if before.material != object.material => {
                        format!("Change material of {name}")
                    }
                    Some(before) if before.shape != object.shape => {
                        format!("Change shape of {name}")
                    }
                    Some(before) if before.tracker_from_object != object.tracker_from_object => {
                        format!("Move {name}")
                    }
                    _ => format!("Change {name}"),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::document;
    use super::super::{Document, Edit};
    use super::*;
    use trackwright_metal::setup::{
        DEFAULT_TRIANGLES, MaterialTolerance, ObjectMaterial, ObjectShape,
    };

    fn ball(name: &str) -> MetalObject {
        MetalObject {
            name: name.to_owned(),
            shape: ObjectShape::Sphere { radius_mm: 30.0 },
            material: ObjectMaterial::Named("copper"),
            tracker_from_object: Pose::translation(0.0, 0.0, -700.0),
            most_triangles: DEFAULT_TRIANGLES,
            tolerance: MaterialTolerance::default(),
        }
    }

    fn one_ball() -> Option<Arc<RoomMetal>> {
        let empty = RoomMetal::empty(Generator::planar_nine());
        Some(Arc::new(RoomMetal { objects: vec![ball("ball")], ..empty }))
    }

    fn apply(document: &mut Document, edit: MetalEdit) -> Result<bool, EditError> {
        document.apply(Edit::Metal(edit))
    }

    #[test]
    fn metal_edits_are_undone_by_name() {
        let mut document = document();
        let mut changed = ball("disc");
        let mut edits =
            vec![MetalEdit::Replace(one_ball()), MetalEdit::Add(Box::new(ball("other")))];
        let set =
            |changed: &MetalObject| MetalEdit::Set { index: 0, object: Box::new(changed.clone()) };
        edits.push(set(&changed));
        changed.material = ObjectMaterial::Named("ferrite");
        edits.push(set(&changed));
        changed.shape = ObjectShape::Cylinder { radius_mm: 30.0, length_mm: 5.0 };
        edits.push(set(&changed));
        let tracker_from_object = Pose::translation(0.0, 300.0, -700.0);
        edits.push(MetalEdit::SetPose { index: 1, tracker_from_object });
        edits.push(MetalEdit::SetFrequency(5e3));
        edits.push(MetalEdit::SetGenerator(Box::new(Generator::anser())));
        edits.push(MetalEdit::Remove { index: 1 });
        edits.push(MetalEdit::Replace(None));
        for edit in edits {
            assert!(apply(&mut document, edit).unwrap());
        }
        let undone: Vec<_> = std::iter::from_fn(|| document.undo()).collect();
        let expected = [
            "Remove all metal",
            "Remove other",
            "Change generator",
            "Change frequency",
            "Move other",
            "Change shape of disc",
            "Change material of disc",
            "Rename ball",
            "Add other",
            "Add ball",
        ];
        assert_eq!(undone, expected);
        assert_eq!(document.design().room_metal, None);
    }

    #[test]
    fn impossible_metal_is_refused() {
        let mut document = document();
        let refused =
            |document: &mut Document, edit| apply(document, edit).unwrap_err().to_string();
        assert_eq!(refused(&mut document, MetalEdit::Remove { index: 0 }), "the room has no metal");
        apply(&mut document, MetalEdit::Replace(one_ball())).unwrap();
        let far = Pose::translation(f64::NAN, 0.0, 0.0);
        for (edit, why) in [
            (MetalEdit::Remove { index: 1 }, "the room has no metal object 1, it has 1"),
            (MetalEdit::Add(Box::new(ball("ball"))), "the name \"ball\" is that of two objects"),
            (MetalEdit::SetFrequency(-1.0), "frequency is -1 Hz, expected 0 to 1e7"),
            (
                MetalEdit::SetPose { index: 0, tracker_from_object: far },
                "ball: the pose is not finite, or farther than 1e6 mm",
            ),
        ] {
            assert_eq!(refused(&mut document, edit), why);
        }
        // What is there already is no step.
        let same = MetalEdit::Set { index: 0, object: Box::new(ball("ball")) };
        assert!(!apply(&mut document, same).unwrap());
    }
}
