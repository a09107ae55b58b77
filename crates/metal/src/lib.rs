//! What metal does to the field of a tracker's coils, quasi-static and coil by coil.

pub mod boundary;
mod crossing;
pub mod material;
pub mod panel;
pub mod shapes;
pub mod sphere;
pub mod surface;

#[cfg(test)]
mod tests;
