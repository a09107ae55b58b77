//! Edits of what a design has lists of: anatomy, slides, rooms and decisions.

use super::anatomy::Anatomy;
use super::check::{check_finite, check_mesh, check_not_empty, check_pose};
use super::content::Design;
use super::edit_error::{EditError, MAX_ANATOMY, MAX_FURTHER_ROOMS, MAX_SLIDES};
use super::procedure::Decision;
use super::slides::Slide;
use trackwright_geometry::bounds::Bounds;
use trackwright_procedure::Step;
use trackwright_simulation::mounting::{BoxPlace, check_box};

/// A change of the anatomy.
#[derive(Clone, Debug, PartialEq)]
pub enum AnatomyEdit {
    /// At the end of the list.
    Add(Box<Anatomy>),
    /// In the place of the one at `index`.
    Set { index: usize, anatomy: Box<Anatomy> },
    /// Where on the one at `index` the CRF may stand, in boxes of its mesh's own frame; nothing is
    /// stated without boxes.
    SetCrfPatch { index: usize, boxes: Vec<Bounds> },
    /// Those behind it move up.
    Remove { index: usize },
}

impl AnatomyEdit {
    /// Changes the anatomy, or leaves it as it is.
    pub(super) fn apply_to(self, list: &mut Vec<Anatomy>) -> Result<(), EditError> {
        let count = list.len();
        match self {
            Self::Add(anatomy) => {
                if count >= MAX_ANATOMY {
                    return Err(EditError::TooMuchAnatomy);
                }
                check_anatomy(&anatomy)?;
                check_name(&anatomy.name, list.iter())?;
                list.push(*anatomy);
            }
            Self::Set { index, anatomy } => {
                if index >= count {
                    return Err(EditError::NoSuchAnatomy { index, count });
                }
                check_anatomy(&anatomy)?;
                let others = list.iter().enumerate().filter(|(other, _)| *other != index);
                check_name(&anatomy.name, others.map(|(_, other)| other))?;
                list[index] = *anatomy;
            }
            Self::SetCrfPatch { index, boxes } => {
                let Some(anatomy) = list.get_mut(index) else {
                    return Err(EditError::NoSuchAnatomy { index, count });
                };
                check_crf_patch(&boxes)?;
                anatomy.crf_patch = boxes;
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
            Self::SetCrfPatch { index, .. } => {
                return match list.get(*index) {
                    Some(anatomy) => crf_patch_label(anatomy),
                    None => "Change CRF patch".to_owned(),
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
        } else if before.crf_patch != anatomy.crf_patch {
            crf_patch_label(anatomy)
        } else {
            format!("Change colour of anatomy {}", anatomy.name)
        }
    }
}

fn crf_patch_label(anatomy: &Anatomy) -> String {
    format!("Change CRF patch of anatomy {}", anatomy.name)
}

fn check_crf_patch(boxes: &[Bounds]) -> Result<(), EditError> {
    let mut boxes = boxes.iter().enumerate();
    Ok(boxes.try_for_each(|(index, own)| check_box(BoxPlace::CrfPatch { index }, own))?)
}

fn check_anatomy(anatomy: &Anatomy) -> Result<(), EditError> {
    check_not_empty("anatomy's name", &anatomy.name)?;
    check_mesh(&anatomy.mesh)?;
    check_pose(&anatomy.frame_from_mesh)?;
    check_crf_patch(&anatomy.crf_patch)?;
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

/// A change of the slides.
#[derive(Clone, Debug, PartialEq)]
pub enum SlideEdit {
    /// At `index`, what was there and after it moves back.
    Add { index: usize, slide: Box<Slide> },
    /// In the place of the one at `index`.
    Set { index: usize, slide: Box<Slide> },
    /// Those behind it move up.
    Remove { index: usize },
    /// Takes the slide at `from` and puts it where it then has the index `to`.
    Move { from: usize, to: usize },
}

impl SlideEdit {
    /// Changes the slides, or leaves them as they are.
    pub(super) fn apply_to(self, slides: &mut Vec<Slide>) -> Result<(), EditError> {
        let count = slides.len();
        let check = |index: usize| {
            if index < count { Ok(()) } else { Err(EditError::NoSuchSlide { index, count }) }
        };
        match self {
            Self::Add { index, slide } => {
                if index > count {
                    return Err(EditError::NoSuchSlide { index, count });
                }
                if count >= MAX_SLIDES {
                    return Err(EditError::TooManySlides);
                }
                slide.view.check()?;
                slides.insert(index, *slide);
            }
            Self::Set { index, slide } => {
                check(index)?;
                slide.view.check()?;
                slides[index] = *slide;
            }
            Self::Remove { index } => {
                check(index)?;
                slides.remove(index);
            }
            Self::Move { from, to } => {
                check(from)?;
                check(to)?;
                let slide = slides.remove(from);
                slides.insert(to, slide);
            }
        }
        Ok(())
    }

    /// What undo calls it, knowing what it changes.
    pub(super) fn label_for(&self, slides: &[Slide]) -> String {
        let named = |what: &str, index: usize| format!("{what} slide {}", index + 1);
        match self {
            Self::Add { index, .. } => named("Add", *index),
            Self::Remove { index } => named("Remove", *index),
            Self::Move { from, .. } => named("Move", *from),
            Self::Set { index, slide } => {
                let old = slides.get(*index);
                let is_same = |of: fn(&Slide) -> &str| old.is_some_and(|old| of(old) == of(slide));
                if !is_same(|slide| &slide.title) {
                    named("Change title of", *index)
                } else if !is_same(|slide| &slide.caption) {
                    named("Change caption of", *index)
                } else if old.is_some_and(|old| old.figures != slide.figures) {
                    named("Change figures of", *index)
                } else {
                    named("Change view of", *index)
                }
            }
        }
    }
}

/// A change of the procedure.
#[derive(Clone, Debug, PartialEq)]
pub enum ProcedureEdit {
    /// A file relative to the design's, at the end of the list.
    AddRoom(String),
    /// As it is written in the list. What was decided in it stays decided.
    RemoveRoom(String),
    /// In the place of what was decided before.
    Decide { step: Step, decision: Box<Decision> },
    /// What was decided is decided no more.
    Withdraw { step: Step },
}

impl ProcedureEdit {
    /// Changes the procedure, or leaves it as it is.
    pub(super) fn apply_to(self, design: &mut Design) -> Result<(), EditError> {
        match self {
            Self::AddRoom(file) => {
                check_not_empty("further room's file", &file)?;
                let rooms = &mut design.procedure.further_rooms;
                if file == design.environment || rooms.contains(&file) {
                    return Err(EditError::RoomTwice { file });
                }
                if rooms.len() >= MAX_FURTHER_ROOMS {
                    return Err(EditError::TooManyRooms);
                }
                rooms.push(file);
            }
            Self::RemoveRoom(file) => {
                let rooms = &mut design.procedure.further_rooms;
                let Some(index) = rooms.iter().position(|room| *room == file) else {
                    return Err(EditError::NoSuchRoom { file });
                };
                rooms.remove(index);
            }
            Self::Decide { step, decision } => {
                if step == Step::Crf && design.crf.is_none() {
                    return Err(EditError::NoCrf);
                }
                decision.check(step)?;
                *design.procedure.decision_mut(step) = Some(*decision);
            }
            Self::Withdraw { step } => {
                if design.procedure.decision_mut(step).take().is_none() {
                    return Err(EditError::NotDecided { step });
                }
            }
        }
        Ok(())
    }

    /// What undo calls it.
    pub(super) fn label(&self) -> String {
        match self {
            Self::AddRoom(_) => "Add room".to_owned(),
            Self::RemoveRoom(_) => "Remove room".to_owned(),
            Self::Decide { step, .. } => format!("Decide on {step}"),
            Self::Withdraw { step } => format!("Withdraw decision on {step}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::document;
    use super::super::{AnatomyFrame, Edit, View};
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};
    use trackwright_geometry::mesh_reference::MeshReference;
    use trackwright_geometry::pose::Pose;
    use trackwright_geometry::pose::pose_from_parts;

    fn anatomy(name: &str) -> Anatomy {
        Anatomy {
            name: name.to_owned(),
            mesh: MeshReference::new("head.stl"),
            on: AnatomyFrame::Crf,
            frame_from_mesh: Pose::translation(1.0, 2.0, 3.0),
            color: None,
            crf_patch: Vec::new(),
        }
    }

    fn add(name: &str) -> Edit {
        Edit::Anatomy(AnatomyEdit::Add(Box::new(anatomy(name))))
    }

    fn set(index: usize, anatomy: Anatomy) -> Edit {
        Edit::Anatomy(AnatomyEdit::Set { index, anatomy: Box::new(anatomy) })
    }

    fn patch(index: usize, boxes: Vec<Bounds>) -> Edit {
        Edit::Anatomy(AnatomyEdit::SetCrfPatch { index, boxes })
    }

    #[test]
    fn anatomy_edits_are_undone_by_name() {
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
        present.crf_patch = vec![Bounds::from(([-9.0, 0.0, 1.0], [9.0, 5.0, 2.0]))];
        document.apply(patch(0, present.crf_patch.clone())).unwrap();
        // What is there already is no step.
        assert!(!document.apply(patch(0, present.crf_patch.clone())).unwrap());
        present.crf_patch[0].max_mm.x = 8.0;
        document.apply(set(0, present.clone())).unwrap();
        document.apply(Edit::Anatomy(AnatomyEdit::Remove { index: 1 })).unwrap();
        assert_eq!(document.design().anatomy, [present]);
        let undone: Vec<_> = std::iter::from_fn(|| document.undo()).collect();
        let expected = [
            "Remove anatomy table",
            "Change CRF patch of anatomy skull",
            "Change CRF patch of anatomy skull",
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
    fn impossible_anatomy_is_refused() {
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
            (
                patch(
                    0,
                    vec![Bounds::from(([0.0; 3], [1.0; 3])), Bounds::from(([2.0; 3], [1.0; 3]))],
                ),
                "crf_patch[1]: min x is 2, max x is 1, expected min at most max",
            ),
            (
                patch(0, vec![Bounds::from(([0.0; 3], [1.0, f64::NAN, 1.0]))]),
                "crf_patch[0]: max is (1, NaN, 1), expected finite numbers",
            ),
            (
                changed(|a| a.crf_patch = vec![Bounds::from(([0.0; 3], [1.0, 0.0, 1.0]))]),
                "crf_patch[0]: min y and max y are 0, expected min below max",
            ),
            (patch(3, Vec::new()), "the design has no anatomy at 3, it has 1"),
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
    fn anatomy_on_another_frame_stays_in_place() {
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

    fn slide(title: &str) -> Box<Slide> {
        Box::new(Slide { title: title.to_owned(), ..Slide::default() })
    }

    #[test]
    fn slide_edits_are_undone_by_name() {
        let mut document = document();
        let mut edit = |edit| document.apply(Edit::Slides(edit)).unwrap();
        for (index, title) in [(0, "b"), (0, "a"), (2, "c")] {
            edit(SlideEdit::Add { index, slide: slide(title) });
        }
        edit(SlideEdit::Move { from: 0, to: 2 });
        edit(SlideEdit::Set { index: 0, slide: slide("B") });
        edit(SlideEdit::Remove { index: 1 });
        let titles = |document: &super::super::Document| {
            let slides = &document.design().slides;
            slides.iter().map(|s| s.title.clone()).collect::<String>()
        };
        assert_eq!(titles(&document), "Ba");
        let mut undone = Vec::new();
        while let Some(label) = document.undo() {
            undone.push((label, titles(&document)));
        }
        let expected = [
            ("Remove slide 2", "Bca"),
            ("Change title of slide 1", "bca"),
            ("Move slide 1", "abc"),
            ("Add slide 3", "ab"),
            ("Add slide 1", "b"),
            ("Add slide 1", ""),
        ];
        let expected = expected.map(|(label, titles)| (label.to_owned(), titles.to_owned()));
        assert_eq!(undone, expected);
    }

    #[test]
    fn bad_slide_edits_change_nothing() {
        let mut document = document();
        let mut refused = |edit| document.apply(Edit::Slides(edit)).unwrap_err().to_string();
        let index = 1;
        let add = SlideEdit::Add { index, slide: slide("late") };
        assert_eq!(refused(add), "the design has no slide at 1, it has 0");
        let remove = SlideEdit::Remove { index: 0 };
        assert_eq!(refused(remove), "the design has no slide at 0, it has 0");
        let mut blind = slide("blind");
        blind.view.placement_range_mm = Some(-1.0);
        let add = SlideEdit::Add { index: 0, slide: blind };
        let why = refused(add);
        assert!(why.contains("placement_range_mm is -1"), "{why}");
        assert!(document.design().slides.is_empty() && document.undo_label().is_none());
    }

    #[test]
    fn a_presented_view_is_never_the_documents_own() {
        let mut document = document();
        let own = document.own_view().clone();
        let mut presented = View::default();
        presented.layers.ghost = !own.layers.ghost;
        document.present(Some(presented.clone()));
        assert_eq!(*document.view(), presented);
        presented.layers.labels = !presented.layers.labels;
        assert!(document.set_view(presented.clone()));
        assert!(!document.set_view(presented));
        assert_eq!((document.own_view(), document.is_dirty()), (&own, false));
        document.present(None);
        assert_eq!(*document.view(), own);
    }
}
