//! The magnetic field of what flows around holes, tested with currents and fluxes.
//!
//! Its potential goes up by the current from one side of what spans the hole to the other, so that there is none to
//! integrate by parts: the field is integrated itself, with the gradient of a layer on each triangle.

use super::functions::Functions;
use super::layers::{Layers, Number, real};
use super::near::{Rules, place};
use super::pair::{DECAYED, FAR, NEAR};
use crate::panel::{FINE, FULL_ANGLE, Panel, RULE};
use faer::Mat;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use trackwright_task::{Cancelled, Task};

/// `⟨f, ∇ × S K⟩`, a column a hole and a row a function of `m`.
#[derive(Clone, Debug)]
pub(super) struct Around<T>(pub Mat<T>);

impl<T: Number + Send + Sync> Around<T> {
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        panels: &[Panel],
        functions: &Functions,
        k: T,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        let holes = functions.cycles.holes();
        let mut found = Mat::from_fn(functions.count(), holes, |_, _| T::zero());
        if holes == 0 {
            return Ok(Self(found));
        }
        let rules = Rules::new();
        let flows: Vec<(usize, Vec<Vector3<f64>>)> = (0..panels.len())
            .map(|j| (j, functions.cycles.around_in(j)))
            .filter(|(_, currents)| currents.iter().any(|current| current.norm() > 0.0))
            .collect();
        let of_target = |i: usize| {
            // Of each hole's current, with each corner's function.
            let mut tested = vec![[Vector3::from_element(T::zero()); 3]; holes];
            // In its own plane a triangle's field has nothing along itself.
            for (j, currents) in flows.iter().filter(|(j, _)| *j != i) {
                for_gradients(&panels[i], &panels[*j], k, &rules, |bary, gradient| {
                    for (tested, current) in tested.iter_mut().zip(currents) {
                        let field = gradient.cross(&current.map(real));
                        for (tested, part) in tested.iter_mut().zip(bary) {
                            *tested += field * real::<T>(*part);
                        }
                    }
                });
            }
            if task.cancel.is_cancelled() { Err(Cancelled) } else { Ok(tested) }
        };
        let all: Vec<Vec<[Vector3<T>; 3]>> =
            (0..panels.len()).into_par_iter().map(of_target).collect::<Result<_, _>>()?;
        for (i, tested) in all.iter().enumerate() {
            for (hole, fields) in tested.iter().enumerate() {
                let whole: Vector3<T> = fields.iter().sum();
                for (number, current) in functions.currents_of(i) {
                    found[(number, hole)] += current.map(real::<T>).dot(&whole);
                }
                for (number, of) in functions.linear_of(i) {
                    for (at, field) in of.at_corners.iter().zip(fields) {
                        found[(number, hole)] += at.map(real::<T>).dot(field);
                    }
                }
            }
        }
        Ok(Self(found))
    }
}

/// Calls `each` with barycentric coordinates of points of a triangle and `∇ ∫ G` of another one there, times the share of the point.
fn for_gradients<T: Number>(
    target: &Panel,
    source: &Panel,
    k: T,
    rules: &Rules,
    mut each: impl FnMut(&[f64; 3], Vector3<T>),
) {
    let reach_mm = target.radius_mm() + source.radius_mm();
    let apart_mm = (target.center_mm() - source.center_mm()).norm();
    if k.real() * (apart_mm - reach_mm) > DECAYED {
        return;
    }
    if apart_mm < NEAR * reach_mm {
        for (bary, weight) in rules.near(target, source, k.real()).iter() {
            let layers = Layers::seen_from(&place(target, bary), source, k);
            each(bary, layers.gradient * real::<T>(weight * target.area_mm2()));
        }
        return;
    }
    let rule: Vec<([f64; 3], f64)> = match apart_mm > FAR * reach_mm {
        true => RULE.map(|bary| (bary, 1.0 / 3.0)).to_vec(),
        false => FINE.to_vec(),
    };
    let points = |panel: &Panel| -> Vec<(Point3<f64>, f64)> {
        rule.iter().map(|(bary, by)| (place(panel, bary), by * panel.area_mm2())).collect()
    };
    let sources = points(source);
    for ((p, of_p), (bary, _)) in points(target).iter().zip(&rule) {
        let mut gradient = Vector3::from_element(T::zero());
        for (q, of_q) in &sources {
            let v = p - q;
            let r = v.norm();
            let z = k * real(r);
            let size = (-z).exp() * (T::one() + z) * real(-of_p * of_q / (FULL_ANGLE * r.powi(3)));
            gradient += v.map(real::<T>) * size;
        }
        each(bary, gradient);
    }
}
