//! One thread that computes everything the editor shows, the newest wish winning.
//!
//! There is one slot a kind of work. A new job replaces the one that waits in its slot and
//! cancels the one of its kind that runs, so the thread is never more than one job behind. It
//! takes the pose first (cheap, and the hand feels it), then the study, the figures that are to be
//! expected of it, then the slice. Results
//! carry the revision and the generation they were computed for.

use crate::workspaces::study::desk::ModeKind;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use trackwright_simulation::expected::expected_where_measured;
use trackwright_simulation::uncertainty::{TipUncertainty, UncertaintyError, first_order};
use trackwright_simulation::{
    CancelToken, ChartedProfile, Expected, Mode, Outcome, PoseDetail, Quantity, Scenario,
    SliceOutcome, SlicePlan, StudyError, look, run, run_profiled, sample_slice, slice_support,
};
use trackwright_task::Cancelled;

/// How long a running study is left alone although a newer one waits: short studies then finish
/// while the hand moves, and their figures follow it instead of standing still until it rests.
pub const PATIENCE: Duration = Duration::from_millis(100);

/// What a result belongs to. Generations count the worlds that were opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stamp {
    pub generation: u64,
    pub revision: u64,
}

/// Work for the solver.
pub enum Job {
    Pose(Arc<Scenario>, PoseWish),
    Study(Arc<Scenario>, StudyWish),
    /// The figures that are to be expected of a study.
    Expected(Arc<Scenario>, Mode),
    Slice(Arc<Scenario>, SliceWish),
}

/// What is wanted of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceWish {
    pub plan: SlicePlan,
    pub quantity: Quantity,
    /// Whether it keeps model validity.
    pub support: bool,
}

/// What is wanted of a pose beside its trial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoseWish {
    /// How far jitter scatters the tip.
    pub scatter: bool,
    /// The trial whose pose the scenario has; `None` for the design's own.
    pub trial: Option<usize>,
    /// Tells trials of one number apart where their poses are others.
    pub serial: u64,
}

/// What is wanted of a study.
#[derive(Clone, Debug)]
pub struct StudyWish {
    pub mode: Mode,
    pub of: StudyOf,
    /// Whether its trials are kept one by one.
    pub profile: bool,
}

/// What a study's figures are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StudyOf {
    /// A preview visits given poses, and stands for the range of motion.
    pub kind: ModeKind,
    pub extent: Extent,
}

/// How much of a range of motion a study visits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    Whole,
    /// A preview of so many poses, while something is dragged.
    PreviewOf(usize),
}

/// Where jitter puts the tip, or why that is not known.
pub type Scatter = Result<TipUncertainty, UncertaintyError>;

/// What came of a job.
pub struct Answer {
    pub stamp: Stamp,
    pub took: Duration,
    pub result: Solved,
}

/// A result by kind. Cancelled work says so, in order that it can be counted.
pub enum Solved {
    Pose(Box<PoseDetail>, Option<Box<Scatter>>, PoseWish),
    Study(Result<(Outcome, Option<Box<ChartedProfile>>), StudyError>, StudyOf),
    /// `None` where the room keeps no measurements to draw fields from.
    Expected(Result<Option<Box<Expected>>, Cancelled>),
    /// `None` where the room has no model validity.
    Slice(Result<Option<SliceOutcome>, StudyError>, Quantity),
}

/// Called from the solver's thread after each answer.
pub type Waker = Box<dyn Fn() + Send + Sync>;

/// The handle to the thread; dropping it stops the thread.
pub struct Solver {
    shared: Arc<Shared>,
    answers: Mutex<Receiver<Answer>>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    slots: Mutex<Slots>,
    changed: Condvar,
    waker: OnceLock<Waker>,
}

#[derive(Default)]
struct Slots {
    pose: Option<Waiting>,
    study: Option<Waiting>,
    expected: Option<Waiting>,
    slice: Option<Waiting>,
    running: Option<Running>,
    is_stopped: bool,
}

struct Waiting {
    stamp: Stamp,
    job: Job,
}

struct Running {
    kind: Kind,
    generation: u64,
    since: Instant,
    cancel: CancelToken,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Pose,
    Study,
    Expected,
    Slice,
}

impl Job {
    fn kind(&self) -> Kind {
        match self {
            Self::Pose(..) => Kind::Pose,
            Self::Study(..) => Kind::Study,
            Self::Expected(..) => Kind::Expected,
            Self::Slice(..) => Kind::Slice,
        }
    }
}

