//! A small physical tracker in a room with metal, written for these tests: it shares no code with the
//! program's own models.
//!
//! Nine coils, each some dipoles; metal as spheres that answer each coil with a dipole; the pose that
//! the tracker reports is the one whose signals in the empty room are nearest (Gauss-Newton with
//! central differences).

use nalgebra::{DMatrix, DVector, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

type V = Vector3<f64>;

/// Positions with so many times the noise of the median are not reported.
const MOST_NOISE: f64 = 5.0;

/// Numbers that are the same each time.
pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        let part: f64 = StandardUniform.sample(&mut self.0);
        from + (to - from) * part
    }

    pub fn normal(&mut self) -> V {
        V::from_fn(|_, _| StandardNormal.sample(&mut self.0))
    }

    pub fn direction(&mut self) -> V {
        self.normal().normalize()
    }
}

/// A dipole's field, up to a factor.
pub fn dipole(center: &V, moment: &V, at: &V) -> V {
    let d = at - center;
    let r2 = d.norm_squared();
    (d * (3.0 * moment.dot(&d) / r2) - moment) / (r2 * r2.sqrt())
}

/// A tracker in a room.
#[derive(Clone)]
pub struct Room {
    /// Dipoles of each coil.
    coils: Vec<Vec<(V, V)>>,
    /// Metal: a center, and the dipole that each coil induces there.
    metal: Vec<(V, Vec<V>)>,
    metal_gain: f64,
    /// Standard deviation of a signal.
    noise: f64,
    /// Positions with more noise are not reported.
    most_noise_mm: f64,
    has_outliers: bool,
    pub min_mm: V,
    pub max_mm: V,
}

/// What a sensor is and what the tracker reads: position in mm and unit axis.
pub type SensorPose = (V, V);

impl Room {
    /// Metal by chance around a volume by chance. With `wide` coils no dipole is a coil, and one
    /// reading in 200 is an outlier.
    pub fn new(seed: u64, wide: bool) -> Self {
        let mut random = Random::new(seed);
        let coils: Vec<_> = (0..9).map(|i| coil(i, wide, &mut random)).collect();
        let half = random.range(150.0, 230.0);
        let min_mm = V::new(-half, -half, -70.0 - 2.0 * half);
        let max_mm = V::new(half, half, -70.0);
        let bodies = random.range(1.0, 5.0) as usize;
        let spheres: Vec<_> =
            (0..bodies).flat_map(|_| body(&min_mm, &max_mm, &mut random)).collect();
        let room = Self {
            metal: induced(&coils, &spheres),
            coils,
            metal_gain: 1.0,
            noise: random.range(1e-11, 4e-11),
            most_noise_mm: f64::INFINITY,
            has_outliers: wide,
            min_mm,
            max_mm,
        };
        let wanted_mm = random.range(1.2, 4.0);
        room.of_raw_error(wanted_mm)
    }

    /// Coils and metal of any make: spheres are centers and what the field there is multiplied by; the noise
    /// is that of a position in mm, in the median over the volume. As a real one, the tracker reports no pose
    /// that its signals hardly determine.
    pub fn of_parts(
        coils: Vec<Vec<(V, V)>>,
        spheres: &[(V, f64)],
        [min_mm, max_mm]: [V; 2],
        (raw_mm, noise_mm): (f64, f64),
    ) -> Self {
        let metal = induced(&coils, spheres);
        let (noise, metal_gain, has_outliers) = (0.0, 1.0, false);
        let most_noise_mm = f64::INFINITY;
        let mut room =
            Self { metal, coils, metal_gain, noise, most_noise_mm, has_outliers, min_mm, max_mm };
        let mut random = Random::new(76);
        let unit = |_| Some(room.position_noise(&(room.position(&mut random), random.direction())));
        let mut units: Vec<f64> = (0..61).filter_map(unit).flatten().collect();
        units.sort_by(f64::total_cmp);
        room.noise = noise_mm / units[units.len() / 2];
        room.most_noise_mm = MOST_NOISE * noise_mm;
        room.of_raw_error(raw_mm)
    }

    /// The noise of a position in mm for a unit noise of the signals.
    fn position_noise(&self, sensor: &SensorPose) -> Option<f64> {
        let inverse = self.jacobian(sensor).0.qr().r().try_inverse()?;
        Some(inverse.fixed_rows::<3>(0).norm())
    }

