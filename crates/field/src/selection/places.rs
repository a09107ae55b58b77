//! Finds readings that belong together without a column that states it: closer than the field can
//! change, and with residuals that depend on each other.
//!
//! The places are those of [`super::clusters`]; whether their readings depend on each other is
//! estimated from what a moderate model leaves of them while their place is held out: one-way
//! analysis of variance for the short range, and a variogram (Cressie 1993, section 2.4) for the
//! distance over which the residuals change.

use super::clusters::{Repeats, Tree};
use super::cross_validation::{self, Problem, Split};
use super::folds::Folds;
use super::scoring::Residual;
use super::settings::{Candidate, DEFAULT_FOLDS, DEFAULT_SEED, SelectSettings};
use crate::bernstein::coefficient_count;
use crate::samples::{Sample, SampleSet};
use nalgebra::{Point3, Vector3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::Task;

/// Highest order of the moderate model: it follows a room's general shape, and no place by itself.
const MAX_MODERATE_ORDER: usize = 2;

/// Places that the moderate model has for each coefficient, at least.
const PLACES_PER_COEFFICIENT: usize = 4;

/// A place has to be narrower than this part of the distance over which residuals change.
const MAX_PART_OF_LENGTH: f64 = 0.25;

/// Part of the places that has to be that narrow.
const MIN_NARROW_SHARE: f64 = 0.9;

/// Part of the residuals' variance that the readings of a place have in common, at least: below it
/// a reading predicts its neighbours so little that holding out rows is fair.
const MIN_DEPENDENCE: f64 = 0.1;

/// Probability of as much dependence by chance, at most.
const SIGNIFICANCE: f64 = 1e-3;

/// Rows whose pairs make the variogram; of more, so many are drawn.
const VARIOGRAM_ROWS: usize = 2_000;

/// Distances of the variogram, in equal ratios.
const BINS: usize = 16;

/// Pairs that a distance has to have.
const MIN_PAIRS: usize = 30;

/// Axes at most this far apart count as the same in the variogram, where axes were measured.
const MAX_AXIS_ANGLE_DEG: f64 = 30.0;

/// Round-off of residuals, as a part of the errors.
const ROUND_OFF: f64 = 1e-9;

/// Semivariance of residuals at a distance: half the mean squared difference of pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VariogramPoint {
    /// Mean distance of the pairs.
    pub distance_mm: f64,
    pub semivariance_mm2: f64,
    pub pairs: usize,
}

/// Places that were measured several times, found from the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    /// The place of each row, numbered from 0 in order of appearance.
    pub groups: Vec<usize>,
    pub count: usize,
    /// Median width of the places, the diagonal of a box around their readings.
    pub width_mm: f64,
    /// Part of the residuals' variance that the readings of a place have in common (intraclass
    /// correlation), 0 to 1.
    pub dependence: f64,
    /// Distance at which residuals have lost all but 1/e of what they have in common.
    pub correlation_length_mm: f64,
    /// Semivariance within places: the nugget.
    pub nugget_mm2: f64,
    /// Variance of all residuals: the sill.
    pub sill_mm2: f64,
    /// Beyond the places, nearest first; empty where there are too few pairs.
    pub variogram: Vec<VariogramPoint>,
}

/// Analysis of variance of position residuals by place.
struct Variance {
    within_mm2: f64,
    intraclass_correlation: f64,
    probability: f64,
}

