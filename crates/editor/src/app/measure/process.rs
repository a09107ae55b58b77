//! When the process began, and the processor time it has used.

use std::time::{Duration, Instant};

/// Linux counts a process's times in hundredths of a second, whatever the kernel's own clock.
const TICKS_A_SECOND: u64 = 100;

/// Fields of `/proc/self/stat` behind the program's name, which may hold anything itself.
const USER_TICKS: usize = 11;
const SYSTEM_TICKS: usize = 12;
const START_TICKS: usize = 19;

/// When the process began.
#[derive(Clone, Copy, Debug)]
pub struct Started(Instant);

impl Started {
    /// As the system has it, to 10 ms; now where it does not report it.
    pub fn of_process() -> Self {
        let now = Instant::now();
        Self(age().and_then(|age| now.checked_sub(age)).unwrap_or(now))
    }

    pub fn until(self, then: Instant) -> Duration {
        then.saturating_duration_since(self.0)
    }
}

/// Processor time of all threads; `None` where the system does not report it.
pub fn processor_time() -> Option<Duration> {
    let stat = stat()?;
    ticks(&stat, USER_TICKS)?.checked_add(ticks(&stat, SYSTEM_TICKS)?)
}

fn age() -> Option<Duration> {
    let uptime = std::fs::read_to_string("/proc/uptime").ok()?;
    let uptime: f64 = uptime.split_whitespace().next()?.parse().ok()?;
    Duration::try_from_secs_f64(uptime).ok()?.checked_sub(ticks(&stat()?, START_TICKS)?)
}

fn stat() -> Option<String> {
    std::fs::read_to_string("/proc/self/stat").ok()
}

fn ticks(stat: &str, field: usize) -> Option<Duration> {
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks: u64 = fields.split_whitespace().nth(field)?.parse().ok()?;
    Some(Duration::from_millis(ticks * 1000 / TICKS_A_SECOND))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_spaces_and_brackets_shifts_no_field() {
        let stat = "7 (a) b (c) S 1 7 7 0 -1 0 0 0 0 0 150 25 0 0 20 0 9 0 4200 0";
        assert_eq!(ticks(stat, USER_TICKS), Some(Duration::from_millis(1500)));
        assert_eq!(ticks(stat, SYSTEM_TICKS), Some(Duration::from_millis(250)));
        assert_eq!(ticks(stat, START_TICKS), Some(Duration::from_secs(42)));
        assert_eq!(ticks("7 (a)", USER_TICKS), None);
    }
}
