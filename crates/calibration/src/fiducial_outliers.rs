//! Fiducials that do not fit the others.
//!
//! A point is judged by the registration of all others: how far off it is there, against what they
//! were localised to and what their registration is off by at its place (TRE). Of points localised
//! alike in all directions, the ratio of the mean squares per component follows Fisher's F with 3 and
//! `3 (N − 1) − 6` degrees of freedom, nearly. The worst point is left out where chance has one so far
//! off in fewer than 1 % of registrations of `N` points (Bonferroni), and the rest is judged anew.

use super::registration::{MIN_PAIRS, Registration, RegistrationError, register};
use super::registration_error::{PointSpread, fle_rms_mm};
use nalgebra::Point3;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// How often a good set of points may have one left out.
const LEVEL: f64 = 0.01;

/// Points that stay: one more than a pose needs, or nothing is left to contradict it.
const MIN_LEFT: usize = MIN_PAIRS + 1;

/// A point that the others contradict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlyingPoint {
    /// Its place among all points, from 0.
    pub index: usize,
    /// How far off it is where the points that stay are registered, mm.
    pub off_mm: f64,
    /// How often chance has the worst of so many points so far off.
    pub chance: f64,
}

/// Registers the points that agree.
pub fn register_without_outliers(
    source: &[Point3<f64>],
    target: &[Point3<f64>],
) -> Result<(Registration, Vec<OutlyingPoint>), RegistrationError> {
    let mut found = register(source, target)?;
    let mut stay: Vec<usize> = (0..source.len()).collect();
    let mut left_out = Vec::new();
    while let Some((place, chance)) = worst(source, target, &stay) {
        if chance > LEVEL {
            break;
        }
        left_out.push((stay.remove(place), chance));
        found = registered(source, target, &stay)?;
    }
    let outlying = left_out.into_iter().map(|(index, chance)| OutlyingPoint {
        index,
        off_mm: (found.target_from_source * source[index] - target[index]).norm(),
        chance,
    });
    Ok((found, outlying.collect()))
}

fn registered(
    source: &[Point3<f64>],
    target: &[Point3<f64>],
    stay: &[usize],
) -> Result<Registration, RegistrationError> {
    let of = |points: &[Point3<f64>]| stay.iter().map(|&k| points[k]).collect::<Vec<_>>();
    register(&of(source), &of(target))
}

/// The index in `stay` of the point that the others contradict most, and the chance of that.
fn worst(source: &[Point3<f64>], target: &[Point3<f64>], stay: &[usize]) -> Option<(usize, f64)> {
    if stay.len() <= MIN_LEFT {
        return None;
    }
    let freedom = 3 * (stay.len() - 1) - 6;
    let judged = (0..stay.len()).filter_map(|place| {
        let mut others = stay.to_vec();
        let point = others.remove(place);
        // Others on a line determine nothing, and contradict nobody.
        let found = registered(source, target, &others).ok()?;
        let off_mm = (found.target_from_source * source[point] - target[point]).norm();
        let fle_mm = fle_rms_mm(found.fre_rms_mm, others.len());
        let points: Vec<_> = others.iter().map(|&k| source[k]).collect();
        let tre_mm = PointSpread::of(&points).tre_rms_mm(fle_mm, &source[point]);
        let expected_mm2 = fle_mm * fle_mm + tre_mm * tre_mm;
        // Exact points have no error but round-off.
        let least_mm2 = (1e-9 * (1.0 + source[point].coords.norm())).powi(2);
        let ratio = off_mm * off_mm / expected_mm2.max(least_mm2);
        Some((place, ratio))
    });
    let (place, ratio) = judged.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let by_chance = FisherSnedecor::new(3.0, freedom as f64).ok()?;
    Some((place, (stay.len() as f64 * by_chance.sf(ratio)).min(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use trackwright_field::random_models::Seeded;

    fn points(count: usize, rng: &mut Seeded) -> Vec<Point3<f64>> {
        (0..count).map(|_| (rng.normal_vector() * 60.0).into()).collect()
    }

    fn noisy(points: &[Point3<f64>], rng: &mut Seeded) -> Vec<Point3<f64>> {
        points.iter().map(|p| p + rng.normal_vector() * 0.4).collect()
    }

    #[test]
    fn outlying_points_are_left_out_and_good_ones_stay() {
        let mut rng = Seeded::new(11);
        let source = points(8, &mut rng);
        let mut target = noisy(&source, &mut rng);
        target[2].x += 9.0;
        target[5].z -= 14.0;
        let (found, out) = register_without_outliers(&source, &target).unwrap();
        let mut indices: Vec<_> = out.iter().map(|point| point.index).collect();
        indices.sort_unstable();
        assert_eq!(indices, [2, 5]);
        assert!(found.fre_rms_mm < 1.0 && out.iter().all(|point| point.off_mm > 8.0));
    }

    #[test]
    fn good_sets_lose_a_point_at_the_stated_level() {
        let mut rng = Seeded::new(12);
        let trials = 1000;
        let lost = (0..trials).filter(|_| {
            let source = points(6, &mut rng);
            let target = noisy(&source, &mut rng);
            let found = register_without_outliers(&source, &target).unwrap();
            !found.1.is_empty()
        });
        // The bound is 1 % where the tests are one another's; three standard deviations above.
        let lost = lost.count();
        assert!(lost <= 20, "{lost} of {trials}");
    }

    #[test]
    fn four_points_stay_whatever_they_are() {
        let mut rng = Seeded::new(13);
        let source = points(5, &mut rng);
        let target = points(5, &mut rng);
        let (_, out) = register_without_outliers(&source, &target).unwrap();
        assert!(out.len() <= 1);
        let (_, out) = register_without_outliers(&source[..4], &target[..4]).unwrap();
        assert_eq!(out, []);
    }

    #[test]
    fn exact_points_are_no_outliers() {
        let mut rng = Seeded::new(14);
        let source = points(7, &mut rng);
        let target: Vec<_> = source.iter().map(|p| p + Vector3::new(1.0, 2.0, 3.0)).collect();
        assert_eq!(register_without_outliers(&source, &target).unwrap().1, []);
    }
}