/// The places of the rows; `None` where no two readings are closer than the field can change, where
/// their residuals do not depend on each other, or where there are too few places to find out.
pub fn find(set: &SampleSet) -> Option<Places> {
    if !set.samples.iter().all(Sample::is_usable) {
        return None;
    }
    let positions: Vec<_> = set.samples.iter().map(|s| s.position_mm).collect();
    let repeats = Tree::of(&positions)?.repeats()?;
    if repeats.count < DEFAULT_FOLDS {
        return None;
    }
    let residuals = moderate_residuals(set, &repeats)?;
    let scale_mm2: f64 =
        set.samples.iter().map(|s| s.error.position_mm.norm_squared()).sum::<f64>()
            / set.samples.len() as f64;
    let sill_mm2 = variance_mm2(&residuals);
    if sill_mm2 <= ROUND_OFF * ROUND_OFF * scale_mm2 {
        return None;
    }
    let variance = Variance::by_place(&residuals, &repeats)?;
    if variance.intraclass_correlation < MIN_DEPENDENCE || variance.probability > SIGNIFICANCE {
        return None;
    }
    let nugget_mm2 = variance.within_mm2;
    let variogram = variogram(set, &positions, &residuals, &repeats);
    let changed_mm2 = nugget_mm2 + (1.0 - (-1.0_f64).exp()) * (sill_mm2 - nugget_mm2);
    let correlation_length_mm = variogram
        .iter()
        .find(|point| point.semivariance_mm2 >= changed_mm2)
        .or(variogram.last())
        .map_or(repeats.spacing_mm, |point| point.distance_mm);
    let limit_mm = MAX_PART_OF_LENGTH * correlation_length_mm;
    let narrow = repeats.widths_mm.iter().filter(|&&w| w <= limit_mm).count();
    if (narrow as f64) < MIN_NARROW_SHARE * repeats.count as f64 {
        return None;
    }
    let mut widths_mm: Vec<f64> = repeats.widths_mm.clone();
    let middle = widths_mm.len() / 2;
    let width_mm = *widths_mm.select_nth_unstable_by(middle, f64::total_cmp).1;
    Some(Places {
        groups: repeats.groups,
        count: repeats.count,
        width_mm,
        dependence: variance.intraclass_correlation.min(1.0),
        correlation_length_mm,
        nugget_mm2,
        sill_mm2,
        variogram,
    })
}

/// What a moderate model of one orientation leaves of each row while its place is held out.
fn moderate_residuals(set: &SampleSet, repeats: &Repeats) -> Option<Vec<Vector3<f64>>> {
    let has_enough = |order: &usize| {
        *order == 0 || PLACES_PER_COEFFICIENT * coefficient_count(*order) <= repeats.count
    };
    let order = (0..=MAX_MODERATE_ORDER).rev().find(has_enough)?;
    let candidate = Candidate { order, directions: DirectionSet::One, ridge: 0.0 };
    let folds = Folds::of_groups(&repeats.groups, repeats.count, DEFAULT_FOLDS, DEFAULT_SEED);
    let bounds = Bounds::around(set.samples.iter().map(|s| s.position_mm))?;
    let residuals = cross_validation::residuals(
        &Problem::without_places(set, bounds),
        &candidate,
        &Split::new(set, folds),
        &SelectSettings::for_samples(set),
        &Task::default(),
    );
    let position = |r: &Residual| Vector3::new(r[0], r[1], r[2]);
    Some(residuals.ok()?.iter().map(position).collect())
}

/// Sum over the axes of the variance about the mean.
fn variance_mm2(residuals: &[Vector3<f64>]) -> f64 {
    let count = residuals.len() as f64;
    let mean = residuals.iter().sum::<Vector3<f64>>() / count;
    let squares: f64 = residuals.iter().map(|r| (r - mean).norm_squared()).sum();
    squares / (count - 1.0)
}

impl Variance {
    /// `None` without repeated readings or with fewer than two places.
    fn by_place(residuals: &[Vector3<f64>], repeats: &Repeats) -> Option<Self> {
        let mut sizes = vec![0.0; repeats.count];
        let mut means = vec![Vector3::zeros(); repeats.count];
        for (residual, &place) in residuals.iter().zip(&repeats.groups) {
            sizes[place] += 1.0;
            means[place] += residual;
        }
        for (mean, size) in means.iter_mut().zip(&sizes) {
            *mean /= *size;
        }
        let rows = residuals.len() as f64;
        let grand = residuals.iter().sum::<Vector3<f64>>() / rows;
        let within: f64 = residuals
            .iter()
            .zip(&repeats.groups)
            .map(|(r, &place)| (r - means[place]).norm_squared())
            .sum();
        let between: f64 =
            means.iter().zip(&sizes).map(|(mean, size)| size * (mean - grand).norm_squared()).sum();
        let between_freedom = repeats.count as f64 - 1.0;
        let within_freedom = rows - repeats.count as f64;
        if between_freedom < 1.0 || within_freedom < 1.0 {
            return None;
        }
        let (within, between) = (within / within_freedom, between / between_freedom);
        // Mean size of a place for unequal ones, as in any textbook on random effects.
        let squares: f64 = sizes.iter().map(|size| size * size).sum();
        let size = (rows - squares / rows) / between_freedom;
        let ratio = between / within.max(f64::MIN_POSITIVE);
        // Three components each.
        let distribution = FisherSnedecor::new(3.0 * between_freedom, 3.0 * within_freedom).ok()?;
        Some(Self {
            within_mm2: within,
            intraclass_correlation: (between - within) / (between + (size - 1.0) * within),
            probability: distribution.sf(ratio),
        })
    }
}

