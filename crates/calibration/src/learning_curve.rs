//! How much of a room's error each kind of model leaves, against how much was measured.

use super::kind_choice::{KindChoice, KindError, TriedKind, choose_kind};
use super::row_labels::{Grouping, RowLabels};
use trackwright_field::gaussian::chosen_rows;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::SelectSettings;
use trackwright_task::Task;

/// Fewest rows that a curve begins with: below, five folds are not representative.
pub const LEAST_ROWS: usize = 50;

/// The kinds of models on so many of the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct LearningPoint {
    /// That were taken by chance and cross-validated.
    pub rows: usize,
    pub choice: KindChoice,
}

/// Numbers of rows, each twice as many as the one before, up to all of them.
///
/// ```
/// use trackwright_calibration::learning_curve::doubled;
/// assert_eq!(doubled(4_000), [62, 125, 250, 500, 1_000, 2_000, 4_000]);
/// assert_eq!(doubled(60), [60]);
/// assert!(doubled(30).is_empty());
/// ```
pub fn doubled(all: usize) -> Vec<usize> {
    let halves = std::iter::successors(Some(all), |rows| Some(rows / 2));
    let mut rows: Vec<usize> = halves.take_while(|rows| *rows >= LEAST_ROWS).collect();
    rows.reverse();
    rows
}

/// Cross-validates the kinds on some of the rows, for each number of them. Smaller sets lie in larger
/// ones as far as chance has it; the same numbers give the same sets.
pub fn learning_curve(
    samples: &SampleSet,
    labels: &RowLabels,
    tried: &SelectSettings,
    kinds: &[TriedKind],
    sizes: &[usize],
    task: &Task,
) -> Result<Vec<LearningPoint>, KindError> {
    let all: usize = sizes.iter().sum();
    let mut before = 0;
    let mut points = Vec::with_capacity(sizes.len());
    for &size in sizes {
        let part = |rows: usize| rows as f64 / all.max(1) as f64;
        let rows = chosen_rows(samples.samples.len(), size);
        let some = samples.of_rows(&rows);
        let task = task.subtask(part(before), part(before + size));
        let (_, choice) = choose_kind(&some, labels_of(labels, &rows), tried, kinds, &task)?;
        points.push(LearningPoint { rows: rows.len(), choice });
        before += size;
    }
    Ok(points)
}

/// What is known of some of the rows.
pub(crate) fn labels_of(labels: &RowLabels, rows: &[usize]) -> RowLabels {
    let of = |all: &[usize]| -> Vec<usize> { rows.iter().map(|&row| all[row]).collect() };
    RowLabels {
        grouping: labels
            .grouping
            .as_ref()
            .map(|grouping| Grouping { groups: of(&grouping.groups), ..grouping.clone() }),
        sensors: labels.sensors.as_deref().map(of),
        deciding: labels.deciding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stay_with_their_rows() {
        let labels = RowLabels {
            grouping: Some(Grouping {
                by: "column pose".to_owned(),
                groups: vec![7, 8, 9, 7],
                is_found: false,
                places: None,
            }),
            sensors: Some(vec![0, 1, 0, 1]),
            deciding: None,
        };
        let some = labels_of(&labels, &[1, 3]);
        assert_eq!(some.groups(), Some(&[8, 7][..]));
        assert_eq!(some.sensors, Some(vec![1, 1]));
    }
}
