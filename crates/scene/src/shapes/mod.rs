//! Layers that are a few shapes: arrows, an ellipsoid, lines. Each is one file, which the window and
//! exported scenes draw alike; both go through [`LAYERS`].

mod motion;
mod requirement;
mod sensor_errors;
mod tip_error;
mod tip_scatter;

pub use motion::outline_of;

use super::arrow_style::ArrowStyle;
use super::palette::Rgb;
use super::tool_errors::ToolErrors;
use nalgebra::{Matrix3, Point3, Vector3};
use trackwright_design::view::Layer;
use trackwright_design::{BodyRole, Design, Things};
use trackwright_geometry::gizmo::Eye;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::solid::{ArrowSize, Solid};
use trackwright_simulation::PoseDetail;
use trackwright_simulation::uncertainty::TipUncertainty;

/// A layer of shapes in one colour.
#[derive(Clone, Copy, Debug)]
pub struct ShapeLayer {
    /// Its row in the table of layers.
    pub row: &'static Layer,
    pub color: Rgb,
    pub shapes: fn(&Shown) -> Vec<Shape>,
    /// Its line in the legend while it is on; `None` while there is nothing to explain.
    pub legend: fn(&Shown) -> Option<LegendLine>,
}

/// Every such layer.
pub const LAYERS: &[ShapeLayer] = &[
    sensor_errors::LAYER,
    tip_error::LAYER,
    requirement::LAYER,
    motion::LAYER,
    tip_scatter::LAYER,
];

/// What shapes are made from.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// As it is designed.
    pub design: &'a Design,
    /// As it is shown: a trial, a drag or a tracker may have its bodies elsewhere.
    pub shown: &'a Design,
    pub hidden: &'a Things,
    /// `None` while nothing is known.
    pub pose: Option<&'a PoseDetail>,
    /// `None` where the room states no jitter.
    pub scatter: Option<&'a TipUncertainty>,
    /// How many times larger than life errors are.
    pub times: f64,
    pub eye: Eye,
    /// Whether the bodies are where a tracker has them.
    pub is_live: bool,
}

/// What stands in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendLine {
    pub words: String,
    /// For those who do not design the tool.
    pub plain_words: String,
    /// Whether it is larger than life by the magnification of errors.
    pub is_magnified: bool,
}

/// One thing that is drawn, tracker frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    pub name: String,
    pub form: Form,
    /// Figures of it for programs that read the scene, by name and unit.
    pub figures: Vec<(&'static str, f64)>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    Arrow(Arrow),
    /// Of some half lengths along the columns of a rotation.
    Ellipsoid {
        center_mm: Point3<f64>,
        turn: Matrix3<f64>,
        half_lengths_mm: Vector3<f64>,
        look: Look,
    },
    /// Strips, with an opacity.
    Lines {
        strips: Vec<Vec<Point3<f64>>>,
        alpha: f64,
    },
}

/// An error, magnified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrow {
    pub from_mm: Point3<f64>,
    /// At true size.
    pub error_mm: Vector3<f64>,
    pub times: f64,
    pub style: ArrowStyle,
}

/// How an ellipsoid is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Little more than its outline, so that it hides nothing.
    Outline,
    /// A translucent surface.
    Veil,
}

impl Shown<'_> {
    /// Of the tool and its tip; `None` while nothing is known.
    pub fn tool(&self) -> Option<ToolErrors> {
        Some(ToolErrors::of(self.shown, self.pose?))
    }

    pub fn tracker_from_crf(&self) -> Pose {
        self.shown.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity)
    }
}

impl LegendLine {
    fn magnified(words: &str, plain_words: &str) -> Self {
        let [words, plain_words] = [words, plain_words].map(str::to_owned);
        Self { words, plain_words, is_magnified: true }
    }
}

impl Shape {
    fn new(name: impl Into<String>, form: Form) -> Self {
        Self { name: name.into(), form, figures: Vec::new() }
    }
}

impl Arrow {
    fn drawn_mm(&self) -> Vector3<f64> {
        self.error_mm * self.times
    }

    /// As it looks from somewhere; one that is too short to be seen is left out.
    pub fn push_to(&self, solid: &mut Solid, eye: &Eye) {
        if let Some(size) = self.size(eye) {
            solid.push_arrow(&self.from_mm, &self.drawn_mm(), &size);
        }
    }

    /// Whether it is drawn shorter than it is, with two heads.
    pub fn is_cut(&self, eye: &Eye) -> bool {
        self.size(eye).is_some_and(|size| self.drawn_mm().norm() > size.most_mm)
    }

    fn size(&self, eye: &Eye) -> Option<ArrowSize> {
        self.style.size(&self.drawn_mm(), eye.mm_per_px(&self.from_mm), eye.view_px[1])
    }
}
