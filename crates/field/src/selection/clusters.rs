//! Finds clusters of positions, where the positions themselves show that there are some.
//!
//! Single linkage: the minimum spanning tree of the positions (Prim 1957), cut at its longest
//! edges, or where two lengths are distinct.

use super::folds::numbered;
use nalgebra::Point3;
use trackwright_geometry::bounds::Bounds;

/// Most positions that are looked at: the tree takes time with their square.
const MAX_POSITIONS: usize = 20_000;

/// How much longer than the widest cluster is wide every way from one cluster to another has to
/// be. From here on any two positions of a cluster are nearer to each other than to any of another.
const MIN_SEPARATION: f64 = 1.0;

/// Positions that a cluster has to have on average; with fewer hardly anything belongs together.
const MIN_MEAN_SIZE: usize = 2;

/// How much longer the median way from place to place has to be than that between readings of a
/// place. Random designs (uniform, normal, 40 to 2,000 positions), jittered lattices and paths give
/// 1.0 to 2.2; five readings a place that scatter by a tenth of the places' spacing give 8.
const MIN_SPACING_RATIO: f64 = 4.0;

/// Part of the rows that has to be at places which were measured more than once.
const MIN_REPEATED_SHARE: f64 = 0.1;

/// Part of the rows that has to be at places narrower than the places are apart.
const MIN_NARROW_SHARE: f64 = 0.9;

/// Edges below this part of the longest are as good as zero, whose logarithm is meaningless.
const ROUND_OFF: f64 = 1e-9;

/// An edge of the tree, mm.
struct Edge {
    length_mm: f64,
    ends: [usize; 2],
}

/// The minimum spanning tree of positions.
pub(super) struct Tree<'a> {
    positions_mm: &'a [Point3<f64>],
    /// The longest first.
    edges: Vec<Edge>,
}

/// Rows at the same places, where two lengths separate readings of a place from the next place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Repeats {
    /// The place of each position, numbered from 0 in order of appearance.
    pub groups: Vec<usize>,
    pub count: usize,
    /// Median edge of the tree from place to place, mm.
    pub spacing_mm: f64,
    /// The widest extent of each place, mm.
    pub widths_mm: Vec<f64>,
}

/// The cluster of each position, numbered from 0 in order of appearance; `None` where positions do
/// not come in clusters, or are more than 20,000.
///
/// Clusters are apart where every way between two of them is longer than the widest is wide; of
/// all such partitions the one is taken whose clusters are farthest apart in that measure.
pub fn find(positions_mm: &[Point3<f64>]) -> Option<Vec<usize>> {
    Tree::of(positions_mm)?.clusters()
}

impl<'a> Tree<'a> {
    /// `None` for fewer than two positions, and for more than 20,000.
    pub fn of(positions_mm: &'a [Point3<f64>]) -> Option<Self> {
        if !(2..=MAX_POSITIONS).contains(&positions_mm.len()) {
            return None;
        }
        let mut edges = spanning_tree(positions_mm);
        edges.sort_unstable_by(|a, b| b.length_mm.total_cmp(&a.length_mm));
        Some(Self { positions_mm, edges })
    }

    /// See [`find`].
    pub fn clusters(&self) -> Option<Vec<usize>> {
        let mut best: Option<(f64, Vec<usize>)> = None;
        for cut in 1..=(self.positions_mm.len() / MIN_MEAN_SIZE).saturating_sub(1) {
            let least = best.as_ref().map_or(MIN_SEPARATION, |(least, _)| *least);
            let gap_mm = self.edges[cut - 1].length_mm;
            // A cluster is at least as wide as the longest edge within it.
            let bound = gap_mm / self.edges[cut].length_mm;
            if bound > least {
                let clusters = components(self.positions_mm.len(), &self.edges[cut..]);
                let separation = gap_mm / widest_mm(&widths_mm(self.positions_mm, &clusters));
                if separation > least {
                    best = Some((separation, clusters));
                }
            }
        }
        best.map(|(_, clusters)| clusters)
    }

    /// Readings that scatter about places, even where a few places stand as near to each other as
    /// readings do: the edges' logarithms are split where the variance between the two classes is
    /// largest (Otsu 1979), and the classes' medians have to be [`MIN_SPACING_RATIO`] apart.
    ///
    /// `None` where there are no two such lengths, where hardly any rows are repeated, or where
    /// what the short edges hold together is wider than the places are apart, as a densely measured
    /// part of the volume or a path is.
    pub fn repeats(&self) -> Option<Repeats> {
        let longest_mm = self.edges.first()?.length_mm;
        let floor_mm = longest_mm * ROUND_OFF;
        let lengths: Vec<f64> = self.edges.iter().map(|e| e.length_mm.max(floor_mm)).collect();
        let cut = two_classes(&lengths)?;
        let (spacing_mm, within_mm) = (lengths[cut / 2], lengths[(cut + lengths.len()) / 2]);
        if spacing_mm < MIN_SPACING_RATIO * within_mm {
            return None;
        }
        let groups = components(self.positions_mm.len(), &self.edges[cut..]);
        let widths_mm = widths_mm(self.positions_mm, &groups);
        let mut sizes = vec![0_usize; widths_mm.len()];
        groups.iter().for_each(|&group| sizes[group] += 1);
        let rows_where = |is: &dyn Fn(usize) -> bool| -> f64 {
            let rows: usize = (0..sizes.len()).filter(|&g| is(g)).map(|g| sizes[g]).sum();
            rows as f64 / groups.len() as f64
        };
        let are_repeated = rows_where(&|g| sizes[g] > 1) >= MIN_REPEATED_SHARE;
        let are_narrow = rows_where(&|g| widths_mm[g] < spacing_mm) >= MIN_NARROW_SHARE;
        (are_repeated && are_narrow).then_some(Repeats {
            count: sizes.len(),
            groups,
            spacing_mm,
            widths_mm,
        })
    }
}

