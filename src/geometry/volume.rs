//! Measurement volumes of trackers, in the tracker frame (field generator at z = 0, volume at
//! negative z).

use super::bounds::Bounds;
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// Where a tracker promises to measure. Lengths in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Volume {
    /// The 500 mm cube of a planar NDI Aurora generator.
    AuroraCube,
    /// Any box.
    Box(Bounds),
}

impl Volume {
    pub const AURORA_CUBE: ([f64; 3], [f64; 3]) = ([-250.0, -250.0, -550.0], [250.0, 250.0, -50.0]);

    /// The smallest box around the volume.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::AuroraCube => Self::AURORA_CUBE.into(),
            Self::Box(bounds) => *bounds,
        }
    }

    pub fn contains(&self, point_mm: &Point3<f64>) -> bool {
        self.bounds().contains(point_mm)
    }

    /// What a person calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::AuroraCube => "Aurora cube",
            Self::Box(_) => "box",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_aurora_cube_lies_in_front_of_the_generator() {
        assert!(Volume::AuroraCube.contains(&Point3::new(0.0, 0.0, -300.0)));
        assert!(!Volume::AuroraCube.contains(&Point3::new(0.0, 0.0, -40.0)));
        assert!(!Volume::AuroraCube.contains(&Point3::new(0.0, 0.0, 300.0)));
    }
}
