//! Fields as VTK image data (`*.vti`) for ParaView: tracker frame, mm.
//!
//! VTK's XML format, version 1.0, with raw appended data: each array is its length in bytes, 64 bits,
//! and little-endian numbers.

use super::nrrd::first_point;
use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_simulation::field_lattice::{Displacement, FieldLattice};

/// Writes displacements with their lengths, angles where there are any, and what lies outside.
pub fn write(out: &mut dyn Write, field: &FieldLattice) -> io::Result<()> {
    let plan = &field.plan;
    let points = field.displacement_mm.len() as u64;
    let origin = first_point(field);
    let list = |values: [f64; 3]| values.map(shortest).join(" ");
    let extent = plan.counts.map(|n| format!("0 {}", n.max(1) - 1)).join(" ");
    let [vectors, lengths, angles] = names(plan.displacement);
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <!-- {} -->\n\
         <VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">\n\
         <Piece Extent=\"{extent}\">\n\
         <PointData Vectors=\"{vectors}\" Scalars=\"{lengths}\">",
        plan.meaning(),
        list(origin.coords.into()),
        list(plan.step_mm()),
    )?;
    let mut offset = 0;
    let mut announce = |name: &str, kind: &str, components: u64, bytes: u64| {
        let line = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             format=\"appended\" offset=\"{offset}\"/>"
        );
        offset += 8 + points * components * bytes;
        line
    };
    writeln!(out, "{}", announce(vectors, "Float64", 3, 8))?;
    writeln!(out, "{}", announce(lengths, "Float64", 1, 8))?;
    if field.angle_rad.is_some() {
        writeln!(out, "{}", announce(angles, "Float64", 1, 8))?;
    }
    writeln!(out, "{}", announce("outside", "UInt8", 1, 1))?;
    write!(
        out,
        "</PointData>\n<CellData/>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_"
    )?;
    let begin = |out: &mut dyn Write, bytes: u64| out.write_all(&(points * bytes).to_le_bytes());
    begin(out, 24)?;
    for value in field.displacement_mm.iter().flatten() {
        out.write_all(&value.to_le_bytes())?;
    }
    begin(out, 8)?;
    for vector in &field.displacement_mm {
        out.write_all(&vector.norm().to_le_bytes())?;
    }
    if let Some(angles) = &field.angle_rad {
        begin(out, 8)?;
        for angle in angles {
            out.write_all(&angle.to_degrees().to_le_bytes())?;
        }
    }
    begin(out, 1)?;
    for &is_outside in &field.is_outside {
        out.write_all(&[u8::from(is_outside)])?;
    }
    writeln!(out, "\n</AppendedData>\n</VTKFile>")
}

/// Of vectors, lengths and angles.
pub(super) fn names(displacement: Displacement) -> [&'static str; 3] {
    match displacement {
        Displacement::Error => ["error_mm", "error_magnitude_mm", "error_angle_deg"],
        Displacement::Correction => {
            ["correction_mm", "correction_magnitude_mm", "correction_angle_deg"]
        }
    }
}