    /// With metal that answers so strongly that the raw error is about this.
    fn of_raw_error(mut self, wanted_mm: f64) -> Self {
        for _ in 0..3 {
            self.metal_gain *= wanted_mm / self.raw_rms_mm();
        }
        self
    }

    /// With all the metal's answers multiplied.
    pub fn with_gain(&self, factor: f64) -> Self {
        Self { metal_gain: self.metal_gain * factor, ..self.clone() }
    }

    /// With another noise of the signals.
    pub fn with_noise(&self, factor: f64) -> Self {
        Self { noise: self.noise * factor, ..self.clone() }
    }

    fn raw_rms_mm(&self) -> f64 {
        let mut random = Random::new(77);
        let each = (0..60).filter_map(|_| {
            let (p, n) = (self.position(&mut random), random.direction());
            Some((self.read(&(p, n))?.0 - p).norm_squared())
        });
        let squared: Vec<f64> = each.collect();
        (squared.iter().sum::<f64>() / squared.len() as f64).sqrt()
    }

    /// Anywhere in the measured volume.
    pub fn position(&self, random: &mut Random) -> V {
        V::from_fn(|k, _| random.range(self.min_mm[k], self.max_mm[k]))
    }

    pub fn contains(&self, p: &V) -> bool {
        (0..3).all(|k| (self.min_mm[k]..=self.max_mm[k]).contains(&p[k]))
    }

    /// The reading without noise.
    pub fn read(&self, sensor: &SensorPose) -> Option<SensorPose> {
        self.nearest(sensor, &self.signals(sensor))
    }

    /// The reading with noise, and sometimes an outlier.
    pub fn measure(&self, sensor: &SensorPose, random: &mut Random) -> Option<SensorPose> {
        let mut signals = self.signals(sensor);
        for signal in signals.iter_mut() {
            *signal += random.normal().x * self.noise;
        }
        let (mut p, mut n) = self.nearest(sensor, &signals)?;
        if self.has_outliers && random.range(0.0, 1.0) < 1.0 / 200.0 {
            p += random.normal() * 8.0;
            n = (n + random.normal() * 0.05).normalize();
        }
        Some((p, n))
    }

    fn signals(&self, (p, n): &SensorPose) -> DVector<f64> {
        let disturbance = |coil: usize| -> V {
            let each = self.metal.iter().map(|(c, m)| dipole(c, &m[coil], p));
            each.sum::<V>() * self.metal_gain
        };
        DVector::from_fn(self.coils.len(), |i, _| {
            n.dot(&(field(&self.coils[i], p) + disturbance(i)))
        })
    }

    /// The pose in the empty room with the nearest signals; a turn counts as 100 mm a radian.
    fn nearest(&self, (p, n): &SensorPose, signals: &DVector<f64>) -> Option<SensorPose> {
        let (mut p, mut n) = (*p, *n);
        for _ in 0..30 {
            let (jacobian, empty, [first, second]) = self.jacobian(&(p, n));
            let left = signals - empty;
            let qr = jacobian.qr();
            let step = qr.r().solve_upper_triangular(&(qr.q().transpose() * left))?;
            let length = step.norm();
            let step = step * (30.0 / length).min(1.0);
            p += V::new(step[0], step[1], step[2]);
            n = (n + (first * step[3] + second * step[4]) / 100.0).normalize();
            if length < 1e-6 {
                let is_determined = self.most_noise_mm.is_infinite()
                    || self.noise * self.position_noise(&(p, n))? < self.most_noise_mm;
                return is_determined.then_some((p, n));
            }
        }
        None
    }

    /// How the signals of the empty room change with a pose, these signals, and the tangents of the axis.
    fn jacobian(&self, (p, n): &SensorPose) -> (DMatrix<f64>, DVector<f64>, [V; 2]) {
        const STEP_MM: f64 = 0.01;
        let other = if n.x.abs() < 0.7 { V::x() } else { V::y() };
        let first = n.cross(&other).normalize();
        let second = n.cross(&first);
        let mut jacobian = DMatrix::zeros(self.coils.len(), 5);
        let mut empty = DVector::zeros(self.coils.len());
        for (i, coil) in self.coils.iter().enumerate() {
            let b = field(coil, p);
            empty[i] = n.dot(&b);
            for k in 0..3 {
                let step = V::ith(k, STEP_MM);
                let change = field(coil, &(p + step)) - field(coil, &(p - step));
                jacobian[(i, k)] = n.dot(&change) / (2.0 * STEP_MM);
            }
            jacobian[(i, 3)] = first.dot(&b) / 100.0;
            jacobian[(i, 4)] = second.dot(&b) / 100.0;
        }
        (jacobian, empty, [first, second])
    }
}

