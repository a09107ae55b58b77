//! Where the layers of a triangle are taken on another one that is near.

use crate::panel::{FINE, Panel};
use nalgebra::{Point3, Vector3};
use std::borrow::Cow;

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

/// Parts of a triangle are halved until half of each edge is no longer than this times the length over which layers vary
/// along it. Moments of discs and rods are within 2·10⁻³ of those with 0.8.
const COARSE: f64 = 1.25;

/// How often at most: a part that touches the source has a 64th of the triangle's size then.
const MOST_HALVINGS: u32 = 12;

/// In lengths over which a kernel decays by `e`: over what it varies at least, beyond what its edges do not count, and
/// beyond what it is none, to 10⁻⁵ of what a triangle has of itself.
const STEEP: f64 = 3.0;
const FADED: f64 = 4.0;
const GONE: f64 = 12.0;

/// Barycentric coordinates, with weights.
type Rule = Vec<([f64; 3], f64)>;

/// Where the layers of another triangle are taken.
pub(super) struct Rules {
    /// Nearer to each other towards the edge opposite to each corner, where a skin depth that is small beside the
    /// triangle leaves only a strip.
    towards_edge: [Rule; 3],
    towards_edges: Rule,
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

    /// For a kernel that decays by `e` over `1/decay_per_mm`.
    pub fn near(
        &self,
        target: &Panel,
        source: &Panel,
        decay_per_mm: f64,
    ) -> Cow<'_, [([f64; 3], f64)]> {
        let is_own = |corner: &usize| !source.corners_mm().contains(&target.corners_mm()[*corner]);
        let own: Vec<usize> = (0..3).filter(is_own).collect();
        match own[..] {
            [] => Cow::Borrowed(&self.towards_edges),
            [corner] => Cow::Borrowed(&self.towards_edge[corner]),
            _ => Cow::Owned(Near { target, source, decay_per_mm }.rule()),
        }
    }
}

/// Two triangles that have no edge in common.
struct Near<'a> {
    target: &'a Panel,
    source: &'a Panel,
    decay_per_mm: f64,
}

/// Of a triangle, by barycentric coordinates.
struct Part {
    corners: [[f64; 3]; 3],
    halvings: u32,
}

impl Near<'_> {
    /// In parts of the target that are the smaller the nearer they are to the source's edges.
    fn rule(&self) -> Rule {
        let mut rule = Rule::new();
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut left = vec![Part { corners, halvings: 0 }];
        while let Some(part) = left.pop() {
            let at = part.corners.map(|bary| place(self.target, &bary));
            let center = Point3::from((at[0].coords + at[1].coords + at[2].coords) / 3.0);
            let radius_mm = at.iter().fold(0.0, |most: f64, p| most.max((p - center).norm()));
            let nearest_mm = self.source.distance_mm(&center) - radius_mm;
            if self.decay_per_mm * nearest_mm > GONE {
                continue;
            }
            let edges = [0, 1, 2].map(|k| at[(k + 2) % 3] - at[(k + 1) % 3]);
            let varies_mm = self.varies_over_mm(&center, radius_mm, &edges);
            let coarse = |k: &usize| 0.5 * edges[*k].norm() / varies_mm[*k];
            let worst = (0..3).max_by(|a, b| coarse(a).total_cmp(&coarse(b)));
            match worst.filter(|k| coarse(k) > COARSE && part.halvings < MOST_HALVINGS) {
                Some(corner) => left.extend(part.halves(corner)),
                None => rule.extend(FINE.iter().map(|(bary, weight)| part.point(bary, *weight))),
            }
        }
        rule
    }

    /// Over what length layers vary near a place, in each direction: its distance from the nearest edge of the source,
    /// more along that edge, but no more than to the edge's end.
    fn varies_over_mm(
        &self,
        at: &Point3<f64>,
        radius_mm: f64,
        directions: &[Vector3<f64>; 3],
    ) -> [f64; 3] {
        let mut least = [f64::INFINITY; 3];
        for k in 0..3 {
            let [a, b] = [k, (k + 1) % 3].map(|corner| self.source.corners_mm()[corner]);
            let along = b - a;
            let share = (at - a).dot(&along) / along.norm_squared();
            let apart = (at - (a + along * share.clamp(0.0, 1.0))).norm();
            if self.decay_per_mm * (apart - radius_mm) > FADED {
                continue;
            }
            let across = apart.min(STEEP / self.decay_per_mm);
            let end = (at - a).norm().min((at - b).norm());
            for (least, direction) in least.iter_mut().zip(directions) {
                let sine = direction.cross(&along).norm() / (direction.norm() * along.norm());
                let is_beside = (0.0..=1.0).contains(&share);
                *least = least.min(if is_beside { end.min(across / sine) } else { across });
            }
        }
        least
    }
}

impl Part {
    /// By the middle of the edge opposite to a corner.
    fn halves(&self, corner: usize) -> [Self; 2] {
        let [a, b] = [1, 2].map(|next| (corner + next) % 3);
        let middle = [0, 1, 2].map(|k| 0.5 * (self.corners[a][k] + self.corners[b][k]));
        [a, b].map(|moved| {
            let mut corners = self.corners;
            corners[moved] = middle;
            Self { corners, halvings: self.halvings + 1 }
        })
    }

    fn point(&self, bary: &[f64; 3], weight: f64) -> ([f64; 3], f64) {
        let at =
            [0, 1, 2].map(|k| (0..3).map(|corner| self.corners[corner][k] * bary[corner]).sum());
        (at, weight / f64::from(1_u32 << self.halvings))
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
