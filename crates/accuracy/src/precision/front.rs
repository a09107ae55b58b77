//! The Pareto front: what nothing else beats in both time and error.

/// Whether each `(seconds, error)` is on the front: no other is at least as good in both and
/// better in one. Equals stand on it together; what is not a number never does.
pub fn on_front(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    points
        .iter()
        .map(|&p| !p.0.is_nan() && !p.1.is_nan() && !points.iter().any(|&q| beats(q, p)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_slower_and_worse_is_not_on_the_front() {
        let points = [(1.0, 9.0), (2.0, 4.0), (3.0, 5.0), (4.0, 1.0), (4.0, 2.0)];
        assert_eq!(on_front(&points), [true, true, false, true, false]);
    }

    #[test]
    fn equals_share_the_front_and_nan_has_no_place() {
        let points = [(1.0, 1.0), (1.0, 1.0), (0.5, f64::NAN), (f64::NAN, 0.0)];
        assert_eq!(on_front(&points), [true, true, false, false]);
    }

    #[test]
    fn an_exact_result_is_on_the_front_at_its_least_time() {
        let points = [(2.0, 0.0), (1.0, 0.0), (0.5, 1e-9)];
        assert_eq!(on_front(&points), [false, true, true]);
        assert_eq!(on_front(&[]), [false; 0]);
    }

    #[test]
    fn along_the_front_error_falls_as_time_grows() {
        // A sequence without pattern.
        let mut state = 7_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16)
        };
        let points: Vec<_> = (0..200).map(|_| (next(), next())).collect();
        let flags = on_front(&points);
        let mut front: Vec<_> =
            points.iter().zip(&flags).filter_map(|(&p, &f)| f.then_some(p)).collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(front.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 > w[1].1));
        for (p, _) in points.iter().zip(&flags).filter(|(_, f)| !**f) {
            assert!(front.iter().any(|q| q.0 <= p.0 && q.1 <= p.1));
        }
    }
}
