//! What long work shares with whoever waits for it: a flag that stops it, a hold, and its progress.
//!
//! ```
//! use std::sync::{Arc, Mutex};
//! use trackwright_task::{Cancelled, Task};
//! let progress = Arc::new(Mutex::new(0.0));
//! let shown = Arc::clone(&progress);
//! let task = Task::with_progress(move |part| *shown.lock().unwrap() = part);
//! let half = task.subtask(0.0, 0.5);
//! assert_eq!(half.step(1, 2), Ok(()));
//! assert_eq!(*progress.lock().unwrap(), 0.25);
//! task.cancel.cancel();
//! assert_eq!(half.step(2, 2), Err(Cancelled));
//! ```

mod hold;

pub use hold::Hold;

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A flag that stops a computation whose answer nobody wants any more; checked at least every few
/// milliseconds. What waits and cannot check it is called by it.
#[derive(Clone, Default)]
pub struct CancelToken {
    flag: Arc<Flag>,
    hold: Option<Hold>,
}

#[derive(Default)]
struct Flag {
    is_cancelled: AtomicBool,
    /// Called once the flag is set.
    hooks: Mutex<Vec<Hook>>,
}

type Hook = Box<dyn FnOnce() + Send>;

impl CancelToken {
    /// Requests that the work stop.
    pub fn cancel(&self) {
        self.flag.is_cancelled.store(true, Ordering::Relaxed);
        let hooks =
            std::mem::take(&mut *self.flag.hooks.lock().unwrap_or_else(PoisonError::into_inner));
        hooks.into_iter().for_each(|hook| hook());
    }

    /// Whether the work is to stop.
    pub fn is_cancelled(&self) -> bool {
        let is_cancelled = || self.flag.is_cancelled.load(Ordering::Relaxed);
        if let Some(hold) = &self.hold {
            hold.wait(is_cancelled);
        }
        is_cancelled()
    }

    /// The same flag for work that a hold lets wait: [`is_cancelled`](Self::is_cancelled) of what is
    /// returned, and of its clones, waits first while the work is held.
    #[must_use]
    pub fn held_by(&self, hold: &Hold) -> Self {
        let woken = hold.clone();
        self.on_cancel(move || woken.wake());
        Self { flag: Arc::clone(&self.flag), hold: Some(hold.clone()) }
    }

    /// Calls the hook once by the thread that cancels; at once where that has happened.
    pub fn on_cancel(&self, hook: impl FnOnce() + Send + 'static) {
        let mut hooks = self.flag.hooks.lock().unwrap_or_else(PoisonError::into_inner);
        // The flag is set before the hooks are called: either it is seen here or the hook is there.
        if self.is_cancelled() {
            drop(hooks);
            hook();
        } else {
            hooks.push(Box::new(hook));
        }
    }
}

impl fmt::Debug for CancelToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("CancelToken").field(&self.is_cancelled()).finish()
    }
}

/// The work was stopped by its [`CancelToken`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Called with the part of the work that is done, 0 to 1, from any thread.
type Listener = Arc<dyn Fn(f64) + Send + Sync>;

/// A piece of long work as seen from inside: may it go on, and who wants to know how far it is.
#[derive(Clone, Default)]
pub struct Task {
    pub cancel: CancelToken,
    listener: Option<Listener>,
}

impl Task {
    /// Work that can be stopped, without anyone listening.
    pub fn cancelled_by(cancel: CancelToken) -> Self {
        Self { cancel, listener: None }
    }

    /// Work whose progress is reported as a part from 0 to 1.
    pub fn with_progress(listener: impl Fn(f64) + Send + Sync + 'static) -> Self {
        Self { cancel: CancelToken::default(), listener: Some(Arc::new(listener)) }
    }

    /// The same task for work that a hold lets wait.
    #[must_use]
    pub fn held_by(&self, hold: &Hold) -> Self {
        Self { cancel: self.cancel.held_by(hold), listener: self.listener.clone() }
    }

    /// A part of this task as a task of its own: its 0 is `from`, its 1 is `to`.
    pub fn subtask(&self, from: f64, to: f64) -> Self {
        let outer = self.listener.clone();
        Self {
            cancel: self.cancel.clone(),
            listener: outer.map(|outer| -> Listener {
                Arc::new(move |part| outer(from + (to - from) * part))
            }),
        }
    }

    /// Reports how much is done, and returns whether to go on.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn step(&self, done: usize, all: usize) -> Result<(), Cancelled> {
        if self.cancel.is_cancelled() {
            return Err(Cancelled);
        }
        if let Some(listener) = &self.listener {
            listener(done as f64 / all.max(1) as f64);
        }
        Ok(())
    }
}

impl fmt::Debug for Task {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Task")
            .field("cancel", &self.cancel)
            .field("has_listener", &self.listener.is_some())
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hook_is_called_once_by_the_cancelling_thread() {
        let calls = Arc::new(Mutex::new(Vec::new()));
        let hook = || {
            let calls = calls.clone();
            move || calls.lock().unwrap().push(std::thread::current().id())
        };
        let token = CancelToken::default();
        token.on_cancel(hook());
        assert!(calls.lock().unwrap().is_empty());
        let other = token.clone();
        let canceller = std::thread::spawn(move || {
            other.cancel();
            other.cancel();
            std::thread::current().id()
        });
        let canceller = canceller.join().unwrap();
        assert_eq!(*calls.lock().unwrap(), [canceller]);
        // Too late to wait for it.
        token.on_cancel(hook());
        assert_eq!(*calls.lock().unwrap(), [canceller, std::thread::current().id()]);
    }

    #[test]
    fn steps_report_their_part_and_stop_when_cancelled() {
        for (from, to, expected) in [(0.0, 1.0, [0.0, 0.5, 1.0]), (0.5, 0.75, [0.5, 0.625, 0.75])] {
            let parts = Arc::new(Mutex::new(Vec::new()));
            let task = Task::with_progress({
                let parts = parts.clone();
                move |part| parts.lock().unwrap().push(part)
            });
            let subtask = task.subtask(from, to);
            for done in 0..3 {
                assert_eq!(subtask.step(done, 2), Ok(()));
            }
            task.cancel.cancel();
            assert_eq!(subtask.step(2, 2), Err(Cancelled));
            assert_eq!(*parts.lock().unwrap(), expected);
        }
    }
}
