//! Where samples were taken: counted in the session's thread as they come, looked at once a frame.

use nalgebra::{Point3, Vector3};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use trackwright_calibration::coverage::{Cell, Coverage, CoveragePlan, CoverageSummary};
use trackwright_design::BodyRole;
use trackwright_openigtlink::session::SessionEvent;

/// Counts while something is recorded; shared by the session's thread and the frame.
#[derive(Clone, Debug, Default)]
pub struct Collector(Arc<Mutex<Counting>>);

#[derive(Debug, Default)]
struct Counting {
    coverage: Option<Coverage>,
    is_on: bool,
    /// Why a recording ended that nobody ended, until it is taken.
    failed: Option<String>,
    /// Tools that are the CRF, which stands while the others are waved about.
    crfs: BTreeSet<String>,
}

/// What was collected, as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Collected {
    pub plan: CoveragePlan,
    pub summary: CoverageSummary,
    /// Where to go next.
    pub next_mm: Option<Point3<f64>>,
    pub cells: Vec<Cell>,
    pub cell_mm: Vector3<f64>,
}

impl Collector {
    /// Takes what happened in a session.
    pub fn receive(&self, event: &SessionEvent) {
        match event {
            SessionEvent::Pose(sent) if sent.role == Some(BodyRole::Crf) => {
                let mut counting = self.lock();
                if !counting.crfs.contains(&sent.tool) {
                    counting.crfs.insert(sent.tool.clone());
                }
            }
            SessionEvent::Pose(sent) => {
                self.lock().crfs.remove(&sent.tool);
            }
            SessionEvent::Measured { tool, pose } => {
                let mut counting = self.lock();
                if counting.is_on
                    && !counting.crfs.contains(tool)
                    && let Some(coverage) = &mut counting.coverage
                {
                    coverage.add(pose);
                }
            }
            SessionEvent::NotRecorded { why } => {
                let mut counting = self.lock();
                counting.is_on = false;
                counting.failed = Some(why.clone());
            }
            _ => {}
        }
    }

    /// Why a recording ended by itself, once.
    pub fn take_failure(&self) -> Option<String> {
        self.lock().failed.take()
    }

    /// Counts from now on; on from where it was, where the plan is the same.
    pub fn begin(&self, plan: CoveragePlan) {
        let mut counting = self.lock();
        counting.is_on = true;
        let is_same = (counting.coverage.as_ref()).is_some_and(|c| *c.plan() == plan);
        if !is_same {
            counting.coverage = Some(Coverage::new(plan));
        }
    }

    pub fn pause(&self) {
        self.lock().is_on = false;
    }

    /// Forgets what was counted; goes on counting where it did.
    pub fn start_over(&self) {
        let mut counting = self.lock();
        let plan = counting.coverage.as_ref().map(|coverage| *coverage.plan());
        counting.coverage = plan.filter(|_| counting.is_on).map(Coverage::new);
    }

    /// What there is, where it is other than what is shown.
    pub fn newer_than(&self, shown: Option<&Collected>) -> Option<Option<Collected>> {
        let counting = self.lock();
        let Some(coverage) = &counting.coverage else {
            return shown.is_some().then_some(None);
        };
        let summary = coverage.summary();
        match shown {
            Some(shown) if shown.summary == summary && shown.plan == *coverage.plan() => None,
            // Samples that are alike change counts only.
            Some(shown)
                if shown.plan == *coverage.plan() && shown.summary.distinct == summary.distinct =>
            {
                Some(Some(Collected { summary, ..shown.clone() }))
            }
            _ => Some(Some(Collected {
                plan: *coverage.plan(),
                summary,
                next_mm: coverage.next_mm(),
                cells: coverage.cells().collect(),
                cell_mm: coverage.cell_mm(),
            })),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Counting> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
