//! Displacement fields as MetaImage (`*.mha`), which 3D Slicer and ITK read as grid transforms.
//!
//! The rows of `TransformMatrix` are the directions of the lattice's axes in LPS, and `Offset` is the
//! centre of the first point.

use super::nrrd::{first_point, write_vectors};
use super::patient_axes::PatientAxes;
use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_simulation::field_lattice::FieldLattice;

/// Writes a field in LPS, mm, 64-bit numbers.
pub fn write(out: &mut dyn Write, field: &FieldLattice, axes: PatientAxes) -> io::Result<()> {
    let plan = &field.plan;
    let [nx, ny, nz] = plan.counts;
    let list = |values: [f64; 3]| values.map(|v| shortest(v + 0.0)).join(" ");
    let [x, y, z] = axes.signs().map(shortest);
    write!(
        out,
        "ObjectType = Image\n\
         NDims = 3\n\
         Comment = {}\n\
         BinaryData = True\n\
         BinaryDataByteOrderMSB = False\n\
         CompressedData = False\n\
         TransformMatrix = {x} 0 0 0 {y} 0 0 0 {z}\n\
         Offset = {}\n\
         CenterOfRotation = 0 0 0\n\
         ElementSpacing = {}\n\
         DimSize = {nx} {ny} {nz}\n\
         ElementNumberOfChannels = 3\n\
         ElementType = MET_DOUBLE\n\
         ElementDataFile = LOCAL\n",
        plan.meaning(),
        list(axes.lps_point(&first_point(field))),
        list(plan.step_mm()),
    )?;
    write_vectors(out, field, axes)
}
