//! Files for other programs: fields, points and transforms for 3D Slicer and ParaView.

pub mod field_table;
pub mod itk_transform;
pub mod markups;
pub mod mha;
pub mod nrrd;
mod patient_axes;
#[cfg(test)]
mod tests;
pub mod tips_table;
pub mod vti;

pub use patient_axes::PatientAxes;
