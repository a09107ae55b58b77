//! A thread with an event loop, and locks that outlast a thread that panicked.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use tokio::runtime::Runtime;
use tokio::sync::oneshot;

/// A thread that runs as long as this is there.
pub struct EventThread {
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl EventThread {
    /// Starts it. What `run` makes ends once it receives anything, or that this was dropped.
    pub fn start<F: Future<Output = ()>>(
        name: &str,
        runtime: Runtime,
        run: impl FnOnce(oneshot::Receiver<()>) -> F + Send + 'static,
    ) -> io::Result<Self> {
        let (stop, stopped) = oneshot::channel();
        let thread = Builder::new().name(name.to_owned()).spawn(move || {
            runtime.block_on(run(stopped));
            // A name that is still being looked up is not waited for.
            runtime.shutdown_background();
        })?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }

    /// Stops it; returns once it has ended.
    pub fn end(&mut self) {
        if let Some(stop) = self.stop.take() {
            // A thread that ended by itself needs no word.
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for EventThread {
    fn drop(&mut self) {
        self.end();
    }
}

/// Locks whatever a thread that panicked left.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
