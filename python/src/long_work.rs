//! Long work: done on a thread of its own while Python's other threads run, and stopped by Ctrl+C.

use crate::errors::Done;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use trackwright_task::Task;

/// Between two looks for a signal: much less than a person notices.
const POLL: Duration = Duration::from_millis(20);

/// Does work without holding Python's lock. Signals are looked for meanwhile, by the thread that
/// called: the main one is the only one that may. One that raises an exception, as Ctrl+C does, cancels
/// the task, and is what is returned once the work has ended.
///
/// # Errors
/// Those of the work, or the exception.
pub fn run<T: Send>(py: Python<'_>, work: impl FnOnce(&Task) -> Done<T> + Send) -> Done<T> {
    let task = Task::default();
    py.detach(|| {
        thread::scope(|scope| {
            let (ended, is_ended) = channel::<()>();
            let work = || {
                // Dropped however the work ends.
                let _ended = ended;
                work(&task)
            };
            let worker = thread::Builder::new().spawn_scoped(scope, work)?;
            while is_ended.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
                if let Err(signal) = Python::attach(|py| py.check_signals()) {
                    task.cancel.cancel();
                    // What it came to is not wanted any more.
                    drop(worker.join());
                    return Err(signal.into());
                }
            }
            worker.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    })
}
