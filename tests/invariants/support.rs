//! What a fit says of its own reach agrees with what refits to new noise do.

use nalgebra::{Point3, Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use trackwright::field::fit::{Fit, FitMethod, FitSettings, factor};
use trackwright::field::samples::{MapKind, PoseError, Sample, SampleSet};
use trackwright::field::support::SupportAt;
use trackwright::field::{DistortionModel, OutsidePolicy, Support};
use trackwright::geometry::bounds::Bounds;
use trackwright::geometry::directions::{DirectionSet, Weighting};
use trackwright::task::Task;

const NOISE_MM: f64 = 0.2;
const NOISE_RAD: f64 = 0.003;

fn bounds() -> Bounds {
    Bounds::from(([-100.0, -80.0, -400.0], [100.0, 80.0, -100.0]))
}

/// A sequence that fills [0, 1) evenly.
fn spread(i: usize, step: f64) -> f64 {
    (i as f64 * step + 0.5).fract()
}

/// Places spread over box and sphere (Kronecker sequences).
fn places(count: usize, bounds: &Bounds) -> Vec<(Point3<f64>, Unit<Vector3<f64>>)> {
    (0..count)
        .map(|i| {
            let unit = Vector3::new(
                spread(i, 0.819_172_5),
                spread(i, 0.671_043_6),
                spread(i, 0.549_700_5),
            );
            let z = 2.0 * spread(i, 0.754_877_7) - 1.0;
            let turn = std::f64::consts::TAU * spread(i, 0.569_840_3);
            let r = (1.0 - z * z).sqrt();
            (
                bounds.min_mm + bounds.size_mm().component_mul(&unit),
                Unit::new_normalize(Vector3::new(r * turn.cos(), r * turn.sin(), z)),
            )
        })
        .collect()
}

/// A model with unlike coefficients; the same for all orientations, so that the paper's way of
/// fitting each by itself can follow it exactly, or not.
fn truth(order: usize, directions: DirectionSet, is_same: bool) -> DistortionModel {
    let p = (order + 1).pow(3);
    let coefficients = (0..directions.len() * p)
        .map(|i| if is_same { i % p } else { i })
        .map(|i| std::array::from_fn(|k| ((i * 7 + k * 3 + 1) as f64 * 0.618).fract() - 0.5))
        .collect();
    DistortionModel::new(
        order,
        directions,
        Weighting::Area,
        MapKind::Distortion,
        bounds(),
        coefficients,
    )
    .unwrap()
}

fn exact(
    model: &DistortionModel,
    places: impl IntoIterator<Item = (Point3<f64>, Unit<Vector3<f64>>)>,
) -> SampleSet {
    SampleSet {
        samples: places
            .into_iter()
            .map(|(position_mm, axis)| Sample {
                position_mm,
                axis,
                error: model
                    .evaluate(&position_mm, &axis, OutsidePolicy::Extrapolate)
                    .error,
            })
            .collect(),
        has_rotations: true,
        ambiguous: 0,
    }
}

fn noisy(set: &SampleSet, seed: u64) -> SampleSet {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [mm, rad] = [NOISE_MM, NOISE_RAD].map(|s| Normal::new(0.0, s).unwrap());
    let mut set = set.clone();
    for s in &mut set.samples {
        s.error = PoseError {
            position_mm: s.error.position_mm + Vector3::from_fn(|_, _| mm.sample(&mut rng)),
            rotation_rad: s.error.rotation_rad + Vector3::from_fn(|_, _| rad.sample(&mut rng)),
        };
    }
    set
}

fn fitted(set: &SampleSet, settings: &FitSettings, bounds: Option<Bounds>) -> (Fit, Support) {
    let task = Task::default();
    let decomposed = factor(set, settings, bounds, &task)
        .unwrap()
        .decompose()
        .unwrap();
    let damping = (settings.rcond, settings.ridge);
    let fit = decomposed.solve(damping.0, damping.1).unwrap().judged(set);
    let support = Support::of_fit(set, &decomposed, damping, &fit.model, &task).unwrap();
    (fit, support)
}

fn at(fit: &Fit, support: &Support, place: &(Point3<f64>, Unit<Vector3<f64>>)) -> SupportAt {
    support.at(&fit.model, &place.0, &place.1, OutsidePolicy::Extrapolate)
}

/// Mean squares over refits to fresh noise, of what the field scatters by and of what each refit
/// predicts: position in mm², rotation in rad², one a probe.
struct Scatter {
    scattered: Vec<[f64; 2]>,
    predicted: Vec<[f64; 2]>,
}

fn scatter(
    settings: &FitSettings,
    truth: &DistortionModel,
    samples: usize,
    refits: u64,
) -> Scatter {
    let set = exact(truth, places(samples, &bounds()));
    let probes: Vec<_> = places(samples + 60, &bounds()).split_off(samples);
    let mut values = vec![Vec::new(); probes.len()];
    let mut predicted = vec![[0.0; 2]; probes.len()];
    for seed in 0..refits {
        let (fit, support) = fitted(&noisy(&set, seed), settings, Some(bounds()));
        for ((probe, values), predicted) in probes.iter().zip(&mut values).zip(&mut predicted) {
            let e = fit
                .model
                .evaluate(&probe.0, &probe.1, OutsidePolicy::Clamp)
                .error;
            values.push(e);
            let at = at(&fit, &support, probe);
            predicted[0] += at.position_std_error_mm.powi(2) / refits as f64;
            predicted[1] += at.angle_std_error_rad.unwrap().powi(2) / refits as f64;
        }
    }
    let scattered = values
        .iter()
        .map(|values| {
            let n = values.len() as f64;
            let spread = |of: &dyn Fn(&PoseError) -> Vector3<f64>| {
                let mean = values.iter().map(of).sum::<Vector3<f64>>() / n;
                let squares: f64 = values.iter().map(|v| (of(v) - mean).norm_squared()).sum();
                squares / (n - 1.0)
            };
            [spread(&|e| e.position_mm), spread(&|e| e.rotation_rad)]
        })
        .collect();
    Scatter {
        scattered,
        predicted,
    }
}

/// Variance over three axes from `refits` fits scatters by `sqrt(2 / (3 (refits - 1)))` of itself.
fn relative_sigma(refits: u64) -> f64 {
    (2.0 / (3.0 * (refits - 1) as f64)).sqrt()
}

fn assert_agreement(what: &str, found: &Scatter, refits: u64) {
    let sigma = relative_sigma(refits);
    let mut ratios = [0.0; 2];
    for (s, p) in found.scattered.iter().zip(&found.predicted) {
        for k in 0..2 {
            let ratio = s[k] / p[k];
            // 60 probes of two values: five sigma happens once in ten thousand runs.
            assert!((ratio - 1.0).abs() < 5.0 * sigma, "{what}: {k}: {ratio}");
            ratios[k] += ratio / found.scattered.len() as f64;
        }
    }
    println!("{what}: variance ratios {ratios:?}");
}

#[test]
fn predicted_standard_errors_are_what_refits_scatter_by() {
    let refits = 200;
    for (method, is_same, ridge) in [
        (FitMethod::PerDirection, true, 0.0),
        (FitMethod::PerDirection, true, 0.05),
        (FitMethod::Joint, false, 0.0),
        (FitMethod::Joint, false, 0.02),
    ] {
        let settings = FitSettings {
            method,
            ridge,
            ..FitSettings::new(2, DirectionSet::Six)
        };
        let truth = truth(2, DirectionSet::Six, is_same);
        let found = scatter(&settings, &truth, 700, refits);
        assert_agreement(&format!("{method:?} {ridge}"), &found, refits);
    }
}
