//! Layers of one triangle over another one.

use super::layers::{Layers, Number, real};
use crate::panel::{FINE, FULL_ANGLE, Panel, RULE};
use nalgebra::{Point3, Vector3};

/// Triangles farther apart than this many times their radii are sums over three points of each, or seven.
pub(super) const FAR: f64 = 2.0;
pub(super) const NEAR: f64 = 1.2;

/// A triangle that has another one nearer to its middle than this part of its radius is beside the other side of a
/// thin wall.
const OPPOSITE: f64 = 0.5;

/// Gauss and Legendre's rules from 0 to 1 along an edge and away from it.
const ALONG: [(f64, f64); 4] = [
    (0.069_431_844_202_974, 0.173_927_422_568_727),
    (0.330_009_478_207_572, 0.326_072_577_431_273),
    (0.669_990_521_792_428, 0.326_072_577_431_273),
    (0.930_568_155_797_026, 0.173_927_422_568_727),
];
const AWAY: [(f64, f64); 8] = [
    (0.019_855_071_751_232, 0.050_614_268_145_188),
    (0.101_666_761_293_187, 0.111_190_517_226_687),
    (0.237_233_795_041_836, 0.156_853_322_938_944),
    (0.408_282_678_752_175, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164, 0.156_853_322_938_944),
    (0.898_333_238_706_813, 0.111_190_517_226_687),
    (0.980_144_928_248_768, 0.050_614_268_145_188),
];

/// A kernel that has decayed by so many times `e` is none: what is left is 10⁻¹¹.
pub(super) const DECAYED: f64 = 25.0;

type Rule = Vec<([f64; 3], f64)>;

/// Where the layers of another triangle are taken.
pub(super) struct Rules {
    /// Nearer to each other towards the edge opposite to each corner, where a skin depth that is small beside the
    /// triangle leaves only a strip.
    towards_edge: [Rule; 3],
    towards_edges: Rule,
}

/// Layers of one triangle, with each corner's function `λ`, over another one.
#[derive(Clone, Copy)]
pub(super) struct Pair<T> {
    /// `∬ λ G` and, with the place `r` in the other one, `∬ λ r G`.
    pub single: [T; 3],
    pub moment: [Vector3<T>; 3],
    /// `∬ λ n·∇G`.
    pub double: [T; 3],
}

pub(super) fn place(panel: &Panel, bary: &[f64; 3]) -> Point3<f64> {
    let corners = panel.corners_mm();
    Point3::from((0..3).map(|k| corners[k].coords * bary[k]).sum::<Vector3<f64>>())
}

impl Rules {
    pub fn new() -> Self {
        let towards_edge = [0, 1, 2].map(towards_edge);
        // The middle in place of the corner.
        let of_middle = |corner: usize| {
            let moved = move |(bary, weight): &([f64; 3], f64)| {
                let share = bary[corner] / 3.0;
                let own = [0, 1, 2].map(|k| share + if k == corner { 0.0 } else { bary[k] });
                (own, weight / 3.0)
            };
            towards_edge[corner].iter().map(moved).collect::<Rule>()
        };
        let towards_edges = (0..3).flat_map(of_middle).collect();
        Self { towards_edge, towards_edges }
    }

    pub fn near(&self, target: &Panel, source: &Panel) -> &[([f64; 3], f64)] {
        let is_own = |corner: &usize| !source.corners_mm().contains(&target.corners_mm()[*corner]);
        let own: Vec<usize> = (0..3).filter(is_own).collect();
        match own[..] {
            [] => &self.towards_edges,
            [corner] => &self.towards_edge[corner],
            [_, _, _] if source.distance_mm(target.center_mm()) < OPPOSITE * target.radius_mm() => {
                &self.towards_edges
            }
            _ => &FINE,
        }
    }
}

fn towards_edge(corner: usize) -> Rule {
    let each = AWAY.iter().flat_map(|(place, of_place)| {
        let (away, of_away) = (place.powi(3), 3.0 * place * place * of_place);
        ALONG.iter().map(move |(along, of_along)| {
            let mut bary = [away; 3];
            bary[(corner + 1) % 3] = (1.0 - away) * (1.0 - along);
            bary[(corner + 2) % 3] = (1.0 - away) * along;
            (bary, 2.0 * (1.0 - away) * of_along * of_away)
        })
    });
    each.collect()
}

impl<T: Number> Pair<T> {
    fn none() -> Self {
        Self {
            single: [T::zero(); 3],
            moment: [Vector3::from_element(T::zero()); 3],
            double: [T::zero(); 3],
        }
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
            [Self::near(one, other, k, rules), Self::near(other, one, k, rules)]
        }
    }

    pub fn is_none(&self) -> bool {
        self.single.iter().all(|single| *single == T::zero())
    }

    /// Of a triangle over itself.
    pub fn own(panel: &Panel, k: T, rules: &Rules) -> Self {
        // In its own plane a double layer is none, but for round-off of the height.
        Self { double: [T::zero(); 3], ..Self::near(panel, panel, k, rules) }
    }

    fn near(target: &Panel, source: &Panel, k: T, rules: &Rules) -> Self {
        let mut pair = Self::none();
        for (bary, weight) in rules.near(target, source) {
            let r = place(target, bary);
            let layers = Layers::seen_from(&r, source, k);
            let weight: T = real(weight * target.area_mm2());
            let r: Vector3<T> = r.coords.map(real);
            for corner in 0..3 {
                let single = layers.single[corner] * weight;
                pair.single[corner] += single;
                pair.moment[corner] += r * single;
                pair.double[corner] += layers.double[corner] * weight;
            }
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
                both[0].add(&p, &at_q, single, slope * real(along_other));
                both[1].add(&q, &at_p, single, slope * real(-along_one));
            }
        }
        both
    }

    /// A point of the source, seen from one of the target.
    fn add(&mut self, target: &Point3<f64>, source: &[f64; 3], single: T, double: T) {
        let r: Vector3<T> = target.coords.map(real);
        for (corner, part) in source.iter().enumerate() {
            let own = single * real(*part);
            self.single[corner] += own;
            self.moment[corner] += r * own;
            self.double[corner] += double * real(*part);
        }
    }
}
