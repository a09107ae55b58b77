//! Why nothing was measured.

use std::time::Duration;

/// How long an answer may take.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    #[error(transparent)]
    Window(#[from] crate::app::EditorError),
    #[error("the window was closed before everything was measured")]
    Closed,
    #[error(transparent)]
    Store(#[from] trackwright_project::StoreError),
    #[error("no figures within {} s", PATIENCE.as_secs())]
    NoFigures,
    #[error(transparent)]
    Placement(#[from] trackwright_simulation::PlacementError),
    #[error(transparent)]
    Model(#[from] trackwright_field::model::ModelError),
}
