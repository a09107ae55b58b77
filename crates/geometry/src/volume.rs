//! Measurement volumes of trackers, in the tracker frame (field generator at z = 0, volume at
//! negative z).
//!
//! Figures are those of NDI's volumes as open-source navigation toolkits ship them. Widths, tops and
//! poles are exact there; where walls end ("about" 452, 519 and 148 mm) is rounded and follows from
//! the rest, as [`domed_cylinder`](super::domed_cylinder) argues. One mesh of the dome has its top at
//! +50 mm, behind the generator: a slip of the sign, not taken over. The tabletop is the product's,
//! which begins 120 mm from its generator; a prototype began at 80 mm.

use super::bounds::Bounds;
use super::domed_cylinder::DomedCylinder;
use super::outline::{Dimension, Outline};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// Where a tracker promises to measure. Lengths in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Volume {
    /// The 500 mm cube of a planar NDI Aurora generator.
    AuroraCube,
    /// The dome of a planar NDI Aurora generator, 960 mm across and 610 mm deep.
    AuroraDome,
    /// That of the NDI Aurora tabletop generator, an elliptic cylinder of 420 by 600 mm.
    AuroraTabletop,
    /// That of the compact NDI Aurora generator, 220 mm across.
    AuroraCompact,
    /// Any box.
    Box(Bounds),
}

impl Volume {
    /// Those of trackers, which have a name.
    pub const NAMED: [Self; 4] =
        [Self::AuroraCube, Self::AuroraDome, Self::AuroraTabletop, Self::AuroraCompact];

    pub const AURORA_CUBE: ([f64; 3], [f64; 3]) = ([-250.0, -250.0, -550.0], [250.0, 250.0, -50.0]);

    pub(super) const DOME: DomedCylinder =
        DomedCylinder { radii_mm: [480.0, 480.0], top_mm: -50.0, reach_mm: 660.0 };
    pub(super) const TABLETOP: DomedCylinder =
        DomedCylinder { radii_mm: [210.0, 300.0], top_mm: -120.0, reach_mm: 600.0 };
    pub(super) const COMPACT: DomedCylinder =
        DomedCylinder { radii_mm: [110.0, 110.0], top_mm: -10.0, reach_mm: 185.0 };

    /// The smallest box around the volume.
    pub fn bounds(&self) -> Bounds {
        match self.shape() {
            Shape::Box(bounds) => bounds,
            Shape::Domed(domed) => domed.bounds(),
        }
    }

    /// Whether the point is within, give or take round-off.
    #[inline]
    pub fn contains(&self, point_mm: &Point3<f64>) -> bool {
        match self.shape() {
            Shape::Box(bounds) => bounds.contains(point_mm),
            Shape::Domed(domed) => domed.contains(point_mm),
        }
    }

    /// A continuous scalar that is at most zero within the volume, for surfaces that end with it;
    /// `None` where the volume is all of its [`bounds`](Self::bounds).
    pub fn excess_mm(&self) -> Option<impl Fn(&Point3<f64>) -> f64 + use<>> {
        match self.shape() {
            Shape::Box(_) => None,
            Shape::Domed(domed) => Some(move |point_mm: &Point3<f64>| domed.excess_mm(point_mm)),
        }
    }

    /// Volume of the shape.
    pub fn volume_mm3(&self) -> f64 {
        match self.shape() {
            Shape::Box(bounds) => bounds.size_mm().product(),
            Shape::Domed(domed) => domed.volume_mm3(),
        }
    }

    /// What it is drawn with.
    pub fn outline(&self) -> Outline {
        match self.shape() {
            Shape::Box(bounds) => Outline::of_box(&bounds),
            Shape::Domed(domed) => domed.outline(),
        }
    }

    /// How large it is, in a few lengths.
    pub fn dimensions(&self) -> Vec<Dimension> {
        match self.shape() {
            Shape::Box(bounds) => Dimension::of_box(&bounds),
            Shape::Domed(domed) => domed.dimensions(),
        }
    }

    /// What a person calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::AuroraCube => "Aurora cube",
            Self::AuroraDome => "Aurora dome",
            Self::AuroraTabletop => "Aurora tabletop",
            Self::AuroraCompact => "Aurora compact",
            Self::Box(_) => "box",
        }
    }

    fn shape(&self) -> Shape {
        match self {
            Self::AuroraCube => Shape::Box(Self::AURORA_CUBE.into()),
            Self::AuroraDome => Shape::Domed(Self::DOME),
            Self::AuroraTabletop => Shape::Domed(Self::TABLETOP),
            Self::AuroraCompact => Shape::Domed(Self::COMPACT),
            Self::Box(bounds) => Shape::Box(*bounds),
        }
    }
}

enum Shape {
    Box(Bounds),
    Domed(DomedCylinder),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_lie_in_front_of_the_generator() {
        // Just within and just beyond: the top, the pole, the wall along x and y, the dome's edge.
        for (volume, within, beyond) in [
            (
                Volume::AuroraCube,
                [[0.0, 0.0, -51.0], [249.0, -249.0, -549.0]],
                [[0.0, 0.0, -49.0], [249.0, -249.0, -551.0]],
            ),
            (
                Volume::AuroraDome,
                [[0.0, 0.0, -659.0], [339.0, 339.0, -450.0]],
                [[0.0, 0.0, -661.0], [340.0, 340.0, -450.0]],
            ),
            (
                Volume::AuroraTabletop,
                [[209.0, 0.0, -560.0], [0.0, 299.0, -519.0]],
                [[0.0, 211.0, -119.0], [0.0, 299.0, -521.0]],
            ),
            (
                Volume::AuroraCompact,
                [[0.0, 0.0, -11.0], [0.0, -109.0, -148.0]],
                [[0.0, 0.0, -9.0], [0.0, -109.0, -150.0]],
            ),
        ] {
            let has = |point: &[f64; 3]| volume.contains(&Point3::from(*point));
            assert!(within.iter().all(has), "{volume:?}");
            assert!(!beyond.iter().any(has), "{volume:?}");
            let opposite = within.map(|[x, y, z]| [x, y, -z]);
            assert!(!opposite.iter().any(has), "{volume:?}");
        }
    }
}
