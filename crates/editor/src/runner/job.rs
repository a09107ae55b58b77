//! One piece of long work on a thread of its own: it tells how far it is and what it came to, and
//! can be given up.

use crate::runner::wake::Waker;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use trackwright_task::{CancelToken, Task};

/// A bar of some hundred steps is smooth enough; each costs a frame.
const STEP: f64 = 0.01;

/// Work under way; dropping it gives it up.
#[derive(Debug)]
pub struct Job<T> {
    cancel: CancelToken,
    told: Mutex<Receiver<Told<T>>>,
    part: f64,
}

enum Told<T> {
    Part(f64),
    Done(T),
}

/// How work ended.
#[derive(Debug, PartialEq)]
pub enum Ended<T> {
    Done(T),
    /// Its thread is gone without an answer.
    Lost,
}

impl<T: Send + 'static> Job<T> {
    /// Starts a thread.
    ///
    /// # Errors
    /// The system's, where it has no thread to give.
    pub fn start(
        name: &str,
        waker: &Waker,
        work: impl FnOnce(&Task) -> T + Send + 'static,
    ) -> std::io::Result<Self> {
        let (sender, told) = channel();
        let task = Task::told_to({
            let (sender, waker) = (sender.clone(), waker.clone());
            let last = Mutex::new(0.0);
            move |part| {
                if let Ok(mut last) = last.lock()
                    && part - *last >= STEP
                {
                    *last = part;
                    tell(&sender, Told::Part(part), &waker);
                }
            }
        });
        let cancel = task.cancel.clone();
        let waker = waker.clone();
        std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            let answer = work(&task);
            tell(&sender, Told::Done(answer), &waker);
        })?;
        Ok(Self { cancel, told: Mutex::new(told), part: 0.0 })
    }

    /// How far it is, from 0 to 1.
    pub fn part(&self) -> f64 {
        self.part
    }

    /// Asks it to stop; its answer then says so.
    pub fn cancel(&self) {
        self.cancel.cancel();
    }

    /// Listens to what it told meanwhile; how it ended, if it did.
    pub fn hear(&mut self) -> Option<Ended<T>> {
        let Ok(told) = self.told.get_mut() else {
            return Some(Ended::Lost);
        };
        loop {
            match told.try_recv() {
                Ok(Told::Part(part)) => self.part = part,
                Ok(Told::Done(answer)) => return Some(Ended::Done(answer)),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => return Some(Ended::Lost),
            }
        }
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

fn tell<T>(sender: &Sender<Told<T>>, what: Told<T>, waker: &Waker) {
    // Whoever asked may be gone.
    if sender.send(what).is_ok() {
        waker.wake();
    }
}
