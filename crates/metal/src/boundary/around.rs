//! The magnetic field of what flows around holes, tested with currents and fluxes.
//!
//! Its potential goes up by the current from one side of what spans the hole to the other, so that there is none to
//! integrate by parts: the field is integrated itself, with the gradient of a layer on each triangle.

use super::functions::Functions;
use super::layers::{Layers, Number, real};
use super::pair::{DECAYED, FAR, NEAR, Rules, place};
use crate::panel::{FINE, FULL_ANGLE, Panel, RULE};
use faer::Mat;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use trackwright_task::{Cancelled, Task};

/// `⟨f, ∇ × S K⟩`, a column a hole and a row a current or a flux.
#[derive(Clone, Debug)]
pub(super) struct Around<T> {
    pub currents: Mat<T>,
    pub fluxes: Mat<T>,
}

/// Of one hole's current over a triangle: `∫ H` and, with the place, `∫ r·H`.
#[derive(Clone)]
struct Tested<T> {
    field: Vector3<T>,
    moment: T,
}

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
        let mut found = Self {
            currents: Mat::from_fn(functions.currents(), holes, |_, _| T::zero()),
            fluxes: Mat::from_fn(functions.fluxes, holes, |_, _| T::zero()),
        };
        if holes == 0 {
            return Ok(found);
        }
        let rules = Rules::new();
        let flows: Vec<(usize, Vec<Vector3<f64>>)> = (0..panels.len())
            .map(|j| (j, functions.cycles.around_in(j)))
            .filter(|(_, currents)| currents.iter().any(|current| current.norm() > 0.0))
            .collect();
        let of_target = |i: usize| {
            let none = Tested { field: Vector3::from_element(T::zero()), moment: T::zero() };
            let mut tested = vec![none; holes];
            // In its own plane a triangle's field has nothing along itself.
            for (j, currents) in flows.iter().filter(|(j, _)| *j != i) {
                for_gradients(&panels[i], &panels[*j], k, &rules, |p, gradient| {
                    for (tested, current) in tested.iter_mut().zip(currents) {
                        let field = gradient.cross(&current.map(real));
                        tested.moment += p.coords.map(real::<T>).dot(&field);
                        tested.field += field;
                    }
                });
            }
            if task.cancel.is_cancelled() { Err(Cancelled) } else { Ok(tested) }
        };
        let all: Vec<Vec<Tested<T>>> =
            (0..panels.len()).into_par_iter().map(of_target).collect::<Result<_, _>>()?;
        for (i, tested) in all.iter().enumerate() {
            for (hole, Tested { field, moment }) in tested.iter().enumerate() {
                for (number, current) in functions.currents_of(i) {
                    found.currents[(number, hole)] += current.map(real::<T>).dot(field);
                }
                for flux in &functions.fluxes_of[i] {
                    let from = flux.from_mm.map(real::<T>).dot(field);
                    found.fluxes[(flux.number, hole)] += (*moment - from) * real(flux.by);
                }
            }
        }
        Ok(found)
    }
}

/// Calls `each` with points of a triangle and `∇ ∫ G` of another one there, times the share of the point.
fn for_gradients<T: Number>(
    target: &Panel,
    source: &Panel,
    k: T,
    rules: &Rules,
    mut each: impl FnMut(&Point3<f64>, Vector3<T>),
) {
    let reach_mm = target.radius_mm() + source.radius_mm();
    let apart_mm = (target.center_mm() - source.center_mm()).norm();
    if k.real() * (apart_mm - reach_mm) > DECAYED {
        return;
    }
    if apart_mm < NEAR * reach_mm {
        for (bary, weight) in rules.near(target, source) {
            let p = place(target, bary);
            let layers = Layers::seen_from(&p, source, k);
            each(&p, layers.gradient * real::<T>(weight * target.area_mm2()));
        }
        return;
    }
    let rule = |panel: &Panel| -> Vec<(Point3<f64>, f64)> {
        let point =
            |(bary, weight): &([f64; 3], f64)| (place(panel, bary), weight * panel.area_mm2());
        match apart_mm > FAR * reach_mm {
            true => RULE.map(|bary| point(&(bary, 1.0 / 3.0))).to_vec(),
            false => FINE.iter().map(point).collect(),
        }
    };
    let sources = rule(source);
    for (p, of_p) in rule(target) {
        let mut gradient = Vector3::from_element(T::zero());
        for (q, of_q) in &sources {
            let v = p - q;
            let r = v.norm();
            let z = k * real(r);
            let size = (-z).exp() * (T::one() + z) * real(-of_p * of_q / (FULL_ANGLE * r.powi(3)));
            gradient += v.map(real::<T>) * size;
        }
        each(&p, gradient);
    }
}