impl Solver {
    /// Starts the thread.
    ///
    /// # Errors
    /// The system's, where it has no thread to give.
    pub fn start() -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            slots: Mutex::default(),
            changed: Condvar::new(),
            waker: OnceLock::new(),
        });
        let (sender, answers) = channel();
        let thread = std::thread::Builder::new().name("solver".into()).spawn({
            let shared = Arc::clone(&shared);
            move || work(&shared, &sender)
        })?;
        Ok(Self { shared, answers: Mutex::new(answers), thread: Some(thread) })
    }

    /// Names whom to wake after each answer; only the first name counts.
    pub fn wake_with(&self, waker: Waker) {
        // A second waker would wake the same loop once more.
        let _ = self.shared.waker.set(waker);
    }

    pub fn has_waker(&self) -> bool {
        self.shared.waker.get().is_some()
    }

    /// Hands a job over; one of its kind that still waits is forgotten.
    pub fn submit(&self, stamp: Stamp, job: Job) {
        let mut slots = self.shared.slots();
        let kind = job.kind();
        if kind == Kind::Study {
            // Another study has other expected figures.
            slots.forget(Kind::Expected);
        }
        if let Some(running) = &slots.running
            && running.kind == kind
            && (running.generation != stamp.generation
                || kind != Kind::Study
                || running.since.elapsed() >= PATIENCE)
        {
            running.cancel.cancel();
        }
        *slots.slot(kind) = Some(Waiting { stamp, job });
        drop(slots);
        self.shared.changed.notify_one();
    }

    /// Forgets the slice that waits and cancels the one that runs.
    pub fn drop_slice(&self) {
        self.shared.slots().forget(Kind::Slice);
    }

    /// Answers since the last call, in the order in which they were found.
    pub fn answers(&self) -> Vec<Answer> {
        let answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        answers.try_iter().collect()
    }

    /// Whether nothing waits and nothing runs.
    pub fn is_idle(&self) -> bool {
        let slots = self.shared.slots();
        slots.pose.is_none()
            && slots.study.is_none()
            && slots.expected.is_none()
            && slots.slice.is_none()
            && slots.running.is_none()
    }
}

impl Drop for Solver {
    fn drop(&mut self) {
        {
            let mut slots = self.shared.slots();
            slots.is_stopped = true;
            if let Some(running) = &slots.running {
                running.cancel.cancel();
            }
        }
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported by the panic hook.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn slots(&self) -> MutexGuard<'_, Slots> {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Slots {
    fn slot(&mut self, kind: Kind) -> &mut Option<Waiting> {
        match kind {
            Kind::Pose => &mut self.pose,
            Kind::Study => &mut self.study,
            Kind::Expected => &mut self.expected,
            Kind::Slice => &mut self.slice,
        }
    }

    /// Forgets the job of a kind that waits and cancels the one that runs.
    fn forget(&mut self, kind: Kind) {
        *self.slot(kind) = None;
        if let Some(running) = &self.running
            && running.kind == kind
        {
            running.cancel.cancel();
        }
    }

    fn take(&mut self) -> Option<Waiting> {
        self.pose
            .take()
            .or_else(|| self.study.take())
            .or_else(|| self.expected.take())
            .or_else(|| self.slice.take())
    }
}

/// A study, and what it is charted from where that is wanted.
fn study(
    scenario: &Scenario,
    wish: &StudyWish,
    cancel: &CancelToken,
) -> Result<(Outcome, Option<Box<ChartedProfile>>), StudyError> {
    if !wish.profile {
        return run(scenario, &wish.mode, cancel, None).map(|outcome| (outcome, None));
    }
    let (outcome, profile) = run_profiled(scenario, &wish.mode, cancel)?;
    let charted = |profile| ChartedProfile::new(profile, scenario.requirement.as_ref());
    Ok((outcome, profile.map(charted).map(Box::new)))
}

fn slice(
    scenario: &Scenario,
    wish: &SliceWish,
    cancel: &CancelToken,
) -> Result<Option<SliceOutcome>, StudyError> {
    let mut sampled = sample_slice(scenario, wish.quantity, &wish.plan, cancel)?;
    if let (Some(slice), true) = (&mut sampled, wish.support) {
        slice.is_supported =
            slice_support(scenario, wish.quantity, &wish.plan, cancel)?.unwrap_or_default();
    }
    Ok(sampled)
}

fn work(shared: &Shared, sender: &Sender<Answer>) {
    loop {
        let (waiting, cancel) = {
            let mut slots = shared.slots();
            slots.running = None;
            loop {
                if slots.is_stopped {
                    return;
                }
                if let Some(waiting) = slots.take() {
                    let cancel = CancelToken::default();
                    slots.running = Some(Running {
                        kind: waiting.job.kind(),
                        generation: waiting.stamp.generation,
                        since: Instant::now(),
                        cancel: cancel.clone(),
                    });
                    break (waiting, cancel);
                }
                slots = shared.changed.wait(slots).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let start = Instant::now();
        let result = match waiting.job {
            Job::Pose(scenario, wish) => Solved::Pose(
                Box::new(look(&scenario)),
                wish.scatter.then(|| Box::new(first_order(&scenario))),
                wish,
            ),
            Job::Study(scenario, wish) => Solved::Study(study(&scenario, &wish, &cancel), wish.of),
            Job::Expected(scenario, mode) => {
                let expected = expected_where_measured(&scenario, &mode, &cancel);
                Solved::Expected(expected.map(|expected| expected.map(Box::new)))
            }
            Job::Slice(scenario, wish) => {
                Solved::Slice(slice(&scenario, &wish, &cancel), wish.quantity)
            }
        };
        let answer = Answer { stamp: waiting.stamp, took: start.elapsed(), result };
        if sender.send(answer).is_err() {
            return;
        }
        if let Some(wake) = shared.waker.get() {
            wake();
        }
    }
}