/// Semivariance of pairs from different places, with axes alike where they were measured.
fn variogram(
    set: &SampleSet,
    positions: &[Point3<f64>],
    residuals: &[Vector3<f64>],
    repeats: &Repeats,
) -> Vec<VariogramPoint> {
    let rows = drawn(positions.len());
    let Some(bounds) = Bounds::around(positions.iter().copied()) else {
        return Vec::new();
    };
    let (least_mm, most_mm) = (0.5 * repeats.spacing_mm, bounds.diagonal_mm());
    if !(least_mm > 0.0 && most_mm > least_mm) {
        return Vec::new();
    }
    let ratio = (most_mm / least_mm).ln() / BINS as f64;
    let least_cosine = match set.has_rotations {
        true => MAX_AXIS_ANGLE_DEG.to_radians().cos(),
        false => -1.0,
    };
    let mut sums = [(0_usize, 0.0, 0.0); BINS];
    for (i, &a) in rows.iter().enumerate() {
        for &b in &rows[i + 1..] {
            let is_alike =
                !set.has_rotations || set.samples[a].axis.dot(&set.samples[b].axis) >= least_cosine;
            if repeats.groups[a] == repeats.groups[b] || !is_alike {
                continue;
            }
            let distance_mm = (positions[a] - positions[b]).norm();
            let bin = ((distance_mm / least_mm).ln() / ratio).max(0.0) as usize;
            let (pairs, distances, squares) = &mut sums[bin.min(BINS - 1)];
            *pairs += 1;
            *distances += distance_mm;
            *squares += (residuals[a] - residuals[b]).norm_squared();
        }
    }
    sums.into_iter()
        .filter(|(pairs, ..)| *pairs >= MIN_PAIRS)
        .map(|(pairs, distances, squares)| VariogramPoint {
            distance_mm: distances / pairs as f64,
            semivariance_mm2: 0.5 * squares / pairs as f64,
            pairs,
        })
        .collect()
}

