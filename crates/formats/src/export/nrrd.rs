//! Displacement fields as NRRD (`*.nrrd`), which 3D Slicer and ITK read as grid transforms.
//!
//! Format: teem's definition of NRRD, version 5. The vector comes first of four dimensions, and the
//! origin is the centre of the first point.

use super::patient_axes::PatientAxes;
use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_simulation::field_lattice::FieldLattice;

/// Writes a field in LPS, mm, 64-bit numbers.
pub fn write(out: &mut dyn Write, field: &FieldLattice, axes: PatientAxes) -> io::Result<()> {
    let plan = &field.plan;
    let [nx, ny, nz] = plan.counts;
    let (signs, steps) = (axes.signs(), plan.step_mm());
    let list = |values: [f64; 3]| values.map(|v| shortest(v + 0.0)).join(",");
    let along = |k: usize| {
        let mut direction = [0.0; 3];
        direction[k] = signs[k] * steps[k];
        list(direction)
    };
    let origin = list(axes.lps_point(&first_point(field)));
    write!(
        out,
        "NRRD0005\n\
         # Displacements of an electromagnetic tracker's readings\n\
         type: double\n\
         dimension: 4\n\
         space: left-posterior-superior\n\
         sizes: 3 {nx} {ny} {nz}\n\
         space directions: none ({}) ({}) ({})\n\
         centers: ??? node node node\n\
         kinds: vector domain domain domain\n\
         endian: little\n\
         encoding: raw\n\
         space units: \"mm\" \"mm\" \"mm\"\n\
         space origin: ({origin})\n\
         meaning:={}\n\n",
        along(0),
        along(1),
        along(2),
        plan.meaning(),
    )?;
    write_vectors(out, field, axes)
}

/// Where the lattice begins.
pub(super) fn first_point(field: &FieldLattice) -> nalgebra::Point3<f64> {
    field.points().next().unwrap_or(field.plan.bounds.min_mm)
}

/// Every vector in LPS, little-endian.
pub(super) fn write_vectors(
    out: &mut dyn Write,
    field: &FieldLattice,
    axes: PatientAxes,
) -> io::Result<()> {
    for vector in &field.displacement_mm {
        for value in axes.lps(vector) {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    Ok(())
}
