//! The closing figures of a session.

use super::{LatencySummary, SessionState};
use std::collections::BTreeMap;
use std::time::Duration;
use trackwright_result::{Row, Section, count, data, number, text};

impl SessionState {
    /// What was received, sent and left out while it lasted.
    pub fn section(&self, lasted: Duration) -> Section {
        let counts = &self.counts;
        let dropped = counts.dropped.iter().map(|(reason, found)| {
            let key = format!("dropped.{}", reason.name().to_lowercase());
            Row { label: format!("not sent: {reason}").into(), ..counted(key, "", *found) }.part()
        });
        let shifts_ms: BTreeMap<&String, f64> =
            self.tools.iter().map(|(tool, view)| (tool, 1e3 * view.clock.shift_s)).collect();
        let shifts = shifts_ms.iter().map(|(tool, shift_ms)| {
            let row = number("", format!("clock shift of {tool}"), *shift_ms, 0, "ms");
            row.shown_if(*shift_ms >= 1.0)
        });
        let recording = self.recording.as_ref();
        let samples = recording.map_or(0, |recording| recording.samples);
        let failed = recording.and_then(|recording| recording.failed.as_ref());
        let has_clients = self.serving.is_some();
        Section::of([
            number("seconds", "time", lasted.as_secs_f64(), 1, "s"),
            counted("connections", "connections", self.connections),
            count("", "tools", self.tools.len()),
            data("tools", self.tools.keys().collect::<Vec<_>>()),
            counted("messages", "messages", counts.messages),
            counted("poses", "poses", counts.poses),
            counted("sent", "sent on", counts.sent),
            counted("followed", "of these ambiguous, known by their motion", counts.followed),
            data("dropped", BTreeMap::<String, u64>::new()),
        ])
        .with_all(dropped)
        .with_all([
            counted("went_stale", "tools gone stale", counts.went_stale),
            counted("clock_jumps", "clock jumps", counts.clock_jumps),
            counted("unreadable", "messages that could not be read", self.unreadable),
            counted("skipped", "messages passed over", self.skipped),
            match recording {
                Some(_) => counted("recorded", "samples recorded", samples),
                None => data("recorded", ()),
            },
            match failed {
                Some(why) => text("not_recorded", "none after them:", why).part(),
                None => data("not_recorded", ()),
            },
            counted("slow_clients", "clients dropped as too slow", self.slow_clients)
                .shown_if(has_clients),
            counted("undelivered", "messages too old for a client", self.undelivered)
                .shown_if(has_clients),
            data("clock_shift_ms", &shifts_ms),
        ])
        .with_all(shifts)
        .with_all(times(["latency_ms", "added latency, median"], &self.latency))
        .with_all(times(["age_ms", "age when sent, median"], &self.age))
    }
}

fn counted(key: impl Into<std::borrow::Cow<'static, str>>, label: &'static str, found: u64) -> Row {
    count(key, label, usize::try_from(found).unwrap_or(usize::MAX))
}

fn times([key, median]: [&'static str; 2], times: &LatencySummary) -> Vec<Row> {
    if times.count == 0 {
        return vec![data(key, ())];
    }
    let ms = |end: &str, label, s: f64| number(format!("{key}.{end}"), label, 1e3 * s, 3, "ms");
    vec![
        data(format!("{key}.count"), times.count),
        ms("median", median, times.median_s),
        ms("p99", "99 of 100 below", times.p99_s).part(),
        ms("max", "largest", times.max_s).part(),
    ]
}
