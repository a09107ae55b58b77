//! A sweep as a job array of Slurm: one task a part, and a job that merges once all are done.
//!
//! Nothing of it runs here: files are written for `sbatch`, and `squeue` is read. What a person requests of the
//! cluster goes to `sbatch` as arguments; a script has names of files alone, each quoted as one word.

use super::checksum::hexadecimal;
use super::error::{SweepError, io_error};
use super::folder::{Folder, Part, SLURM, new_file};
use super::sweep::Sweep;
use sha2::{Digest, Sha256};
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

const JOBS: &str = "jobs.txt";

/// The beginning of a script; behind it is the digest of the rest.
const HEAD: &str = "#!/bin/sh\n# Written by trackwright sweep --submit, which replaces it as long as this is the \
    SHA-256 of the lines below: ";

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
/// A cluster that refuses the job, with its own words, a machine without Slurm's commands, control characters in
/// what is requested or in names of files, and a script of somebody else where the scripts are written.
pub fn submit(
    sweep: &Sweep,
    folder: &Folder,
    options: &SlurmOptions,
    program: &Path,
) -> Result<Option<Submission>, SweepError> {
    let requested = requested(options)?;
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
    let out = folder.path();
    let out = fs::canonicalize(out).map_err(io_error(out, "cannot be read"))?;
    let scripts = out.join(SLURM);
    fs::create_dir_all(&scripts).map_err(io_error(&scripts, "cannot be made"))?;
    let table = out.join("rows.parquet");
    let [array, merge] = ["array.sh", "merge.sh"].map(|name| scripts.join(name));
    write_script(&array, &array_command(&out, options, program)?)?;
    write_script(&merge, &merge_command(&out, &table, program)?)?;
    let sbatch = |name: &str, log: &str, own: &[String], script: &Path| {
        // A per cent sign is the beginning of a number of Slurm's.
        let logs = plain("folder", &scripts.to_string_lossy())?.replace('%', "%%");
        let log = format!("--output={logs}/{log}.txt");
        let all = [&[format!("--job-name={name}"), log], requested.as_slice(), own].concat();
        sbatch(&all, script)
    };
    let own = [format!("--array={}", ranges(&parts)), format!("--cpus-per-task={}", options.cores)];
    let job = sbatch("trackwright-sweep", "%A-%a", &own, &array)?;
    note_job(&scripts, &job, options.tasks)?;
    // One that can never run must not stay in the queue.
    let own = [format!("--dependency=afterok:{job}"), "--kill-on-invalid-dep=yes".to_owned()];
    let merge_job = sbatch("trackwright-merge", "%j-merge", &own, &merge)?;
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
    let jobs = folder.path().join(SLURM).join(JOBS);
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
            Some((format!("{number}/{of}").parse().ok()?, state.to_owned()))
        }));
    }
    Ok(queue)
}

fn array_command(out: &Path, options: &SlurmOptions, program: &Path) -> Result<String, SweepError> {
    Ok(format!(
        "export RAYON_NUM_THREADS={}\nexec {} sweep {} --output={} --shard \"$SLURM_ARRAY_TASK_ID/{}\"\n",
        options.cores,
        word("program", program)?,
        word("plan", &Folder::plan_of(out))?,
        word("folder", out)?,
        options.tasks
    ))
}

fn merge_command(out: &Path, table: &Path, program: &Path) -> Result<String, SweepError> {
    Ok(format!(
        "exec {} sweep merge {} --output={} --overwrite\n",
        word("program", program)?,
        word("folder", out)?,
        word("table", table)?
    ))
}

