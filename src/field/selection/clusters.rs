//! Finds clusters of positions, where the positions themselves show that there are some.

use nalgebra::Point3;

/// Fewest clusters that are worth the name.
const MIN_CLUSTERS: usize = 2;

/// Splits of an axis at most: far more than objects are placed at, and few enough to be tried.
const MAX_SPLITS: usize = 100;

/// How much wider than the widest interval the narrowest gap between intervals has to be, so that
/// intervals along an axis count as apart.
const MIN_SEPARATION: f64 = 1.0;

/// The cluster of each position, numbered from 0 by x, then y, then z; `None` where positions do
/// not come in clusters.
///
/// Along each axis the positions are split at the widest gaps between them, at as many as make the
/// narrowest of them widest against the widest interval that stays whole. An axis whose gaps are
/// not wider than its intervals is not split. Clusters are the cells of the splits that hold
/// positions.
pub fn find(positions_mm: &[Point3<f64>]) -> Option<Vec<usize>> {
    let splits: [Vec<f64>; 3] =
        std::array::from_fn(|k| splits_mm(positions_mm.iter().map(|p| p[k]).collect()));
    let cells: Vec<[usize; 3]> = positions_mm
        .iter()
        .map(|p| std::array::from_fn(|k| splits[k].partition_point(|&s| s < p[k])))
        .collect();
    let mut present = cells.clone();
    present.sort_unstable();
    present.dedup();
    // One position a cluster is no cluster: nothing belongs together.
    if present.len() < MIN_CLUSTERS || 2 * present.len() > positions_mm.len() {
        return None;
    }
    cells
        .iter()
        .map(|cell| present.binary_search(cell).ok())
        .collect()
}

/// Middles of the gaps at which coordinates fall apart, ascending; none where they do not.
fn splits_mm(mut values_mm: Vec<f64>) -> Vec<f64> {
    values_mm.sort_unstable_by(f64::total_cmp);
    let mut gaps: Vec<(f64, usize)> = values_mm
        .windows(2)
        .enumerate()
        .map(|(i, w)| (w[1] - w[0], i))
        .collect();
    gaps.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut best = (MIN_SEPARATION, 0);
    for count in 1..=gaps.len().min(MAX_SPLITS) {
        let separation = gaps[count - 1].0 / widest_interval_mm(&values_mm, &gaps[..count]);
        if separation > best.0 {
            best = (separation, count);
        }
    }
    let mut splits: Vec<f64> = gaps[..best.1]
        .iter()
        .map(|&(gap, i)| values_mm[i] + gap / 2.0)
        .collect();
    splits.sort_unstable_by(f64::total_cmp);
    splits
}

fn widest_interval_mm(sorted_mm: &[f64], gaps: &[(f64, usize)]) -> f64 {
    let mut ends: Vec<usize> = gaps.iter().map(|&(_, i)| i).collect();
    ends.sort_unstable();
    ends.push(sorted_mm.len() - 1);
    let mut start = 0;
    let mut widest: f64 = 0.0;
    for end in ends {
        widest = widest.max(sorted_mm[end] - sorted_mm[start]);
        start = end + 1;
    }
    widest
}
