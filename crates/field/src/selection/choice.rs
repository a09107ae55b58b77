//! Which candidate wins: the smallest that is as good as any, and of those that are equally good
//! within the noise of the folds one that is better in position and angle.

use super::scoring::{HeldOutScores, PairedDifference};

/// How much worse than the least cross-validated RMS still counts as equally good.
pub const TOLERANCE: f64 = 0.01;

/// Standard errors, paired by fold, up to which a difference may be noise.
const NOISE: f64 = 1.0;

/// Standard errors beyond which it is not taken for noise. With five folds a difference of none is
/// beyond it in 6 of 100 cases to the one side.
const CLEAR: f64 = 2.0;

/// What a choice needs to know of a candidate, whatever kind of model it is.
#[derive(Clone, Copy, Debug)]
pub struct Contender<'a> {
    /// Number of coefficients, or what stands for it.
    pub size: usize,
    pub is_regularised: bool,
    /// Whether the samples determine all of it.
    pub is_admissible: bool,
    pub scores: &'a HeldOutScores,
}

/// Places among the contenders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    pub best: usize,
    /// The one with the least position RMS.
    pub least: usize,
    /// What position alone would have chosen, where that is not the best.
    pub instead_of: Option<usize>,
}

impl Contender<'_> {
    fn position(&self) -> f64 {
        self.scores.overall.position_rms_mm
    }

    fn angle(&self) -> f64 {
        self.scores.overall.angle_rms_rad.unwrap_or(0.0)
    }

    /// Position and angle as one figure: a part less of either makes it less by as much.
    fn both(&self) -> f64 {
        (self.position() * self.angle()).sqrt()
    }

    /// Whether it is not worse than another in position, clearly better in angle, and better in
    /// both together.
    fn is_better_on_both(&self, other: &Self) -> bool {
        let position = self.scores.position_difference(other.scores);
        let angle = self.scores.rotation_difference(other.scores);
        position.is_at_most_noise()
            && angle.is_clearly_less()
            && self.angle() < other.angle() * (1.0 - TOLERANCE)
            && self.both() < other.both() * (1.0 - TOLERANCE)
    }
}

impl PairedDifference {
    fn is_at_most_noise(&self) -> bool {
        self.mean <= NOISE * self.std_error
    }

    fn is_clearly_less(&self) -> bool {
        self.mean < -CLEAR * self.std_error
    }
}

/// By position, the smallest candidate whose RMS is within [`TOLERANCE`] of the least; of equally
/// large ones the unregularised, if it is among them, else the one with the least RMS. Where
/// orientations were measured, one that is better on both takes its place: not worse in position
/// than the noise of the folds, clearly better in angle; of several such the smallest within
/// [`TOLERANCE`] of the least geometric mean of position and angle RMS.
///
/// Only `eligible` ones are chosen. `None` for no contenders.
///
/// ```
/// use trackwright_field::selection::scoring::{FoldSums, HeldOutScores};
/// use trackwright_field::selection::{Contender, choose};
///
/// let scores = [2.0, 1.009, 1.0].map(|rms_mm: f64| {
///     let fold = FoldSums { rows: 1, position_squares_mm2: rms_mm * rms_mm, ..FoldSums::default() };
///     HeldOutScores::of_sums(vec![fold], false)
/// });
/// let contender = |(size, scores)| {
///     Contender { size, is_regularised: false, is_admissible: true, scores }
/// };
/// let contenders: Vec<_> = [0, 27, 64].into_iter().zip(&scores).map(contender).collect();
/// assert_eq!(choose(&contenders).unwrap().best, 1);
/// ```
pub fn choose(contenders: &[Contender]) -> Option<Choice> {
    let eligible = eligible(contenders);
    let (by_position, least) = smallest(contenders, &eligible, Contender::position)?;
    let has_angles = contenders.iter().all(|c| c.scores.overall.angle_rms_rad.is_some());
    let better: Vec<usize> = eligible
        .into_iter()
        .filter(|&i| has_angles && contenders[i].is_better_on_both(&contenders[by_position]))
        .collect();
    let better = smallest(contenders, &better, Contender::both).map(|(best, _)| best);
    Some(Choice {
        best: better.unwrap_or(by_position),
        least,
        instead_of: better.map(|_| by_position),
    })
}

/// Places of the contenders that may be chosen: those that the samples determine, no correction
/// among them. Where they determine no correction that is tried, all of them if only one size is
/// tried, or if there is nothing else.
///
/// Held-out places are places of the same survey, often of the same lattice. How a model that has
/// a coefficient for each place swings between them does not show there, and nothing but its ridge
/// holds it.
fn eligible(contenders: &[Contender]) -> Vec<usize> {
    let mut sizes = contenders.iter().map(|c| c.size).filter(|&size| size > 0);
    let first = sizes.next();
    let is_one_size = sizes.all(|size| Some(size) == first);
    let is_any_admissible =
        contenders.iter().any(|c| c.is_admissible && (c.size > 0 || !is_one_size));
    (0..contenders.len()).filter(|&i| contenders[i].is_admissible || !is_any_admissible).collect()
}

