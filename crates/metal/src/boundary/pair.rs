//! Layers of one triangle over another one.

use super::layers::{Layers, Number, real};
use super::near::{Rules, place};
use crate::panel::{FINE, FULL_ANGLE, Panel, RULE};

/// Triangles farther apart than this many times their radii are sums over three points of each, or seven.
pub(super) const FAR: f64 = 2.0;
pub(super) const NEAR: f64 = 1.2;

/// A kernel that has decayed by so many times `e` is none: what is left is 10⁻¹¹.
pub(super) const DECAYED: f64 = 25.0;

/// Layers of one triangle, with each corner's function `λ`, over another one.
#[derive(Clone, Copy)]
pub(super) struct Pair<T> {
    /// `∬ λ′ λ G`, with a row for each corner's function `λ′` on the other one.
    pub single: [[T; 3]; 3],
    /// `∬ λ n·∇G`.
    pub double: [T; 3],
}

impl<T: Number> Pair<T> {
    fn none() -> Self {
        Self { single: [[T::zero(); 3]; 3], double: [T::zero(); 3] }
    }

    /// Of the second triangle over the first one, and the other way round.
    pub fn both(one: &Panel, other: &Panel, k: T, rules: &Rules) -> [Self; 2] {
        let reach_mm = one.radius_mm() + other.radius_mm();
        let apart_mm = (one.center_mm() - other.center_mm()).norm();
        if k.real() * (apart_mm - reach_mm) > DECAYED {
            return [Self::none(); 2];
        }
        if apart_mm > FAR * reach_mm {
            Self::by_points(one, other, k, &RULE.map(|bary| (bary, 1.0 / 3.0)))
        } else if apart_mm > NEAR * reach_mm {
            Self::by_points(one, other, k, &FINE)
        } else {
            [(one, other), (other, one)]
                .map(|(target, source)| Self::near(target, source, k, rules))
        }
    }

    pub fn is_none(&self) -> bool {
        self.single.as_flattened().iter().all(|single| *single == T::zero())
    }

    /// `∬ G`.
    pub fn whole(&self) -> T {
        self.single.as_flattened().iter().fold(T::zero(), |sum, own| sum + *own)
    }

    /// Of a triangle over itself.
    pub fn own(panel: &Panel, k: T, rules: &Rules) -> Self {
        // In its own plane a double layer is none, but for round-off of the height.
        Self { double: [T::zero(); 3], ..Self::near(panel, panel, k, rules) }
    }

    fn near(target: &Panel, source: &Panel, k: T, rules: &Rules) -> Self {
        let mut pair = Self::none();
        for (bary, weight) in rules.near(target, source, k.real()).iter() {
            let layers = Layers::seen_from(&place(target, bary), source, k);
            let weight = real(weight * target.area_mm2());
            pair.add(bary, layers.single, layers.double, [weight; 2]);
        }
        pair
    }

    /// By a few points of each.
    fn by_points<const N: usize>(
        one: &Panel,
        other: &Panel,
        k: T,
        rule: &[([f64; 3], f64); N],
    ) -> [Self; 2] {
        let points = |panel: &Panel| {
            rule.map(|(bary, weight)| (place(panel, &bary), bary, weight * panel.area_mm2()))
        };
        let mut both = [Self::none(); 2];
        let of_other = points(other);
        for (p, at_p, of_p) in points(one) {
            for (q, at_q, of_q) in of_other {
                let v = p - q;
                let r = v.norm();
                let z = k * real(r);
                let single = (-z).exp() * real(of_p * of_q / (FULL_ANGLE * r));
                let slope = single * (T::one() + z) * real(1.0 / (r * r));
                let [along_other, along_one] = [other, one].map(|of| v.dot(of.normal()));
                let [of_p, of_q] = [at_p, at_q].map(|bary| bary.map(real::<T>));
                both[0].add(&at_p, of_q, of_q, [single, slope * real(along_other)]);
                both[1].add(&at_q, of_p, of_p, [single, slope * real(-along_one)]);
            }
        }
        both
    }

    /// Layers, or functions of corners at a point of the source, seen from a point of the target.
    fn add(&mut self, target: &[f64; 3], single: [T; 3], double: [T; 3], by: [T; 2]) {
        for corner in 0..3 {
            let own = single[corner] * by[0];
            for (row, part) in self.single.iter_mut().zip(target) {
                row[corner] += own * real(*part);
            }
            self.double[corner] += double[corner] * by[1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::c64;

    /// `∬ λ′ λ G` does not depend on which triangle it is integrated over first, in parts of what one has of itself.
    #[test]
    fn layers_are_the_same_both_ways() {
        let panel = |corners: [[f64; 3]; 3]| Panel::new(corners.map(Into::into)).unwrap();
        let flat = panel([[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [30.0, 1.0, 0.0]]);
        let rules = Rules::new();
        for (name, other) in [
            ("an edge", [[0.0, 0.0, 0.0], [30.0, 1.0, 0.0], [0.0, 1.0, 0.0]]),
            ("a corner", [[30.0, 0.0, 0.0], [60.0, 0.0, 0.0], [60.0, 1.0, 0.0]]),
            ("a corner across", [[30.0, 1.0, 0.0], [30.0, 1.3, 0.0], [0.0, 1.3, 0.0]]),
            ("nothing, beside", [[5.0, 1.5, 0.0], [5.0, -9.0, 12.0], [15.0, 1.5, 8.0]]),
            ("nothing, opposite", [[1.0, 0.1, 0.4], [31.0, 0.1, 0.4], [31.0, 1.2, 0.4]]),
        ] {
            for decay in [0.0, 0.1, 1.0, 5.0] {
                let k = c64::new(decay, decay);
                let [there, back] = Pair::both(&flat, &panel(other), k, &rules);
                let own = Pair::own(&flat, k, &rules).whole().norm();
                for i in 0..3 {
                    for j in 0..3 {
                        let off = (there.single[i][j] - back.single[j][i]).norm() / own;
                        assert!(off < 0.003, "{name} {decay} {i} {j}: {off}");
                    }
                }
            }
        }
    }
}
