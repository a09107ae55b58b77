//! The background runner: work on a thread of its own, of which the newest of each kind counts.
//!
//! Everything that takes longer than a frame goes through a [`Runner`]: studies, layers, fits,
//! readings, recovery files. There is one slot a kind of work. A new job replaces the one that
//! waits in its slot and cancels the one of its kind that runs, so that the thread is never more
//! than one job behind. An answer carries the key of its request (a revision, for instance) and
//! whether it is of the newest job of its kind; each answer wakes the event loop, and no frame is
//! drawn while waiting. Work checks its cancel token at least every 5 ms.

use crate::runner::wake::Waker;
use std::collections::BTreeMap;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use trackwright_task::{CancelToken, Task};

/// A bar of some hundred steps is smooth enough; each costs a frame.
const PROGRESS_STEP: f64 = 0.01;

/// What is done for a job: it reports whatever it finds, as often as it finds something better,
/// and returns the last.
pub type Work<A> = Box<dyn FnOnce(&Task, &mut dyn FnMut(A)) -> Option<A> + Send>;

/// How a job queues.
#[derive(Clone, Copy, Debug, Default)]
pub struct JobInfo {
    /// Jobs of one kind replace each other; the smallest kind that waits goes first.
    pub kind: u8,
    /// How long a running job of the kind is left alone although a newer one waits.
    pub patience: Duration,
    /// The job starts once there was no newer one for so long…
    pub quiet: Duration,
    /// …but at the latest so long after the first of those that it replaced.
    pub longest_wait: Duration,
    /// Whether somebody sees how far it is: each step of the bar costs a frame.
    pub shows_progress: bool,
}

impl JobInfo {
    /// Once there was no newer job for so long, however long that takes.
    pub fn once_quiet(quiet: Duration) -> Self {
        Self { quiet, longest_wait: Duration::from_secs(3600), ..Self::default() }
    }
}

/// What came of a job.
#[derive(Debug)]
pub struct Answer<K, A> {
    pub key: K,
    pub kind: u8,
    pub took: Duration,
    /// Whether no newer job of its kind was submitted, and it was not given up.
    pub is_newest: bool,
    pub value: Result<A, Lost>,
}

/// Why a job has no answer.
#[derive(Debug, thiserror::Error)]
pub enum Lost {
    #[error("cannot start a thread: {0}")]
    NoThread(io::Error),
    #[error("the work ended without an answer")]
    Panicked,
}

/// A thread that does jobs; it starts with the first one, so that a layer that nobody turns on has
/// none. Dropping the runner cancels them.
pub struct Runner<K, A> {
    name: &'static str,
    shared: Arc<Shared<K, A>>,
    sender: Sender<Sent<K, A>>,
    answers: Mutex<Receiver<Sent<K, A>>>,
    thread: Option<JoinHandle<()>>,
    waker: Waker,
    /// Number of the newest job, and that of each kind.
    number: u64,
    newest: BTreeMap<u8, u64>,
}

type Sent<K, A> = (u64, Answer<K, A>);

struct Shared<K, A> {
    slots: Mutex<Slots<K, A>>,
    changed: Condvar,
    /// Bits of how far the job is that runs, from 0 to 1.
    progress: Arc<AtomicU64>,
}

struct Slots<K, A> {
    waiting: BTreeMap<u8, Waiting<K, A>>,
    running: Option<Running>,
    ending: Option<Ending>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Ending {
    Now,
    /// Once nothing waits any more.
    AfterTheRest,
}

struct Waiting<K, A> {
    number: u64,
    key: K,
    work: Work<A>,
    since: Instant,
    ready_at: Instant,
    shows_progress: bool,
    /// It was cancelled before it began; its task then is from the start.
    is_cancelled: bool,
}

struct Running {
    kind: u8,
    since: Instant,
    cancel: CancelToken,
}

impl<K: Clone + Send + 'static, A: Send + 'static> Runner<K, A> {
    pub fn new(name: &'static str, waker: Waker) -> Self {
        let (sender, answers) = channel();
        Self {
            name,
            shared: Arc::new(Shared {
                slots: Mutex::new(Slots { waiting: BTreeMap::new(), running: None, ending: None }),
                changed: Condvar::new(),
                progress: Arc::default(),
            }),
            sender,
            answers: Mutex::new(answers),
            thread: None,
            waker,
            number: 0,
            newest: BTreeMap::new(),
        }
    }

