//! A process that a job waits for until it ends, or is ended because the job is cancelled.

use std::io::{self, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use trackwright_task::CancelToken;

/// How a process ended, and what it wrote to its standard error.
#[derive(Clone, Debug)]
pub struct EndedProcess {
    pub status: ExitStatus,
    pub complaint: String,
}

/// Runs a command to its end, which comes at once where the work is cancelled. It has neither input
/// nor output. Its end is noticed by its standard error, which closes with it: a process that closes
/// it before is no longer cancelled.
///
/// # Errors
/// A process that cannot be started, read or waited for.
pub fn run_process(command: &mut Command, cancel: &CancelToken) -> io::Result<EndedProcess> {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let stderr = child.stderr.take();
    let child = Arc::new(Mutex::new(child));
    let to_kill = Arc::clone(&child);
    cancel.on_cancel(move || kill(&to_kill));
    let mut complaint = Vec::new();
    let read = stderr.map_or(Ok(0), |mut stderr| stderr.read_to_end(&mut complaint));
    if read.is_err() {
        kill(&child);
    }
    let status = child.lock().unwrap_or_else(PoisonError::into_inner).wait()?;
    read?;
    Ok(EndedProcess { status, complaint: String::from_utf8_lossy(&complaint).into_owned() })
}

/// One that is locked is at its end. One that cannot be killed is waited for.
fn kill(child: &Mutex<Child>) {
    if let Ok(mut child) = child.try_lock() {
        let _ = child.kill();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_process_ends_with_status_and_complaint() {
        // More than a pipe holds.
        let mut command = shell("yes word | head -n 100000 >&2; exit 3");
        let ended = run_process(&mut command, &CancelToken::default()).unwrap();
        assert_eq!(ended.status.code(), Some(3));
        assert!(ended.complaint == "word\n".repeat(100_000), "{} bytes", ended.complaint.len());
    }

    #[test]
    fn cancelling_ends_a_process_that_never_ends() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("started");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let mut command = shell("echo > \"$0\"; exec sleep 600");
        command.arg(&pipe);
        let cancel = CancelToken::default();
        let (sender, ended) = channel();
        let token = cancel.clone();
        std::thread::spawn(move || sender.send(run_process(&mut command, &token)));
        // Blocks until it is written: the process runs.
        std::fs::read(&pipe).unwrap();
        assert!(ended.try_recv().is_err());
        cancel.cancel();
        assert_eq!(ended.recv().unwrap().unwrap().status.code(), None, "killed");
        // A process of work that is cancelled already ends as well.
        let late = run_process(&mut shell("exec sleep 600"), &cancel).unwrap();
        assert_eq!(late.status.code(), None, "killed");
    }

    #[test]
    fn a_program_that_is_not_there_is_an_error() {
        let mut nowhere = Command::new("/no/such/program");
        let error = run_process(&mut nowhere, &CancelToken::default()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
    }
}
