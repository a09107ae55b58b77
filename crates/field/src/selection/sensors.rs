//! What sensors differ by among themselves: a random-effects estimate from held-out residuals.
//!
//! Model: a residual is a mean, its sensor's own offset (independent from sensor to sensor), its
//! pose's part, and a rest. The offset's variance is estimated by analysis of variance (Searle,
//! Casella, McCulloch 1992, chapter 3), crossed with poses where every sensor was read in most of
//! them. Offsets are in tracker axes: what is fixed to a sensor's own axes averages out over
//! orientations, and is no part of it.

use super::folds::Folds;
use super::scoring::Residual;
use crate::least_squares::VALUES;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Part of the rows that has to be of poses with a reading of each sensor, for poses to be used.
const MIN_CROSSED_SHARE: f64 = 0.5;

/// What sensors differ by among themselves, in tracker axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorSpread {
    pub sensors: usize,
    /// Sensors less one: few, so that the estimate is rough.
    pub degrees_of_freedom: usize,
    /// Variance of the sensors' mean residuals, X, Y, Z; the rest's part of it included.
    pub position_between_mm2: [f64; 3],
    /// The rest's part of that variance.
    pub position_rest_mm2: [f64; 3],
    /// Likewise; `None` where orientations were not measured.
    pub rotation_between_rad2: Option<[f64; 3]>,
    pub rotation_rest_rad2: Option<[f64; 3]>,
}

/// Why sensors cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SensorSpreadError {
    #[error("found {0} sensors, expected at least 2 to compare them")]
    FewSensors(usize),
    #[error("found {found} rows of sensors, poses or folds, expected {expected}")]
    Rows { found: usize, expected: usize },
    #[error("found {rows} rows of {sensors} sensors, expected more rows than sensors")]
    FewRows { rows: usize, sensors: usize },
}

/// Analysis of variance of one component.
struct Variance {
    between: f64,
    rest: f64,
}

/// Estimates the spread of sensors from one held-out residual a row.
///
/// `sensors` and `poses` name each row's by numbers from 0 without gaps. `held_out` are the folds
/// that the residuals are of: where a sensor was held out whole, what it left is its offset less
/// the mean offset of those that were fitted, and the variance is corrected for it.
pub fn sensor_spread(
    residuals: &[Residual],
    sensors: &[usize],
    poses: Option<&[usize]>,
    held_out: &Folds,
    has_rotations: bool,
) -> Result<SensorSpread, SensorSpreadError> {
    let rows = residuals.len();
    let of_folds = held_out.rows.iter().map(Vec::len).sum();
    let counts = [sensors.len(), poses.map_or(rows, <[usize]>::len), of_folds];
    if let Some(&found) = counts.iter().find(|&&count| count != rows) {
        return Err(SensorSpreadError::Rows { found, expected: rows });
    }
    let count = sensors.iter().max().map_or(0, |last| last + 1);
    if count < 2 {
        return Err(SensorSpreadError::FewSensors(count));
    }
    if rows <= count {
        return Err(SensorSpreadError::FewRows { rows, sensors: count });
    }
    let inflation = inflation(sensors, count, held_out);
    let crossed = poses.and_then(|poses| crossed(sensors, count, poses));
    let variance = |component: usize| {
        let value = |row: usize| residuals[row][component];
        let found = match &crossed {
            Some(crossed) => Variance::crossed(crossed, count, value),
            None => Variance::one_way(sensors, count, value),
        };
        (found.between / inflation, found.rest / inflation)
    };
    let found: [(f64, f64); VALUES] = std::array::from_fn(variance);
    let between = |from: usize| std::array::from_fn(|i| found[from + i].0);
    let rest = |from: usize| std::array::from_fn(|i| found[from + i].1);
    Ok(SensorSpread {
        sensors: count,
        degrees_of_freedom: count - 1,
        position_between_mm2: between(0),
        position_rest_mm2: rest(0),
        rotation_between_rad2: has_rotations.then(|| between(3)),
        rotation_rest_rad2: has_rotations.then(|| rest(3)),
    })
}

impl SensorSpread {
    /// Between-sensor variance of X, Y, Z, mm²; 0 where the rest explains it all.
    pub fn position_variance_mm2(&self) -> [f64; 3] {
        less(&self.position_between_mm2, &self.position_rest_mm2)
    }

