//! Slides: what a design shows to people who do not design it, saved with it and edited like it.

use super::content::Design;
use super::edit::EditError;
use super::view::View;
use serde::{Deserialize, Serialize};

/// More than anybody presents; a file may hold any number, edits stop here.
pub const MAX_SLIDES: usize = 100;

/// One picture with words: how the scene is looked at, and what is said of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Slide {
    pub title: String,
    /// A sentence or two below the picture.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub caption: String,
    /// Figures in plain words, from above.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<SlideFigure>,
    /// Camera, layers, slice, magnification. Without a camera the one before it stays.
    pub view: View,
}

/// A figure of the design's study, told in plain words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SlideFigure {
    /// The part of the poses whose tip error is within the requirement.
    WithinLimit,
    TypicalTipError,
    LargestTipError,
    TypicalAngleError,
}

impl SlideFigure {
    pub const ALL: [Self; 4] =
        [Self::WithinLimit, Self::TypicalTipError, Self::LargestTipError, Self::TypicalAngleError];

    /// What a list of them calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::WithinLimit => "positions within the limit",
            Self::TypicalTipError => "typical tip error",
            Self::LargestTipError => "largest tip error",
            Self::TypicalAngleError => "typical angle error",
        }
    }
}

/// A change of the slides.
#[derive(Clone, Debug, PartialEq)]
pub enum SlideEdit {
    /// At `index`, what was there and after it moves back.
    Add {
        index: usize,
        slide: Box<Slide>,
    },
    /// In the place of the one at `index`.
    Set {
        index: usize,
        slide: Box<Slide>,
    },
    Remove {
        index: usize,
    },
    /// Takes the slide at `from` and puts it where it then has the index `to`.
    Move {
        from: usize,
        to: usize,
    },
}

impl SlideEdit {
    /// Changes the slides, or leaves them as they are.
    pub(super) fn apply_to(self, design: &mut Design) -> Result<(), EditError> {
        let slides = &mut design.slides;
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

#[cfg(test)]
mod tests {
    use super::super::tests::document;
    use super::super::{Edit, View};
    use super::*;

    fn slide(title: &str) -> Box<Slide> {
        Box::new(Slide { title: title.to_owned(), ..Slide::default() })
    }

    #[test]
    fn slides_are_added_moved_changed_removed_and_undone_under_names_that_say_so() {
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
    fn a_slide_that_is_not_there_or_cannot_be_drawn_leaves_the_slides_as_they_are() {
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
    fn a_presented_view_is_looked_at_and_changed_but_never_the_documents_own() {
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
