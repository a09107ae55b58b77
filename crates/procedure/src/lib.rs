//! Where a design stands in the paper's procedure (Fischer & Taylor 2005, section 4.1): the CRF alone,
//! the tool against it, the built tool against its prediction.

mod changes;
mod grounds;
mod plan;
mod standing;
mod words;

pub use changes::{Change, Changed};
pub use grounds::{
    AngleFigures, DecidedFigures, DecidedRecording, DecidedRow, DecidedStudies, Grounds,
    PositionFigures, RoomName, Step,
};
pub use plan::{Plan, Recording, Room, RoomStudies};
pub use standing::{
    BuiltStanding, Row, RowCounts, Standing, State, StudiesStanding, Undecidable, standing,
};
pub use words::headline;
