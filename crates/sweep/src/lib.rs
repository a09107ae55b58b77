//! Sweeps: the rows of a plan, computed in shards that any number of workers share, as Parquet files.
//!
//! ```
//! use trackwright_formats::sweep_plan;
//! use trackwright_sweep::{Folder, Part, Sweep, run};
//! use trackwright_task::Task;
//!
//! let plan = sweep_plan::parse(br#"(
//!     version: 1,
//!     designs: ["pointer-on-head"],
//!     vary: [Grid([(path: "tool.body.sensors[0].position.z", values: List([60, 72]))])],
//!     motions: [Single],
//! )"#)?;
//! let folder = tempfile::tempdir()?;
//! let sweep = Sweep::of_plan(plan, folder.path())?;
//! let out = Folder::open(&folder.path().join("out"), &sweep)?;
//! let report = run(&sweep, &out, Part::WHOLE, &Task::default(), &|_| ())?;
//! assert_eq!(report.computed, 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod checksum;
mod error;
mod folder;
mod merge;
mod order;
mod points;
mod read;
mod row_design;
mod run;
mod shard;
pub mod slurm;
mod status;
mod sweep;
mod table;
mod template;
#[cfg(test)]
mod tests;

pub use error::SweepError;
pub use folder::{Coverage, Folder, Part};
pub use merge::{MergeReport, is_merge_of, merge};
pub use order::Direction;
pub use read::{Cell, Column, SweepTable};
pub use row_design::{RowDesign, RowDesignError};
pub use run::{RunReport, run};
pub use status::{Status, status};
pub use sweep::{Row, RowFigures, RowKey, Sweep};
pub use table::{PROBLEM, ROW, UNIT};
pub use template::number_paths;
