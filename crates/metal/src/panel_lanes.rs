//! Fields of many evenly charged triangles at a point, eight triangles in the lanes of the machine's vectors.
//!
//! Most triangles are far from most points, where their field is a few products and one root; nearer ones are sums
//! over some points. Those that are near are left to [`Panel::field`]. The sums do not depend on the machine's
//! vectors.

use crate::panel::{FAR, FINE, MIDDLE, Panel};
use faer::Mat;
use nalgebra::{Point3, SimdComplexField, SimdValue, Vector3};
use pulp::{Arch, Simd, WithSimd};
use trackwright_field::generator::MAX_COILS;
use trackwright_field::generator::lanes::{LANES, Lanes};

/// Groups whose fields are computed before they are added up for one coil after the other.
const GROUPS: usize = 16;

/// What far fields are computed from, of eight triangles.
#[derive(Clone, Debug)]
struct Group {
    center_mm: Vector3<Lanes>,
    area_mm2: Lanes,
    /// Squared distances from which on the far field, and a sum over points, hold.
    far_mm2: Lanes,
    middle_mm2: Lanes,
    corners_mm: [Vector3<Lanes>; 3],
    /// Second moments xx, yy, zz, xy, xz, yz.
    moment_mm2: [Lanes; 6],
}

/// The triangles of a surface by eights; what is left over is not in here.
#[derive(Clone, Debug)]
pub(crate) struct PanelLanes(Vec<Group>);

impl PanelLanes {
    pub fn new(panels: &[Panel]) -> Self {
        let group = |panels: &[Panel]| {
            let of = |value: &dyn Fn(&Panel) -> f64| {
                simba::simd::AutoSimd(std::array::from_fn(|lane| value(&panels[lane])))
            };
            Group {
                center_mm: Vector3::from_fn(|k, _| of(&|panel| panel.center_mm()[k])),
                area_mm2: of(&|panel| panel.area_mm2()),
                far_mm2: of(&|panel| (FAR * panel.radius_mm()).powi(2)),
                middle_mm2: of(&|panel| (MIDDLE * panel.radius_mm()).powi(2)),
                corners_mm: [0, 1, 2].map(|corner: usize| {
                    Vector3::from_fn(|k, _| of(&|panel| panel.corners_mm()[corner][k]))
                }),
                moment_mm2: [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
                    .map(|at| of(&|panel| panel.moment_mm2()[at])),
            }
        };
        Self(panels.chunks_exact(LANES).map(group).collect())
    }

    /// Adds the fields of charges at a point; `charges` has a row a panel and a column a field.
    ///
    /// # Panics
    /// If there are not as many charges as panels and fields.
    pub fn add_fields(
        &self,
        panels: &[Panel],
        charges: &Mat<f64>,
        p: &Point3<f64>,
        fields: &mut [Vector3<f64>],
    ) {
        assert_eq!((charges.nrows(), charges.ncols()), (panels.len(), fields.len()));
        let mut first = 0;
        for fields in fields.chunks_mut(MAX_COILS) {
            let columns = first..first + fields.len();
            first = columns.end;
            Arch::new().dispatch(Sum { groups: &self.0, panels, charges, columns, p, fields });
        }
    }
}

struct Sum<'a> {
    groups: &'a [Group],
    panels: &'a [Panel],
    charges: &'a Mat<f64>,
    columns: std::ops::Range<usize>,
    p: &'a Point3<f64>,
    fields: &'a mut [Vector3<f64>],
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { groups, panels, charges, columns, p, fields } = self;
        simd.vectorize(|| {
            let zero = Vector3::repeat(Lanes::splat(0.0));
            let mut sums = [zero; MAX_COILS];
            let mut each = [zero; GROUPS];
            for (block, groups) in groups.chunks(GROUPS).enumerate() {
                let first = block * GROUPS * LANES;
                for (k, (field, group)) in each.iter_mut().zip(groups).enumerate() {
                    *field = group.field(p, &panels[first + k * LANES..]);
                }
                for (sum, column) in sums.iter_mut().zip(columns.clone()) {
                    let charges = charges.col_as_slice(column)[first..].chunks_exact(LANES);
                    for (field, charges) in each[..groups.len()].iter().zip(charges) {
                        let charges: Lanes =
                            simba::simd::AutoSimd(std::array::from_fn(|lane| charges[lane]));
                        *sum += field * charges;
                    }
                }
            }
            for (field, sum) in fields.iter_mut().zip(&sums) {
                *field += sum.map(|lanes| lanes.0.iter().sum::<f64>());
            }
        });
        let rest = groups.len() * LANES;
        for (row, panel) in panels.iter().enumerate().skip(rest) {
            let field = panel.field(p);
            for (sum, column) in fields.iter_mut().zip(columns.clone()) {
                *sum += field * charges[(row, column)];
            }
        }
    }
}

