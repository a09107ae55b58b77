//! The process against closed forms, drawn fields and input that has no answer.

use super::*;
use crate::FieldPoint;
use crate::generator::Generator;
use crate::harmonic::HarmonicModel;
use crate::harmonic::solid_harmonics::terms;
use crate::random_models::{Seeded, room};
use crate::samples::{PoseError, Sample, SampleSet};
use nalgebra::{Point3, Unit, Vector3};
use std::sync::Arc;
use trackwright_geometry::bounds::Bounds;
use trackwright_task::Task;

fn axis(seeded: &mut Seeded) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::from_fn(|_, _| seeded.normal()))
}

fn points(count: usize, bounds: &Bounds, seed: u64) -> Vec<FieldPoint> {
    let mut seeded = Seeded::new(seed);
    let each = (0..count).map(|_| FieldPoint::new(seeded.position(bounds, 0.0), axis(&mut seeded)));
    each.collect()
}

fn known_kernel() -> Kernel {
    let scale = |length_mm, axis_sine, variance| KernelScale {
        length_mm,
        axis_sine,
        x_axis_sine: f64::INFINITY,
        variance,
    };
    Kernel { scales: [scale(150.0, 0.5, 1.0), scale(50.0, 0.2, 0.2)], nugget: 1e-4 }
}

/// A field without measurements, of 2 mm and 0.01 rad.
fn prior_field(bounds: &Bounds) -> GaussianField {
    let variance = |c: usize| if c < 3 { 4.0 } else { 1e-4 };
    let far = FieldPoint::new(Point3::new(1e6, 0.0, 0.0), Vector3::z_axis());
    GaussianField {
        trend: Trend::None,
        kernel: known_kernel(),
        amplitude: Amplitude::flat(bounds),
        component_covariance: std::array::from_fn(|a| {
            std::array::from_fn(|b| if a == b { variance(a) } else { 0.0 })
        }),
        rows: vec![Row { point: far, error: [0.0; 6], noise_factor: 1.0 }],
        has_rotations: true,
        measured_rows: 1,
        left_out_rms_mm: 0.0,
        sensor_variance: None,
        refits: Vec::new(),
        registration: None,
    }
}

/// Samples of one field that the known kernel describes.
fn drawn_samples(count: usize, seed: u64) -> SampleSet {
    let bounds = room();
    let at = points(count, &bounds, seed);
    let covariance = known_kernel().lower_triangle(&at);
    let factor = covariance.llt(faer::Side::Lower).unwrap().L().to_owned();
    let mut seeded = Seeded::new(seed + 1);
    let unit = faer::Mat::from_fn(count, 6, |_, _| seeded.normal());
    let values = &factor * &unit;
    let samples = at.iter().enumerate().map(|(i, point)| {
        let three = |from: usize, size: f64| {
            Vector3::new(values[(i, from)], values[(i, from + 1)], values[(i, from + 2)]) * size
        };
        let turn = three(3, 0.01);
        Sample::new(
            point.position_mm,
            point.axis,
            PoseError {
                position_mm: three(0, 2.0),
                rotation_rad: turn - point.axis.into_inner() * point.axis.dot(&turn),
            },
        )
    });
    SampleSet { samples: samples.collect(), has_rotations: true, ambiguous: 0 }
}

fn fitted(set: &SampleSet) -> GaussianField {
    GaussianField::fit(set, None, &Task::default()).unwrap()
}

#[test]
fn a_coil_turned_round_reads_the_same() {
    let kernel = known_kernel();
    for pair in points(40, &room(), 1).chunks(2) {
        let turned = FieldPoint { axis: -pair[1].axis, ..pair[1] };
        let covariance = kernel.covariance(&pair[0], &pair[1]);
        assert_eq!(covariance, kernel.covariance(&pair[0], &turned));
        assert!(covariance > 0.0 && covariance < kernel.variance());
    }
}

