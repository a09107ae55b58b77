//! A tool that was recorded while its tip rested in one point, against its design.

use super::{Agreement, AgreementError, AgreementSettings, agreement, pivot_rows};
use crate::pivot::{Pivot, PivotError, PivotLimits, pivot};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::scenario::Scenario;
use trackwright_task::Task;

/// What a pivoted tool comes to.
#[derive(Clone, Debug)]
pub struct PivotedTool {
    pub pivot: Pivot,
    pub agreement: Agreement,
}

/// Why a pivoted tool has no figures.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PivotedError {
    #[error("no tip: {0}")]
    NoTip(PivotError),
    /// The design cannot be simulated there.
    #[error(transparent)]
    Simulation(AgreementError),
    /// The recording says nothing.
    #[error(transparent)]
    Agreement(AgreementError),
}

/// Finds the tip, predicts, compares; the scenario's CRF is not looked at.
///
/// # Errors
/// See [`PivotedError`].
pub fn pivoted_tool(
    scenario: &Scenario,
    poses: &[Pose],
    settings: &AgreementSettings,
    task: &Task,
) -> Result<PivotedTool, PivotedError> {
    // How far the tip strays is what is asked here, so no distance is too large.
    let limits = PivotLimits { max_rms_mm: f64::MAX, ..PivotLimits::default() };
    let found = pivot(poses, &limits).map_err(PivotedError::NoTip)?;
    let (with_tip, rows) = pivot_rows(scenario, poses, &found, &task.stretch(0.0, 0.5))
        .map_err(PivotedError::Simulation)?;
    let agreement = agreement(&with_tip, rows, settings, &task.stretch(0.5, 1.0))
        .map_err(PivotedError::Agreement)?;
    Ok(PivotedTool { pivot: found, agreement })
}
