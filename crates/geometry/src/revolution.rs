//! The axis of a body of revolution, from the symmetry of its surface.
//!
//! A normal of a surface of revolution meets the axis. For an axis along the unit vector `d` through
//! `p` and a normal `n` at `c` that is `(c − p) · (n × d) = 0`, which is linear in the axis' Plücker
//! coordinates `d` and `m = p × d`: `d · (c × n) + m · n = 0` (Pottmann & Randrup, Computing 60, 1998).
//!
//! The normals are those of the creases between triangles, halfway between both: on a mesh that was
//! cut from a surface of revolution they meet the axis exactly, at the middle of a crease around it
//! and all along one that runs from end to end, however coarse the mesh is, however its flats were
//! cut into triangles and whatever is missing of them. Flat facets themselves do not: a slanted end
//! puts their middle to one side. A crease weighs as much as the curvature in it, its length by its
//! angle. What belongs to no revolution, such as a slanted tip, a crease of either kind that is of
//! the other or a housing, loses its weight step by step.

use super::weld::welded;
use nalgebra::{Matrix3, Point3, SymmetricEigen, Unit, Vector3};
use rayon::slice::ParallelSliceMut;

/// Triangles next to each other whose normals turn by less than this are flat: more than the rounding
/// of corners in f32, less than from side to side of any round that is drawn.
const FLAT_RAD: f64 = 1e-4;

/// So many creases decide at most, those of most weight: a few hundredths of a second.
const MOST_CREASES: usize = 50_000;

/// How far a normal may miss the axis before it loses its weight, in radii, from the first step to
/// the last: from where nothing is known to some hundred times the rounding of corners in f32 on a
/// shaft of 1 mm. On a shaft ten radii long, creases that miss by the last tilt the axis by less than
/// a hundredth of a degree.
const SCALES: [f64; 12] = [0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3, 1e-3, 1e-3];

/// A crease is a part of the revolution where its normal leads past the axis by less, as a sine: 6
/// degrees, to allow for meshes that were not cut along the shaft.
const ON_AXIS: f64 = 0.1;

/// The least part of a body's curvature that has to be of revolution for the body to be one: a shaft
/// with flutes, buttons and a cable beside it is one still, and three rods in a star, of which the
/// largest is a quarter, are none.
const LEAST_SHARE: f64 = 0.4;

/// Where turning the axis sideways makes less of a difference than this, a mean square in sizes, it is
/// one of many: a ball of 16 rings has 1e-4, and a shaft that is as long as it is wide 0.02.
const LEAST_CURVATURE: f64 = 1e-3;

/// Down to this scale the difference is taken: below, the poles of a ball's mesh count as its axis.
const ROUGH: f64 = 0.1;

/// The axis of a body of revolution, body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RevolutionAxis {
    /// The point of it that is nearest to the middle of the surface.
    pub point_mm: Point3<f64>,
    /// Of either sign.
    pub direction: Unit<Vector3<f64>>,
    /// The part of the surface's curvature that is of revolution about it.
    pub share: f64,
}

impl RevolutionAxis {
    /// Of triangles by their corners; `None` where most of them are of no revolution, or where there
    /// are many axes.
    pub fn of(triangles: &[[Point3<f64>; 3]]) -> Option<Self> {
        let vertices = welded(triangles.as_flattened());
        let vertices: Vec<[u32; 3]> = vertices.as_chunks().0.to_vec();
        Self::of_connected(triangles, &vertices)
    }

