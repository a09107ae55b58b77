//! Sensors that a layout has in a small part of where they may be.

use crate::bodies::{Bodies, Movable};
use crate::outcome::body_key;
use nalgebra::Point3;
use serde::Serialize;
use trackwright_simulation::PlacedBody;

/// Part of the largest distance between allowed places below which sensors are close together. The lever of their
/// building errors and jitter is as much shorter.
const CROWDED: f64 = 0.4;

/// Allowed places of each sensor that are looked at.
const PLACES: usize = 64;

/// The sensors of a body that are close together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Crowding {
    /// `tool` or `crf`.
    pub body: &'static str,
    /// The largest distance between two of them.
    pub span_mm: f64,
    /// The nearest and the farthest from the tool's tip; `None` of a CRF.
    pub from_tip_mm: Option<[f64; 2]>,
    /// The largest distance between two places that are allowed, or taken by sensors that stay.
    pub allowed_mm: f64,
}

impl Crowding {
    /// For a person.
    pub fn words(&self) -> String {
        let Self { body, span_mm, from_tip_mm, allowed_mm } = self;
        let body = match *body {
            "crf" => "CRF",
            body => body,
        };
        let place = from_tip_mm.map_or_else(String::new, |[nearest, farthest]| {
            format!(", {nearest:.1} to {farthest:.1} mm from the tip")
        });
        format!(
            "the sensors of the {body} are within {span_mm:.1} mm of each other{place}; places up to {allowed_mm:.1} mm \
             apart are allowed"
        )
    }
}

/// Bodies with sensors that move and are close together.
pub(crate) fn crowded(movable: &Movable, bodies: &Bodies) -> Vec<Crowding> {
    let each = [PlacedBody::Tool, PlacedBody::Crf].into_iter();
    each.filter_map(|body| crowding(movable, bodies, body)).collect()
}

fn crowding(movable: &Movable, bodies: &Bodies, body: PlacedBody) -> Option<Crowding> {
    let (rigid, places) = (bodies.body(body)?, movable.places(body)?);
    let moved: Vec<usize> =
        movable.slots.iter().filter(|slot| slot.body == body).map(|slot| slot.index).collect();
    if moved.is_empty() || rigid.sensors.len() < 2 {
        return None;
    }
    let taken: Vec<Point3<f64>> = rigid.sensors.iter().map(|own| own.position_in_body).collect();
    let allowed = moved.iter().flat_map(|&index| {
        let grid = places.grid(&rigid.sensors[index], PLACES).places;
        grid.into_iter().map(|place| place.sensor.position_in_body)
    });
    let allowed: Vec<Point3<f64>> = allowed.chain(taken.iter().copied()).collect();
    let [span_mm, allowed_mm] = [&taken, &allowed].map(|points| span_mm(points));
    if span_mm >= CROWDED * allowed_mm {
        return None;
    }
    let from_tip_mm = rigid.tip_in_body.map(|tip| {
        let each = taken.iter().map(|place| (place - tip).norm());
        each.fold([f64::INFINITY, 0.0], |[least, most], mm| [mm.min(least), mm.max(most)])
    });
    Some(Crowding { body: body_key(body), span_mm, from_tip_mm, allowed_mm })
}

/// The largest distance between two points.
fn span_mm(points: &[Point3<f64>]) -> f64 {
    let each = points.iter().enumerate();
    let pairs = each.flat_map(|(k, a)| points[k + 1..].iter().map(move |b| (a - b).norm()));
    pairs.fold(0.0, f64::max)
}
