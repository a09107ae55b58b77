//! Well-spread samples of scattered points, and values between them.

/// A point with whatever else distinguishes positions, in one length.
pub type Position = [f64; 7];

/// Samples that a value between them is made of: on a surface about those of the next ring.
const NEIGHBOURS: usize = 8;

/// Square of the distance.
fn distance2(a: &Position, b: &Position) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The first `count` positions in farthest-first order: each is the one farthest from all before it,
/// the first of equals, and the first is the one farthest from the mean. Places that are not
/// numbers never come.
///
/// Each prefix covers all positions with at most twice the radius that any choice of as many could
/// (Gonzalez, Theoretical Computer Science 38, 1985).
pub fn farthest_first(positions: &[Position], count: usize) -> Vec<usize> {
    let is_finite = |p: &Position| p.iter().all(|v| v.is_finite());
    let finite = positions.iter().filter(|p| is_finite(p));
    let n = finite.clone().count();
    let mean: Position =
        std::array::from_fn(|k| finite.clone().map(|p| p[k] / n.max(1) as f64).sum());
    let mut away: Vec<f64> =
        positions.iter().map(|p| if is_finite(p) { distance2(p, &mean) } else { -1.0 }).collect();
    let mut order = Vec::with_capacity(count.min(n));
    while order.len() < count.min(n) {
        let mut next = 0;
        for (i, d) in away.iter().enumerate() {
            if *d > away[next] {
                next = i;
            }
        }
        if order.is_empty() {
            for d in away.iter_mut().filter(|d| **d >= 0.0) {
                *d = f64::INFINITY;
            }
        }
        for (d, p) in away.iter_mut().zip(positions) {
            *d = d.min(distance2(p, &positions[next]));
        }
        away[next] = -1.0;
        order.push(next);
    }
    order
}

/// The samples near a place and how much each counts; the counts add to 1.
///
/// Shepard's interpolation in the form of Franke and Little: `((R - d) / (R d))²` of the nearest
/// eight, `R` the distance of the next, so that a value changes continuously where the
/// neighbours do (Franke, Mathematics of Computation 38(157), 1982). A sample at the very place is
/// all that counts there. Empty without samples.
pub fn shares(
    at: &Position,
    samples: &[Position],
    without: Option<usize>,
    near: &mut Vec<(f64, usize)>,
    out: &mut Vec<(f64, usize)>,
) {
    near.clear();
    near.extend(
        samples
            .iter()
            .enumerate()
            .filter(|(i, _)| Some(*i) != without)
            .map(|(i, sample)| (distance2(at, sample), i)),
    );
    out.clear();
    let by_distance = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    let reach = if near.len() > NEIGHBOURS {
        let (_, &mut (beyond, _), _) = near.select_nth_unstable_by(NEIGHBOURS, by_distance);
        near.truncate(NEIGHBOURS);
        beyond.sqrt()
    } else {
        // All count: the farthest as if the next were twice as far.
        2.0 * near.iter().map(|n| n.0).fold(0.0, f64::max).sqrt()
    };
    near.sort_unstable_by(by_distance);
    let Some(&(nearest, first)) = near.first() else {
        return;
    };
    if nearest == 0.0 || nearest.sqrt() >= reach {
        out.push((1.0, first));
        return;
    }
    out.extend(near.iter().map(|&(d2, i)| {
        let d = d2.sqrt();
        (((reach - d).max(0.0) / (reach * d)).powi(2), i)
    }));
    let sum: f64 = out.iter().map(|s| s.0).sum();
    for (share, _) in out.iter_mut() {
        *share /= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_line(x: f64) -> Position {
        [x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    #[test]
    fn the_ends_come_first_and_then_the_middle() {
        let mut positions: Vec<_> = (0..=8).map(|i| on_line(f64::from(i))).collect();
        positions.push(on_line(f64::NAN));
        assert_eq!(farthest_first(&positions, 5), [0, 8, 4, 2, 6]);
        assert_eq!(farthest_first(&positions, 99).len(), 9);
        assert!(farthest_first(&[], 3).is_empty());
        // Of positions that are twice there both come, the second when all others are through.
        assert_eq!(farthest_first(&[on_line(1.0), on_line(1.0)], 2), [0, 1]);
    }

    #[test]
    fn shares_add_to_one_and_a_sample_is_its_own_value() {
        let samples: Vec<_> = (0..40)
            .map(|i| {
                let t = f64::from(i);
                [t.sin(), (2.0 * t).cos(), 0.1 * t, 0.0, 0.0, 0.0, 0.0]
            })
            .collect();
        let (mut near, mut out) = (Vec::new(), Vec::new());
        for i in 0..40 {
            shares(&samples[i], &samples, None, &mut near, &mut out);
            assert_eq!(out, [(1.0, i)]);
            shares(&samples[i], &samples, Some(i), &mut near, &mut out);
            assert!(out.iter().all(|s| s.0 >= 0.0 && s.1 != i));
            assert!((out.iter().map(|s| s.0).sum::<f64>() - 1.0).abs() < 1e-14);
        }
        shares(&samples[0], &[], None, &mut near, &mut out);
        assert!(out.is_empty());
        shares(&samples[0], &samples[..1], Some(0), &mut near, &mut out);
        assert!(out.is_empty());
    }
}
