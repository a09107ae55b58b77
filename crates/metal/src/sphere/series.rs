//! The field that a sphere adds beside a dipole, by its whole multipole series.
//!
//! A dipole `m` at `c` has the potential `m·∇_c 1/|r − c|`. Its order `n` inside `|r| < |c|` is
//! answered by `g_n a^{2n+1}`, so that with `t = a²/(|r| |c|)` and `x = cos(r, c)`
//!
//! `B₁(r) = −∇_r (m·∇_c) (1/a) Σ_{n≥1} g_n t^{n+1} P_n(x)`,
//!
//! which is symmetric in source and point (reciprocity). The derivatives are taken term by term.

use super::response::{MAX_ORDER, SphereResponse};
use nalgebra::{Point3, Vector3};

/// The series ends where what is left out is below this part of the field: round-off.
const TAIL: f64 = 1e-15;

/// The field of a series, and how it ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeriesField {
    /// In the unit of the dipole's moment over mm³.
    pub field: Vector3<f64>,
    /// Orders summed.
    pub orders: usize,
    /// Bound on the norm of what the orders left out would add.
    pub tail_bound: f64,
}

/// Why there is no field.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SeriesError {
    #[error("a position or moment is not finite")]
    NotFinite,
    #[error("the dipole is {distance_mm} mm from the sphere's middle, within its {radius_mm} mm")]
    DipoleInside { distance_mm: f64, radius_mm: f64 },
    #[error("the point is {distance_mm} mm from the sphere's middle, within its {radius_mm} mm")]
    PointInside { distance_mm: f64, radius_mm: f64 },
    #[error(
        "the series did not converge: up to {tail_bound:.1e} of a field of {field:.1e} is left after {orders} orders"
    )]
    NoConvergence { orders: usize, field: f64, tail_bound: f64 },
}

impl SphereResponse {
    /// The field that this sphere, about the origin, adds at a point to that of a dipole.
    ///
    /// Summed until a bound on the rest is below 1e-15 of the field. The bound: `|P_n| ≤ 1`,
    /// `|P_n'| ≤ n (n + 1)/2`, `|P_n''| ≤ (n − 1) n (n + 1) (n + 2)/8` and `|g_n| ≤ 1` make the
    /// order `n` of the field at most `|m| t^{n+1} (n + 1)⁴ / (a |r| |c|)`, and from where these
    /// fall their sum is that of a geometric series.
    ///
    /// # Errors
    /// A dipole or point in the sphere or on it, values that are not finite, and a source and point
    /// both so near to the sphere that [`MAX_ORDER`] orders do not suffice.
    ///
    /// ```
    /// use nalgebra::{Point3, Vector3};
    /// use trackwright_metal::sphere::SphereResponse;
    ///
    /// let sphere = SphereResponse::perfect_conductor(60.0)?;
    /// let (at, moment) = (Point3::new(0.0, 90.0, 30.0), Vector3::new(1.0, 0.2, -0.5));
    /// let added = sphere.field_of_dipole(&at, &moment, &Point3::new(0.0, -70.0, 40.0))?;
    /// assert!((added.field.x + 5.9196884574858736e-8).abs() < 1e-16);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn field_of_dipole(
        &self,
        dipole_at_mm: &Point3<f64>,
        moment: &Vector3<f64>,
        at_mm: &Point3<f64>,
    ) -> Result<SeriesField, SeriesError> {
        let radius_mm = self.radius_mm();
        let (point_distance, source_distance) = (at_mm.coords.norm(), dipole_at_mm.coords.norm());
        if !(point_distance.is_finite() && source_distance.is_finite() && moment.norm().is_finite())
        {
            return Err(SeriesError::NotFinite);
        }
        if source_distance <= radius_mm {
            return Err(SeriesError::DipoleInside { distance_mm: source_distance, radius_mm });
        }
        if point_distance <= radius_mm {
            return Err(SeriesError::PointInside { distance_mm: point_distance, radius_mm });
        }
        let geometry = Geometry {
            r: at_mm.coords / point_distance,
            c: dipole_at_mm.coords / source_distance,
            moment: *moment,
        };
        let t = (radius_mm / point_distance) * (radius_mm / source_distance);
        let unit = 1.0 / (radius_mm * point_distance * source_distance);
        let mut sums = Sums::default();
        let mut legendre = Legendre::first(geometry.cosine());
        let mut power = t * t;
        for order in 1..=MAX_ORDER {
            sums.add(order, self.ratio(order) * power, &legendre);
            power *= t;
            // The next order's bound, and how bounds fall from there.
            let next = (order + 2) as f64;
            let bound = power * next.powi(4);
            let fall = t * ((next + 1.0) / next).powi(4);
            if fall < 1.0 {
                let tail_bound = moment.norm() * bound / (1.0 - fall) * unit;
                let field = geometry.field(&sums) * unit;
                if tail_bound <= TAIL * field.norm() || bound < f64::MIN_POSITIVE {
                    return Ok(SeriesField { field, orders: order, tail_bound });
                }
                if order == MAX_ORDER {
                    let field = field.norm();
                    return Err(SeriesError::NoConvergence { orders: order, field, tail_bound });
                }
            }
            legendre.raise(order, geometry.cosine());
        }
        let field = geometry.field(&sums).norm() * unit;
        Err(SeriesError::NoConvergence { orders: MAX_ORDER, field, tail_bound: f64::INFINITY })
    }
}