    /// The same of triangles whose vertices are known: one number a place.
    pub fn of_connected(triangles: &[[Point3<f64>; 3]], vertices: &[[u32; 3]]) -> Option<Self> {
        let creases = Creases::of(triangles, vertices)?;
        let starts = creases.starts();
        let found = starts.iter().filter_map(|start| creases.refined(*start));
        // Of two that are as good, as of a square bar, the one along which the body is longer.
        let rank = |axis: &Self| ((axis.share * 100.0).round(), creases.length(&axis.direction));
        let best = found.max_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        })?;
        let point_mm = best.point_mm + creases.middle_mm.coords;
        Some(Self { point_mm, direction: squared_up(best.direction), ..best })
    }

    /// Of either sign, the one that points along a direction.
    #[must_use]
    pub fn towards(self, along: &Vector3<f64>) -> Self {
        let is_against = self.direction.dot(along) < 0.0;
        let direction = if is_against { -self.direction } else { self.direction };
        Self { direction, ..self }
    }

    /// How far along it a point is, from [`Self::point_mm`].
    pub fn along_mm(&self, point_mm: &Point3<f64>) -> f64 {
        (point_mm - self.point_mm).dot(&self.direction)
    }

    /// From the axis to a point, square to it.
    pub fn arm_mm(&self, point_mm: &Point3<f64>) -> Vector3<f64> {
        let from = point_mm - self.point_mm;
        from - self.direction.into_inner() * from.dot(&self.direction)
    }

    /// Whether a surface with this normal at a point may be of revolution about the axis: the normal
    /// leads past it by less than the side of a hexagonal shaft does.
    pub fn is_met_by(&self, point_mm: &Point3<f64>, normal: &Vector3<f64>) -> bool {
        // Halfway along the flat of a hexagon: sin 30°, and some for the mesh.
        const MOST_SINE: f64 = 0.6;
        let arm = self.arm_mm(point_mm);
        let past = arm.dot(&normal.cross(&self.direction)).abs();
        past <= MOST_SINE * arm.norm() * normal.cross(&self.direction).norm()
    }
}

/// An axis of the frame where the direction is one up to the rounding of a mesh in f32: who modelled
/// along it gets 1 and not 0.999999999.
fn squared_up(direction: Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    const ROUND_OFF: f64 = 1e-5;
    let longest = direction.iamax();
    let mut axis = Vector3::zeros();
    axis[longest] = direction[longest].signum();
    let is_along = (axis - direction.into_inner()).norm() < ROUND_OFF;
    if is_along { Unit::new_unchecked(axis) } else { direction }
}

/// An edge between two triangles that are not flat, from the middle of all.
#[derive(Clone, Copy, Debug)]
struct Crease {
    /// Length by angle.
    weight: f64,
    /// Halfway between both sides.
    normal: Vector3<f64>,
    middle_mm: Vector3<f64>,
    /// Along the edge, so long that its square is the mean over the edge.
    along_mm: Vector3<f64>,
}

struct Creases {
    all: Vec<Crease>,
    weight: f64,
    /// The sum of `n nᵀ` over the surface.
    normals: Matrix3<f64>,
    middle_mm: Point3<f64>,
    /// Root of the area.
    size_mm: f64,
}

impl Creases {
    fn of(triangles: &[[Point3<f64>; 3]], vertices: &[[u32; 3]]) -> Option<Self> {
        let doubled: Vec<Vector3<f64>> =
            triangles.iter().map(|[a, b, c]| (b - a).cross(&(c - a))).collect();
        let area_mm2: f64 = doubled.iter().map(|cross| cross.norm() / 2.0).sum();
        if !(area_mm2 > 0.0 && area_mm2.is_finite()) {
            return None;
        }
        let weighted = triangles
            .iter()
            .zip(&doubled)
            .map(|([a, b, c], cross)| (a.coords + b.coords + c.coords) * (cross.norm() / 6.0));
        let middle_mm = Point3::from(weighted.sum::<Vector3<f64>>() / area_mm2);
        // A sliver's normal is round-off.
        let least = 1e-12 * area_mm2;
        let unit: Vec<Option<Vector3<f64>>> =
            doubled.iter().map(|cross| cross.try_normalize(least)).collect();
        let normals = unit.iter().zip(&doubled).filter_map(|(normal, cross)| {
            let normal = (*normal)?;
            Some(normal * normal.transpose() * cross.norm())
        });
        let mut all = creases((triangles, vertices), &unit, &middle_mm);
        all.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        all.truncate(MOST_CREASES);
        Some(Self {
            weight: all.iter().map(|crease| crease.weight).sum(),
            all,
            normals: normals.sum(),
            middle_mm,
            size_mm: area_mm2.sqrt(),
        })
    }

    /// Directions that an axis may be near to: square to most normals, or along them, as of a disc.
    fn starts(&self) -> [Vector3<f64>; 3] {
        let eigen = SymmetricEigen::new(self.normals);
        [0, 1, 2].map(|k| eigen.eigenvectors.column(k).into_owned())
    }

