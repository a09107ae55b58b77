//! Work in the background of which only the newest wish counts, answered in one picture or in
//! better and better ones.

use crate::runner::wake::Waker;
use bevy::log::warn;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use trackwright_task::{CancelToken, Task};

/// What is done for a wish: it tells whatever it finds, as often as it finds something better.
pub type Work<A> = Box<dyn FnOnce(&Task, &mut dyn FnMut(A)) + Send>;

/// A thread that works on the newest wish; dropping it stops the thread.
///
/// The thread starts with the first wish: a layer that nobody turns on has none.
pub struct Latest<A> {
    name: &'static str,
    shared: Arc<Shared<A>>,
    sender: Sender<(u64, A)>,
    answers: Mutex<Receiver<(u64, A)>>,
    thread: Option<JoinHandle<()>>,
    waker: Waker,
    number: u64,
}

struct Shared<A> {
    slot: Mutex<Slot<A>>,
    changed: Condvar,
}

struct Slot<A> {
    waiting: Option<(u64, Work<A>)>,
    running: Option<CancelToken>,
    is_stopped: bool,
}

impl<A: Send + 'static> Latest<A> {
    pub fn new(name: &'static str, waker: Waker) -> Self {
        let (sender, answers) = channel();
        Self {
            name,
            shared: Arc::new(Shared {
                slot: Mutex::new(Slot { waiting: None, running: None, is_stopped: false }),
                changed: Condvar::new(),
            }),
            sender,
            answers: Mutex::new(answers),
            thread: None,
            waker,
            number: 0,
        }
    }

    /// Gives up what was wished before, whether it runs or waits.
    ///
    /// # Errors
    /// The system's, where it has no thread to give.
    pub fn wish(&mut self, work: Work<A>) -> std::io::Result<()> {
        self.number += 1;
        {
            let mut slot = self.shared.slot();
            if let Some(running) = &slot.running {
                running.cancel();
            }
            slot.waiting = Some((self.number, work));
        }
        if self.thread.is_none() {
            let (shared, sender) = (Arc::clone(&self.shared), self.sender.clone());
            let waker = self.waker.clone();
            self.thread = Some(
                std::thread::Builder::new()
                    .name(self.name.into())
                    .spawn(move || work_on(&shared, &sender, &waker))?,
            );
        }
        self.shared.changed.notify_one();
        Ok(())
    }

    /// Gives everything up that was wished.
    pub fn give_up(&mut self) {
        self.number += 1;
        let mut slot = self.shared.slot();
        slot.waiting = None;
        if let Some(running) = &slot.running {
            running.cancel();
        }
    }

    /// What was found for the newest wish since the last call.
    pub fn answers(&self) -> Vec<A> {
        let answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        answers
            .try_iter()
            .filter(|(number, _)| *number == self.number)
            .map(|(_, answer)| answer)
            .collect()
    }

    /// Whether nothing waits and nothing runs.
    pub fn is_idle(&self) -> bool {
        let slot = self.shared.slot();
        slot.waiting.is_none() && slot.running.is_none()
    }
}

impl<A> Drop for Latest<A> {
    fn drop(&mut self) {
        {
            let mut slot = self.shared.slot();
            slot.is_stopped = true;
            if let Some(running) = &slot.running {
                running.cancel();
            }
        }
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported by the panic hook.
            let _ = thread.join();
        }
    }
}

/// The newest answer, and what it was found for: it stays while a newer one is on its way.
pub struct Newest<K, A> {
    latest: Latest<(K, A)>,
    asked: Option<K>,
    found: Option<(K, A)>,
}

impl<K: Clone + PartialEq + Send + 'static, A: Send + 'static> Newest<K, A> {
    pub fn new(name: &'static str, waker: Waker) -> Self {
        Self { latest: Latest::new(name, waker), asked: None, found: None }
    }

    /// What was asked for last.
    pub fn asked(&self) -> Option<&K> {
        self.asked.as_ref()
    }

    /// Asks in the place of what was asked before; work without an answer was given up.
    pub fn ask(&mut self, key: K, work: impl FnOnce(&Task) -> Option<A> + Send + 'static) {
        self.asked = Some(key.clone());
        let wish = self.latest.wish(Box::new(move |task, found| {
            if let Some(answer) = work(task) {
                found((key, answer));
            }
        }));
        if let Err(error) = wish {
            warn!("no thread for {}: {error}", self.latest.name);
        }
    }

    /// Forgets what was asked and found.
    pub fn give_up(&mut self) {
        self.latest.give_up();
        self.asked = None;
        self.found = None;
    }

    /// Forgets what was found, of something else than what is asked for now.
    pub fn forget(&mut self) {
        self.found = None;
    }

    /// Takes what was found since the last call; whether there was anything.
    pub fn hear(&mut self) -> bool {
        let newest = self.latest.answers().into_iter().next_back();
        let is_new = newest.is_some();
        self.found = newest.or(self.found.take());
        is_new
    }

    pub fn found(&self) -> Option<&(K, A)> {
        self.found.as_ref()
    }

    /// Whether nothing waits and nothing runs.
    pub fn is_idle(&self) -> bool {
        self.latest.is_idle()
    }
}

impl<A> Shared<A> {
    fn slot(&self) -> MutexGuard<'_, Slot<A>> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn work_on<A>(shared: &Shared<A>, sender: &Sender<(u64, A)>, waker: &Waker) {
    loop {
        let (number, work, task) = {
            let mut slot = shared.slot();
            slot.running = None;
            loop {
                if slot.is_stopped {
                    return;
                }
                if let Some((number, work)) = slot.waiting.take() {
                    let task = Task::default();
                    slot.running = Some(task.cancel.clone());
                    break (number, work, task);
                }
                slot = shared.changed.wait(slot).unwrap_or_else(PoisonError::into_inner);
            }
        };
        work(&task, &mut |answer| {
            // The window may be gone.
            if !task.cancel.is_cancelled() && sender.send((number, answer)).is_ok() {
                waker.wake();
            }
        });
        shared.slot().running = None;
        // Whoever waits for rest sees it.
        waker.wake();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn only_the_newest_wish_is_answered() {
        let (tell, told) = channel();
        let waker = Waker::new(move || {
            let _ = tell.send(());
        });
        let mut latest: Latest<u32> = Latest::new("test", waker);
        let (go, gate) = channel::<()>();
        let first: Work<u32> = Box::new(move |task, found| {
            found(1);
            // Until the second wish is there.
            let _ = gate.recv();
            assert!(task.cancel.is_cancelled());
            found(2);
        });
        latest.wish(first).unwrap();
        told.recv().unwrap();
        assert_eq!(latest.answers(), [1]);
        let second: Work<u32> = Box::new(|_, found| {
            found(3);
            found(4);
        });
        latest.wish(second).unwrap();
        go.send(()).unwrap();
        let mut answers = Vec::new();
        while answers.len() < 2 {
            told.recv().unwrap();
            answers.extend(latest.answers());
        }
        assert_eq!(answers, [3, 4]);
    }

    #[test]
    fn a_wish_that_is_given_up_is_not_answered() {
        let mut latest: Latest<u32> = Latest::new("test", Waker::new(|| {}));
        let (done, is_done) = channel();
        let work: Work<u32> = Box::new(move |_, found| {
            found(1);
            done.send(()).unwrap();
        });
        latest.wish(work).unwrap();
        is_done.recv().unwrap();
        latest.give_up();
        assert!(latest.answers().is_empty());
    }
}