/// `P_n`, `P_n'` and `P_n''` of two orders that follow each other.
struct Legendre {
    /// Of the order before.
    before: [f64; 3],
    now: [f64; 3],
}

impl Legendre {
    fn first(x: f64) -> Self {
        Self { before: [1.0, 0.0, 0.0], now: [x, 1.0, 0.0] }
    }

    /// From order `n` to the next: Bonnet's recurrence, and `P'_{n+1} = P'_{n−1} + (2n + 1) P_n` for
    /// the derivatives, which divides by nothing at `x = ±1`.
    fn raise(&mut self, n: usize, x: f64) {
        let (n, odd) = (n as f64, (2 * n + 1) as f64);
        let [p, slope, _] = self.now;
        let next = [
            (odd * x * p - n * self.before[0]) / (n + 1.0),
            self.before[1] + odd * p,
            self.before[2] + odd * slope,
        ];
        (self.before, self.now) = (self.now, next);
    }
}

/// `Σ g_n t^{n+1}` times …
#[derive(Default)]
struct Sums {
    /// … `(n + 1) P_n`
    value: f64,
    /// … `(n + 1)² P_n`
    radial: f64,
    /// … `P_n'`
    slope: f64,
    /// … `(n + 1) P_n'`
    radial_slope: f64,
    /// … `P_n''`
    curvature: f64,
}

impl Sums {
    fn add(&mut self, order: usize, factor: f64, legendre: &Legendre) {
        let above = (order + 1) as f64;
        let [p, slope, curvature] = legendre.now;
        self.value += factor * above * p;
        self.radial += factor * above * above * p;
        self.slope += factor * slope;
        self.radial_slope += factor * above * slope;
        self.curvature += factor * curvature;
    }
}

/// Directions of the point and of the dipole, and its moment.
struct Geometry {
    r: Vector3<f64>,
    c: Vector3<f64>,
    moment: Vector3<f64>,
}

impl Geometry {
    fn cosine(&self) -> f64 {
        self.r.dot(&self.c).clamp(-1.0, 1.0)
    }