    /// The axis that is found from a direction; its point is from the middle of all.
    fn refined(&self, start: Vector3<f64>) -> Option<RevolutionAxis> {
        // The first step has the direction given and looks for the place alone.
        let mut line = self.through(start)?;
        let mut radius_mm = self.radius_mm(&line)?;
        let mut curvature = 0.0;
        for scale in SCALES {
            let (next, gap) = self.solved(&line, scale * radius_mm)?;
            line = next;
            if scale >= ROUGH {
                curvature = gap;
            }
            radius_mm = self.radius_mm(&line)?;
        }
        let on_axis = self.all.iter().filter(|crease| crease.is_about(&line));
        let on_axis: f64 = on_axis.map(|crease| crease.weight).sum();
        let share = on_axis / self.weight;
        (share >= LEAST_SHARE && curvature > LEAST_CURVATURE).then(|| RevolutionAxis {
            point_mm: Point3::from(line.direction.cross(&line.moment)),
            direction: Unit::new_normalize(line.direction),
            share,
        })
    }

    /// The line of a direction that the normals meet best.
    fn through(&self, direction: Vector3<f64>) -> Option<Line> {
        let mut sums = Sums::default();
        for crease in &self.all {
            sums.add(crease, &Vector3::zeros(), crease.weight);
        }
        let moment = -(sums.held()? * (sums.mixed.transpose() * direction));
        Some(Line { direction, moment })
    }

    /// The line that the normals meet best where those count that miss the latest by less than a
    /// limit, and how much worse the next best direction is, as a mean square in sizes.
    fn solved(&self, latest: &Line, limit_mm: f64) -> Option<(Line, f64)> {
        // Geman & McClure's: what is far off counts for nothing.
        let kept = |miss2_mm2: f64| (1.0 + miss2_mm2 / (limit_mm * limit_mm)).powi(-2);
        let mut sums = Sums::default();
        for crease in &self.all {
            let at_middle = crease.miss_mm(latest).powi(2);
            let over_it = at_middle + crease.slant_mm(latest).powi(2);
            sums.add(crease, &Vector3::zeros(), crease.weight * kept(at_middle));
            sums.add(crease, &crease.along_mm, crease.weight * kept(over_it));
        }
        let held = sums.held()?;
        let schur = sums.moments - sums.mixed * held * sums.mixed.transpose();
        let eigen = SymmetricEigen::new((schur + schur.transpose()) / 2.0);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let direction = eigen.eigenvectors.column(order[0]).into_owned();
        let moment = -(held * (sums.mixed.transpose() * direction));
        let gap = eigen.eigenvalues[order[1]] - eigen.eigenvalues[order[0]];
        let curvature = gap / (sums.weight * self.size_mm * self.size_mm);
        curvature.is_finite().then_some((Line { direction, moment }, curvature))
    }

    /// Root mean square of the distance from a line; `None` where all is on it.
    fn radius_mm(&self, line: &Line) -> Option<f64> {
        let point = line.direction.cross(&line.moment);
        let arms = self.all.iter().map(|crease| {
            let arm = (crease.middle_mm - point).cross(&line.direction);
            arm.norm_squared() * crease.weight
        });
        let radius_mm = f64::sqrt(arms.sum::<f64>() / self.weight);
        (radius_mm > 1e-9 * self.size_mm).then_some(radius_mm)
    }

    /// Mean square of the length along a direction.
    fn length(&self, direction: &Vector3<f64>) -> f64 {
        let along = self.all.iter().map(|crease| {
            let middle = crease.middle_mm.dot(direction).powi(2);
            (middle + crease.along_mm.dot(direction).powi(2)) * crease.weight
        });
        along.sum()
    }
}

/// Plücker coordinates of a line: `direction` of length 1 and `p × direction`.
#[derive(Clone, Copy, Debug)]
struct Line {
    direction: Vector3<f64>,
    moment: Vector3<f64>,
}

impl Crease {
    /// How far the normal at its middle misses a line, by the sine of the angle between them.
    fn miss_mm(&self, line: &Line) -> f64 {
        line.direction.dot(&self.middle_mm.cross(&self.normal)) + line.moment.dot(&self.normal)
    }

