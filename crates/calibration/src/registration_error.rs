//! The error of a registration of points at other points (Fitzpatrick, West, Maurer: Predicting
//! error in rigid-body point-based registration, IEEE TMI 17(5), 1998).
//!
//! The residual at the points themselves (FRE) is no error anywhere else: it shows how well they
//! were localised (FLE), and that, with where they are, how far off a target is to be expected
//! (TRE).

use super::registration::MIN_PAIRS;
use nalgebra::{Matrix3, Point3, Vector3};

/// How points of a registration are spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSpread {
    count: usize,
    mean: Vector3<f64>,
    axes: Matrix3<f64>,
    /// Mean squared distance of the points from each of them, mm².
    from_axis_mm2: [f64; 3],
}

impl PointSpread {
    /// Of points in either frame of the registration; none have no spread.
    pub fn of(points: &[Point3<f64>]) -> Self {
        let count = points.len().max(1) as f64;
        let mean = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count;
        let scatter: Matrix3<f64> =
            points.iter().map(|p| (p.coords - mean) * (p.coords - mean).transpose()).sum();
        let eigen = (scatter / count).symmetric_eigen();
        let along = eigen.eigenvalues.map(|value| value.max(0.0));
        Self {
            count: points.len(),
            mean,
            axes: eigen.eigenvectors,
            from_axis_mm2: [0, 1, 2].map(|k| along.sum() - along[k]),
        }
    }

    /// RMS distance of the points from the line that they are nearest to.
    pub fn off_line_mm(&self) -> f64 {
        let least = self.from_axis_mm2.iter().copied().fold(f64::INFINITY, f64::min);
        least.sqrt()
    }

    /// RMS distance that is to be expected of a target (TRE), same frame as the points, for points
    /// that were localised with an RMS error of `fle_rms_mm`, the same in all directions:
    ///
    /// `TRE² = FLE² / N · (1 + ⅓ Σ d² / f²)`, with the distances `d` of the target and `f`, RMS, of the
    /// points from each principal axis.
    pub fn tre_rms_mm(&self, fle_rms_mm: f64, target: &Point3<f64>) -> f64 {
        let from_mean = target.coords - self.mean;
        let lever: f64 = (0..3)
            .map(|k| {
                let along = self.axes.column(k).dot(&from_mean);
                let squared = (from_mean.norm_squared() - along * along).max(0.0);
                match squared {
                    0.0 => 0.0,
                    _ => squared / self.from_axis_mm2[k],
                }
            })
            .sum();
        fle_rms_mm * ((1.0 + lever / 3.0) / self.count as f64).sqrt()
    }

    /// Standard error of the turn about the axis about which it is known least: that of the formula
    /// above, which has a target at a distance `d` off by this angle times `d`.
    pub fn turn_std_error_rad(&self, fle_rms_mm: f64) -> f64 {
        match fle_rms_mm {
            0.0 => 0.0,
            _ => fle_rms_mm / (3.0 * self.count as f64).sqrt() / self.off_line_mm(),
        }
    }
}

/// How well points were localised, from what their registration leaves: `FRE² = (1 - 2/N) FLE²`.
///
/// ```
/// use trackwright_calibration::registration_error::fle_rms_mm;
/// assert!((fle_rms_mm(0.3, 8) - 0.3 / 0.75_f64.sqrt()).abs() < 1e-15);
/// ```
pub fn fle_rms_mm(fre_rms_mm: f64, points: usize) -> f64 {
    fre_rms_mm / (1.0 - 2.0 / points.max(MIN_PAIRS) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::registration::register;
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, Normal};

    /// Markers of NDI's tools 8700340 and 8700339.
    fn tool(number: u32) -> Vec<Point3<f64>> {
        let markers = match number {
            8_700_340 => {
                [[0.0, 0.0, 0.0], [0.0, 0.0, 50.0], [0.0, 25.0, 100.0], [0.0, -25.0, 135.0]]
            }
            _ => [[0.0, 0.0, 0.0], [0.0, 28.59, 41.02], [0.0, 0.0, 88.0], [0.0, -44.32, 40.45]],
        };
        markers.map(Point3::from).to_vec()
    }

    #[test]
    fn catalogue_tools_have_published_errors() {
        let fle_mm = 0.25 * 3.0_f64.sqrt();
        for (number, target, expected_mm) in
            [(8_700_340, [0.0, 0.0, -150.0], 0.7881), (8_700_339, [120.0, 30.0, -60.0], 0.9575)]
        {
            let found = PointSpread::of(&tool(number)).tre_rms_mm(fle_mm, &target.into());
            assert!((found - expected_mm).abs() < 0.5e-4, "{number}: {found}");
        }
    }

    #[test]
    fn noisy_registrations_err_as_predicted() {
        let markers = tool(8_700_339);
        let target = Point3::new(120.0, 30.0, -60.0);
        let spread = PointSpread::of(&markers);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let noise = Normal::new(0.0, 0.25).unwrap();
        let trials = 4000;
        let (mut tre2, mut fre2) = (0.0, 0.0);
        for _ in 0..trials {
            let read: Vec<_> = markers
                .iter()
                .map(|p| p + Vector3::from_fn(|_, _| noise.sample(&mut rng)))
                .collect();
            let found = register(&markers, &read).unwrap();
            tre2 += (found.target_from_source * target - target).norm_squared();
            fre2 += found.fre_rms_mm.powi(2);
        }
        let [tre, fre] = [tre2, fre2].map(|sum| (sum / f64::from(trials)).sqrt());
        // A squared error of a few components has a standard deviation below 1.2 of its mean, so the
        // root of a mean over 4000 one below 1 %; four of them.
        let predicted = spread.tre_rms_mm(0.25 * 3.0_f64.sqrt(), &target);
        assert!((tre / predicted - 1.0).abs() < 0.04, "{tre} {predicted}");
        let fle = fle_rms_mm(fre, 4);
        assert!((fle / (0.25 * 3.0_f64.sqrt()) - 1.0).abs() < 0.04, "{fle}");
    }

    #[test]
    fn points_on_a_line_leave_the_turn_open() {
        let line: Vec<_> = (0..4).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        let spread = PointSpread::of(&line);
        assert!(spread.off_line_mm() < 1e-7);
        assert!(spread.turn_std_error_rad(0.1) > 1e5);
        assert!(spread.tre_rms_mm(0.1, &Point3::new(1.5, 0.0, 0.0)) < 0.1);
        assert!(spread.tre_rms_mm(0.1, &Point3::new(1.5, 1.0, 0.0)) > 1e3);
    }
}
