//! A sphere among other bodies: what it answers to the field on its surface, as multipoles.
//!
//! With lengths in radii the incident potential is a sum of `R_l^m`, the answer of `S_l^m`:
//! `R_l^m = r^l P_l^m e^{imφ} / (l + m)!`, `S_l^m = (l − m)! P_l^m e^{imφ} / r^{l+1}`, Legendre functions
//! without the sign `(−1)^m`. Derivatives of `S` are those of one order more (Hobson, The Theory of
//! Spherical and Ellipsoidal Harmonics, 1931):
//! `∂z S_l^m = −S_{l+1}^m`, `(∂x + i ∂y) S_l^m = −S_{l+1}^{m+1}`, `(∂x − i ∂y) S_l^m = S_{l+1}^{m−1}`.

use super::response::SphereResponse;
use super::rule::spherical_rule;
use crate::phase::InPhaseAndLag;
use faer::Mat;
use nalgebra::{Complex, Point3, Unit, Vector3};
use std::f64::consts::PI;

/// Highest degree: `S` of it reaches 10²⁰⁰ near the sphere, and a source one ninth of the radius off
/// it leaves 1 % of the last term's part.
pub const MAX_DEGREE: usize = 40;

/// Lowest degree that is used.
pub const MIN_DEGREE: usize = 6;

/// What the first term left out may be, on the sphere's surface and relative to the first.
const LEFT_OUT: f64 = 1e-7;

/// A sphere that answers the normal field on its surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereBody {
    radius_mm: f64,
    degree: usize,
    directions: Vec<Unit<Vector3<f64>>>,
    /// Moments, two a term for `m > 0`, from the outward field at the directions.
    answer: InPhaseAndLag,
}

/// The degree at which sources at this distance from the middle are answered to 10⁻⁷, within
/// [`MIN_DEGREE`] to [`MAX_DEGREE`].
pub fn degree_for(radius_mm: f64, nearest_mm: f64) -> usize {
    let degree = LEFT_OUT.ln() / (radius_mm / nearest_mm).ln();
    match degree > 0.0 && degree < MAX_DEGREE as f64 {
        true => (degree.ceil() as usize).max(MIN_DEGREE),
        false => MAX_DEGREE,
    }
}

impl SphereBody {
    /// A sphere whose answer has terms up to `degree`, at most [`MAX_DEGREE`].
    pub fn new(response: &SphereResponse, degree: usize) -> Self {
        let degree = degree.clamp(1, MAX_DEGREE);
        let radius_mm = response.radius_mm();
        let rule = spherical_rule(2 * degree);
        let count = (terms(degree), rule.len());
        let [mut in_phase, mut lag] = [Mat::zeros(count.0, count.1), Mat::zeros(count.0, count.1)];
        for (sample, (direction, weight)) in rule.iter().enumerate() {
            let values = regular(degree, direction);
            let mut row = 0;
            for l in 1..=degree {
                // R² over the sphere is 2π (1 + δ) / ((2l + 1) (l + m)! (l − m)!), and R r^{−2l−1} is
                // S / ((l + m)! (l − m)!): the factorials cancel.
                let by = -radius_mm * weight * (2 * l + 1) as f64 / (2.0 * PI * l as f64);
                let ratio = response.complex_ratio(l) * by;
                for m in 0..=l {
                    let value = values[index(l, m)];
                    for (answer, ratio) in [(&mut in_phase, ratio.re), (&mut lag, ratio.im)] {
                        if m == 0 {
                            answer[(row, sample)] = 0.5 * value.re * ratio;
                        } else {
                            answer[(row, sample)] = value.re * ratio;
                            answer[(row + 1, sample)] = value.im * ratio;
                        }
                    }
                    row += if m == 0 { 1 } else { 2 };
                }
            }
        }
        let directions = rule.into_iter().map(|(direction, _)| direction).collect();
        Self { radius_mm, degree, directions, answer: InPhaseAndLag { in_phase, lag } }
    }

    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Directions from the middle in which the outward field on the surface is needed.
    pub fn directions(&self) -> &[Unit<Vector3<f64>>] {
        &self.directions
    }

    /// From the outward field at the directions: multipole moments.
    pub(crate) fn answer(&self) -> &InPhaseAndLag {
        &self.answer
    }

    /// How many moments there are.
    pub fn terms(&self) -> usize {
        terms(self.degree)
    }

    /// Calls `each` with the number of every moment and the field that a unit of it has at a point
    /// outside, from the sphere's middle.
    pub fn for_fields(&self, p: &Point3<f64>, mut each: impl FnMut(usize, Vector3<f64>)) {
        let values = irregular(self.degree + 1, &(p.coords / self.radius_mm));
        let i = Complex::new(0.0, 1.0);
        let scale = -1.0 / self.radius_mm;
        let mut row = 0;
        for l in 1..=self.degree {
            for m in 0..=l {
                let up = -values[index(l + 1, m + 1)];
                let down = match m {
                    0 => up.conj(),
                    _ => values[index(l + 1, m - 1)],
                };
                let [x, y] = [(up + down) * 0.5, i * (down - up) * 0.5];
                let z = -values[index(l + 1, m)];
                each(row, Vector3::new(x.re, y.re, z.re) * scale);
                row += 1;
                if m > 0 {
                    each(row, Vector3::new(x.im, y.im, z.im) * scale);
                    row += 1;
                }
            }
        }
    }

