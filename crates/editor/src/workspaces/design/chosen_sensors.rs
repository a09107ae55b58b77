//! The sensors that are selected, and the edit that changes all of them.

use trackwright_design::{BodyRole, Design, Edit};
use trackwright_simulation::{Sensor, SensorOrientation};

/// Numbers that differ by less are the same: what moving to and fro leaves.
const SAME: f64 = 1e-9;

/// The selected sensors of a body, in its order.
pub struct ChosenSensors<'a> {
    body: BodyRole,
    sensors: Vec<(usize, &'a Sensor)>,
}

impl<'a> ChosenSensors<'a> {
    /// Those of a body that are at these places; `None` where there is none.
    pub fn new(design: &'a Design, body: BodyRole, indices: &[usize]) -> Option<Self> {
        let all = &design.body(body)?.rigid.sensors;
        let own = indices.iter().filter_map(|index| Some((*index, all.get(*index)?)));
        let sensors: Vec<_> = own.collect();
        (!sensors.is_empty()).then_some(Self { body, sensors })
    }

    /// The one that is selected alone.
    pub fn single(&self) -> Option<(usize, &'a Sensor)> {
        match self.sensors[..] {
            [single] => Some(single),
            _ => None,
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.sensors.len()
    }

    /// What all of them have; `None` where it is mixed.
    pub fn common<T: PartialEq>(&self, of: impl Fn(&Sensor) -> T) -> Option<T> {
        let mut values = self.sensors.iter().map(|(_, sensor)| of(sensor));
        let first = values.next()?;
        values.all(|value| value == first).then_some(first)
    }

    /// The number that all of them have; `None` where it is mixed, or where one has none.
    pub fn common_number(&self, of: impl Fn(&Sensor) -> Option<f64>) -> Option<f64> {
        let mut values = self.sensors.iter().map(|(_, sensor)| of(sensor));
        let first = values.next()??;
        values.all(|value| value.is_some_and(|v| (v - first).abs() < SAME)).then_some(first)
    }

    /// Changes all of them in one step; `None` where one cannot be changed.
    pub fn edit(&self, change: impl Fn(&Sensor) -> Option<Sensor>) -> Option<Edit> {
        let body = self.body;
        if let Some((index, sensor)) = self.single() {
            return Some(Edit::SetSensor { body, index, sensor: change(sensor)? });
        }
        let changed = self.sensors.iter().map(|(index, sensor)| Some((*index, change(sensor)?)));
        let sensors: Option<Vec<(usize, Sensor)>> = changed.collect();
        Some(Edit::SetSensors { body, sensors: sensors? })
    }

    /// Changes how all of them are turned, in one step.
    pub fn edit_orientation(
        &self,
        change: impl Fn(&SensorOrientation) -> Option<SensorOrientation>,
    ) -> Option<Edit> {
        self.edit(|sensor| {
            Some(Sensor { orientation: change(&sensor.orientation)?, ..sensor.clone() })
        })
    }

    /// What they are called in the label of a step.
    pub fn name(&self) -> String {
        match self.single() {
            Some((_, sensor)) => format!("sensor {}", sensor.name),
            None => format!("{} sensors", self.count()),
        }
    }
}