    /// Hands a job over. A system without a thread to give answers it as [`Lost`].
    pub fn submit(&mut self, job: JobInfo, key: K, work: Work<A>) {
        self.number += 1;
        self.newest.insert(job.kind, self.number);
        let now = Instant::now();
        {
            let mut slots = self.shared.slots();
            if let Some(running) = &slots.running
                && running.kind == job.kind
                && running.since.elapsed() >= job.patience
            {
                running.cancel.cancel();
            }
            let since = slots.waiting.get(&job.kind).map_or(now, |old| old.since);
            let ready_at = (now + job.quiet).min((since + job.longest_wait).max(now));
            let waiting = Waiting {
                number: self.number,
                key: key.clone(),
                work,
                since,
                ready_at,
                shows_progress: job.shows_progress,
                is_cancelled: false,
            };
            slots.waiting.insert(job.kind, waiting);
        }
        if let Err(error) = self.start() {
            self.shared.slots().waiting.remove(&job.kind);
            let answer = Answer {
                key,
                kind: job.kind,
                took: Duration::ZERO,
                is_newest: true,
                value: Err(Lost::NoThread(error)),
            };
            // The receiver is this runner's own.
            let _ = self.sender.send((self.number, answer));
            self.waker.wake();
        }
        self.shared.changed.notify_one();
    }

    fn start(&mut self) -> io::Result<()> {
        if self.thread.is_none() {
            let (shared, sender) = (Arc::clone(&self.shared), self.sender.clone());
            let waker = self.waker.clone();
            let thread = std::thread::Builder::new()
                .name(self.name.into())
                .spawn(move || shared.work(&sender, &waker))?;
            self.thread = Some(thread);
        }
        Ok(())
    }

    /// Forgets the job of a kind that waits and cancels the one that runs; neither has an answer
    /// that is the newest.
    pub fn give_up(&mut self, kind: u8) {
        self.newest.remove(&kind);
        let mut slots = self.shared.slots();
        slots.waiting.remove(&kind);
        if let Some(running) = slots.running.as_ref().filter(|running| running.kind == kind) {
            running.cancel.cancel();
        }
    }

    /// Requests that the jobs that run or wait stop; their answers then report it.
    pub fn cancel(&self) {
        let mut slots = self.shared.slots();
        if let Some(running) = &slots.running {
            running.cancel.cancel();
        }
        slots.waiting.values_mut().for_each(|job| job.is_cancelled = true);
    }

    /// The answers since the last call, in the order in which they were found.
    pub fn answers(&self) -> Vec<Answer<K, A>> {
        let answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        let stamped = |(number, answer): Sent<K, A>| {
            let is_newest = self.newest.get(&answer.kind) == Some(&number);
            Answer { is_newest, ..answer }
        };
        answers.try_iter().map(stamped).collect()
    }

    /// How far the running job is, from 0 to 1.
    pub fn progress(&self) -> f64 {
        f64::from_bits(self.shared.progress.load(Ordering::Relaxed))
    }

    /// Whether nothing waits and nothing runs.
    pub fn is_idle(&self) -> bool {
        let slots = self.shared.slots();
        slots.waiting.is_empty() && slots.running.is_none()
    }

    /// Waits until everything that was submitted is done, however long it was to stay quiet.
    pub fn finish(&mut self) {
        self.shared.slots().ending = Some(Ending::AfterTheRest);
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported by the panic hook.
            let _ = thread.join();
        }
    }
}

impl<K, A> Drop for Runner<K, A> {
    fn drop(&mut self) {
        let mut slots = self.shared.slots();
        slots.ending = Some(Ending::Now);
        if let Some(running) = &slots.running {
            running.cancel.cancel();
        }
        drop(slots);
        self.shared.changed.notify_one();
    }
}

