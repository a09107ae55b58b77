//! Anatomy: meshes that a design shows beside its bodies, the patient or what stands around. Drawn
//! translucent and nothing else: no figure, no sensor and no placement depends on them.

use super::check::{check_finite, check_mesh, check_not_empty, check_pose};
use super::content::{BodyRole, Design};
use super::edit::EditError;
use serde::Deserialize;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;

/// More than a scene has room for; a file may hold any number, edits stop here.
pub const MAX_ANATOMY: usize = 100;

/// A mesh that is only looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Anatomy {
    pub name: String,
    /// Its file is relative to the design's.
    pub mesh: MeshReference,
    pub on: AnatomyFrame,
    /// From the mesh's own frame to that of `on`.
    pub frame_from_mesh: Pose,
    /// sRGB, each from 0 to 1; that of bone where it is not said.
    pub color: Option<[f64; 3]>,
}

/// What a mesh of anatomy moves with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
pub enum AnatomyFrame {
    /// The patient. The tracker's frame where the design has no CRF.
    #[default]
    Crf,
    /// The room.
    Tracker,
}

impl AnatomyFrame {
    pub const ALL: [Self; 2] = [Self::Crf, Self::Tracker];

    /// What a list of them calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crf => "CRF",
            Self::Tracker => "tracker",
        }
    }
}

impl Anatomy {
    /// Where the mesh is in the tracker frame.
    pub fn tracker_from_mesh(&self, design: &Design) -> Pose {
        tracker_from_frame(design, self.on) * self.frame_from_mesh
    }

    /// The same on another frame, staying where it is.
    pub fn put_on(&self, on: AnatomyFrame, design: &Design) -> Self {
        let frame_from_tracker = tracker_from_frame(design, on).inverse();
        Self {
            on,
            frame_from_mesh: match on == self.on {
                true => self.frame_from_mesh,
                false => frame_from_tracker * self.tracker_from_mesh(design),
            },
            ..self.clone()
        }
    }
}

fn tracker_from_frame(design: &Design, frame: AnatomyFrame) -> Pose {
    match frame {
        AnatomyFrame::Tracker => Pose::identity(),
        AnatomyFrame::Crf => {
            (design.tracker_from_body(BodyRole::Crf)).unwrap_or_else(Pose::identity)
        }
    }
}

/// A change of the anatomy.
#[derive(Clone, Debug, PartialEq)]
pub enum AnatomyEdit {
    /// At the end of the list.
    Add(Box<Anatomy>),
    /// In the place of the one at `index`.
    Set {
        index: usize,
        anatomy: Box<Anatomy>,
    },
    Remove {
        index: usize,
    },
}

impl AnatomyEdit {
    /// Changes the anatomy, or leaves it as it is.
    pub(super) fn apply_to(self, design: &mut Design) -> Result<(), EditError> {
        let list = &mut design.anatomy;
        let count = list.len();
        match self {
            Self::Add(anatomy) => {
                if count >= MAX_ANATOMY {
                    return Err(EditError::TooMuchAnatomy);
                }
                check(&anatomy)?;
                check_name(&anatomy.name, list.iter())?;
                list.push(*anatomy);
            }
            Self::Set { index, anatomy } => {
                if index >= count {
                    return Err(EditError::NoSuchAnatomy { index, count });
                }
                check(&anatomy)?;
                let others = list.iter().enumerate().filter(|(other, _)| *other != index);
                check_name(&anatomy.name, others.map(|(_, other)| other))?;
                list[index] = *anatomy;
            }
            Self::Remove { index } => {
                if index >= count {
                    return Err(EditError::NoSuchAnatomy { index, count });
                }
                list.remove(index);
            }
        }
        Ok(())
    }

    /// What undo calls it, knowing what it changes.
    pub(super) fn label_for(&self, list: &[Anatomy]) -> String {
        let (index, anatomy) = match self {
            Self::Add(anatomy) => return format!("Add anatomy {}", anatomy.name),
            Self::Remove { index } => {
                return match list.get(*index) {
                    Some(anatomy) => format!("Remove anatomy {}", anatomy.name),
                    None => "Remove anatomy".to_owned(),
                };
            }
            Self::Set { index, anatomy } => (*index, anatomy),
        };
        let Some(before) = list.get(index) else {
            return format!("Change anatomy {}", anatomy.name);
        };
        if before.name != anatomy.name {
            format!("Rename anatomy {}", before.name)
        } else if before.on != anatomy.on {
            format!("Put anatomy {} on {}", anatomy.name, anatomy.on.name())
        } else if before.frame_from_mesh != anatomy.frame_from_mesh {
            format!("Move anatomy {}", anatomy.name)
        } else if before.mesh != anatomy.mesh {
            format!("Change mesh of anatomy {}", anatomy.name)
        } else {
            format!("Change colour of anatomy {}", anatomy.name)
        }
    }
}

fn check(anatomy: &Anatomy) -> Result<(), EditError> {
    check_not_empty("anatomy's name", &anatomy.name)?;
    check_mesh(&anatomy.mesh)?;
    check_pose(&anatomy.frame_from_mesh)?;
    let color = anatomy.color.iter().flatten();
    check_finite("the colour", color.clone())?;
    match color.copied().find(|part| !(0.0..=1.0).contains(part)) {
        Some(value) => Err(EditError::NoColor { value }),
        None => Ok(()),
    }
}

