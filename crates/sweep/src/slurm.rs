//! A sweep as a job array of Slurm: one task a part, and a job that merges once all are done.
//!
//! Nothing of it runs here: files are written for `sbatch`, and `squeue` is read.

use super::error::{SweepError, io_error};
use super::folder::{Folder, Part};
use super::sweep::Sweep;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

const FOLDER: &str = "slurm";
const JOBS: &str = "jobs.txt";

/// What is requested of the cluster.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlurmOptions {
    /// Tasks of the array.
    pub tasks: u64,
    /// Cores of each.
    pub cores: u32,
    pub partition: Option<String>,
    pub account: Option<String>,
    /// As `sbatch --time` has it.
    pub time: Option<String>,
    /// As `sbatch --mem` has it.
    pub memory: Option<String>,
}

/// What was submitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Submission {
    pub job: String,
    pub merge_job: String,
    /// Parts whose rows are missing.
    pub parts: Vec<u64>,
    /// Parts that are in the queue already.
    pub queued: Vec<u64>,
    /// What the merged rows will be in.
    pub table: PathBuf,
}

/// Tasks of a folder's arrays that the cluster knows of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Queue {
    /// The part, the number of parts and the state of each, as `squeue` has it.
    pub tasks: Vec<(Part, String)>,
}

/// Submits what is missing; nothing where all is there or in the queue.
///
/// # Errors
/// A cluster that refuses the job, with its own words, and a machine without Slurm's commands.
pub fn submit(
    sweep: &Sweep,
    folder: &Folder,
    options: &SlurmOptions,
    program: &Path,
) -> Result<Option<Submission>, SweepError> {
    let queue = queue(folder)?;
    let coverage = folder.coverage()?;
    let part = |number| Part { number, of: options.tasks };
    let is_missing = |number: &u64| !coverage.missing(part(*number).rows(sweep.rows())).is_empty();
    let (queued, parts): (Vec<u64>, Vec<u64>) =
        (1..=options.tasks).filter(is_missing).partition(|number| {
            queue.tasks.iter().any(|(task, _)| overlap(*task, part(*number), sweep.rows()))
        });
    if parts.is_empty() {
        return Ok(None);
    }
    let scripts = folder.path().join(FOLDER);
    fs::create_dir_all(&scripts).map_err(io_error(&scripts, "cannot be made"))?;
    let scripts = fs::canonicalize(&scripts).map_err(io_error(&scripts, "cannot be read"))?;
    let out = scripts.parent().unwrap_or(&scripts).to_owned();
    let table = out.join("rows.parquet");
    let array = script(&scripts, "array.sh", &array_text(&out, &parts, options, program))?;
    let merge = script(&scripts, "merge.sh", &merge_text(&out, &table, options, program))?;
    let job = sbatch(&[&array.to_string_lossy()])?;
    note_job(&scripts, &job, options.tasks)?;
    let dependency = format!("--dependency=afterok:{job}");
    // One that can never run must not stay in the queue.
    let merge_job = sbatch(&[&dependency, "--kill-on-invalid-dep=yes", &merge.to_string_lossy()])?;
    Ok(Some(Submission { job, merge_job, parts, queued, table }))
}

fn overlap(a: Part, b: Part, rows: u64) -> bool {
    let (a, b) = (a.rows(rows), b.rows(rows));
    a.start < b.end && b.start < a.end
}

/// The tasks that are waiting or running.
///
/// # Errors
/// Files that cannot be read. A machine without Slurm's commands has none.
pub fn queue(folder: &Folder) -> Result<Queue, SweepError> {
    let jobs = folder.path().join(FOLDER).join(JOBS);
    let text = match fs::read_to_string(&jobs) {
        Ok(text) => text,
        Err(cause) if cause.kind() == ErrorKind::NotFound => return Ok(Queue::default()),
        Err(cause) => return Err(io_error(&jobs, "cannot be read")(cause)),
    };
    let mut queue = Queue::default();
    for line in text.lines() {
        let Some((job, of)) = line.split_once(' ') else {
            continue;
        };
        let Ok(of) = of.parse() else {
            continue;
        };
        // Of a job that has ended there is nothing, or an error.
        let listed = Command::new("squeue")
            .args(["--noheader", "--array", "--format=%K %T", "--jobs", job])
            .output();
        let Ok(listed) = listed else {
            return Ok(queue);
        };
        let tasks = String::from_utf8_lossy(&listed.stdout);
        queue.tasks.extend(tasks.lines().filter_map(|task| {
            let (number, state) = task.trim().split_once(' ')?;
            Some((Part { number: number.parse().ok()?, of }, state.to_owned()))
        }));
    }
    Ok(queue)
}