#[test]
fn far_from_all_rows_nothing_is_known() {
    let at = points(5, &room(), 2);
    let posterior = prior_field(&room()).posterior(&at).unwrap();
    for i in 0..at.len() {
        assert!(posterior.mean[i].iter().all(|e| e.abs() < 1e-12));
        assert!((posterior.unit_variance[i] - 1.2).abs() < 1e-9);
    }
}

#[test]
fn variances_alone_are_those_of_draws() {
    let field = fitted(&drawn_samples(300, 3));
    let at = points(40, &room(), 2);
    let (alone, of_draws) =
        (field.unit_variances(&at).unwrap(), field.posterior(&at).unwrap().unit_variance);
    for (alone, of_draws) in alone.iter().zip(&of_draws) {
        assert!((alone - of_draws).abs() < 1e-9);
    }
}

#[test]
fn at_a_row_the_field_is_what_was_measured() {
    let set = drawn_samples(200, 3);
    let field = GaussianField { kernel: Kernel { nugget: 1e-8, ..known_kernel() }, ..fitted(&set) };
    let at: Vec<_> = field.rows.iter().take(20).map(|row| row.point).collect();
    let posterior = field.posterior(&at).unwrap();
    for (row, mean) in field.rows.iter().zip(&posterior.mean) {
        for (c, (error, mean)) in row.error.iter().zip(mean).enumerate() {
            let scale = if c < 3 { 2.0 } else { 0.01 };
            assert!((error - mean).abs() < 1e-5 * scale);
        }
    }
    assert!(posterior.unit_variance.iter().all(|v| *v < 1e-6));
}

#[test]
fn draws_have_the_stated_mean_and_variance() {
    let at = points(12, &room(), 4);
    let posterior = prior_field(&room()).posterior(&at).unwrap();
    let count = 4_000;
    let draws = posterior.draws(count, 7);
    let all = |c: usize| draws.iter().flatten().map(move |e| e[c]);
    let n = (count * at.len()) as f64;
    for (c, expected) in [(0, 4.0 * 1.2), (4, 1e-4 * 1.2)] {
        let mean = all(c).sum::<f64>() / n;
        let variance = all(c).map(|e| e * e).sum::<f64>() / n;
        // The draws of a point are independent: five standard deviations of their mean. Amplitudes
        // vary by chance, which makes the kurtosis of a component some 7.
        let std = (expected / count as f64).sqrt();
        assert!(mean.abs() < 5.0 * std, "{c}: {mean}");
        let bound = 5.0 * (7.0 / count as f64).sqrt();
        assert!((variance / expected - 1.0).abs() < bound, "{c}: {variance}");
    }
    assert_eq!(posterior.draws(3, 7)[..2], posterior.draws(3, 7)[..2]);
}

