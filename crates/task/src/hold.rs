//! Lets long work wait while something else needs the processor more.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Holds work for stated times, where it checks its [`CancelToken`](crate::CancelToken::held_by); shared
/// by clones.
#[derive(Clone, Debug)]
pub struct Hold(Arc<Until>);

#[derive(Debug)]
struct Until {
    start: Instant,
    /// Until when, in ns from the start; 0 where nothing is held.
    ns: AtomicU64,
    /// Held by those that change what is waited for.
    changing: Mutex<()>,
    changed: Condvar,
}

impl Default for Hold {
    fn default() -> Self {
        Self(Arc::new(Until {
            start: Instant::now(),
            ns: AtomicU64::new(0),
            changing: Mutex::new(()),
            changed: Condvar::new(),
        }))
    }
}

impl Hold {
    /// Holds the work for so long from now on, whatever was left of an earlier hold.
    pub fn hold_for(&self, time: Duration) {
        let until = (self.0.start.elapsed() + time).as_nanos();
        let until = u64::try_from(until).unwrap_or(u64::MAX);
        let _changing = self.changing();
        self.0.ns.store(until, Ordering::Relaxed);
        self.0.changed.notify_all();
    }

    /// How much longer the work is held.
    pub fn left(&self) -> Duration {
        // Most checks read this number and no clock.
        match self.0.ns.load(Ordering::Relaxed) {
            0 => Duration::ZERO,
            until => Duration::from_nanos(until).saturating_sub(self.0.start.elapsed()),
        }
    }

    /// Waits while the work is held and not cancelled; [`wake`](Self::wake) follows a cancel.
    pub(crate) fn wait(&self, is_cancelled: impl Fn() -> bool) {
        if self.0.ns.load(Ordering::Relaxed) == 0 {
            return;
        }
        let mut changing = self.changing();
        loop {
            let left = self.left();
            if left.is_zero() {
                self.0.ns.store(0, Ordering::Relaxed);
                return;
            }
            if is_cancelled() {
                return;
            }
            let waited = self.0.changed.wait_timeout(changing, left);
            changing = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Lets those that wait see that they are cancelled.
    pub(crate) fn wake(&self) {
        let _changing = self.changing();
        self.0.changed.notify_all();
    }

    fn changing(&self) -> MutexGuard<'_, ()> {
        self.0.changing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use crate::{CancelToken, Hold};
    use std::time::{Duration, Instant};

    const LONG: Duration = Duration::from_secs(3600);

    #[test]
    fn held_work_waits_until_the_end_of_the_hold() {
        let (hold, own) = (Hold::default(), CancelToken::default());
        let token = own.held_by(&hold);
        assert_eq!((hold.left(), token.is_cancelled()), (Duration::ZERO, false));
        let start = Instant::now();
        hold.hold_for(Duration::from_millis(30));
        assert!(!token.is_cancelled());
        assert!(start.elapsed() >= Duration::from_millis(30));
        assert_eq!(hold.left(), Duration::ZERO);
    }

    #[test]
    fn a_hold_is_replaced_by_a_shorter_one() {
        let (hold, own) = (Hold::default(), CancelToken::default());
        let token = own.held_by(&hold);
        hold.hold_for(LONG);
        assert!(hold.left() > LONG / 2);
        hold.hold_for(Duration::ZERO);
        assert!(!token.is_cancelled());
    }

    #[test]
    fn cancelled_work_is_not_held() {
        let (hold, own) = (Hold::default(), CancelToken::default());
        let token = own.held_by(&hold);
        hold.hold_for(LONG);
        // Who ends the work does not wait for it.
        assert!(!own.is_cancelled());
        let waiting = std::thread::spawn(move || token.is_cancelled());
        own.cancel();
        assert!(waiting.join().unwrap());
    }
}