    /// `−∇_r D |r| |c|`, `D |c| = −(m·ĉ) value + β slope`, `β = m·r̂ − x m·ĉ`: the chain rule with
    /// `|r| ∇_r ln t = −r̂` and `|r| ∇_r x = ĉ − x r̂`.
    fn field(&self, sums: &Sums) -> Vector3<f64> {
        let (r, c, m) = (&self.r, &self.c, &self.moment);
        let x = self.cosine();
        let (along_r, along_c) = (m.dot(r), m.dot(c));
        let across = c - r * x;
        let beta = along_r - x * along_c;
        let beta_slope = m - r * along_r - across * along_c;
        let radial = along_c * sums.radial - beta * sums.radial_slope;
        -(r * radial
            + across * (beta * sums.curvature - along_c * sums.radial_slope)
            + beta_slope * sums.slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use crate::tests::{physics, vector};

    fn permeable(radius_mm: f64, mu: f64) -> SphereResponse {
        SphereResponse::new(radius_mm, &Material::new(0.0, mu).unwrap(), 1e3).unwrap()
    }

    #[test]
    fn fields_beside_a_dipole_are_the_worked_ones() {
        let golden = physics();
        let cases = golden["sphere_beside_a_dipole"].as_array().unwrap();
        assert_eq!(cases.len(), 4);
        for case in cases {
            let radius_mm = case["radius_mm"].as_f64().unwrap();
            let sphere = match case["relative_permeability"].as_f64() {
                Some(mu) => permeable(radius_mm, mu),
                None => SphereResponse::perfect_conductor(radius_mm).unwrap(),
            };
            let found = sphere
                .field_of_dipole(
                    &vector(&case["dipole_at_mm"]).into(),
                    &vector(&case["dipole"]),
                    &vector(&case["at_mm"]).into(),
                )
                .unwrap();
            let worked = vector(&case["field"]);
            for axis in 0..3 {
                let error = (found.field[axis] - worked[axis]).abs();
                assert!(error <= 1e-9 * worked[axis].abs(), "{case} {found:?}");
            }
            assert!(found.tail_bound <= 1e-15 * worked.norm());
        }
    }

    #[test]
    fn source_and_receiver_can_be_exchanged() {
        let iron = Material::named("steel-416").unwrap();
        for sphere in [permeable(60.0, 100.0), SphereResponse::new(60.0, &iron, 2e3).unwrap()] {
            let (a, b) = (Point3::new(10.0, 61.0, 20.0), Point3::new(-3.0, 20.0, -66.0));
            let (m, n) = (Vector3::new(0.4, -1.0, 0.3), Vector3::new(-0.2, 0.5, 0.9));
            let there = sphere.field_of_dipole(&a, &m, &b).unwrap().field.dot(&n);
            let back = sphere.field_of_dipole(&b, &n, &a).unwrap().field.dot(&m);
            assert!((there - back).abs() < 1e-12 * there.abs(), "{there} {back}");
        }
    }

    #[test]
    fn a_far_dipole_induces_a_dipole() {
        let (sphere, mu) = (permeable(20.0, 50.0), 50.0);
        let moment = Vector3::new(1.0, 0.5, -0.3);
        let far = Point3::new(2e4, -1e4, 3e4);
        let at = Point3::new(90.0, 100.0, -60.0);
        let dipole = |r: Vector3<f64>, m: &Vector3<f64>| {
            let (unit, distance) = (r.normalize(), r.norm());
            (unit * (3.0 * m.dot(&unit)) - m) / distance.powi(3)
        };
        let incident = dipole(-far.coords, &moment);
        let expected = dipole(at.coords, &(incident * ((mu - 1.0) / (mu + 2.0) * 8000.0)));
        let found = sphere.field_of_dipole(&far, &moment, &at).unwrap().field;
        // The next order is a²/(r c) of the first: 7e-5.
        assert!((found - expected).norm() < 5e-4 * expected.norm());
    }

    #[test]
    fn no_flux_enters_a_conductor() {
        let sphere = SphereResponse::perfect_conductor(60.0).unwrap();
        let at = Point3::new(20.0, -65.0, 10.0);
        let moment = Vector3::new(0.3, 1.0, 0.2);
        for direction in [[0.0, -1.0, 0.0], [0.3, -0.7, 0.2], [0.0, 1.0, 0.1]] {
            let normal = Vector3::from(direction).normalize();
            let p = Point3::from(normal * (60.0 * (1.0 + 1e-12)));
            let added = sphere.field_of_dipole(&at, &moment, &p).unwrap().field;
            let r = p - at;
            let own = (r * (3.0 * moment.dot(&r) / r.norm_squared()) - moment) / r.norm().powi(3);
            assert!((own + added).dot(&normal).abs() < 1e-9 * own.norm());
        }
    }

    #[test]
    fn what_has_no_field_is_refused() {
        let sphere = SphereResponse::perfect_conductor(60.0).unwrap();
        let (m, out) = (Vector3::z(), Point3::new(0.0, 0.0, 80.0));
        let field = |a: Point3<f64>, p: Point3<f64>| sphere.field_of_dipole(&a, &m, &p);
        let inside = Point3::new(0.0, 60.0, 0.0);
        let (distance_mm, radius_mm) = (60.0, 60.0);
        assert_eq!(field(inside, out), Err(SeriesError::DipoleInside { distance_mm, radius_mm }));
        assert_eq!(field(out, inside), Err(SeriesError::PointInside { distance_mm, radius_mm }));
        assert_eq!(field(out, Point3::new(f64::NAN, 0.0, 0.0)), Err(SeriesError::NotFinite));
        let touching = Point3::new(0.0, 0.0, 60.0 * (1.0 + 1e-9));
        let error = field(touching, touching).unwrap_err();
        assert!(matches!(error, SeriesError::NoConvergence { orders: MAX_ORDER, .. }), "{error}");
        // 1 % of the radius off the sphere is no problem.
        let near = Point3::new(0.0, 0.0, 60.6);
        assert!(field(near, near).unwrap().orders < 4000);
    }
}
