//! Where a design stands in the paper's procedure (Fischer & Taylor 2005, section 4.1): the CRF alone,
//! the tool against it, the built tool against its prediction.
//!
//! ```
//! use trackwright_procedure::Step;
//! let steps = Step::ALL.map(|step| format!("{}. {step}", step.number()));
//! assert_eq!(steps, ["1. CRF alone", "2. tool", "3. built tool"]);
//! ```

mod changes;
mod decided;
mod plan;
mod status;
mod words;

pub use changes::{Change, Changed};
pub use decided::{
    DecidedFigures, DecidedRecording, DecidedRow, DecidedStudies, DecisionBasis, RoomName, Step,
};
pub use plan::{Plan, Recording, Room, RoomStudies};
pub use status::{
    BuiltStatus, Row, RowCounts, State, StepStatus, StudiesStatus, Undecidable, step_status,
};
pub use words::headline;