/// The arguments of `sbatch` for both jobs.
fn requested(options: &SlurmOptions) -> Result<Vec<String>, SweepError> {
    let all = [
        ("partition", &options.partition),
        ("account", &options.account),
        ("time", &options.time),
        ("mem", &options.memory),
    ];
    let argument = |(option, value): (&'static str, &Option<String>)| {
        let value = plain(option, value.as_ref()?);
        Some(value.map(|value| format!("--{option}={value}")))
    };
    all.into_iter().filter_map(argument).collect()
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

/// Text without control characters.
fn plain<'a>(what: &'static str, text: &'a str) -> Result<&'a str, SweepError> {
    match text.contains(char::is_control) {
        true => Err(SweepError::Unquotable { what, found: text.to_owned() }),
        false => Ok(text),
    }
}

/// The name of a file as one word of a shell.
fn word(what: &'static str, path: &Path) -> Result<String, SweepError> {
    let found = || path.to_string_lossy().into_owned();
    let text = path.to_str().ok_or_else(|| SweepError::Unquotable { what, found: found() })?;
    Ok(format!("'{}'", plain(what, text)?.replace('\'', "'\\''")))
}

/// Writes a script, over one that this wrote and nobody changed.
fn write_script(file: &Path, command: &str) -> Result<(), SweepError> {
    let text = |command: &str| {
        let digest = hexadecimal(Sha256::new_with_prefix(command));
        format!("{HEAD}{digest}\n{command}")
    };
    match fs::read(file) {
        Err(cause) if cause.kind() == ErrorKind::NotFound => {}
        Err(cause) => return Err(io_error(file, "cannot be read")(cause)),
        Ok(there) => {
            let there = String::from_utf8_lossy(&there);
            let command = there.splitn(3, '\n').nth(2).unwrap_or_default();
            if there != text(command) {
                return Err(SweepError::OtherScript { file: file.to_owned() });
            }
        }
    }
    // A script that is not whole would be one of somebody else.
    let mut draft = new_file(file.parent().unwrap_or(Path::new(".")), ".script-")?;
    let written = draft.write_all(text(command).as_bytes());
    written.map_err(io_error(file, "cannot be written"))?;
    draft.persist(file).map_err(|error| io_error(file, "cannot be written")(error.error))?;
    Ok(())
}

fn note_job(folder: &Path, job: &str, tasks: u64) -> Result<(), SweepError> {
    let file = folder.join(JOBS);
    let opened = fs::OpenOptions::new().create(true).append(true).open(&file);
    let written = opened.and_then(|mut out| out.write_all(format!("{job} {tasks}\n").as_bytes()));
    written.map_err(io_error(&file, "cannot be written"))
}

/// The number of the job.
fn sbatch(arguments: &[String], script: &Path) -> Result<String, SweepError> {
    let output = Command::new("sbatch").arg("--parsable").args(arguments).arg(script).output();
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
    fn scripts_have_any_name_as_one_word() {
        let options = SlurmOptions {
            tasks: 8,
            cores: 4,
            partition: Some("long; x".to_owned()),
            account: None,
            time: Some("2:00:00".to_owned()),
            memory: None,
        };
        let (out, program) = (Path::new("/data/it's $(here)"), Path::new("/bin/tw"));
        let text = array_command(out, &options, program).unwrap();
        let command = "exec '/bin/tw' sweep '/data/it'\\''s $(here)/plan.sweep.ron' \
            --output='/data/it'\\''s $(here)' --shard \"$SLURM_ARRAY_TASK_ID/8\"";
        assert_eq!(text.lines().collect::<Vec<_>>(), ["export RAYON_NUM_THREADS=4", command]);
        assert_eq!(requested(&options).unwrap(), ["--partition=long; x", "--time=2:00:00"]);
        for control in ["\n", "\r", "\t", "\0", "\u{1b}", "\u{85}"] {
            let options = SlurmOptions { account: Some(format!("a{control}b")), ..options.clone() };
            assert!(matches!(requested(&options), Err(SweepError::Unquotable { .. })));
            let name = format!("/data/a{control}b");
            let refused = merge_command(Path::new(&name), out, program);
            assert!(matches!(refused, Err(SweepError::Unquotable { what: "folder", .. })));
        }
    }

    #[test]
    fn only_unchanged_own_scripts_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("array.sh");
        for command in ["exec 'a'\n", "exec 'b'\nexec 'c'\n", "exec 'a'\n"] {
            write_script(&file, command).unwrap();
        }
        let own = fs::read(&file).unwrap();
        let changed = (0..own.len()).map(|at| {
            let mut bytes = own.clone();
            bytes[at] ^= 1;
            bytes
        });
        let others = [&b""[..], b"#!/bin/sh\nexec mine\n", &own[..own.len() - 1]];
        for other in others.map(<[u8]>::to_vec).into_iter().chain(changed) {
            fs::write(&file, &other).unwrap();
            let refused = write_script(&file, "exec 'a'\n");
            assert!(matches!(refused, Err(SweepError::OtherScript { .. })), "{other:?}");
            assert_eq!(fs::read(&file).unwrap(), other);
        }
    }
}
