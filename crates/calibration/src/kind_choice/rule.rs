//! The simplest kind of model that is as good as the best within the noise of the folds.

use super::kinds::KindScored;
use crate::room_model::{GeneratorChoice, RoomModel};
use trackwright_field::selection::scoring::PairedDifference;

/// How many times the best kind's error a simpler one may leave, however large the noise is.
const MOST_WORSE: f64 = 1.1;

/// What a generator that is known leaves of what models without one leave, position times angle, where it
/// is the tracker's. Of 213 rooms of other generators a known one was the best in one, of 54 rows: it left
/// 0.74, and the intervals of two of five tools missed. Where it is right it leaves 0.1 and less; where noise
/// is all that is left, either will do.
const RIGHT_GENERATOR_LEAVES: f64 = 0.5;

/// The place of the simplest kind of which position and angle are at most one standard error of the
/// folds' differences worse than those of the best (Breiman et al., *Classification and Regression Trees*,
/// 1984, section 3.4.3), and at most a tenth worse. The best has the least product of both.
///
/// A known generator counts only where it leaves clearly less than what needs none.
pub(super) fn best_of(kinds: &[KindScored]) -> Option<usize> {
    let without = kinds.iter().filter(|kind| generator(kind).is_none()).map(both);
    let without = without.min_by(f64::total_cmp);
    let is_right = |kind: &&KindScored| {
        let is_known = matches!(generator(kind), Some(GeneratorChoice::Known(_)));
        !is_known || without.is_none_or(|least| both(kind) <= RIGHT_GENERATOR_LEAVES * least)
    };
    let best = kinds.iter().filter(is_right).min_by(|a, b| both(a).total_cmp(&both(b)))?;
    let is_as_good = |kind: &KindScored| {
        let (own, least) = (kind.deciding(), best.deciding());
        let is_within = |difference: PairedDifference| difference.mean <= difference.std_error;
        is_within(own.position_difference(least))
            && is_within(own.rotation_difference(least))
            && leaves_at_most(MOST_WORSE, kind, best)
    };
    (0..kinds.len())
        .filter(|&i| is_right(&&kinds[i]))
        .filter(|&i| std::ptr::eq(&kinds[i], best) || is_as_good(&kinds[i]))
        .min_by_key(|&i| rank(&kinds[i]))
}

fn generator(kind: &KindScored) -> Option<&GeneratorChoice> {
    match &kind.model {
        RoomModel::Harmonic(order) => Some(&order.generator),
        RoomModel::Kriging | RoomModel::Bernstein { .. } => None,
    }
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

/// Simple kinds first: by what they assume of a room.
fn rank(kind: &KindScored) -> usize {
    match &kind.model {
        RoomModel::Bernstein { .. } if kind.candidate.is_some_and(|c| c.order == 0) => 0,
        RoomModel::Harmonic(order) => match &order.generator {
            GeneratorChoice::Known(_) => 1,
            GeneratorChoice::Learned(_) => 2,
        },
        // Where nothing was measured it returns to no correction; polynomials continue to anything.
        RoomModel::Kriging => 3,
        RoomModel::Bernstein { is_symmetric: true } => 4,
        RoomModel::Bernstein { is_symmetric: false } => 5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::room_model::HarmonicOrder;
    use trackwright_field::generator::Generator;
    use trackwright_field::harmonic::Loss;
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
    fn a_process_is_simpler_than_polynomials() {
        let polynomials = kind(RoomModel::PAPER, Some(3), &[(1.02, 0.1), (1.0, 0.1), (1.0, 0.1)]);
        let noisy = kriging(&[(1.05, 0.1), (0.95, 0.1), (1.06, 0.1)]);
        assert_eq!(best_of(&[polynomials.clone(), noisy]), Some(1));
        let worse = kriging(&[(1.04, 0.1), (1.03, 0.1), (1.04, 0.1)]);
        assert_eq!(best_of(&[polynomials, worse]), Some(0));
    }

    #[test]
    fn a_worse_angle_is_worse() {
        let raw = none(&[(1.0, 0.2), (1.0, 0.21), (1.0, 0.19)]);
        let better = kriging(&[(1.0, 0.1), (1.0, 0.11), (1.0, 0.1)]);
        assert_eq!(best_of(&[raw, better]), Some(1));
    }

    #[test]
    fn a_known_generator_has_to_explain_much() {
        let harmonic = |generator, folds: &[(f64, f64)]| {
            let order =
                HarmonicOrder { generator, degree: None, ridge: None, loss: Loss::default() };
            kind(RoomModel::Harmonic(order), None, folds)
        };
        let known = || GeneratorChoice::Known(Generator::planar_nine());
        let without = kriging(&[(1.0, 0.1), (1.0, 0.1)]);
        let little = harmonic(known(), &[(0.85, 0.085), (0.85, 0.085)]);
        assert_eq!(best_of(&[little, without.clone()]), Some(1));
        let much = harmonic(known(), &[(0.3, 0.09), (0.3, 0.09)]);
        assert_eq!(best_of(&[much.clone(), without.clone()]), Some(0));
        // One that is learned is as good; the known one needs less of the measurements.
        let learned = harmonic(GeneratorChoice::Learned(None), &[(0.29, 0.088), (0.3, 0.09)]);
        assert_eq!(best_of(&[learned, much, without]), Some(1));
    }
}
