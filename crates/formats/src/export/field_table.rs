//! Sampled fields as a table (`*.csv`): tracker frame, mm and degrees.

use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_simulation::field_lattice::{Displacement, FieldLattice};

/// Writes a row a point, x fastest; where there is no answer cells are empty.
pub fn write(out: &mut dyn Write, field: &FieldLattice) -> io::Result<()> {
    let what = match field.plan.displacement {
        Displacement::Error => "error",
        Displacement::Correction => "correction",
    };
    write!(out, "x,y,z,{what}_x,{what}_y,{what}_z,{what}_mm")?;
    if field.angle_rad.is_some() {
        write!(out, ",{what}_deg")?;
    }
    writeln!(out, ",outside")?;
    let cell = |value: f64| match value.is_finite() {
        true => shortest(value),
        false => String::new(),
    };
    for (i, (at, vector)) in field.points().zip(&field.displacement_mm).enumerate() {
        let [x, y, z] = [at.x, at.y, at.z].map(shortest);
        let [ex, ey, ez] = [vector.x, vector.y, vector.z].map(cell);
        write!(out, "{x},{y},{z},{ex},{ey},{ez},{}", cell(vector.norm()))?;
        if let Some(angles) = &field.angle_rad {
            write!(out, ",{}", cell(angles[i].to_degrees()))?;
        }
        writeln!(out, ",{}", u8::from(field.is_outside[i]))?;
    }
    Ok(())
}
