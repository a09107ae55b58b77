//! Vectors in millimetres, and where parts stand.

use nalgebra::Vector3;

/// A point or direction in a body frame; lengths are millimetres.
pub type Vec3 = Vector3<f64>;

/// Shorthand for a [`Vec3`], because the tables of coordinates should read as tables.
pub const fn vec3(x: f64, y: f64, z: f64) -> Vec3 {
    Vector3::new(x, y, z)
}

/// What mesh making needs besides.
pub trait VecExt {
    /// The direction of a vector that is not zero; zero stays zero.
    fn normalized(self) -> Self;

    /// The point a fraction `t` of the way to `other`.
    fn between(self, other: Self, t: f64) -> Self;

    fn to_array(self) -> [f64; 3];
}

impl VecExt for Vec3 {
    fn normalized(self) -> Self {
        let length = self.norm();
        if length > 0.0 { self * (1.0 / length) } else { self }
    }

    fn between(self, other: Self, t: f64) -> Self {
        self + (other - self) * t
    }

    fn to_array(self) -> [f64; 3] {
        self.into()
    }
}

/// Where a part made along its own +z axis stands in its body: an origin and three unit axes.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    pub origin: Vec3,
    pub x_axis: Vec3,
    pub y_axis: Vec3,
    pub z_axis: Vec3,
}

impl Placement {
    /// Own +z towards `z_axis`, own +x as near to `x_hint` as a right angle allows.
    pub fn new(origin: Vec3, z_axis: Vec3, x_hint: Vec3) -> Self {
        let z_axis = z_axis.normalized();
        let x_axis = (x_hint - z_axis * x_hint.dot(&z_axis)).normalized();
        Self { origin, x_axis, y_axis: z_axis.cross(&x_axis), z_axis }
    }

    pub fn body_from_part(&self, point_in_part: Vec3) -> Vec3 {
        self.origin
            + self.x_axis * point_in_part.x
            + self.y_axis * point_in_part.y
            + self.z_axis * point_in_part.z
    }

    /// Coordinates of a body point along this placement's axes.
    pub fn part_from_body(&self, point_in_body: Vec3) -> Vec3 {
        let offset = point_in_body - self.origin;
        vec3(offset.dot(&self.x_axis), offset.dot(&self.y_axis), offset.dot(&self.z_axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placement_is_right_handed_and_inverts() {
        let placement = Placement::new(vec3(1.0, 2.0, 3.0), vec3(1.0, 1.0, 0.2), Vec3::z());
        assert!((placement.x_axis.cross(&placement.y_axis) - placement.z_axis).norm() < 1e-12);
        let point = vec3(4.0, -5.0, 6.0);
        let back = placement.part_from_body(placement.body_from_part(point));
        assert!((back - point).norm() < 1e-12);
    }
}