#[test]
fn draws_and_readings_hold_what_refits_differ_by() {
    // In front of the generator.
    let bounds = Bounds::from(([-100.0, -100.0, -350.0], [100.0, 100.0, -150.0]));
    let generator = Generator::planar_nine();
    let model = |size: f64| {
        let count = generator.coils.len() * terms(1);
        let coefficients = (0..count).map(|k| size * (1.0 + k as f64).sin()).collect();
        HarmonicModel::new(generator.clone(), bounds.center_mm(), 300.0, 1, coefficients).unwrap()
    };
    let sizes = [0.0, 1e-8, 3e-8];
    let certain = GaussianField { component_covariance: [[0.0; 6]; 6], ..prior_field(&bounds) };
    let field = GaussianField { refits: sizes.map(model).to_vec(), ..certain.clone() };
    // Along some axes the coils hardly determine a pose.
    let is_read = |point: &FieldPoint| {
        let read = |m: &HarmonicModel| m.axis_error_at(&point.position_mm, &point.axis).is_ok();
        field.refits.iter().all(read)
    };
    let at: Vec<_> = points(40, &bounds, 3).into_iter().filter(is_read).take(5).collect();
    let posterior = field.posterior(&at).unwrap();
    let draws = posterior.draws(4_000, 1);
    let readings = Readings::new(&field).errors(&at, &[PoseError::default(); 5]).unwrap();
    for (i, point) in at.iter().enumerate() {
        let errors: Vec<_> = (field.refits.iter())
            .map(|model| model.axis_error_at(&point.position_mm, &point.axis).unwrap())
            .collect();
        let mean = errors.iter().map(|e| e.position_mm).sum::<Vector3<f64>>() / 3.0;
        let squares: f64 = errors.iter().map(|e| (e.position_mm - mean).norm_squared()).sum();
        let expected_mm2 = squares * 2.0 / 3.0;
        let square = |draw: &DrawnErrors| (0..3).map(|c| draw[i][c].powi(2)).sum::<f64>();
        let found_mm2 = draws.iter().map(square).sum::<f64>() / draws.len() as f64;
        assert!(expected_mm2 > 1e-6, "{expected_mm2}");
        // Squares of 2,000 independent numbers scatter by 3 %.
        assert!((found_mm2 / expected_mm2 - 1.0).abs() < 0.12, "{found_mm2} {expected_mm2}");
        let stated_mm = readings[i].position_mm.rms;
        assert!((stated_mm.powi(2) / expected_mm2 - 1.0).abs() < 1e-6, "{stated_mm}");
    }
    // Refits that agree add nothing.
    let agreeing = GaussianField { refits: vec![model(1e-8); 3], ..certain };
    let none = agreeing.posterior(&at).unwrap().draws(2, 1);
    assert!(none.iter().flatten().flatten().all(|v| v.abs() < 1e-12));
}

#[test]
fn a_registration_moves_all_poses_as_one_body() {
    let bounds = room();
    let certain = GaussianField { component_covariance: [[0.0; 6]; 6], ..prior_field(&bounds) };
    let (position_std_mm, angle_std_rad) = (0.3, 2e-3);
    let center_mm = bounds.center_mm();
    let registration =
        Registration { position_std_mm, angle_std_rad, center_mm: center_mm.coords.into() };
    let field = GaussianField { registration: Some(registration), ..certain };
    let at = points(4, &bounds, 9);
    let draws = field.posterior(&at).unwrap().draws(4_000, 3);
    let part = |of: &[f64; 6], from: usize| Vector3::new(of[from], of[from + 1], of[from + 2]);
    for draw in &draws {
        let turn = part(&draw[0], 3);
        for (point, error) in at.iter().zip(draw) {
            // The same rotation everywhere, and positions that it explains.
            assert!((part(error, 3) - turn).norm() < 1e-12);
            let apart = turn.cross(&(point.position_mm - at[0].position_mm));
            assert!((part(error, 0) - part(&draw[0], 0) - apart).norm() < 1e-9);
        }
    }
    let readings = Readings::new(&field).errors(&at, &[PoseError::default(); 4]).unwrap();
    for (i, point) in at.iter().enumerate() {
        // ω × r has a variance of 2 r².
        let lever_mm = (point.position_mm - center_mm).norm();
        let expected_mm2 = 3.0 * position_std_mm.powi(2) + 2.0 * (angle_std_rad * lever_mm).powi(2);
        let squares: f64 = draws.iter().map(|draw| part(&draw[i], 0).norm_squared()).sum();
        let found_mm2 = squares / draws.len() as f64;
        assert!((found_mm2 / expected_mm2 - 1.0).abs() < 0.12, "{found_mm2} {expected_mm2}");
        let stated_mm = readings[i].position_mm.rms;
        assert!((stated_mm.powi(2) / expected_mm2 - 1.0).abs() < 1e-9, "{stated_mm}");
    }
}

