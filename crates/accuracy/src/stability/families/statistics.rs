//! Summary statistics of many trials.

use super::prelude::*;
use trackwright_simulation::Summary;

const MEAN: Quantity = Quantity::new("mean", 4.0, "1", "mean of the absolute values");

const RMS: Quantity = Quantity::new("root mean square", 4.0, "1", "itself");

const STD: Quantity = Quantity::new(
    "standard deviation",
    4.0,
    "root mean square over standard deviation (Chan, Golub & LeVeque, 1983)",
    "itself",
);

const PERCENTILE: Quantity =
    Quantity::new("median and 95th percentile", 2.0, "1", "the largest absolute value");

/// The value of a number in the sequence.
type Value = fn(usize, &mut Sequence) -> f64;

pub(super) fn family(extent: Extent) -> Family {
    let many = extent.of(10_000_000, 10_000);
    let kinds: [(&str, usize, Value); 8] = [
        ("values up to 1", many, |_, s| s.unit()),
        ("values around 0", many / 10, |_, s| s.signed()),
        ("values of 1e6 and a little", many / 10, |_, s| 1e6 + s.unit()),
        ("values of 1e6 and 1e-6 of scatter", 10_000, |_, s| 1e6 + 1e-6 * s.unit()),
        ("all values 0.1", many / 10, |_, _| 0.1),
        ("values from 1e-12 to 1e12", 10_000, |i, s| {
            s.signed() * 10.0_f64.powi((i % 25) as i32 - 12)
        }),
        ("values up to 1e-160", 10_000, |_, s| 1e-160 * s.unit()),
        ("values up to 1e160", 10_000, |_, s| 1e160 * s.unit()),
    ];
    Family::new(
        "statistics",
        "Mean, root mean square, standard deviation and percentiles, against sums in 192 \
            bits and order statistics of the sorted values.",
        &[MEAN, RMS, STD, PERCENTILE],
    )
    .with(
        kinds.map(|(name, count, value)| (format!("{count} {name}"), (count, value))),
        |m, &(count, value)| {
            let mut sequence = Sequence::new(2);
            let values: Vec<_> = (0..count).map(|i| value(i, &mut sequence)).collect();
            rows(m, &values)
        },
    )
    .with([("one value", vec![0.1]), ("two values", vec![1e6, 1e6 + 1e-9])], |m, v| rows(m, v))
}

fn rows(methods: &Methods, values: &[f64]) -> Found {
    let mut reordered = values.to_vec();
    let found = (methods.statistics)(&mut reordered).ok_or("has statistics")?;
    let n = values.len() as f64;
    let mean = values.iter().map(|&v| High::from(v)).sum::<High>() / n;
    let squares = |center: &High| -> High {
        values
            .iter()
            .map(|&v| {
                let d = High::from(v) - center;
                &d * &d
            })
            .sum()
    };
    let rms = (squares(&High::zero()) / n).sqrt();
    let std = (squares(&mean) / n).sqrt();
    let size = values.iter().map(|v| v.abs() / n).sum::<f64>();
    let off = |found: f64, expected: &High| (High::from(found) - expected).abs().to_f64();
    // Where all values are the same there is no condition: what is left of them is round-off.
    let (condition, scale) = if std.to_f64() > 0.0 {
        ((&rms / &std).to_f64(), std.to_f64())
    } else {
        (1.0, rms.to_f64())
    };
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let largest = sorted[0].abs().max(sorted[sorted.len() - 1].abs());
    let errors = [(found.median(), 0.5), (found.p95(), 0.95)]
        .map(|(found, p)| (off(found, &percentile(&sorted, p)), largest));
    Ok(vec![
        MEAN.row(1.0, off(found.mean(), &mean), size),
        RMS.row(1.0, off(found.rms(), &rms), rms.to_f64()),
        STD.row(condition, off(found.get(Summary::Std), &std), scale),
        PERCENTILE.worst(1.0, &errors),
    ])
}

/// Between order statistics at `(n − 1) p`, a place that `f64` holds exactly enough: its own
/// rounding moves the result by less than a neighbour's distance times n epsilon.
fn percentile(sorted: &[f64], p: f64) -> High {
    let place = (sorted.len() - 1) as f64 * p;
    let below = place.floor();
    let low = High::from(sorted[below as usize]);
    let high = High::from(sorted[(below as usize + 1).min(sorted.len() - 1)]);
    &low + (high - &low) * (place - below)
}