fn check_name<'a>(
    name: &str,
    mut others: impl Iterator<Item = &'a Anatomy>,
) -> Result<(), EditError> {
    match others.any(|other| other.name == name) {
        true => Err(EditError::DuplicateAnatomyName { name: name.to_owned() }),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Edit;
    use super::super::tests::document;
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};
    use trackwright_geometry::pose::pose_from_parts;

    fn anatomy(name: &str) -> Anatomy {
        Anatomy {
            name: name.to_owned(),
            mesh: MeshReference::new("head.stl"),
            on: AnatomyFrame::Crf,
            frame_from_mesh: Pose::translation(1.0, 2.0, 3.0),
            color: None,
        }
    }

    fn add(name: &str) -> Edit {
        Edit::Anatomy(AnatomyEdit::Add(Box::new(anatomy(name))))
    }

    fn set(index: usize, anatomy: Anatomy) -> Edit {
        Edit::Anatomy(AnatomyEdit::Set { index, anatomy: Box::new(anatomy) })
    }

    #[test]
    fn anatomy_is_added_changed_removed_and_undone_under_names_that_say_so() {
        let mut document = document();
        let mut present = anatomy("head");
        document.apply(add("head")).unwrap();
        document.apply(add("table")).unwrap();
        present.name = "skull".to_owned();
        document.apply(set(0, present.clone())).unwrap();
        present.frame_from_mesh = Pose::translation(0.0, 0.0, 9.0);
        document.apply(set(0, present.clone())).unwrap();
        present.on = AnatomyFrame::Tracker;
        document.apply(set(0, present.clone())).unwrap();
        present.mesh.file = "skull.obj".to_owned();
        document.apply(set(0, present.clone())).unwrap();
        present.color = Some([0.0, 0.5, 1.0]);
        document.apply(set(0, present.clone())).unwrap();
        document.apply(Edit::Anatomy(AnatomyEdit::Remove { index: 1 })).unwrap();
        assert_eq!(document.design().anatomy, [present]);
        let undone: Vec<_> = std::iter::from_fn(|| document.undo()).collect();
        let expected = [
            "Remove anatomy table",
            "Change colour of anatomy skull",
            "Change mesh of anatomy skull",
            "Put anatomy skull on tracker",
            "Move anatomy skull",
            "Rename anatomy head",
            "Add anatomy table",
            "Add anatomy head",
        ];
        assert_eq!(undone, expected);
        assert!(document.design().anatomy.is_empty());
    }

    #[test]
    fn what_cannot_be_drawn_or_told_apart_is_refused_and_nothing_changes() {
        let mut document = document();
        document.apply(add("head")).unwrap();
        let changed = |change: fn(&mut Anatomy)| {
            let mut wrong = anatomy("face");
            change(&mut wrong);
            Edit::Anatomy(AnatomyEdit::Add(Box::new(wrong)))
        };
        for (edit, why) in [
            (add("head"), "the design already has anatomy named \"head\", expected another name"),
            (changed(|a| a.name = " ".into()), "the anatomy's name is empty, expected a name"),
            (changed(|a| a.mesh.file.clear()), "the mesh's file is empty, expected a name"),
            (
                changed(|a| a.frame_from_mesh.translation.vector.x = f64::NAN),
                "the position is NaN, expected a finite number",
            ),
            (
                changed(|a| a.color = Some([0.0, 1.5, 0.0])),
                "a part of the colour is 1.5, expected a number from 0 to 1",
            ),
            (set(1, anatomy("face")), "the design has no anatomy at 1, it has 1"),
            (
                Edit::Anatomy(AnatomyEdit::Remove { index: 7 }),
                "the design has no anatomy at 7, it has 1",
            ),
        ] {
            assert_eq!(document.apply(edit).unwrap_err().to_string(), why);
        }
        assert_eq!(document.design().anatomy, [anatomy("head")]);
        // Its own name is no other's.
        assert!(!document.apply(set(0, anatomy("head"))).unwrap());
    }

    #[test]
    fn what_is_put_on_the_other_frame_stays_where_it_is_and_moves_with_its_own() {
        let mut document = document();
        let turn = UnitQuaternion::from_euler_angles(0.3, -0.2, 1.1);
        let crf = pose_from_parts(Vector3::new(-40.0, 5.0, -200.0), turn);
        document.apply(Edit::SetCrfPose(crf)).unwrap();
        let on_crf = anatomy("head");
        let on_tracker = on_crf.put_on(AnatomyFrame::Tracker, document.design());
        let distance = |a: &Anatomy, b: &Anatomy, design: &Design| {
            let (a, b) = (a.tracker_from_mesh(design), b.tracker_from_mesh(design));
            let turned = a.rotation.angle_to(&b.rotation);
            (a.translation.vector - b.translation.vector).norm() + turned
        };
        // A few roundings of numbers of some hundred millimetres.
        assert!(distance(&on_crf, &on_tracker, document.design()) < 1e-9);
        let back = on_tracker.put_on(AnatomyFrame::Crf, document.design());
        assert!(distance(&on_crf, &back, document.design()) < 1e-9);
        let moved = Pose::translation(10.0, 0.0, 0.0) * crf;
        document.apply(Edit::SetCrfPose(moved)).unwrap();
        let apart = distance(&on_crf, &on_tracker, document.design());
        assert!((apart - 10.0).abs() < 1e-9, "{apart}");
    }
}
