//! Which rows are held out together: random folds with a fixed seed, row by row or by group.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A partition of a table's rows, each part held out once.
#[derive(Clone, Debug, PartialEq)]
pub struct Folds {
    /// Row numbers of each fold, ascending.
    pub rows: Vec<Vec<usize>>,
}

impl Folds {
    /// Every row by itself; folds differ by at most one row.
    pub fn of_rows(rows: usize, folds: usize, seed: u64) -> Self {
        let mut parts = vec![Vec::new(); folds];
        for (i, row) in shuffled(rows, seed).into_iter().enumerate() {
            parts[i % folds].push(row);
        }
        Self::sorted(parts)
    }

    /// Whole groups: in random order, each to the fold that has the fewest rows so far.
    ///
    /// `groups` names the group of each row by a number below `group_count`.
    pub fn of_groups(groups: &[usize], group_count: usize, folds: usize, seed: u64) -> Self {
        let mut members = vec![Vec::new(); group_count];
        for (row, &group) in groups.iter().enumerate() {
            members[group].push(row);
        }
        let mut parts: Vec<Vec<usize>> = vec![Vec::new(); folds];
        for group in shuffled(group_count, seed) {
            if let Some(least) = parts.iter_mut().min_by_key(|part| part.len()) {
                least.append(&mut members[group]);
            }
        }
        Self::sorted(parts)
    }

    fn sorted(mut rows: Vec<Vec<usize>>) -> Self {
        for part in &mut rows {
            part.sort_unstable();
        }
        Self { rows }
    }
}

/// Group numbers from 0 without gaps, in the order of first appearance, and how many there are.
pub fn numbered<T: Eq + std::hash::Hash + Clone>(labels: &[T]) -> (Vec<usize>, usize) {
    let mut known = std::collections::HashMap::new();
    let groups = labels
        .iter()
        .map(|label| {
            let next = known.len();
            *known.entry(label.clone()).or_insert(next)
        })
        .collect();
    (groups, known.len())
}

/// `0..len` in random order (Fisher-Yates), the same on every machine.
fn shuffled(len: usize, seed: u64) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut order: Vec<usize> = (0..len).collect();
    for i in (1..len).rev() {
        // The remainder's bias is below len / 2⁶⁴.
        order.swap(i, (rng.next_u64() % (i as u64 + 1)) as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_held_out_exactly_once() {
        let groups: Vec<usize> = (0..103).map(|i| i * i % 17).collect();
        let (groups, count) = numbered(&groups);
        for folds in [Folds::of_rows(103, 5, 1), Folds::of_groups(&groups, count, 4, 1)] {
            let mut all = folds.rows.concat();
            all.sort_unstable();
            assert_eq!(all, (0..103).collect::<Vec<_>>());
        }
    }

    #[test]
    fn folds_of_rows_differ_by_at_most_one_row() {
        let sizes: Vec<_> = Folds::of_rows(103, 5, 9).rows.iter().map(Vec::len).collect();
        assert_eq!(sizes, [21, 21, 21, 20, 20]);
    }

    #[test]
    fn a_group_is_never_split_and_folds_stay_balanced() {
        let groups: Vec<usize> = (0..200).map(|i| i / 10).collect();
        let folds = Folds::of_groups(&groups, 20, 5, 3);
        for part in &folds.rows {
            assert_eq!(part.len(), 40);
            for row in part {
                let group = groups[*row];
                let whole = (0..200).filter(|&r| groups[r] == group);
                assert!(whole.into_iter().all(|r| part.contains(&r)));
            }
        }
    }

    #[test]
    fn folds_depend_on_the_seed_alone() {
        assert_eq!(Folds::of_rows(50, 5, 1), Folds::of_rows(50, 5, 1));
        assert_ne!(Folds::of_rows(50, 5, 1), Folds::of_rows(50, 5, 2));
    }
}