impl<K, A> Shared<K, A> {
    fn slots(&self) -> MutexGuard<'_, Slots<K, A>> {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next job; `None` where the thread is to end.
    fn next(&self, waker: &Waker) -> Option<(u8, Waiting<K, A>, Task)> {
        let mut slots = self.slots();
        loop {
            let now = Instant::now();
            let is_ready = |job: &Waiting<K, A>| slots.ending.is_some() || job.ready_at <= now;
            let ready = slots.waiting.iter().find(|(_, job)| is_ready(job)).map(|(kind, _)| *kind);
            match slots.ending {
                Some(Ending::Now) => return None,
                Some(Ending::AfterTheRest) if ready.is_none() => return None,
                _ => {}
            }
            if let Some((kind, job)) = ready.and_then(|kind| slots.waiting.remove_entry(&kind)) {
                let task = match job.shows_progress {
                    true => task(Arc::clone(&self.progress), waker.clone()),
                    false => Task::default(),
                };
                if job.is_cancelled {
                    task.cancel.cancel();
                }
                slots.running = Some(Running { kind, since: now, cancel: task.cancel.clone() });
                return Some((kind, job, task));
            }
            let next = slots.waiting.values().map(|job| job.ready_at).min();
            slots = match next {
                Some(at) => {
                    let waited =
                        self.changed.wait_timeout(slots, at.saturating_duration_since(now));
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
                None => self.changed.wait(slots).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }

    fn work(&self, sender: &Sender<Sent<K, A>>, waker: &Waker)
    where
        K: Clone,
    {
        while let Some((kind, job, task)) = self.next(waker) {
            let Waiting { number, key, work, .. } = job;
            let start = Instant::now();
            let answer = |value| {
                let took = start.elapsed();
                (number, Answer { key: key.clone(), kind, took, is_newest: true, value })
            };
            let mut report = |value| {
                // The window may be gone.
                let _ = sender.send(answer(Ok(value)));
                waker.wake();
            };
            let last = catch_unwind(AssertUnwindSafe(|| work(&task, &mut report)));
            let last = last.map_err(|_| Lost::Panicked).transpose();
            // Whoever sees that nothing runs finds the answer.
            let mut slots = self.slots();
            if let Some(value) = last {
                let _ = sender.send(answer(value));
            }
            slots.running = None;
            drop(slots);
            waker.wake();
        }
    }
}

/// A task that keeps how far it is, from 0 on.
fn task(progress: Arc<AtomicU64>, waker: Waker) -> Task {
    progress.store(0.0_f64.to_bits(), Ordering::Relaxed);
    Task::with_progress(move |part| {
        // Two threads that report at once cost a frame more, or a step of the bar.
        if part - f64::from_bits(progress.load(Ordering::Relaxed)) >= PROGRESS_STEP {
            progress.store(part.to_bits(), Ordering::Relaxed);
            waker.wake();
        }
    })
}

/// A single job on a runner of its own; dropping it cancels it.
pub struct Job<T>(Runner<(), T>);

impl<T: Send + 'static> Job<T> {
    pub fn start(
        name: &'static str,
        waker: &Waker,
        work: impl FnOnce(&Task) -> T + Send + 'static,
    ) -> Self {
        let mut runner = Runner::new(name, waker.clone());
        let info = JobInfo { shows_progress: true, ..JobInfo::default() };
        runner.submit(info, (), Box::new(move |task, _| Some(work(task))));
        Self(runner)
    }

    /// How far it is, from 0 to 1.
    pub fn progress(&self) -> f64 {
        self.0.progress()
    }

    /// Requests that it stops; its answer then reports it.
    pub fn cancel(&self) {
        self.0.cancel();
    }

    /// Waits until it is done.
    pub fn finish(&mut self) {
        self.0.finish();
    }

    /// Its answer, once there is one.
    pub fn answer(&self) -> Option<Result<T, Lost>> {
        self.0.answers().pop().map(|answer| answer.value)
    }
}

/// The newest answer, and what it was found for: it stays while a newer one is on its way.
pub struct Newest<K, A> {
    runner: Runner<K, A>,
    requested: Option<K>,
    found: Option<(K, A)>,
}

impl<K: Clone + PartialEq + Send + 'static, A: Send + 'static> Newest<K, A> {
    pub fn new(name: &'static str, waker: Waker) -> Self {
        Self { runner: Runner::new(name, waker), requested: None, found: None }
    }

    /// What was requested last.
    pub fn requested(&self) -> Option<&K> {
        self.requested.as_ref()
    }

    /// Requests in the place of what was requested before.
    pub fn request(
        &mut self,
        key: K,
        work: impl FnOnce(&Task, &mut dyn FnMut(A)) -> Option<A> + Send + 'static,
    ) {
        self.requested = Some(key.clone());
        self.runner.submit(JobInfo::default(), key, Box::new(work));
    }

    /// Forgets what was requested and found.
    pub fn give_up(&mut self) {
        self.runner.give_up(0);
        self.requested = None;
        self.found = None;
    }

    /// Forgets what was found.
    pub fn forget(&mut self) {
        self.found = None;
    }

    /// Keeps the newest of what was found since the last call, `each` of which is shown;
    /// whether there was anything.
    pub fn receive(&mut self, mut each: impl FnMut(&A)) -> bool {
        let mut is_any = false;
        for answer in self.runner.answers().into_iter().filter(|answer| answer.is_newest) {
            match answer.value {
                Ok(value) => {
                    each(&value);
                    self.found = Some((answer.key, value));
                    is_any = true;
                }
                Err(lost) => bevy::log::warn!("{}: {lost}", self.runner.name),
            }
        }
        is_any
    }

    /// What was found last, and for what.
    pub fn found(&self) -> Option<&(K, A)> {
        self.found.as_ref()
    }

    /// Whether nothing waits and nothing runs.
    pub fn is_idle(&self) -> bool {
        self.runner.is_idle()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A runner, and a channel that receives a message whenever it wakes.
    fn runner() -> (Runner<u32, u32>, Receiver<()>) {
        let (wake, woken) = channel();
        let waker = Waker::new(move || {
            let _ = wake.send(());
        });
        (Runner::new("test", waker), woken)
    }

    fn newest(runner: &Runner<u32, u32>) -> Vec<u32> {
        let answers = runner.answers().into_iter().filter(|answer| answer.is_newest);
        answers.map(|answer| answer.value.unwrap()).collect()
    }

    #[test]
    fn only_the_newest_job_is_answered() {
        let (mut runner, woken) = runner();
        let (go, gate) = channel::<()>();
        let first: Work<u32> = Box::new(move |task, found| {
            found(1);
            // Until the second job is there.
            let _ = gate.recv();
            assert!(task.cancel.is_cancelled());
            Some(2)
        });
        runner.submit(JobInfo::default(), 0, first);
        woken.recv().unwrap();
        assert_eq!(newest(&runner), [1]);
        let second: Work<u32> = Box::new(|_, found| {
            found(3);
            Some(4)
        });
        runner.submit(JobInfo::default(), 1, second);
        go.send(()).unwrap();
        let mut answers = Vec::new();
        while answers.len() < 2 {
            woken.recv().unwrap();
            answers.extend(newest(&runner));
        }
        assert_eq!(answers, [3, 4]);
    }

    #[test]
    fn a_job_that_is_given_up_is_not_answered() {
        let (mut runner, woken) = runner();
        runner.submit(JobInfo::default(), 0, Box::new(|_, _| Some(1)));
        woken.recv().unwrap();
        assert!(runner.is_idle());
        runner.give_up(0);
        assert!(newest(&runner).is_empty());
    }

    #[test]
    fn a_panic_is_reported_and_the_next_job_runs() {
        let (mut runner, woken) = runner();
        runner.submit(JobInfo::default(), 0, Box::new(|_, _| panic!("as the test wants it")));
        woken.recv().unwrap();
        assert!(matches!(runner.answers()[..], [Answer { value: Err(Lost::Panicked), .. }]));
        runner.submit(JobInfo::default(), 1, Box::new(|_, _| Some(7)));
        woken.recv().unwrap();
        assert_eq!(newest(&runner), [7]);
    }

    #[test]
    fn a_job_cancelled_while_it_waits_begins_cancelled() {
        let (mut runner, _woken) = runner();
        let later = JobInfo::once_quiet(Duration::from_secs(3600));
        let work =
            |task: &Task, _: &mut dyn FnMut(u32)| Some(u32::from(task.cancel.is_cancelled()));
        runner.submit(later, 0, Box::new(work));
        runner.cancel();
        runner.finish();
        assert_eq!(newest(&runner), [1]);
    }

    #[test]
    fn a_job_that_waits_for_quiet_is_done_at_the_end() {
        let (mut runner, _woken) = runner();
        let hour = Duration::from_secs(3600);
        let later = JobInfo { quiet: hour, longest_wait: hour, ..JobInfo::default() };
        runner.submit(later, 0, Box::new(|_, _| Some(1)));
        runner.submit(later, 1, Box::new(|_, _| Some(2)));
        assert!(!runner.is_idle());
        runner.finish();
        assert_eq!(newest(&runner), [2]);
    }
}
