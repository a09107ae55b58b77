//! `--support`: how far readings at the poses of a table may be from the model's.

use super::prelude::*;
use trackwright_field::{Environment, FieldPoint, Validity};
use trackwright_geometry::pose::Pose;

#[derive(Clone, Copy, Debug, Args)]
pub struct ValidityArgs {
    /// Add the model validity: the standard error of each reading (std_error_mm, std_error_deg) and
    /// its 95 % bound (within95_mm, within95_deg), misfit included where the environment keeps its
    /// measurements; else the standard error of the fit alone. Also whether the measurements
    /// determine the field there (supported, 0 or 1), the distance to the nearest of them
    /// (distance_mm), and of polynomials the pose's leverage on the fit. Cells are empty where
    /// nothing is known
    #[arg(long)]
    support: bool,
}

impl ValidityArgs {
    /// The model validity at poses, where it is wanted.
    ///
    /// # Errors
    /// An environment that states none.
    pub fn at(
        self,
        environment: &Environment,
        named: &Path,
        poses: &[Pose],
        outside: OutsidePolicy,
    ) -> anyhow::Result<Option<Vec<Validity>>> {
        if !self.support {
            return Ok(None);
        }
        let points: Vec<_> = poses.iter().map(FieldPoint::of_pose).collect();
        let validity = environment.validity(&points, outside);
        let validity = validity.with_context(|| named.display().to_string())?;
        validity.map(Some).with_context(|| {
            format!(
                "{}: found no `support` and no `process`, expected one of them with --support; `fit` \
                 writes both without --no-support",
                named.display()
            )
        })
    }
}
