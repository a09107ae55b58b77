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

#[cfg(test)]
mod tests {
    use super::super::{Candidate, Scores};
    use super::*;
    use crate::geometry::directions::DirectionSet;

    fn row(order: usize, ridge: f64, position_rms_mm: f64) -> Scored {
        Scored {
            candidate: Candidate {
                order,
                directions: DirectionSet::One,
                ridge,
            },
            by_row: Scores {
                position_rms_mm,
                position_max_mm: 1.0,
                angle_rms_rad: None,
            },
            by_group: None,
            is_determined: true,
        }
    }

    fn chosen(table: &[Scored]) -> (usize, f64) {
        let best = choose(table, eligible(table)).unwrap().best;
        (table[best].candidate.order, table[best].candidate.ridge)
    }

    #[test]
    fn the_smallest_within_one_percent_of_the_least_wins() {
        let rows = |second| [row(0, 0.0, 2.0), row(2, 0.0, second), row(3, 0.0, 1.0)];
        assert_eq!(chosen(&rows(1.009)), (2, 0.0));
        assert_eq!(chosen(&rows(1.011)), (3, 0.0));
        let nothing_helps = [row(0, 0.0, 1.009), row(1, 0.0, 1.0)];
        assert_eq!(chosen(&nothing_helps), (0, 0.0));
    }

    #[test]
    fn no_ridge_goes_before_a_ridge_that_hardly_helps() {
        let rows = |plain| [row(2, 0.0, plain), row(2, 1e-3, 1.004), row(2, 1e-2, 1.0)];
        assert_eq!(chosen(&rows(1.009)), (2, 0.0));
        assert_eq!(chosen(&rows(1.011)), (2, 1e-2));
    }

    #[test]
    fn groups_decide_where_there_are_any() {
        let mut table = [row(1, 0.0, 1.0), row(2, 0.0, 0.1)];
        for (row, rms) in table.iter_mut().zip([1.0, 5.0]) {
            row.by_group = Some(Scores {
                position_rms_mm: rms,
                ..row.by_row
            });
        }
        assert_eq!(chosen(&table), (1, 0.0));
    }

    #[test]
    fn a_score_that_is_no_number_never_wins() {
        assert_eq!(chosen(&[row(1, 0.0, f64::NAN), row(2, 0.0, 3.0)]), (2, 0.0));
    }

    #[test]
    fn what_is_not_determined_is_not_chosen_while_anything_else_is() {
        let mut table = [row(0, 0.0, 9.0), row(1, 0.0, 2.0), row(6, 1e-3, 1.0)];
        table[2].is_determined = false;
        assert_eq!(chosen(&table), (1, 0.0));
        assert_eq!(chosen(&[table[0], table[2]]), (6, 1e-3));
    }
}
