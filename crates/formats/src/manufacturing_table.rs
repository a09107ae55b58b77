//! A manufacturing sheet as a table: one row a sensor.

use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_simulation::tolerance::{
    ManufacturingSheet, SheetBody, SheetSensor, Tolerance, Tolerances,
};

/// The table's columns, in order. Lengths are in mm and angles in degrees; cells of what does not
/// apply are empty.
pub const HEADER: &str = "role,body,sensor,kind,x,y,z,from_tip_x,from_tip_y,from_tip_z,from_tip_mm,\
    axis_x,axis_y,axis_z,axis_polar_deg,axis_azimuth_deg,qw,qx,qy,qz,coil_diameter_mm,coil_length_mm,\
    alone_position_mm,alone_position_limited_by,alone_angle_deg,alone_angle_limited_by,\
    together_position_mm,together_position_limited_by,together_angle_deg,together_angle_limited_by";

/// Writes the sheet's sensors, the tool's first.
pub fn write(out: &mut dyn Write, sheet: &ManufacturingSheet) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(HEADER.split(','))?;
    for body in &sheet.bodies {
        for sensor in &body.sensors {
            table.write_record(row(body, sensor))?;
        }
    }
    table.flush()
}

fn row(body: &SheetBody, sensor: &SheetSensor) -> Vec<String> {
    let role = serde_json::to_value(body.role).ok();
    let role = role.as_ref().and_then(|role| role.as_str());
    let mut row = vec![
        role.unwrap_or_default().to_owned(),
        body.name.clone(),
        sensor.name.clone(),
        sensor.kind.to_owned(),
    ];
    let mut numbers = |values: &[Option<f64>]| {
        let cells = values.iter().map(|v| v.map(shortest).unwrap_or_default());
        row.extend(cells);
    };
    numbers(&sensor.position_in_body_mm.map(Some));
    numbers(&each(sensor.position_from_tip_mm));
    numbers(&[sensor.distance_from_tip_mm]);
    numbers(&each(sensor.axis.map(|a| a.direction)));
    numbers(&[sensor.axis.map(|a| a.polar_deg), sensor.axis.and_then(|a| a.azimuth_deg)]);
    numbers(&each(sensor.rotation));
    let coil = sensor.coil;
    numbers(&[coil.map(|c| c.diameter_mm), coil.map(|c| c.length_mm)]);
    row.extend(tolerances(sensor.alone.as_ref()));
    row.extend(tolerances(body.together.as_ref()));
    row
}

fn each<const N: usize>(values: Option<[f64; N]>) -> [Option<f64>; N] {
    values.map_or([None; N], |values| values.map(Some))
}

fn tolerances(found: Option<&Tolerances>) -> [String; 4] {
    let of = |tolerance: Option<&Tolerance>| {
        let within = tolerance.and_then(Tolerance::within);
        let bound = within.and_then(|w| w.limited_by);
        [
            within.map(|w| shortest(w.value)).unwrap_or_default(),
            bound.map(|c| c.metric.name().to_owned()).unwrap_or_default(),
        ]
    };
    let [a, b] = of(found.map(|t| &t.position_mm));
    let [c, d] = of(found.map(|t| &t.angle_deg));
    [a, b, c, d]
}