impl Group {
    /// Fields of the group's triangles, which are the first of `panels`.
    #[inline(always)]
    fn field(&self, p: &Point3<f64>, panels: &[Panel]) -> Vector3<Lanes> {
        let number = |value: f64| Lanes::splat(value);
        let r = p.coords.map(number) - self.center_mm;
        let distance2 = r.dot(&r);
        let inverse2 = number(1.0) / distance2;
        let inverse3 = inverse2 * inverse2.simd_sqrt();
        let [xx, yy, zz, xy, xz, yz] = self.moment_mm2;
        let along = Vector3::new(
            xx * r.x + xy * r.y + xz * r.z,
            xy * r.x + yy * r.y + yz * r.z,
            xz * r.x + yz * r.y + zz * r.z,
        );
        let square = r.dot(&along) * inverse2;
        let radial = number(1.0) + inverse2 * (number(7.5) * square - number(1.5) * (xx + yy + zz));
        let scale = inverse3 * self.area_mm2;
        let mut field = (r * radial - along * (number(3.0) * inverse2)) * scale;
        let is_beyond = |mm2: &Lanes| -> [bool; LANES] {
            // A distance that is no number is not.
            std::array::from_fn(|lane| distance2.0[lane] > mm2.0[lane])
        };
        let is_far = is_beyond(&self.far_mm2);
        if is_far == [true; LANES] {
            return field;
        }
        let is_middle = is_beyond(&self.middle_mm2);
        let is_any_middle = is_middle.iter().zip(&is_far).any(|(middle, far)| *middle && !far);
        let by_points = if is_any_middle { self.field_of_points(p) } else { field };
        for (lane, panel) in panels.iter().take(LANES).enumerate() {
            if is_far[lane] {
                continue;
            }
            let near = match is_middle[lane] {
                true => by_points.map(|lanes| lanes.0[lane]),
                false => panel.field(p),
            };
            for k in 0..3 {
                field[k].0[lane] = near[k];
            }
        }
        field
    }

    /// By the charges at the points of a rule.
    #[inline(always)]
    fn field_of_points(&self, p: &Point3<f64>) -> Vector3<Lanes> {
        let number = |value: f64| Lanes::splat(value);
        let from_corners = self.corners_mm.map(|corner| p.coords.map(number) - corner);
        let mut field = Vector3::repeat(number(0.0));
        for (bary, weight) in FINE {
            let mut r = from_corners[0] * number(bary[0]);
            r += from_corners[1] * number(bary[1]);
            r += from_corners[2] * number(bary[2]);
            let inverse2 = number(1.0) / r.dot(&r);
            field += r * (inverse2 * inverse2.simd_sqrt() * number(weight));
        }
        field * self.area_mm2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cuboid;
    use crate::surface::ClosedSurface;

    #[test]
    fn lanes_sum_what_panels_have() {
        let mesh = cuboid(&Vector3::new(60.0, 40.0, 10.0), 300).unwrap();
        let surface = ClosedSurface::new(&mesh).unwrap();
        // One left over, and more fields than a group of coils.
        let panels = &surface.panels()[..surface.panels().len() - 3];
        assert!(panels.len() > 200 && !panels.len().is_multiple_of(LANES), "{}", panels.len());
        let count = MAX_COILS + 3;
        let charges = Mat::from_fn(panels.len(), count, |i, j| (1.7 * i as f64 + j as f64).sin());
        let lanes = PanelLanes::new(panels);
        for at in [[5.0, 3.0, 12.0], [80.0, 0.0, 0.0], [400.0, -300.0, 900.0]] {
            let p = Point3::from(at);
            let mut found = vec![Vector3::zeros(); count];
            lanes.add_fields(panels, &charges, &p, &mut found);
            for (j, found) in found.iter().enumerate() {
                let each =
                    panels.iter().enumerate().map(|(i, panel)| panel.field(&p) * charges[(i, j)]);
                let (sum, size) = each.fold((Vector3::zeros(), 0.0), |(sum, size), field| {
                    (sum + field, size + field.norm())
                });
                assert!((found - sum).norm() < 1e-14 * size, "{p} {j}");
            }
        }
    }
}
