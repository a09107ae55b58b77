//! What the text formats of marker tools spell out.

use super::super::error::FormatError;
use nalgebra::Point3;
use trackwright_simulation::body::{RigidBody, Sensor, SensorOrientation};

/// Markers and, perhaps, the point that the tool turns about; millimetres, tool frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    pub id: Option<i64>,
    pub fiducials: Vec<Point3<f64>>,
    pub pivot: Option<Point3<f64>>,
}

impl Geometry {
    /// Most markers that are read or written: fifty times what any tool has.
    pub const MAX_FIDUCIALS: usize = 1000;

    pub(super) fn check_count(count: usize) -> Result<(), FormatError> {
        if count <= Self::MAX_FIDUCIALS {
            return Ok(());
        }
        Err(FormatError::field("count", count, "at most 1000 markers"))
    }

    /// The body's name.
    pub(super) fn name(&self) -> String {
        name_of(self.id)
    }

    pub(super) fn to_body(&self) -> RigidBody {
        let sensors = self.fiducials.iter().enumerate();
        RigidBody {
            name: self.name(),
            tip_in_body: self.pivot,
            sensors: sensors.map(|(slot, at)| marker(slot, *at)).collect(),
        }
    }
}

fn name_of(id: Option<i64>) -> String {
    id.map_or_else(|| "geometry".to_owned(), |id| format!("geometry {id}"))
}

/// The number of a geometry of this name, if it is such a name.
pub(super) fn id_of(name: &str) -> Option<i64> {
    let id = name.strip_prefix("geometry ")?.parse().ok();
    id.filter(|id| name_of(Some(*id)) == name)
}

/// The marker of a slot, counted from 0.
pub(super) fn marker(slot: usize, position_in_body: Point3<f64>) -> Sensor {
    Sensor::new(format!("marker {}", slot + 1), position_in_body, SensorOrientation::Marker)
}