    /// Adds the fields of moments at a point outside, from the sphere's middle; one field a coil.
    ///
    /// `moments` has a row a moment and a column a coil.
    ///
    /// # Panics
    /// If the moments are not those of this sphere, or `fields` are not one a column.
    pub fn add_fields(&self, moments: &Mat<f64>, p: &Point3<f64>, fields: &mut [Vector3<f64>]) {
        assert_eq!((moments.nrows(), moments.ncols()), (self.terms(), fields.len()));
        self.for_fields(p, |moment, field| {
            for (coil, sum) in fields.iter_mut().enumerate() {
                *sum += field * moments[(moment, coil)];
            }
        });
    }
}

const fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 1) - 1
}

const fn index(l: usize, m: usize) -> usize {
    l * (l + 1) / 2 + m
}

/// `R_l^m` up to a degree on the unit sphere.
fn regular(degree: usize, x: &Vector3<f64>) -> Vec<Complex<f64>> {
    let mut values = vec![Complex::new(0.0, 0.0); index(degree + 1, 0)];
    let across = Complex::new(x.x, x.y);
    values[0] = Complex::new(1.0, 0.0);
    for l in 1..=degree {
        for m in 0..l {
            let before = if l >= m + 2 { values[index(l - 2, m)] } else { Complex::new(0.0, 0.0) };
            let next = values[index(l - 1, m)] * ((2 * l - 1) as f64 * x.z) - before;
            values[index(l, m)] = next / ((l * l - m * m) as f64);
        }
        values[index(l, l)] = values[index(l - 1, l - 1)] * across / (2 * l) as f64;
    }
    values
}

/// `S_l^m` up to a degree.
fn irregular(degree: usize, x: &Vector3<f64>) -> Vec<Complex<f64>> {
    let mut values = vec![Complex::new(0.0, 0.0); index(degree + 1, 0)];
    let inverse2 = 1.0 / x.norm_squared();
    let across = Complex::new(x.x, x.y) * inverse2;
    values[0] = Complex::new(inverse2.sqrt(), 0.0);
    for l in 1..=degree {
        for m in 0..l {
            let mut next = values[index(l - 1, m)] * ((2 * l - 1) as f64 * x.z);
            if l >= m + 2 {
                next -= values[index(l - 2, m)] * (((l - 1) * (l - 1) - m * m) as f64);
            }
            values[index(l, m)] = next * inverse2;
        }
        values[index(l, l)] = values[index(l - 1, l - 1)] * across * (2 * l - 1) as f64;
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use trackwright_field::generator::dipole::Dipole;

    #[test]
    fn moments_have_the_fields_of_the_series() {
        let iron = Material::new(5e6, 200.0).unwrap();
        let at = Point3::new(-20.0, 120.0, 60.0);
        let dipole = Dipole::new(&at, &Vector3::new(0.7, -0.2, 0.5));
        for response in [
            SphereResponse::perfect_conductor(60.0).unwrap(),
            SphereResponse::new(60.0, &iron, 1e3).unwrap(),
        ] {
            let mut errors = Vec::new();
            for degree in [10, 20, 40] {
                let body = SphereBody::new(&response, degree);
                let normal_field = Mat::from_fn(body.directions().len(), 1, |k, _| {
                    let direction = &body.directions()[k];
                    let p = Point3::from(direction.into_inner() * 60.0);
                    dipole.field(&p).dot(direction)
                });
                let moments = body.answer().in_phase_of(&normal_field);
                let p = Point3::new(10.0, -70.0, 45.0);
                let mut field = [Vector3::zeros()];
                body.add_fields(&moments, &p, &mut field);
                let moment = Vector3::new(0.7, -0.2, 0.5);
                let expected = response.field_of_dipole(&at, &moment, &p).unwrap().field;
                errors.push((field[0] - expected).norm() / expected.norm());
            }
            // (a²/(r c))^degree, times the degree's square: 0.315^10, ^20, ^40.
            assert!(errors[0] < 3e-3 && errors[1] < 4e-8 && errors[2] < 1e-12, "{errors:?}");
        }
    }

    #[test]
    fn fields_of_moments_are_gradients() {
        let body = SphereBody::new(&SphereResponse::perfect_conductor(2.0).unwrap(), 5);
        let p = Point3::new(2.2, -1.1, 1.9);
        let h = 1e-5;
        let potential = |p: Point3<f64>| {
            let values = irregular(5, &(p.coords / 2.0));
            let mut all = Vec::new();
            for l in 1..=5 {
                for m in 0..=l {
                    all.push(values[index(l, m)].re);
                    if m > 0 {
                        all.push(values[index(l, m)].im);
                    }
                }
            }
            all
        };
        let mut fields = vec![Vector3::zeros(); body.terms()];
        body.for_fields(&p, |row, field| fields[row] = field);
        for axis in 0..3 {
            let step = Vector3::ith(axis, h);
            let (plus, minus) = (potential(p + step), potential(p - step));
            for (row, field) in fields.iter().enumerate() {
                let slope = (plus[row] - minus[row]) / (2.0 * h);
                assert!((field[axis] + slope).abs() < 1e-7 * field.norm(), "{row} {axis}");
            }
        }
    }

    #[test]
    fn degrees_grow_towards_the_surface() {
        assert_eq!(degree_for(10.0, 1000.0), MIN_DEGREE);
        assert_eq!(degree_for(10.0, 20.0), 24);
        assert_eq!(degree_for(10.0, 10.1), MAX_DEGREE);
        assert_eq!(degree_for(10.0, 9.0), MAX_DEGREE);
    }
}