/// How many of the lengths, which fall, belong to the class of the longer ones; `None` where they
/// are all the same.
fn two_classes(lengths: &[f64]) -> Option<usize> {
    let logs: Vec<f64> = lengths.iter().map(|length| length.ln()).collect();
    let all: f64 = logs.iter().sum();
    let mut sum = 0.0;
    let mut best = None;
    let mut most = 0.0;
    for cut in 1..logs.len() {
        sum += logs[cut - 1];
        let (longer, shorter) = (cut as f64, (logs.len() - cut) as f64);
        let apart = sum / longer - (all - sum) / shorter;
        let between = longer * shorter * apart * apart;
        if between > most {
            (most, best) = (between, Some(cut));
        }
    }
    best
}

/// The minimum spanning tree, one edge fewer than positions.
fn spanning_tree(positions_mm: &[Point3<f64>]) -> Vec<Edge> {
    // Positions outside the tree, and their nearest one inside it.
    let mut outside: Vec<(usize, f64, usize)> =
        (1..positions_mm.len()).map(|i| (i, f64::INFINITY, 0)).collect();
    let mut tree = Vec::with_capacity(outside.len());
    let mut newest = 0;
    while !outside.is_empty() {
        let mut nearest = (0, f64::INFINITY);
        for (place, (i, square, from)) in outside.iter_mut().enumerate() {
            let to_newest = (positions_mm[*i] - positions_mm[newest]).norm_squared();
            if to_newest < *square {
                (*square, *from) = (to_newest, newest);
            }
            if *square < nearest.1 {
                nearest = (place, *square);
            }
        }
        let (i, square, from) = outside.swap_remove(nearest.0);
        tree.push(Edge { length_mm: square.sqrt(), ends: [from, i] });
        newest = i;
    }
    tree
}

/// What the edges hold together, numbered in order of appearance.
fn components(len: usize, edges: &[Edge]) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..len).collect();
    for edge in edges {
        let [a, b] = edge.ends.map(|i| root(&mut parent, i));
        parent[a] = b;
    }
    let roots: Vec<usize> = (0..len).map(|i| root(&mut parent, i)).collect();
    numbered(&roots).0
}

/// The root of a tree of parents, shortening the way to it.
fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// The diagonal of a box around each cluster: no two of its positions are farther apart.
fn widths_mm(positions_mm: &[Point3<f64>], clusters: &[usize]) -> Vec<f64> {
    let count = clusters.iter().max().map_or(0, |last| last + 1);
    let mut boxes: Vec<Option<Bounds>> = vec![None; count];
    for (p, &cluster) in positions_mm.iter().zip(clusters) {
        let around = &mut boxes[cluster];
        let corners = around.map(|b| [b.min_mm, b.max_mm]);
        *around = Bounds::around(corners.into_iter().flatten().chain([*p]));
    }
    boxes.iter().flatten().map(Bounds::diagonal_mm).collect()
}

fn widest_mm(widths_mm: &[f64]) -> f64 {
    widths_mm.iter().copied().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_models::Seeded;
    use nalgebra::Vector3;

    fn uniform() -> impl FnMut() -> f64 {
        let mut seeded = Seeded::new(7);
        move || seeded.uniform()
    }

    #[test]
    fn repeated_places_are_clusters() {
        let mut next = uniform();
        let places: Vec<_> = (0..40).map(|_| Point3::new(next(), next(), next()) * 400.0).collect();
        // Repeats lie within 0.1 mm, and two places are hardly ever within 1 mm.
        let positions: Vec<_> = (0..400)
            .map(|i| places[i % 40] + Vector3::new(next(), next(), next()) * 0.05)
            .collect();
        let clusters = find(&positions).unwrap();
        assert_eq!(clusters, (0..400).map(|i| i % 40).collect::<Vec<_>>());
    }

    #[test]
    fn blocks_on_a_lattice_are_clusters() {
        let mut next = uniform();
        let mut positions = Vec::new();
        for i in 0..270 {
            let corner = Vector3::new((i % 3) as f64, (i / 3 % 3) as f64, (i / 9 % 3) as f64);
            let inside = Vector3::new(next(), next(), next()) * 28.0;
            positions.push(Point3::from(corner * 125.0 + inside));
        }
        let clusters = find(&positions).unwrap();
        assert_eq!(clusters, (0..270).map(|i| i % 27).collect::<Vec<_>>());
    }

    #[test]
    fn scattered_positions_are_no_clusters() {
        let mut next = uniform();
        let positions: Vec<_> =
            (0..500).map(|_| Point3::new(next(), next(), next()) * 400.0).collect();
        assert_eq!(find(&positions), None);
    }

    #[test]
    fn paths_and_lattices_are_no_clusters() {
        let path: Vec<_> =
            (0..200).map(|i| Point3::new(f64::from(i), 0.0, f64::from(i % 5))).collect();
        assert_eq!(find(&path), None);
        let lattice: Vec<_> = (0..125)
            .map(|i| Point3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64))
            .collect();
        assert_eq!(find(&lattice), None);
    }

    #[test]
    fn exact_repeats_are_clusters() {
        let twice: Vec<_> = (0..20).map(|i| Point3::new(f64::from(i % 10), 0.0, 0.0)).collect();
        assert_eq!(find(&twice).unwrap(), (0..20).map(|i| i % 10).collect::<Vec<_>>());
        assert_eq!(find(&[Point3::origin(); 9]), None);
        assert_eq!(find(&[Point3::origin()]), None);
        assert_eq!(find(&[]), None);
    }
}
