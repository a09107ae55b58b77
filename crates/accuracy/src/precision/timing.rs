//! How long a piece of work takes: the least of several runs, which other programs disturb least.

use std::time::Instant;

/// How often work is repeated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Runs at least; the first warms up.
    pub min_runs: usize,
    /// Repeated until so much time is spent.
    pub min_seconds: f64,
    /// Not repeated once so much time is spent, however few the runs.
    pub max_seconds: f64,
}

impl Timing {
    /// Each thing once: where only the errors matter.
    pub const ONCE: Self = Self { min_runs: 1, min_seconds: 0.0, max_seconds: 0.0 };

    /// The least time of a run, in seconds, and what the last run gave.
    pub fn measure<T>(&self, mut work: impl FnMut() -> T) -> (f64, T) {
        let mut timed = || {
            let start = Instant::now();
            let result = std::hint::black_box(work());
            (start.elapsed().as_secs_f64(), result)
        };
        let (mut least, mut result) = timed();
        let mut spent = least;
        for run in 1.. {
            let is_enough = run >= self.min_runs && spent >= self.min_seconds;
            if is_enough || spent >= self.max_seconds {
                break;
            }
            let (seconds, next) = timed();
            least = least.min(seconds);
            spent += seconds;
            result = next;
        }
        (least, result)
    }
}

impl Default for Timing {
    /// At 40 measurements of 0.15 s and more the whole takes well below a minute.
    fn default() -> Self {
        Self { min_runs: 3, min_seconds: 0.15, max_seconds: 1.5 }
    }
}