/// The smallest within [`TOLERANCE`] of the least score, and the least.
fn smallest<'a>(
    contenders: &[Contender<'a>],
    places: &[usize],
    score: impl Fn(&Contender<'a>) -> f64,
) -> Option<(usize, usize)> {
    let score = |i: usize| score(&contenders[i]);
    let least = places.iter().copied().min_by(|&a, &b| score(a).total_cmp(&score(b)))?;
    let limit = score(least) * (1.0 + TOLERANCE);
    let best = places.iter().copied().filter(|&i| score(i) <= limit).min_by(|&a, &b| {
        let key = |i: usize| (contenders[i].size, contenders[i].is_regularised);
        key(a).cmp(&key(b)).then(score(a).total_cmp(&score(b)))
    })?;
    Some((best, least))
}

#[cfg(test)]
mod tests {
    use super::super::scoring::FoldSums;
    use super::*;

    /// A candidate of a size with position RMS and angle RMS in each of the folds.
    struct Model {
        size: usize,
        is_regularised: bool,
        is_admissible: bool,
        scores: HeldOutScores,
    }

    fn in_folds(size: usize, folds: &[(f64, f64)], has_angles: bool) -> Model {
        let sums = folds.iter().map(|(position, angle)| FoldSums {
            rows: 1,
            position_squares_mm2: position * position,
            position_max_square_mm2: position * position,
            rotation_squares_rad2: angle * angle,
        });
        Model {
            size,
            is_regularised: false,
            is_admissible: true,
            scores: HeldOutScores::of_sums(sums.collect(), has_angles),
        }
    }

    fn row(size: usize, position_rms_mm: f64) -> Model {
        in_folds(size, &[(position_rms_mm, 0.0)], false)
    }

    fn ridged(size: usize, position_rms_mm: f64) -> Model {
        Model { is_regularised: true, ..row(size, position_rms_mm) }
    }

    fn chosen(table: &[Model]) -> Choice {
        let contenders: Vec<_> = table
            .iter()
            .map(|model| Contender {
                size: model.size,
                is_regularised: model.is_regularised,
                is_admissible: model.is_admissible,
                scores: &model.scores,
            })
            .collect();
        choose(&contenders).unwrap()
    }

    #[test]
    fn smallest_within_one_percent_wins() {
        let rows = |second| [row(0, 2.0), row(27, second), row(64, 1.0)];
        assert_eq!(chosen(&rows(1.009)).best, 1);
        assert_eq!(chosen(&rows(1.011)).best, 2);
        assert_eq!(chosen(&[row(0, 1.009), row(8, 1.0)]).best, 0);
    }

    #[test]
    fn no_ridge_goes_before_a_ridge_that_hardly_helps() {
        let rows = |plain| [row(27, plain), ridged(27, 1.004), ridged(27, 1.0)];
        assert_eq!(chosen(&rows(1.009)).best, 0);
        assert_eq!(chosen(&rows(1.011)).best, 2);
    }

    #[test]
    fn a_score_that_is_no_number_never_wins() {
        assert_eq!(chosen(&[row(8, f64::NAN), row(27, 3.0)]).best, 1);
        assert!(choose(&[]).is_none());
    }

    #[test]
    fn what_is_not_determined_is_chosen_only_by_itself() {
        let undetermined = || Model { is_admissible: false, ..ridged(343, 1.0) };
        assert_eq!(chosen(&[row(0, 9.0), row(8, 2.0), undetermined()]).best, 1);
        assert_eq!(chosen(&[row(0, 9.0), undetermined()]).best, 1);
        // Of several that are not, none: no correction is better than any that looks good.
        let larger = || Model { size: 729, ..undetermined() };
        assert_eq!(chosen(&[row(0, 9.0), undetermined(), larger()]).best, 0);
        assert_eq!(chosen(&[larger(), undetermined()]).best, 1);
    }

    #[test]
    fn of_equal_positions_the_better_angle_wins() {
        let small = in_folds(8, &[(1.0, 0.050), (1.1, 0.052), (0.9, 0.048)], true);
        // Worse in position by 2 %, but not in every fold; a fifth better in angle in each.
        let noisy = in_folds(48, &[(1.1, 0.040), (1.1, 0.041), (0.87, 0.039)], true);
        let choice = chosen(&[small, noisy]);
        assert_eq!((choice.best, choice.least), (1, 0));
        assert_eq!(choice.instead_of, Some(0));
    }

    #[test]
    fn angles_do_not_outweigh_a_clear_loss_in_position() {
        let small = in_folds(8, &[(1.0, 0.050), (1.1, 0.052), (0.9, 0.048)], true);
        let worse = in_folds(48, &[(1.2, 0.040), (1.3, 0.041), (1.1, 0.039)], true);
        assert_eq!(chosen(&[small, worse]).best, 0);
    }

    #[test]
    fn a_better_angle_within_noise_is_ignored() {
        let small = in_folds(8, &[(1.0, 0.050), (1.1, 0.052), (0.9, 0.048)], true);
        // 8 % better on the whole, in one fold of three.
        let lucky = in_folds(48, &[(1.0, 0.037), (1.1, 0.053), (0.9, 0.047)], true);
        let choice = chosen(&[small, lucky]);
        assert_eq!((choice.best, choice.instead_of), (0, None));
    }
}
