//! The point about which a range of motion turns a body.

use crate::body::RigidBody;
use crate::shaft::shaft_in_body;
use nalgebra::Point3;
use serde::{Deserialize, Serialize};
use trackwright_geometry::limits::position_problem;
use trackwright_geometry::pose::Pose;

/// What stays where it is when a range of motion turns a body.
///
/// It is a place at the design's own pose: shifts of the range move it too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Pivot {
    /// The body's origin, as in the paper.
    #[default]
    Origin,
    /// The tip whose error is judged.
    Tip,
    /// Another point of the body, mm in its frame, such as where a needle enters the skin.
    Body([f64; 3]),
    /// A point of the reference, mm, such as a joint of the patient: in the CRF's frame, in the
    /// tracker's where there is no CRF.
    Reference([f64; 3]),
}

/// How far behind the tip [`Pivot::on_shaft`] is, mm: a needle that is half in.
const ENTRY_MM: f64 = 50.0;

impl Pivot {
    /// On a body's shaft, where it may enter the skin; at the tip of one that has none.
    pub fn on_shaft(body: &RigidBody) -> Self {
        let entry_mm = shaft_in_body(body).map_or_else(Default::default, |axis| *axis * ENTRY_MM);
        Self::Body((body.judged_tip_in_body() + entry_mm).coords.into())
    }

    /// What it is, to follow "about".
    pub fn words(&self, body: &str, reference: &str) -> String {
        match self {
            Self::Origin => format!("the {body}'s origin"),
            Self::Tip => format!("the {body}'s tip"),
            Self::Body(_) => format!("a point of the {body}"),
            Self::Reference(_) => format!("a point of the {reference}"),
        }
    }

    /// The coordinates of a point of one's own, mm.
    pub fn point(&self) -> Option<[f64; 3]> {
        match *self {
            Self::Body(point) | Self::Reference(point) => Some(point),
            Self::Origin | Self::Tip => None,
        }
    }

    pub(super) fn is_origin(&self) -> bool {
        *self == Self::Origin
    }

    /// In the body's frame, mm.
    pub fn in_body(&self, tip_in_body: &Point3<f64>, reference_from_body: &Pose) -> Point3<f64> {
        match *self {
            Self::Origin => Point3::origin(),
            Self::Tip => *tip_in_body,
            Self::Body(point) => point.into(),
            Self::Reference(point) => reference_from_body.inverse_transform_point(&point.into()),
        }
    }

    /// At another place of the reference: a point of it where it was one, else of the body.
    #[must_use]
    pub fn moved_to(self, in_reference: &Point3<f64>, reference_from_body: &Pose) -> Self {
        match self {
            Self::Reference(_) => Self::Reference(in_reference.coords.into()),
            Self::Origin | Self::Tip | Self::Body(_) => {
                let in_body = reference_from_body.inverse_transform_point(in_reference);
                Self::Body(in_body.coords.into())
            }
        }
    }

    /// See [`super::motion::Motion::with_reference_moved`].
    pub(super) fn with_reference_moved(self, from: &Pose, to: &Pose) -> Self {
        match self {
            Self::Reference(point) => {
                let in_body = from.inverse_transform_point(&point.into());
                Self::Reference((to * in_body).coords.into())
            }
            _ => self,
        }
    }

    /// A point that cannot be one, and what was expected.
    pub(super) fn problem(&self) -> Option<([f64; 3], &'static str)> {
        let point = self.point()?;
        position_problem(&point).map(|expected| (point, expected))
    }
}
