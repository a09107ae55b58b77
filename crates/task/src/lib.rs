//! What long work shares with whoever waits for it: a flag that stops it, and how far it is.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that stops a computation whose answer nobody wants any more; checked at least every few
/// milliseconds.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
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

    /// Work whose progress is told as a part from 0 to 1.
    pub fn told_to(listener: impl Fn(f64) + Send + Sync + 'static) -> Self {
        Self { cancel: CancelToken::default(), listener: Some(Arc::new(listener)) }
    }

    /// A stretch of this task as a task of its own: its 0 is `from`, its 1 is `to`.
    pub fn stretch(&self, from: f64, to: f64) -> Self {
        let outer = self.listener.clone();
        Self {
            cancel: self.cancel.clone(),
            listener: outer.map(|outer| -> Listener {
                Arc::new(move |part| outer(from + (to - from) * part))
            }),
        }
    }

    /// Says how much is done and whether to go on.
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
            .field("is_told", &self.listener.is_some())
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn a_step_tells_its_part_and_stops_after_a_cancel() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let task = Task::told_to({
            let heard = heard.clone();
            move |part| heard.lock().unwrap().push(part)
        });
        assert_eq!(task.step(1, 4), Ok(()));
        task.cancel.cancel();
        assert_eq!(task.step(2, 4), Err(Cancelled));
        assert_eq!(*heard.lock().unwrap(), [0.25]);
    }

    #[test]
    fn a_stretch_tells_its_part_of_the_whole_and_stops_with_it() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let task = Task::told_to({
            let heard = heard.clone();
            move |part| heard.lock().unwrap().push(part)
        });
        let stretch = task.stretch(0.5, 0.75);
        stretch.step(0, 2).unwrap();
        stretch.step(1, 2).unwrap();
        stretch.step(2, 2).unwrap();
        assert_eq!(*heard.lock().unwrap(), [0.5, 0.625, 0.75]);
        task.cancel.cancel();
        assert_eq!(stretch.step(2, 2), Err(Cancelled));
    }
}
