//! What a fit depends on, without its samples: systems that add up and are solved for any ridge.

use super::bernstein::coefficient_count;
use super::evaluation::OutsidePolicy;
use super::fit::{
    Fit, FitError, FitMethod, FitSettings, SystemReport, check_damping, checked_bounds, residuals,
};
use super::joint::JointSystem;
use super::least_squares::{Decomposition, Solution, Triangle};
use super::model::DistortionModel;
use super::rows::{Progress, Rows};
use super::samples::SampleSet;
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_task::Task;

/// Samples reduced to what their fit depends on. Systems over disjoint samples add up, and every
/// ridge and cutoff is solved from here without the samples.
#[derive(Clone, Debug)]
pub struct Factored {
    pub settings: FitSettings,
    pub bounds: Bounds,
    pub samples: usize,
    /// One an orientation, or for a joint fit one a face of the sphere; none at order 0.
    parts: Vec<Triangle>,
}

/// [`Factored`] after the singular value decomposition of its systems.
#[derive(Clone, Debug)]
pub struct Decomposed {
    pub settings: FitSettings,
    pub bounds: Bounds,
    /// One an orientation, or one for a joint fit; none at order 0.
    pub systems: Vec<Decomposition>,
}

/// A model and what its systems were like, before it is judged on samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    pub model: DistortionModel,
    /// One an orientation, or one for a joint fit; none at order 0.
    pub systems: Vec<SystemReport>,
}

/// Reduces samples to their systems, in the samples' bounding box or in `bounds` where given.
/// Ridge and rcond of the settings are not used yet, only checked.
pub fn factor(
    set: &SampleSet,
    settings: &FitSettings,
    bounds: Option<Bounds>,
    task: &Task,
) -> Result<Factored, FitError> {
    factor_in(checked_bounds(set, settings, bounds)?, set, settings, task)
}

pub(super) fn factor_in(
    bounds: Bounds,
    set: &SampleSet,
    settings: &FitSettings,
    task: &Task,
) -> Result<Factored, FitError> {
    let parts = if settings.order == 0 {
        Vec::new()
    } else {
        let FitSettings { order, directions, weighting, .. } = *settings;
        let rows = Rows::new(&set.samples, order, directions, weighting, &bounds)?;
        match settings.method {
            FitMethod::PerDirection => {
                let progress = Progress::new(task, rows.count_each_direction());
                (0..settings.directions.len())
                    .into_par_iter()
                    .map(|direction| rows.of_direction(direction, &progress))
                    .collect::<Result<_, _>>()?
            }
            FitMethod::Joint => {
                let progress = Progress::new(task, rows.count());
                rows.faces
                    .par_iter()
                    .map(|face| rows.of_face(face, &progress))
                    .collect::<Result<_, _>>()?
            }
        }
    };
    Ok(Factored { settings: *settings, bounds, samples: set.samples.len(), parts })
}