#[test]
fn the_kernel_of_a_drawn_field_is_found() {
    let field = fitted(&drawn_samples(500, 5));
    let known = known_kernel();
    let ratio = field.kernel.scales[0].length_mm / known.scales[0].length_mm;
    // One field of 500 rows: lengths and sizes are known to some tens of percent.
    assert!((0.6..1.6).contains(&ratio), "length {ratio}");
    let sine = field.kernel.scales[0].axis_sine / known.scales[0].axis_sine;
    assert!((0.6..1.6).contains(&sine), "sine {sine}");
    let variance = field.component_covariance[0][0] * field.kernel.variance() / (4.0 * 1.2);
    assert!((0.4..2.5).contains(&variance), "variance {variance}");
}

#[test]
fn held_out_readings_lie_in_their_intervals() {
    let mut set = drawn_samples(600, 6);
    let held_out = set.samples.split_off(450);
    let field = fitted(&set);
    let mut inside = 0;
    for sample in &held_out {
        let point = FieldPoint::new(sample.position_mm, sample.axis);
        let at = field.posterior(&[point]).unwrap();
        let amplitude = field.amplitude.at(&point.position_mm);
        for c in 0..3 {
            let variance = at.unit_variance[0] * field.component_covariance[c][c];
            let left = sample.error.position_mm[c] - at.mean[0][c];
            inside += usize::from(left.abs() <= 1.96 * amplitude * variance.sqrt());
        }
    }
    let part = inside as f64 / (3 * held_out.len()) as f64;
    // 450 components, of which 150 are independent: one standard deviation is 1 to 1.8 %.
    assert!((0.89..=0.995).contains(&part), "{part}");
}

#[test]
fn outliers_count_for_nothing() {
    let mut set = drawn_samples(400, 8);
    let clean = fitted(&set);
    for i in (0..400).step_by(80) {
        set.samples[i].error.position_mm.x += 60.0;
    }
    let field = fitted(&set);
    let flagged: Vec<usize> = (0..400).filter(|&i| field.rows[i].noise_factor > 1.0).collect();
    assert_eq!(flagged, [0, 80, 160, 240, 320]);
    let ratio = field.component_covariance[0][0] / clean.component_covariance[0][0];
    assert!((0.7..1.4).contains(&ratio), "{ratio}");
}

#[test]
fn tables_with_little_information_have_an_answer() {
    let some = drawn_samples(60, 9);
    let changed = |change: &dyn Fn(usize, &mut Sample)| {
        let mut set = some.clone();
        for (i, sample) in set.samples.iter_mut().enumerate() {
            change(i, sample);
        }
        set
    };
    let tables = [
        ("few", {
            let mut set = some.clone();
            set.samples.truncate(4);
            set
        }),
        ("one place", changed(&|_, s| s.position_mm = Point3::new(1.0, 2.0, -300.0))),
        ("one line", changed(&|_, s| s.position_mm = Point3::new(s.position_mm.x, 0.0, -300.0))),
        ("one axis", changed(&|_, s| s.axis = Vector3::z_axis())),
        (
            "contradictory duplicates",
            changed(&|i, s| {
                s.position_mm = Point3::new((i / 2) as f64, 0.0, -300.0);
                s.axis = Vector3::x_axis();
            }),
        ),
        ("no error", changed(&|_, s| s.error = PoseError::default())),
    ];
    for (name, set) in tables {
        let field = fitted(&set);
        let at = points(6, &room(), 10);
        let draws = field.posterior(&at).unwrap().draws(4, 1);
        let is_finite = draws.iter().flatten().flatten().all(|e| e.is_finite());
        assert!(is_finite, "{name}");
    }
}

#[test]
fn samples_that_are_none_are_refused() {
    let mut set = drawn_samples(20, 11);
    let refused = |set: &SampleSet| GaussianField::fit(set, None, &Task::default()).unwrap_err();
    set.samples[7].error.position_mm.y = f64::NAN;
    assert_eq!(refused(&set), GaussianError::NotFinite(7));
    set.samples.truncate(3);
    assert_eq!(refused(&set), GaussianError::TooFewRows(3));
    let task = Task::default();
    task.cancel.cancel();
    let cancelled = GaussianField::fit(&drawn_samples(20, 12), None, &task);
    assert!(matches!(cancelled, Err(GaussianError::Cancelled(_))));
}

