//! What is written on slides, and the panel in which they are made.

pub mod slides_ui;
pub mod stage_ui;
pub mod systems;

use crate::workspaces::present::first;
use crate::workspaces::present::requests::Presenter;
use std::borrow::Cow;
use trackwright_design::{Document, Slide};
use trackwright_field::Environment;
use trackwright_simulation::Figures;

/// What a slide is drawn from.
pub struct StageView<'a> {
    pub document: &'a Document,
    pub environment: &'a Environment,
    pub presenter: &'a Presenter,
    /// Of the design's study; `None` until they are known.
    pub figures: Option<&'a Figures>,
}

impl StageView<'_> {
    /// The shown slide with its index and how many there are; of a design without slides the one
    /// that it is shown with, as the only one.
    pub fn slide(&self) -> (Cow<'_, Slide>, usize, usize) {
        let slides = &self.document.design().slides;
        let index = self.presenter.slide.min(slides.len().saturating_sub(1));
        match slides.get(index) {
            Some(slide) => (Cow::Borrowed(slide), index, slides.len()),
            None => (Cow::Owned(first::slide_of(self.document)), 0, 1),
        }
    }
}
