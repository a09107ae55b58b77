//! A low rounded housing with room for a coil, as on handles and on the reference frame.

use crate::profile::{RoundedRectangle, at, lofted};
use crate::shape::Shape;
use crate::vector::Placement;

/// A housing that stands on its foot at z = 0 and is longest along x.
#[derive(Clone, Copy, Debug)]
pub struct Pod {
    pub placement: Placement,
    pub length_mm: f64,
    pub width_mm: f64,
    pub height_mm: f64,
    /// Rounding of the upper edge.
    pub edge_mm: f64,
    /// Radius of the hollow that leads from the surface below into the wall; 0 for none.
    pub foot_mm: f64,
}

impl Pod {
    pub fn shape(&self) -> Shape {
        let outline = RoundedRectangle {
            half_width_mm: self.length_mm / 2.0,
            half_height_mm: self.width_mm / 2.0,
            corner_mm: self.width_mm / 2.0 - 0.05,
            corner_pieces: 7,
            side_pieces: [6, 1],
        };
        // Walls lean in a little, as moulded ones do.
        let lean_mm = 0.12 * self.height_mm;
        let mut corners = Vec::new();
        if self.foot_mm > 0.0 {
            // Below the foot the hollow's rim goes on down, to meet a surface that bends away.
            corners.push(at(-1.0, self.foot_mm + 0.1, 0.0));
            corners.push(at(0.0, self.foot_mm + 0.1, 0.0));
        }
        corners.extend([
            at(0.0, 0.0, self.foot_mm),
            at(self.height_mm, -lean_mm, self.edge_mm),
            at(self.height_mm, -0.3 * self.width_mm, 0.0),
        ]);
        lofted(&corners, |outset_mm| outline.outline(outset_mm)).placed(&self.placement)
    }
}
