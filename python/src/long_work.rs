//! Long work: done on a thread of its own while Python's other threads run, and stopped by Ctrl+C.

use crate::errors::Done;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
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
    run_with_progress(py, None, work)
}

/// The same with a callable that gets the part of the work that is done, 0 to 1, by the thread that called.
/// An exception of it ends the work as a signal does.
///
/// # Errors
/// Those of the work, or the exception.
pub fn run_with_progress<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Task) -> Done<T> + Send,
) -> Done<T> {
    let progress = progress.map(|progress| Progress::new(progress.clone().unbind()));
    let task = progress.as_ref().map_or_else(Task::default, Progress::task);
    let look = |py: Python<'_>| -> PyResult<()> {
        py.check_signals()?;
        progress.as_ref().map_or(Ok(()), |progress| progress.report(py))
    };
    let found = py.detach(|| {
        thread::scope(|scope| {
            let (ended, is_ended) = channel::<()>();
            let work = || {
                // Dropped however the work ends.
                let _ended = ended;
                work(&task)
            };
            let worker = thread::Builder::new().spawn_scoped(scope, work)?;
            while is_ended.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
                if let Err(signal) = Python::attach(look) {
                    task.cancel.cancel();
                    // What it came to is not wanted any more.
                    drop(worker.join());
                    return Err(signal.into());
                }
            }
            worker.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    })?;
    if let Some(progress) = &progress {
        progress.report(py)?;
    }
    Ok(found)
}

/// How far work is, for a callable that gets each part once.
struct Progress {
    callable: Py<PyAny>,
    /// The bits of the part that is done; of none before the first one.
    latest: Arc<AtomicU64>,
    reported: AtomicU64,
}

const NONE: u64 = u64::MAX;

impl Progress {
    fn new(callable: Py<PyAny>) -> Self {
        let latest = Arc::new(AtomicU64::new(NONE));
        Self { callable, latest, reported: AtomicU64::new(NONE) }
    }

    fn task(&self) -> Task {
        let latest = Arc::clone(&self.latest);
        Task::with_progress(move |part| latest.store(part.to_bits(), Ordering::Relaxed))
    }

    fn report(&self, py: Python<'_>) -> PyResult<()> {
        let latest = self.latest.load(Ordering::Relaxed);
        if self.reported.swap(latest, Ordering::Relaxed) != latest {
            self.callable.call1(py, (f64::from_bits(latest),))?;
        }
        Ok(())
    }
}
