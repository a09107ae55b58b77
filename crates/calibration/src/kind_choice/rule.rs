//! The simplest kind of model that is as good as the best within the noise of the folds.

use super::KindScored;
use crate::room_model::{GeneratorChoice, RoomModel};
use trackwright_field::selection::scoring::PairedDifference;

/// How many times the best kind's error a simpler one may leave, however large the noise is.
const MOST_WORSE: f64 = 1.1;

/// How many times the error of polynomials a process may leave that is taken in their place. By eight paths of
/// `tests/rooms/others.rs`: on seven of them kriging leaves at most 1.13 times as much.
const MOST_WORSE_PROCESS: f64 = 1.2;

/// The place of the simplest kind of which position and angle are at most one standard error of the
/// folds' differences worse than those of the best (Breiman et al., *Classification and Regression Trees*,
/// 1984, section 3.4.3), and at most a tenth worse. The best has the least product of both.
///
/// Polynomials have to be a fifth better than a process: it is as uncertain as before where nothing was
/// measured, such as in orientations that a path has not, and they continue to anything.
pub(super) fn best_of(kinds: &[KindScored]) -> Option<usize> {
    let best = kinds.iter().min_by(|a, b| both(a).total_cmp(&both(b)))?;
    let is_as_good = |kind: &KindScored| {
        let (own, least) = (kind.deciding(), best.deciding());
        let is_within = |difference: PairedDifference| difference.mean <= difference.std_error;
        is_within(own.position_difference(least))
            && is_within(own.rotation_difference(least))
            && leaves_at_most(MOST_WORSE, kind, best)
    };
    let simplest = (0..kinds.len())
        .filter(|&i| std::ptr::eq(&kinds[i], best) || is_as_good(&kinds[i]))
        .min_by_key(|&i| rank(&kinds[i]))?;
    let found = &kinds[simplest];
    let replaces = |kind: &KindScored| {
        kind.model == RoomModel::Kriging && leaves_at_most(MOST_WORSE_PROCESS, kind, found)
    };
    let process = is_polynomials(found).then(|| kinds.iter().position(replaces));
    Some(process.flatten().unwrap_or(simplest))
}

/// In position and in angle.
fn leaves_at_most(times: f64, kind: &KindScored, other: &KindScored) -> bool {
    let [own, other] = [kind, other].map(|kind| kind.deciding().overall);
    let [own_rad, other_rad] = [own, other].map(|scores| scores.angle_rms_rad.unwrap_or(0.0));
    own.position_rms_mm <= times * other.position_rms_mm && own_rad <= times * other_rad
}

/// Position and angle as one figure: a part less of either makes it less by as much.
fn both(kind: &KindScored) -> f64 {
    let scores = kind.deciding().overall;
    scores.position_rms_mm * scores.angle_rms_rad.unwrap_or(1.0)
}

/// Whether it is polynomials of the place, which continue outside the poses that were measured.
fn is_polynomials(kind: &KindScored) -> bool {
    matches!(kind.model, RoomModel::Bernstein { .. })
        && kind.candidate.is_some_and(|candidate| candidate.order > 0)
}

/// Simple kinds first: by what they assume of a room.
fn rank(kind: &KindScored) -> usize {
    match &kind.model {
        RoomModel::Bernstein { .. } if kind.candidate.is_some_and(|c| c.order == 0) => 0,
        RoomModel::Harmonic(order) => match order.generator {
            GeneratorChoice::Known(_) => 1,
            GeneratorChoice::Learned => 2,
        },
        RoomModel::Bernstein { is_symmetric: true } => 3,
        RoomModel::Bernstein { is_symmetric: false } => 4,
        RoomModel::Kriging => 5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_field::selection::other::OtherScored;
    use trackwright_field::selection::scoring::{FoldSums, HeldOutScores};
    use trackwright_field::selection::{Candidate, HoldOutBy};
    use trackwright_geometry::directions::DirectionSet;

    fn kind(model: RoomModel, order: Option<usize>, folds: &[(f64, f64)]) -> KindScored {
        let sums = folds.iter().map(|(position_mm, angle_rad)| FoldSums {
            rows: 1,
            position_squares_mm2: position_mm * position_mm,
            position_max_square_mm2: position_mm * position_mm,
            rotation_squares_rad2: angle_rad * angle_rad,
        });
        let scores = HeldOutScores::of_sums(sums.collect(), true);
        KindScored {
            model,
            candidate: order.map(|order| Candidate {
                order,
                directions: DirectionSet::One,
                ridge: 0.0,
            }),
            scores: OtherScored {
                hold_outs: vec![(HoldOutBy::Rows, scores)],
                decided_by: HoldOutBy::Rows,
            },
        }
    }

    fn none(folds: &[(f64, f64)]) -> KindScored {
        kind(RoomModel::PAPER, Some(0), folds)
    }

    fn kriging(folds: &[(f64, f64)]) -> KindScored {
        kind(RoomModel::Kriging, None, folds)
    }

    #[test]
    fn within_the_noise_the_simpler_kind_wins() {
        let raw = none(&[(1.02, 0.1), (1.08, 0.1), (1.03, 0.1)]);
        let noisy = kriging(&[(1.05, 0.1), (0.95, 0.1), (1.03, 0.1)]);
        assert_eq!(best_of(&[noisy.clone(), raw.clone()]), Some(1));
        let clear = kriging(&[(0.99, 0.1), (1.05, 0.1), (1.0, 0.1)]);
        assert_eq!(best_of(&[clear, raw]), Some(0));
    }

    #[test]
    fn a_tenth_worse_is_worse_whatever_the_noise() {
        let raw = none(&[(2.0, 0.1), (1.0, 0.1), (1.5, 0.1)]);
        let better = kriging(&[(1.0, 0.1), (1.0, 0.1), (1.55, 0.1)]);
        assert_eq!(best_of(&[better, raw]), Some(0));
    }

    #[test]
    fn a_process_replaces_slightly_better_polynomials() {
        let folds = |by: f64| [(by, 0.1), (1.1 * by, 0.1), (1.2 * by, 0.1)];
        let polynomials = kind(RoomModel::PAPER, Some(3), &folds(1.0));
        let near = [polynomials.clone(), kriging(&folds(1.15))];
        assert_eq!(best_of(&near), Some(1));
        let far = [polynomials, kriging(&folds(1.25))];
        assert_eq!(best_of(&far), Some(0));
        // What needs no measurements is simpler than both.
        let raw = [none(&folds(1.0)), kriging(&folds(1.15))];
        assert_eq!(best_of(&raw), Some(0));
    }

    #[test]
    fn a_worse_angle_is_worse() {
        let raw = none(&[(1.0, 0.2), (1.0, 0.21), (1.0, 0.19)]);
        let better = kriging(&[(1.0, 0.1), (1.0, 0.11), (1.0, 0.1)]);
        assert_eq!(best_of(&[raw, better]), Some(1));
    }
}
