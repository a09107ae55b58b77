//! The work on a sweep as JSON.

use serde_json::{Value, json};
use trackwright_sweep::{MergeReport, RunReport, Status};

/// What a worker did, as `sweep --format json` prints it beside the time.
pub fn run_json(report: &RunReport) -> Value {
    let RunReport { kept, computed, problems, dropped, shards, torn, rows_there, rows } = report;
    json!({
        "kept": kept, "computed": computed, "problems": problems, "dropped": dropped, "shards": shards,
        "torn": torn, "rows_there": rows_there, "rows": rows,
    })
}

/// What was merged, as `sweep merge --format json` prints it.
pub fn merge_json(report: &MergeReport) -> Value {
    let MergeReport { rows, shards, bytes } = report;
    json!({"rows": rows, "shards": shards, "bytes": bytes})
}

/// How far a sweep is, as `sweep status --format json` prints it.
pub fn status_json(status: &Status) -> Value {
    let Status { rows, rows_there, shards, torn, missing, tasks } = status;
    let missing: Vec<[u64; 2]> = missing.iter().map(|gap| [gap.start, gap.end]).collect();
    json!({
        "rows": rows, "rows_there": rows_there, "shards": shards, "torn": torn, "missing": missing,
        "slurm": tasks,
    })
}
