//! Distances and angles between the sensors of a body: what a person knows it by.

use super::body::Sensor;

/// Two sensors by their indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorPair {
    pub a: usize,
    pub b: usize,
    pub distance_mm: f64,
    /// Between their axes, 0 to π; `None` where one of them has none.
    pub angle_rad: Option<f64>,
}

/// Every pair once, the lower index first.
pub fn sensor_pairs(sensors: &[Sensor]) -> impl Iterator<Item = SensorPair> {
    let count = sensors.len();
    let indices = (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)));
    indices.map(|(a, b)| {
        let (first, second) = (&sensors[a], &sensors[b]);
        let axes = first.axis_in_body().zip(second.axis_in_body());
        SensorPair {
            a,
            b,
            distance_mm: (second.position_in_body - first.position_in_body).norm(),
            // Not by the arc cosine alone, which cannot resolve small angles.
            angle_rad: axes.map(|(u, v)| u.cross(&v).norm().atan2(u.dot(&v))),
        }
    })
}
