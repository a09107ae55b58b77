//! What is written in a frame and where: what tests of the layout judge.

use bevy::prelude::*;
use bevy_egui::egui::epaint::{ClippedShape, TextShape};
use bevy_egui::egui::{Rect, Shape};
use bevy_egui::{EguiFullOutput, EguiPostUpdateSet};

/// A text of the interface, in egui's points.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintedText {
    pub text: String,
    pub rect: Rect,
    /// Outside of it nothing is seen.
    pub clip: Rect,
    /// Whether it ends in an ellipsis for want of room.
    pub is_shortened: bool,
}

impl PaintedText {
    /// The part that is seen.
    pub fn seen(&self) -> Rect {
        self.rect.intersect(self.clip)
    }
}

/// The texts of the newest frame. Insert it to have them.
#[derive(Resource, Default)]
pub struct PaintedTexts(pub Vec<PaintedText>);

/// Fills [`PaintedTexts`].
pub struct PaintedTextPlugin;

impl Plugin for PaintedTextPlugin {
    fn build(&self, app: &mut App) {
        let collect = collect
            .after(EguiPostUpdateSet::EndPass)
            .before(EguiPostUpdateSet::ProcessOutput)
            .run_if(resource_exists::<PaintedTexts>);
        app.add_systems(PostUpdate, collect);
    }
}

fn collect(outputs: Query<&EguiFullOutput>, mut texts: ResMut<PaintedTexts>) {
    texts.0.clear();
    for output in outputs.iter().filter_map(|output| output.0.as_ref()) {
        for ClippedShape { clip_rect, shape } in &output.shapes {
            add_texts(shape, *clip_rect, &mut texts.0);
        }
    }
}

fn add_texts(shape: &Shape, clip: Rect, texts: &mut Vec<PaintedText>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| add_texts(shape, clip, texts)),
        Shape::Text(shape) => texts.push(painted(shape, clip)),
        _ => {}
    }
}

fn painted(shape: &TextShape, clip: Rect) -> PaintedText {
    PaintedText {
        text: shape.galley.text().to_owned(),
        rect: shape.visual_bounding_rect(),
        clip,
        is_shortened: shape.galley.elided,
    }
}