    /// Between-sensor variance of the rotation vector, rad².
    pub fn rotation_variance_rad2(&self) -> Option<[f64; 3]> {
        Some(less(&self.rotation_between_rad2?, self.rotation_rest_rad2.as_ref()?))
    }

    /// Variance of what a sensor that was not measured is off by from the mean of those that were, a
    /// component, mm² and rad².
    pub fn of_another(&self) -> [f64; VALUES] {
        let mean = 1.0 + 1.0 / self.sensors as f64;
        let [x, y, z] = self.position_variance_mm2();
        let [a, b, c] = self.rotation_variance_rad2().unwrap_or_default();
        [x, y, z, a, b, c].map(|variance| variance * mean)
    }

    /// Standard deviation of a sensor's offset along X, Y, Z.
    pub fn position_std_dev_mm(&self) -> [f64; 3] {
        self.position_variance_mm2().map(f64::sqrt)
    }

    /// RMS length of a sensor's offset.
    pub fn position_rms_mm(&self) -> f64 {
        self.position_variance_mm2().iter().sum::<f64>().sqrt()
    }

    /// RMS angle of a sensor's offset.
    pub fn angle_rms_rad(&self) -> Option<f64> {
        Some(self.rotation_variance_rad2()?.iter().sum::<f64>().sqrt())
    }

    /// Interval that holds [`Self::position_rms_mm`] with this probability, for normal offsets that
    /// are as free as sensors, not as sensors and axes: if anything it is too wide.
    pub fn position_interval_mm(&self, probability: f64) -> [f64; 2] {
        let (between, rest) = (&self.position_between_mm2, &self.position_rest_mm2);
        self.interval(between, rest, probability)
    }

    /// Likewise of [`Self::angle_rms_rad`].
    pub fn angle_interval_rad(&self, probability: f64) -> Option<[f64; 2]> {
        let (between, rest) = (self.rotation_between_rad2?, self.rotation_rest_rad2?);
        Some(self.interval(&between, &rest, probability))
    }

    fn interval(&self, between: &[f64; 3], rest: &[f64; 3], probability: f64) -> [f64; 2] {
        let (between, rest): (f64, f64) = (between.iter().sum(), rest.iter().sum());
        let freedom = self.degrees_of_freedom as f64;
        let Ok(distribution) = ChiSquared::new(freedom) else {
            return [0.0, f64::INFINITY];
        };
        let tail = 0.5 * (1.0 - probability);
        [1.0 - tail, tail].map(|p| {
            let variance = between * freedom / distribution.inverse_cdf(p) - rest;
            variance.max(0.0).sqrt()
        })
    }
}

fn less(between: &[f64; 3], rest: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (between[i] - rest[i]).max(0.0))
}

/// Rows of the poses that have one reading of each sensor: by pose, then sensor.
fn crossed(sensors: &[usize], count: usize, poses: &[usize]) -> Option<Vec<Vec<usize>>> {
    let pose_count = poses.iter().max().map_or(0, |last| last + 1);
    let mut table = vec![vec![Vec::new(); count]; pose_count];
    for (row, (&sensor, &pose)) in sensors.iter().zip(poses).enumerate() {
        table[pose][sensor].push(row);
    }
    let is_whole = |readings: &Vec<Vec<usize>>| readings.iter().all(|rows| rows.len() == 1);
    let whole: Vec<Vec<usize>> = table.into_iter().filter(is_whole).map(|r| r.concat()).collect();
    let share = (whole.len() * count) as f64 / sensors.len() as f64;
    (whole.len() > 1 && share >= MIN_CROSSED_SHARE).then_some(whole)
}

/// How much larger the variance of what sensors leave is than that of their offsets: with `r = A s`
/// of independent offsets `s`, that of `r` about its mean is expected to be `tr(AᵀCA)/(n - 1)` times
/// as large, `C` the matrix that takes out the mean.
fn inflation(sensors: &[usize], count: usize, held_out: &Folds) -> f64 {
    // By fold, then sensor.
    let mut held = vec![vec![0.0; count]; held_out.rows.len()];
    for (held, rows) in held.iter_mut().zip(&held_out.rows) {
        rows.iter().for_each(|&row| held[sensors[row]] += 1.0);
    }
    let all: Vec<f64> = (0..count).map(|s| held.iter().map(|h| h[s]).sum()).collect();
    let row_of = |sensor: usize| -> Vec<f64> {
        let mut row = vec![0.0; count];
        row[sensor] = 1.0;
        let whole = held.iter().find(|h| all[sensor] > 0.0 && h[sensor] == all[sensor]);
        if let Some(held) = whole {
            let fitted: f64 = all.iter().zip(held).map(|(all, held)| all - held).sum();
            if fitted > 0.0 {
                for (k, entry) in row.iter_mut().enumerate() {
                    *entry -= (all[k] - held[k]) / fitted;
                }
            }
        }
        row
    };
    let a: Vec<Vec<f64>> = (0..count).map(row_of).collect();
    let mut squares = 0.0;
    for column in 0..count {
        let mean = a.iter().map(|row| row[column]).sum::<f64>() / count as f64;
        squares += a.iter().map(|row| (row[column] - mean).powi(2)).sum::<f64>();
    }
    let found = squares / (count - 1) as f64;
    if found > 0.0 { found } else { 1.0 }
}