    /// Whether it may be one of a surface of revolution about a line: its normal meets the line, held
    /// against its own distance, and it runs along the line or around it, not through it, as a thin rod
    /// that crosses the line in its middle does.
    fn is_about(&self, line: &Line) -> bool {
        // To the tip of a cone it is twice; around the corner of a triangle too.
        const MOST_FLARE: f64 = 2.5;
        let point = line.direction.cross(&line.moment);
        let arm = |place: Vector3<f64>| (place - point).cross(&line.direction).norm();
        let own = arm(self.middle_mm);
        let half = self.along_mm * f64::sqrt(3.0);
        let across = self.normal.cross(&line.direction).norm();
        self.miss_mm(line).abs() <= ON_AXIS * own * across
            && [half, -half].iter().all(|half| arm(self.middle_mm + half) <= MOST_FLARE * own)
    }

    /// How much further it misses along the edge.
    fn slant_mm(&self, line: &Line) -> f64 {
        self.along_mm.dot(&self.normal.cross(&line.direction))
    }
}

/// The sums of a least-squares problem for a line.
#[derive(Default)]
struct Sums {
    /// Of `(c × n)(c × n)ᵀ`, of `(c × n) nᵀ` and of `n nᵀ`.
    moments: Matrix3<f64>,
    mixed: Matrix3<f64>,
    normals: Matrix3<f64>,
    weight: f64,
}

impl Sums {
    fn add(&mut self, crease: &Crease, along_mm: &Vector3<f64>, weight: f64) {
        let moment = crease.middle_mm.cross(&crease.normal);
        let slant = along_mm.cross(&crease.normal);
        self.moments += (moment * moment.transpose() + slant * slant.transpose()) * weight;
        self.mixed += moment * crease.normal.transpose() * weight;
        self.normals += crease.normal * crease.normal.transpose() * weight;
        self.weight += weight;
    }

    /// The inverse of the sum of `n nᵀ`, without the direction that no normal has: a shift along a
    /// shaft. `None` where all normals are along one.
    fn held(&self) -> Option<Matrix3<f64>> {
        const NO_NORMAL: f64 = 1e-9;
        let eigen = SymmetricEigen::new(self.normals);
        let largest = eigen.eigenvalues.max();
        let held: Vec<usize> =
            (0..3).filter(|&k| eigen.eigenvalues[k] > NO_NORMAL * largest).collect();
        let inverse = held.iter().map(|&k| {
            let own = eigen.eigenvectors.column(k);
            own * own.transpose() / eigen.eigenvalues[k]
        });
        (held.len() >= 2).then(|| inverse.sum())
    }
}

/// The edges that two triangles share and where they turn, from `origin_mm`.
fn creases(
    (triangles, vertices): (&[[Point3<f64>; 3]], &[[u32; 3]]),
    normals: &[Option<Vector3<f64>>],
    origin_mm: &Point3<f64>,
) -> Vec<Crease> {
    let (corners, vertices) = (triangles.as_flattened(), vertices.as_flattened());
    // By their two vertices: the corner that each begins at, and the one that it ends at.
    let mut edges: Vec<(u32, u32, u32, u32)> = Vec::with_capacity(corners.len());
    for first in (0..corners.len() as u32).step_by(3) {
        if normals[first as usize / 3].is_none() {
            continue;
        }
        for (from, to) in [(first, first + 1), (first + 1, first + 2), (first + 2, first)] {
            let (a, b) = (vertices[from as usize], vertices[to as usize]);
            if a != b {
                edges.push((a.min(b), a.max(b), from, to));
            }
        }
    }
    edges.par_sort_unstable();
    let shared = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    let crease = |pair: &[(u32, u32, u32, u32)]| {
        let [(_, _, from, to), (_, _, other, _)] = pair else { return None };
        let sides = [*from, *other].map(|corner| normals[corner as usize / 3]);
        let (one, two) = (sides[0]?, sides[1]?);
        let angle_rad = one.cross(&two).norm().atan2(one.dot(&two));
        let [a, b] = [*from, *to].map(|corner| corners[corner as usize] - origin_mm);
        let edge = b - a;
        (angle_rad > FLAT_RAD).then_some(Crease {
            weight: edge.norm() * angle_rad,
            // A fold has no normal.
            normal: (one + two).try_normalize(1e-3)?,
            middle_mm: (a + b) / 2.0,
            along_mm: edge / f64::sqrt(12.0),
        })
    };
    shared.filter_map(crease).collect()
}

#[cfg(test)]
mod tests;