/// Rows of the variogram, in random order where they are not all.
fn drawn(rows: usize) -> Vec<usize> {
    if rows <= VARIOGRAM_ROWS {
        return (0..rows).collect();
    }
    let parts = rows.div_ceil(VARIOGRAM_ROWS);
    Folds::of_rows(rows, parts, DEFAULT_SEED).rows.swap_remove(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_models::Seeded;
    use crate::samples::PoseError;
    use nalgebra::Unit;

    const SIZE_MM: f64 = 460.0;

    struct Random(Seeded);

    impl Random {
        fn normal(&mut self, std_dev: f64) -> Vector3<f64> {
            self.0.normal_vector() * std_dev
        }

        fn position(&mut self) -> Point3<f64> {
            self.0.position(&Bounds::from(([0.0; 3], [SIZE_MM; 3])), 0.0)
        }
    }

    /// A field that no polynomial of order 2 follows: it changes over some 60 mm.
    fn field_mm(p: &Point3<f64>) -> Vector3<f64> {
        let phase = |a: f64, b: f64, c: f64| (p.x * a + p.y * b + p.z * c).sin();
        Vector3::new(phase(0.03, 0.01, -0.02), phase(-0.01, 0.03, 0.02), phase(0.02, -0.02, 0.03))
            * 3.0
    }

    fn set(
        positions: &[Point3<f64>],
        mut error: impl FnMut(&Point3<f64>) -> Vector3<f64>,
        axis: impl Fn(usize) -> Vector3<f64>,
    ) -> SampleSet {
        let sample = |(i, p): (usize, &Point3<f64>)| {
            Sample::new(
                *p,
                Unit::new_normalize(axis(i)),
                PoseError { position_mm: error(p), rotation_rad: Vector3::zeros() },
            )
        };
        SampleSet {
            samples: positions.iter().enumerate().map(sample).collect(),
            has_rotations: true,
            ambiguous: 0,
        }
    }

    fn along_z(_: usize) -> Vector3<f64> {
        Vector3::z()
    }

    fn repeated(random: &mut Random, places: usize, scatter_mm: f64) -> Vec<Point3<f64>> {
        let centers: Vec<_> = (0..places).map(|_| random.position()).collect();
        (0..5 * places).map(|i| centers[i % places] + random.normal(scatter_mm)).collect()
    }

    #[test]
    fn scattered_readings_of_a_place_are_one_group() {
        let mut random = Random(Seeded::new(1));
        // With 1,000 places in the cube some stand within a few millimetres of each other.
        for (places, scatter_mm) in [(20, 0.3), (100, 0.3), (300, 0.3), (100, 1.0), (1000, 0.3)] {
            let positions = repeated(&mut random, places, scatter_mm);
            let noisy = |p: &Point3<f64>| field_mm(p) + random.normal(0.1);
            let found = find(&set(&positions, noisy, along_z)).expect("places");
            let off = found.count.abs_diff(places);
            assert!(100 * off <= places, "{} of {places}", found.count);
            let together = (0..places).filter(|&i| found.groups[i] == found.groups[i + places]);
            assert!(100 * together.count() >= 99 * places);
            // Noise is a thousandth of the field's variance.
            assert!(found.dependence > 0.95, "{}", found.dependence);
            let length_mm = found.correlation_length_mm;
            assert!((15.0..150.0).contains(&length_mm), "{length_mm}");
        }
    }

    #[test]
    fn independent_readings_of_a_place_are_no_group() {
        let mut random = Random(Seeded::new(2));
        let positions = repeated(&mut random, 100, 0.3);
        let noise = |_: &Point3<f64>| random.normal(0.5);
        assert_eq!(find(&set(&positions, noise, along_z)), None);
    }

    #[test]
    fn ordinary_designs_have_no_places() {
        let mut random = Random(Seeded::new(3));
        let mut designs = Vec::new();
        for rows in [20, 60, 600, 2000] {
            for _ in 0..5 {
                designs.push((0..rows).map(|_| random.position()).collect::<Vec<_>>());
            }
        }
        designs.push((0..1000).map(|_| Point3::from(random.normal(100.0))).collect());
        let node = |i: usize| Point3::new((i % 10) as f64, (i / 10 % 10) as f64, (i / 100) as f64);
        designs.push((0..1000).map(|i| node(i) * 50.0).collect());
        designs.push((0..1000).map(|i| node(i) * 50.0 + random.normal(2.0)).collect());
        // Half of the rows in an eighth of each side.
        designs.push(
            (0..800).map(|i| random.position() * if i % 2 == 0 { 1.0 } else { 0.125 }).collect(),
        );
        // A path, and lines with a step of a twentieth of their distance.
        let mut at = Point3::origin();
        designs.push(
            (0..1500)
                .map(|_| {
                    at += random.normal(1.0);
                    at
                })
                .collect(),
        );
        designs.push(
            (0..2000)
                .map(|i| Point3::new((i % 200) as f64 * 2.0, (i / 200) as f64 * 40.0, 0.0))
                .collect(),
        );
        for (i, positions) in designs.iter().enumerate() {
            let found = find(&set(positions, field_mm, along_z));
            assert_eq!(found.map(|f| f.count), None, "design {i}");
        }
    }

    #[test]
    fn readings_of_a_place_may_point_anywhere() {
        let mut random = Random(Seeded::new(4));
        let positions = repeated(&mut random, 150, 0.3);
        let axes: Vec<_> = (0..750).map(|_| random.normal(1.0)).collect();
        let noisy = |p: &Point3<f64>| field_mm(p) + random.normal(0.3);
        let found = find(&set(&positions, noisy, |i| axes[i])).expect("places");
        assert_eq!(found.count, 150);
    }

    #[test]
    fn what_has_no_places_is_none_whatever_it_is() {
        let one_place = vec![Point3::new(1.0, 2.0, 3.0); 50];
        assert_eq!(find(&set(&one_place, field_mm, along_z)), None);
        assert_eq!(find(&set(&[], field_mm, along_z)), None);
        let line: Vec<_> = (0..50).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        assert_eq!(find(&set(&line, |_| Vector3::zeros(), along_z)), None);
        // Errors that are the same everywhere leave nothing to depend on each other.
        let mut random = Random(Seeded::new(5));
        let positions = repeated(&mut random, 100, 0.3);
        assert_eq!(find(&set(&positions, |_| Vector3::x(), along_z)), None);
        let infinite = set(&positions, |_| Vector3::repeat(f64::INFINITY), along_z);
        assert_eq!(find(&infinite), None);
    }
}
