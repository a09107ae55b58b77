//! What metal does to the field of a tracker's coils, quasi-static and coil by coil.

pub mod material;
pub mod panel;
pub mod shapes;
pub mod sphere;

#[cfg(test)]
mod tests;