#[test]
fn amplitude_follows_where_errors_are_large() {
    let mut set = drawn_samples(600, 13);
    let bounds = room();
    let (middle, half) = (bounds.center_mm(), bounds.size_mm() * 0.5);
    for sample in &mut set.samples {
        let u = (sample.position_mm.x - middle.x) / half.x;
        let by = (0.8 * u).exp();
        sample.error.position_mm *= by;
        sample.error.rotation_rad *= by;
    }
    let field = fitted(&set);
    let at = |u: f64| {
        let x = middle.x + u * half.x;
        field.amplitude.at(&Point3::new(x, middle.y, middle.z))
    };
    let ratio = at(0.9) / at(-0.9);
    let known = (2.0 * 0.8 * 0.9_f64).exp();
    assert!((0.6..1.6).contains(&(ratio / known)), "{ratio} of {known}");
}

/// The field of measurements, its kernel and amplitude given.
fn conditioned(set: &SampleSet) -> GaussianField {
    let fitted = GaussianField::fit(set, None, &Task::default()).unwrap();
    GaussianField { kernel: known_kernel(), ..fitted }
}

#[test]
fn left_out_is_a_process_without_those_rows() {
    let process = conditioned(&drawn_samples(160, 3));
    let folds: Vec<Vec<usize>> = (0..4).map(|f| (f..160).step_by(4).collect()).collect();
    let found = Kriging::left_out(&process, &folds, &Task::default()).unwrap();
    for (fold, found) in folds.iter().zip(&found) {
        let rest = (0..160).filter(|row| !fold.contains(row));
        let without =
            GaussianField { rows: rest.map(|row| process.rows[row]).collect(), ..process.clone() };
        let without = Kriging::new(Arc::new(without), &Task::default()).unwrap();
        for (&row, found) in fold.iter().zip(found) {
            let expected = without.evaluate(&process.rows[row].point);
            for c in 0..6 {
                // Conditions of 1e4 and errors of some millimetres.
                assert!((found[c] - expected[c]).abs() < 1e-9, "{found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn compiled_mean_is_within_0_02_mm() {
    let process = conditioned(&drawn_samples(400, 4));
    let kriging = Kriging::new(Arc::new(process), &Task::default()).unwrap();
    let compiled = kriging.compiled(&room());
    let at = points(300, &room(), 5);
    for p in &at {
        let unit = room().to_unit(&p.position_mm);
        let found = compiled.evaluate(&unit, &p.axis);
        let expected = kriging.evaluate(p);
        let off_mm = (0..3).map(|c| (found[c] - expected[c]).powi(2)).sum::<f64>().sqrt();
        assert!(off_mm < 0.02, "{off_mm}");
    }
}

#[test]
fn the_mean_is_even_and_nears_the_rows() {
    let process = conditioned(&drawn_samples(300, 6));
    let kriging = Kriging::new(Arc::new(process.clone()), &Task::default()).unwrap();
    let (mut left, mut measured) = (0.0, 0.0);
    for row in &process.rows {
        let given = kriging.evaluate(&row.point);
        let turned = kriging.evaluate(&FieldPoint { axis: -row.point.axis, ..row.point });
        for c in 0..3 {
            assert!((given[c] - turned[c]).abs() < 1e-12);
            left += (row.error[c] - given[c]).powi(2);
            measured += row.error[c].powi(2);
        }
    }
    // What is cut off in the axis stays: a sixth of the variance of this kernel's second scale.
    assert!(left < 0.1 * measured, "{left} of {measured}");
}

#[test]
fn far_from_measurements_the_prior_is_the_error() {
    let bounds = Bounds::from(([-100.0; 3], [100.0; 3]));
    let mut field = prior_field(&bounds);
    let at = points(3, &bounds, 4);
    let none = vec![PoseError::default(); 3];
    let errors = |field: &GaussianField| Readings::new(field).errors(&at, &none).unwrap();
    for error in errors(&field) {
        // Three components of 2 mm, and of 0.01 rad, times the kernel's variance.
        assert!((error.position_mm.rms - (1.2 * 12.0_f64).sqrt()).abs() < 1e-6);
        assert!((error.angle_rad.unwrap().rms - (1.2 * 3e-4_f64).sqrt()).abs() < 1e-8);
        // Of a normal vector it would be 1.61; with an amplitude that varies by 0.83 on the logarithmic
        // scale, as a single row leaves it, it is 2.1.
        let ratio = error.position_mm.within_95 / error.position_mm.rms;
        assert!((1.9..2.4).contains(&ratio), "{ratio}");
    }
    field.sensor_variance = Some([1.0, 2.0, 3.0, 1e-4, 0.0, 0.0]);
    for error in errors(&field) {
        assert!((error.position_mm.rms - (1.2 * 12.0 + 6.0_f64).sqrt()).abs() < 1e-6);
        assert!((error.angle_rad.unwrap().rms - (1.2 * 3e-4 + 1e-4_f64).sqrt()).abs() < 1e-8);
    }
    let own = field.sensor_errors(2, 0, 4_000, 1);
    for sensor in 0..2 {
        let square = own.iter().map(|draw| draw[sensor][2].powi(2)).sum::<f64>() / 4_000.0;
        // One standard deviation of it is 2.2 %.
        assert!((square / 3.0 - 1.0).abs() < 0.1, "{square}");
    }
    // The same sensors in another design, others in another body.
    assert_eq!(field.sensor_errors(3, 0, 5, 1)[4][..2], own[4][..]);
    assert_ne!(field.sensor_errors(2, 1, 5, 1)[4], own[4]);
}

#[test]
fn parts_state_the_errors_that_all_rows_state() {
    let bounds = room();
    let rows = points(3_000, &bounds, 5);
    let row = |point: FieldPoint| Row { point, error: [0.0; 6], noise_factor: 1.0 };
    let field = GaussianField { rows: rows.into_iter().map(row).collect(), ..prior_field(&bounds) };
    let at = points(60, &bounds, 6);
    let whole =
        super::posterior::Conditioned::new(field.kernel, &field.rows, &field.amplitude).unwrap();
    let (_, explained) = whole.at(&at);
    let stated = Readings::new(&field).rms(&at, &[PoseError::default(); 60]).unwrap();
    for (i, stated) in stated.iter().enumerate() {
        let explained: f64 = explained.col(i).iter().map(|v| v * v).sum();
        // Three components of 2 mm.
        let expected_mm = (12.0_f64 * (whole.kernel.variance() - explained)).sqrt();
        let ratio = stated.position_mm / expected_mm;
        assert!((1.0 - 1e-6..1.02).contains(&ratio), "{ratio}");
    }
}

#[test]
fn parts_wanted_by_many_threads_at_once_are_the_same() {
    use rayon::prelude::*;
    let bounds = room();
    let row = |point: FieldPoint| Row { point, error: [0.1; 6], noise_factor: 1.0 };
    let rows = points(1_500, &bounds, 5).into_iter().map(row).collect();
    let field = GaussianField { rows, ..prior_field(&bounds) };
    let at = points(200, &bounds, 6);
    let none = vec![PoseError::default(); at.len()];
    let readings = Readings::new(&field);
    // One by one, in the order in which threads come to them.
    let each = at.par_iter().map(|point| readings.rms(&[*point], &none[..1]).unwrap()[0]);
    let found: Vec<_> = each.collect();
    for (one, together) in found.iter().zip(Readings::new(&field).rms(&at, &none).unwrap()) {
        // Sums of 700 squares in another order.
        assert!(
            (one.position_mm / together.position_mm - 1.0).abs() < 1e-9,
            "{one:?} {together:?}"
        );
    }
}
