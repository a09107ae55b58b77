//! Which candidate wins: the smallest that is as good as any.

use super::Scored;

/// How much worse than the least cross-validated RMS still counts as equally good.
pub const TOLERANCE: f64 = 0.01;

/// Places in the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Choice {
    pub best: usize,
    pub least: usize,
}

/// Places of the candidates that may be chosen: those that the samples determine, order 0 among
/// them; all of them where no other order is determined.
///
/// Held-out places are places of the same survey, often of the same lattice. How a model that has
/// a coefficient for each place swings between them is not heard there, and nothing but its ridge
/// holds it.
pub(super) fn eligible(table: &[Scored]) -> Vec<usize> {
    let is_some_determined = table
        .iter()
        .any(|row| row.is_determined && row.candidate.order > 0);
    (0..table.len())
        .filter(|&i| table[i].is_determined || !is_some_determined)
        .collect()
}

/// The smallest candidate whose position RMS is within [`TOLERANCE`] of the least; of equally
/// large ones the unregularised, if it is among them, else the one with the least RMS. `None`
/// where `places` are none.
pub(super) fn choose(table: &[Scored], places: Vec<usize>) -> Option<Choice> {
    let rms = |i: usize| table[i].deciding().position_rms_mm;
    let least = places
        .iter()
        .copied()
        .min_by(|&a, &b| rms(a).total_cmp(&rms(b)))?;
    let limit = rms(least) * (1.0 + TOLERANCE);
    let best = places
        .into_iter()
        .filter(|&i| rms(i) <= limit)
        .min_by(|&a, &b| {
            let key = |i: usize| {
                let candidate = &table[i].candidate;
                (candidate.coefficients(), candidate.ridge > 0.0)
            };
            key(a).cmp(&key(b)).then(rms(a).total_cmp(&rms(b)))
        })?;
    Some(Choice { best, least })
}
