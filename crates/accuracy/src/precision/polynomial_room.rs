//! A room whose model is no polynomial, fitted again with polynomials: the only field that is known to higher
//! precision.

use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_field::computed::ModelKind;
use trackwright_field::fit::{FitSettings, fit_with};
use trackwright_field::gaussian::Trend;
use trackwright_field::model::OutsidePolicy;
use trackwright_field::samples::{PoseError, Sample, SampleSet};
use trackwright_geometry::directions::DirectionSet;
use trackwright_simulation::Scenario;
use trackwright_task::{CancelToken, Task};

const ORDER: usize = 2;
const DIRECTIONS: DirectionSet = DirectionSet::FortyTwo;

/// The design in its room, or in polynomials fitted to the measurements that the room keeps.
pub(super) fn in_polynomials(scenario: &Scenario, cancel: &CancelToken) -> Scenario {
    let room = &scenario.environment;
    if room.model.kind() == ModelKind::Bernstein || room.metal.is_some() {
        return scenario.clone();
    }
    let settings = FitSettings { map: room.model.map(), ..FitSettings::new(ORDER, DIRECTIONS) };
    let task = Task::cancelled_by(cancel.clone());
    let fitted = measured(room).and_then(|samples| fit_with(&samples, &settings, None, &task).ok());
    let Some(fitted) = fitted else { return scenario.clone() };
    let name = format!(
        "{} as polynomials of order {ORDER} with {} orientations",
        room.name,
        DIRECTIONS.len()
    );
    let environment = Environment {
        name,
        model: fitted.model,
        fit_validity: None,
        process: None,
        ..Environment::clone(room)
    };
    Scenario { environment: Arc::new(environment), ..scenario.clone() }
}

/// The measurements that a room keeps.
fn measured(room: &Environment) -> Option<SampleSet> {
    let process = room.process.as_ref()?;
    let each = process.rows.iter().map(|row| {
        let left = PoseError::of_values(row.error);
        let given = match process.trend {
            Trend::None => PoseError::default(),
            Trend::Model => room.model.evaluate_point(&row.point, OutsidePolicy::Clamp).error,
        };
        let error = PoseError {
            position_mm: left.position_mm + given.position_mm,
            rotation_rad: left.rotation_rad + given.rotation_rad,
        };
        Sample {
            x_axis: row.point.x_axis,
            ..Sample::new(row.point.position_mm, row.point.axis, error)
        }
    });
    Some(SampleSet { samples: each.collect(), has_rotations: process.has_rotations, ambiguous: 0 })
}
