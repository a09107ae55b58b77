//! Three-component vectors in millimetres: the little algebra that mesh making needs.

use std::ops::{Add, Mul, Neg, Sub};

/// A point or direction in a body frame; lengths are millimetres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// Shorthand for a [`Vec3`], because the tables of coordinates should read as tables.
pub const fn vec3(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    pub const X: Self = vec3(1.0, 0.0, 0.0);
    pub const Y: Self = vec3(0.0, 1.0, 0.0);
    pub const Z: Self = vec3(0.0, 0.0, 1.0);

    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub fn cross(self, other: Self) -> Self {
        vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The direction of a vector that is not zero; zero stays zero.
    pub fn normalized(self) -> Self {
        let length = self.length();
        if length > 0.0 { self * (1.0 / length) } else { self }
    }

    /// Component by component product.
    pub fn scaled(self, factors: Self) -> Self {
        vec3(self.x * factors.x, self.y * factors.y, self.z * factors.z)
    }

    /// The point a fraction `t` of the way to `other`.
    pub fn lerp(self, other: Self, t: f64) -> Self {
        self + (other - self) * t
    }

    pub fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        vec3(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        vec3(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        vec3(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
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
        let x_axis = (x_hint - z_axis * x_hint.dot(z_axis)).normalized();
        Self { origin, x_axis, y_axis: z_axis.cross(x_axis), z_axis }
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
        vec3(offset.dot(self.x_axis), offset.dot(self.y_axis), offset.dot(self.z_axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placement_is_right_handed_and_inverts() {
        let placement = Placement::new(vec3(1.0, 2.0, 3.0), vec3(1.0, 1.0, 0.2), Vec3::Z);
        assert!((placement.x_axis.cross(placement.y_axis) - placement.z_axis).length() < 1e-12);
        let point = vec3(4.0, -5.0, 6.0);
        let back = placement.part_from_body(placement.body_from_part(point));
        assert!((back - point).length() < 1e-12);
    }
}