impl Factored {
    /// The systems of the samples of all parts together, in the order given. The parts must have
    /// the same order, orientations, method, weighting, map and box; `None` without any, or where
    /// they differ.
    pub fn merged<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let parts: Vec<_> = parts.into_iter().collect();
        let first = *parts.first()?;
        let is_alike = |other: &&Self| {
            let (a, b) = (&first.settings, &other.settings);
            (a.order, a.directions, a.method) == (b.order, b.directions, b.method)
                && (a.weighting, a.map) == (b.weighting, b.map)
                && first.bounds == other.bounds
        };
        parts.iter().all(is_alike).then(|| Self {
            settings: first.settings,
            bounds: first.bounds,
            samples: parts.iter().map(|p| p.samples).sum(),
            parts: (0..first.parts.len())
                .into_par_iter()
                .filter_map(|i| Triangle::merged(parts.iter().map(|p| &p.parts[i])))
                .collect(),
        })
    }

    /// The system of each orientation, or the one of a joint fit with all its unknowns, which for
    /// thousands of them takes long; none at order 0.
    pub fn systems(&self) -> Vec<Triangle> {
        match self.settings.method {
            FitMethod::Joint if self.settings.order > 0 => vec![self.joint().whole()],
            _ => self.parts.clone(),
        }
    }

    /// The singular value decomposition of each system, from which every ridge and cutoff is
    /// cheap. One of a joint fit has as many rows and columns as all orientations together.
    ///
    /// # Errors
    /// [`FitError::NoConvergence`].
    pub fn decompose(&self) -> Result<Decomposed, FitError> {
        let systems = self.systems();
        Ok(Decomposed {
            settings: self.settings,
            bounds: self.bounds,
            systems: systems.par_iter().map(Triangle::decompose).collect::<Result<_, _>>()?,
        })
    }

    /// The model for one ridge and cutoff, without a decomposition where all unknowns are
    /// determined.
    ///
    /// # Errors
    /// [`FitError::NoConvergence`], or a ridge or cutoff that is none.
    pub fn solve(&self, rcond: f64, ridge: f64) -> Result<Solved, FitError> {
        self.solve_with(rcond, ridge, &Task::default())
    }

    /// [`Self::solve`] that can be stopped.
    ///
    /// # Errors
    /// As there, and [`FitError::Cancelled`].
    pub fn solve_with(&self, rcond: f64, ridge: f64, task: &Task) -> Result<Solved, FitError> {
        check_damping(rcond, ridge)?;
        let solutions = match self.settings.method {
            _ if self.settings.order == 0 => Vec::new(),
            FitMethod::Joint => {
                let joint = self.joint();
                vec![(joint.rows(), joint.solve(rcond, ridge, task)?)]
            }
            FitMethod::PerDirection => {
                let progress = Progress::new(task, self.parts.len());
                self.parts
                    .par_iter()
                    .map(|part| {
                        progress.add(1)?;
                        Ok((part.rows(), part.solve(rcond, ridge)?))
                    })
                    .collect::<Result<_, FitError>>()?
            }
        };
        Solved::of(&self.settings, self.bounds, solutions)
    }

    fn joint(&self) -> JointSystem<'_> {
        JointSystem {
            set: self.settings.directions,
            block: coefficient_count(self.settings.order),
            faces: &self.parts,
        }
    }
}

impl Decomposed {
    /// The model for one ridge and cutoff.
    ///
    /// # Errors
    /// A ridge or cutoff that is none.
    pub fn solve(&self, rcond: f64, ridge: f64) -> Result<Solved, FitError> {
        check_damping(rcond, ridge)?;
        let solution = |system: &Decomposition| (system.rows, system.solve(rcond, ridge));
        let solutions = self.systems.iter().map(solution).collect();
        Solved::of(&self.settings, self.bounds, solutions)
    }
}

impl Solved {
    /// The model of solutions, each with the number of its system's rows.
    pub(super) fn of(
        settings: &FitSettings,
        bounds: Bounds,
        solutions: Vec<(usize, Solution)>,
    ) -> Result<Self, FitError> {
        if settings.order == 0 {
            return Ok(Self {
                model: DistortionModel::zero(bounds, settings.map),
                systems: Vec::new(),
            });
        }
        let report = |(samples, solution): &(usize, Solution)| SystemReport {
            samples: *samples,
            unknowns: solution.unknowns.len(),
            rank: solution.rank,
            condition: solution.condition,
        };
        let systems = solutions.iter().map(report).collect();
        let coefficients = solutions.into_iter().flat_map(|(_, s)| s.unknowns);
        let model = DistortionModel::new(
            settings.order,
            settings.directions,
            settings.weighting,
            settings.map,
            bounds,
            coefficients.collect(),
        )?;
        Ok(Self { model, systems })
    }

    /// The fit with its residuals on the samples that it was made from.
    pub fn judged(self, set: &SampleSet) -> Fit {
        let zero = DistortionModel::zero(*self.model.bounds(), self.model.map());
        Fit {
            samples: set.samples.len(),
            before: residuals(&zero, set, OutsidePolicy::Clamp),
            after: residuals(&self.model, set, OutsidePolicy::Clamp),
            model: self.model,
            systems: self.systems,
            ambiguous: set.ambiguous,
        }
    }
}