impl Variance {
    /// Every sensor once in each pose: the poses' parts cancel.
    fn crossed(table: &[Vec<usize>], count: usize, value: impl Fn(usize) -> f64) -> Self {
        let (poses, sensors) = (table.len() as f64, count as f64);
        let mut means = vec![0.0; count];
        let deviations: Vec<Vec<f64>> = table
            .iter()
            .map(|rows| {
                let values: Vec<f64> = rows.iter().map(|&row| value(row)).collect();
                let mean = values.iter().sum::<f64>() / sensors;
                values.iter().map(|v| v - mean).collect()
            })
            .collect();
        for of_pose in &deviations {
            for (mean, d) in means.iter_mut().zip(of_pose) {
                *mean += d / poses;
            }
        }
        let between = means.iter().map(|m| m * m).sum::<f64>() / (sensors - 1.0);
        let squares: f64 = deviations
            .iter()
            .flat_map(|of_pose| of_pose.iter().zip(&means).map(|(d, m)| (d - m).powi(2)))
            .sum();
        Self { between, rest: squares / ((sensors - 1.0) * (poses - 1.0)) / poses }
    }

    fn one_way(sensors: &[usize], count: usize, value: impl Fn(usize) -> f64) -> Self {
        let rows = sensors.len() as f64;
        let (mut sizes, mut means) = (vec![0.0; count], vec![0.0; count]);
        for (row, &sensor) in sensors.iter().enumerate() {
            sizes[sensor] += 1.0;
            means[sensor] += value(row);
        }
        let grand = means.iter().sum::<f64>() / rows;
        for (mean, size) in means.iter_mut().zip(&sizes) {
            *mean /= f64::max(*size, 1.0);
        }
        let freedom = (count - 1) as f64;
        let squares: f64 = sizes.iter().map(|size| size * size).sum();
        let size = (rows - squares / rows) / freedom;
        let weighted = means.iter().zip(&sizes);
        let between: f64 = weighted.map(|(m, size)| size * (m - grand).powi(2)).sum();
        let within: f64 = sensors
            .iter()
            .enumerate()
            .map(|(row, &sensor)| (value(row) - means[sensor]).powi(2))
            .sum();
        Self { between: between / freedom / size, rest: within / (rows - count as f64) / size }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_models::Seeded;
    use crate::selection::folds::numbered;

    const OFFSET: [f64; VALUES] = [2.0, 1.0, 0.5, 0.02, 0.01, 0.03];

    /// Residuals of sensors in poses, each a sensor's offset, a pose's part and noise; where
    /// `is_held_out`, less the mean offset of the other sensors. Sensors that are not `crossed` with
    /// poses have poses of their own.
    fn simulated(
        random: &mut Seeded,
        [sensors, poses]: [usize; 2],
        is_held_out: bool,
        is_crossed: bool,
    ) -> Vec<Residual> {
        let offsets: Vec<Residual> =
            (0..sensors).map(|_| OFFSET.map(|std_dev| std_dev * random.normal())).collect();
        let mut residuals = Vec::new();
        for _ in 0..poses {
            let mut pose = OFFSET.map(|std_dev| 2.0 * std_dev * random.normal());
            for sensor in 0..sensors {
                if !is_crossed {
                    pose = OFFSET.map(|std_dev| 2.0 * std_dev * random.normal());
                }
                residuals.push(std::array::from_fn(|i| {
                    let sum: f64 = offsets.iter().map(|o| o[i]).sum();
                    let others = (sum - offsets[sensor][i]) / (sensors - 1) as f64;
                    let fitted = if is_held_out { others } else { sum / sensors as f64 };
                    offsets[sensor][i] - fitted + pose[i] + 0.3 * OFFSET[i] * random.normal()
                }));
            }
        }
        residuals
    }

    #[test]
    fn the_spread_of_sensors_is_estimated_without_bias() {
        const ROOMS: usize = 400;
        const SENSORS: usize = 5;
        const POSES: usize = 12;
        let sensors: Vec<usize> = (0..SENSORS * POSES).map(|row| row % SENSORS).collect();
        let poses: Vec<usize> = (0..SENSORS * POSES).map(|row| row / SENSORS).collect();
        for is_held_out in [true, false] {
            let folds = match is_held_out {
                true => Folds::of_groups(&sensors, SENSORS, SENSORS, 1),
                false => Folds::of_groups(&poses, POSES, 4, 1),
            };
            for poses in [Some(poses.as_slice()), None] {
                let mut random = Seeded::new(7);
                let mut mean = [0.0; 3];
                let mut held = 0;
                let mut angle = 0.0;
                for _ in 0..ROOMS {
                    let residuals =
                        simulated(&mut random, [SENSORS, POSES], is_held_out, poses.is_some());
                    let found = sensor_spread(&residuals, &sensors, poses, &folds, true).unwrap();
                    assert_eq!((found.sensors, found.degrees_of_freedom), (SENSORS, 4));
                    for (sum, v) in mean.iter_mut().zip(found.position_variance_mm2()) {
                        *sum += v / ROOMS as f64;
                    }
                    angle += found.angle_rms_rad().unwrap().powi(2) / ROOMS as f64;
                    let [low, high] = found.position_interval_mm(0.95);
                    held += usize::from(low <= 5.25_f64.sqrt() && 5.25_f64.sqrt() <= high);
                }
                // A variance of four degrees of freedom scatters by √(2/4), its mean over 400 rooms
                // by 0.035 of itself; poses of their own add to it, and so does that no variance is
                // below zero.
                for (found, std_dev) in mean.iter().zip(OFFSET) {
                    let ratio = found / (std_dev * std_dev);
                    assert!((ratio - 1.0).abs() < 0.25, "{ratio}, {is_held_out} {poses:?}");
                }
                let expected = 0.02_f64.powi(2) + 0.01_f64.powi(2) + 0.03_f64.powi(2);
                assert!((angle / expected - 1.0).abs() < 0.25, "{angle} {expected}");
                // The interval is wide, so it holds at least as often as it states, less four
                // standard errors.
                assert!(held as f64 / ROOMS as f64 > 0.95 - 0.044, "{held}");
            }
        }
    }

    #[test]
    fn sensors_that_are_alike_differ_by_nothing() {
        let mut random = Seeded::new(3);
        let sensors: Vec<usize> = (0..900).map(|row| row % 3).collect();
        let residuals: Vec<Residual> =
            (0..900).map(|_| std::array::from_fn(|_| random.normal())).collect();
        let folds = Folds::of_groups(&sensors, 3, 3, 1);
        let found = sensor_spread(&residuals, &sensors, None, &folds, false).unwrap();
        // Means of 300 rows scatter by 0.058.
        assert!(found.position_rms_mm() < 0.2, "{found:?}");
        assert_eq!(found.angle_rms_rad(), None);
        let [low, high] = found.position_interval_mm(0.95);
        assert_eq!(low, 0.0);
        assert!(high >= found.position_rms_mm());
    }

    #[test]
    fn what_is_no_comparison_is_refused() {
        let one = numbered(&[7_usize; 10]).0;
        let residuals = vec![[1.0; VALUES]; 10];
        let folds = Folds::of_rows(10, 2, 1);
        let spread = |sensors: &[usize], poses: Option<&[usize]>| {
            sensor_spread(&residuals, sensors, poses, &folds, true)
        };
        assert_eq!(spread(&one, None), Err(SensorSpreadError::FewSensors(1)));
        let each: Vec<usize> = (0..10).collect();
        assert_eq!(spread(&each, None), Err(SensorSpreadError::FewRows { rows: 10, sensors: 10 }));
        assert!(spread(&each[..9], None).is_err());
        let two: Vec<usize> = (0..10).map(|row| row % 2).collect();
        assert!(spread(&two, Some(&two[..3])).is_err());
        // Constant residuals: sensors differ by nothing.
        let found = spread(&two, Some(&one)).unwrap();
        assert_eq!(found.position_rms_mm(), 0.0);
    }
}
