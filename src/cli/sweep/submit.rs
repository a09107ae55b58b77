//! `sweep --submit slurm`: a cluster computes what is missing.

use super::super::prelude::*;
use trackwright_sweep::slurm::{SlurmOptions, Submission, submit};
use trackwright_sweep::{Folder, Sweep};

/// What is requested of a cluster.
#[derive(Debug, Args)]
pub(super) struct ClusterArgs {
    /// With --submit: tasks of the job array, each a part of the rows
    #[arg(long, value_name = "N", requires = "submit", default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    tasks: u64,

    /// With --submit: cores of each task
    #[arg(long, value_name = "N", requires = "submit", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    cores: u32,

    /// With --submit: partition
    #[arg(long, value_name = "NAME", requires = "submit")]
    partition: Option<String>,

    /// With --submit: account
    #[arg(long, value_name = "NAME", requires = "submit")]
    account: Option<String>,

    /// With --submit: time limit of each task, as sbatch has it
    #[arg(long, value_name = "H:MM:SS", requires = "submit")]
    time: Option<String>,

    /// With --submit: memory of each task, as sbatch has it
    #[arg(long, value_name = "SIZE", requires = "submit")]
    memory: Option<String>,
}

/// Submits the parts whose rows are missing.
///
/// # Errors
/// A machine that is not of a cluster; a cluster that refuses.
pub(super) fn run(
    args: &ClusterArgs,
    sweep: &Sweep,
    folder: &Folder,
    format: Format,
) -> anyhow::Result<()> {
    let options = SlurmOptions {
        tasks: args.tasks.min(sweep.rows().max(1)),
        cores: args.cores,
        partition: args.partition.clone(),
        account: args.account.clone(),
        time: args.time.clone(),
        memory: args.memory.clone(),
    };
    let program = std::env::current_exe().context("this program's own file is not known")?;
    let submission = submit(sweep, folder, &options, &program)?;
    format.print(|| as_json(submission.as_ref()), || as_text(submission.as_ref(), folder))
}

fn as_json(submission: Option<&Submission>) -> Value {
    match submission {
        None => json!({"job": null, "parts": []}),
        Some(Submission { job, merge_job, parts, queued, table }) => {
            json!({"job": job, "merge_job": merge_job, "parts": parts, "queued": queued, "table": table})
        }
    }
}

fn as_text(submission: Option<&Submission>, folder: &Folder) -> String {
    let Some(Submission { job, merge_job, parts, queued, table }) = submission else {
        return "nothing to submit: all rows are there or in the queue".to_owned();
    };
    let mut lines = vec![format!("job {job}: {} submitted", counted(parts.len(), "task", "tasks"))];
    if !queued.is_empty() {
        lines.push(format!(
            "{} in the queue already",
            counted(queued.len(), "task is", "tasks are")
        ));
    }
    lines.push(format!("job {merge_job}: merges into {} when all are done", table.display()));
    lines.push(format!("how far it is: trackwright sweep status {}", folder.path().display()));
    lines.join("\n")
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", with_separators(count), if count == 1 { one } else { many })
}