fn array_text(out: &Path, parts: &[u64], options: &SlurmOptions, program: &Path) -> String {
    let mut lines = head("trackwright-sweep", out, "%A-%a", options);
    lines.push(format!("#SBATCH --array={}", ranges(parts)));
    lines.push(format!("#SBATCH --cpus-per-task={}", options.cores));
    lines.push(format!("export RAYON_NUM_THREADS={}", options.cores));
    lines.push(format!(
        "exec {} sweep {} -o {} --shard \"$SLURM_ARRAY_TASK_ID/{}\"",
        quoted(program),
        quoted(&Folder::plan_of(out)),
        quoted(out),
        options.tasks
    ));
    lines.join("\n") + "\n"
}

fn merge_text(out: &Path, table: &Path, options: &SlurmOptions, program: &Path) -> String {
    let mut lines = head("trackwright-merge", out, "%j-merge", options);
    lines.push(format!(
        "exec {} sweep merge {} -o {} --overwrite",
        quoted(program),
        quoted(out),
        quoted(table)
    ));
    lines.join("\n") + "\n"
}

fn head(name: &str, out: &Path, log: &str, options: &SlurmOptions) -> Vec<String> {
    let mut lines = vec!["#!/bin/sh".to_owned(), format!("#SBATCH --job-name={name}")];
    lines
        .push(format!("#SBATCH --output={}", quoted(&out.join(FOLDER).join(format!("{log}.txt")))));
    for (option, value) in [
        ("partition", &options.partition),
        ("account", &options.account),
        ("time", &options.time),
        ("mem", &options.memory),
    ] {
        lines.extend(value.as_ref().map(|value| format!("#SBATCH --{option}={value}")));
    }
    lines
}

/// `1-3,7`, as `sbatch --array` has it.
fn ranges(numbers: &[u64]) -> String {
    let mut runs: Vec<(u64, u64)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => runs.push((number, number)),
        }
    }
    let text = |(first, last): &(u64, u64)| match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    };
    runs.iter().map(text).collect::<Vec<_>>().join(",")
}

/// For a shell, whatever is in the name.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.to_string_lossy().replace('\'', "'\\''"))
}

fn script(folder: &Path, name: &str, text: &str) -> Result<PathBuf, SweepError> {
    let file = folder.join(name);
    fs::write(&file, text).map_err(io_error(&file, "cannot be written"))?;
    Ok(file)
}

fn note_job(folder: &Path, job: &str, tasks: u64) -> Result<(), SweepError> {
    let file = folder.join(JOBS);
    let opened = fs::OpenOptions::new().create(true).append(true).open(&file);
    let written = opened.and_then(|mut out| {
        std::io::Write::write_all(&mut out, format!("{job} {tasks}\n").as_bytes())
    });
    written.map_err(io_error(&file, "cannot be written"))
}

/// The number of the job.
fn sbatch(arguments: &[&str]) -> Result<String, SweepError> {
    let output = Command::new("sbatch").arg("--parsable").args(arguments).output();
    let output = output.map_err(|cause| SweepError::NoCluster { cause })?;
    let words = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    // Behind a semicolon is the cluster's name.
    let job = words(&output.stdout).split(';').next().unwrap_or_default().to_owned();
    match output.status.success() && job.parse::<u64>().is_ok() {
        true => Ok(job),
        false => Err(SweepError::Refused { words: words(&output.stderr) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_name_runs_of_parts() {
        assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1-3,7,9-10");
        assert_eq!(ranges(&[4]), "4");
    }

    #[test]
    fn a_script_has_what_was_requested_and_any_name() {
        let options = SlurmOptions {
            tasks: 8,
            cores: 4,
            partition: Some("long".to_owned()),
            account: None,
            time: Some("2:00:00".to_owned()),
            memory: Some("2G".to_owned()),
        };
        let text =
            array_text(Path::new("/data/it's here"), &[2, 3], &options, Path::new("/bin/tw"));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "#!/bin/sh");
        assert!(lines.contains(&"#SBATCH --partition=long"));
        assert!(lines.contains(&"#SBATCH --mem=2G"));
        assert!(lines.contains(&"#SBATCH --array=2-3"));
        assert!(!text.contains("account"));
        let command = "exec '/bin/tw' sweep '/data/it'\\''s here/plan.sweep.ron' -o '/data/it'\\''s here' --shard \"$SLURM_ARRAY_TASK_ID/8\"";
        assert_eq!(lines.last(), Some(&command));
    }
}