/// The dipoles that coils induce in spheres: centers, and what the field there is multiplied by.
fn induced(coils: &[Vec<(V, V)>], spheres: &[(V, f64)]) -> Vec<(V, Vec<V>)> {
    let each = spheres.iter().map(|(center, factor)| {
        (*center, coils.iter().map(|coil| field(coil, center) * *factor).collect())
    });
    each.collect()
}

fn field(coil: &[(V, V)], at: &V) -> V {
    coil.iter().map(|(c, m)| dipole(c, m, at)).sum()
}

/// Coils on a lattice of 120 mm, turned by the golden angle; a wide one is a square of dipoles.
fn coil(index: usize, wide: bool, random: &mut Random) -> Vec<(V, V)> {
    let place =
        |k: usize, random: &mut Random| k as f64 * 120.0 - 120.0 + random.range(-10.0, 10.0);
    let center = V::new(place(index % 3, random), place(index / 3, random), 0.0);
    let (turn, tilt) = (2.4 * index as f64, if index.is_multiple_of(2) { 0.6_f64 } else { 1.2 });
    let moment = V::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos());
    if !wide {
        return vec![(center, moment)];
    }
    square(center, moment, random.range(60.0, 80.0), V::new(0.3, 0.9, 0.2))
}

/// A square of dipoles, which `aside` turns about its normal.
pub fn square(center: V, normal: V, side_mm: f64, aside: V) -> Vec<(V, V)> {
    const ROWS: usize = 4;
    let first = normal.cross(&aside).normalize();
    let second = normal.cross(&first);
    let offset = |k: usize| ((k as f64 + 0.5) / ROWS as f64 - 0.5) * side_mm;
    let moment = normal / (ROWS * ROWS) as f64;
    let each = (0..ROWS * ROWS)
        .map(|k| (center + first * offset(k % ROWS) + second * offset(k / ROWS), moment));
    each.collect()
}

/// A plate, a rod or a ball outside the volume: centers, and what the coil's field there is
/// multiplied by (conductors -a³/2, iron up to a³).
fn body(min: &V, max: &V, random: &mut Random) -> Vec<(V, f64)> {
    let factor = match random.range(0.0, 1.0) < 0.6 {
        true => -0.5,
        false => random.range(0.2, 0.9),
    };
    let kind = random.range(0.0, 1.0);
    let radius = random.range(15.0, 35.0);
    let beyond = random.range(25.0, 120.0) + radius;
    let mut center = V::from_fn(|k, _| random.range(min[k], max[k]));
    let face = random.range(0.0, 5.0) as usize;
    let out = [0, 0, 1, 1, 2][face];
    center[out] = match face {
        0 | 2 => max[out] + beyond,
        _ => min[out] - beyond,
    };
    let middle = (min + max) / 2.0;
    let answer = factor * radius.powi(3);
    if kind < 0.4 {
        let (i, j) = ((out + 1) % 3, (out + 2) % 3);
        let each = (0..81).map(|k| {
            let mut place = center;
            place[i] = middle[i] + (f64::from(k % 9) - 4.0) * 2.0 * radius;
            place[j] = middle[j] + (f64::from(k / 9) - 4.0) * 2.0 * radius;
            (place, 0.7 * answer)
        });
        return each.collect();
    }
    if kind < 0.7 {
        let along = random.direction();
        let each = (-5..=5).map(|k| center + along * (f64::from(k) * 2.0 * radius));
        let is_outside = |p: &V| {
            let over = |k: usize| (min[k] - p[k]).max(p[k] - max[k]);
            (0..3).any(|k| over(k) > radius + 20.0) && p.z < -30.0
        };
        return each.filter(is_outside).map(|p| (p, answer)).collect();
    }
    vec![(center, 6.0 * answer)]
}
