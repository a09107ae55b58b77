//! What `trackwright live` adds, loses and keeps under load: `cargo bench --no-default-features
//! --bench live -- SECONDS [ENVIRONMENT | DESIGN]`. Two of the tools are called like the bodies of the
//! built-in design.
//!
//! A tracker of eight tools at 40 Hz and sixteen clients in this process, the program as a person
//! runs it in between; a client is killed and the tracker's server restarted on the way.

#[path = "../tests/support/live_load.rs"]
mod live_load;
#[path = "../tests/support/wire.rs"]
mod wire;

use live_load::{Gap, Load, Outcome, run, tracker};
use std::io::{self, BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

fn main() -> io::Result<()> {
    // What `cargo bench` itself adds begins with a dash.
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let load = Load {
        tools: 8,
        rate_hz: 40,
        clients: 16,
        seconds: arguments.first().and_then(|s| s.parse().ok()).unwrap_or(30),
    };
    let server = tracker(([127, 0, 0, 1], 0).into());
    let mut program = Command::new(env!("CARGO_BIN_EXE_trackwright"));
    program.args(["live", "--serve", "0", "--format", "json", "--connect"]);
    program.arg(server.address().to_string());
    if let Some(file) = arguments.get(1) {
        let is_design = file.ends_with(".design.ron");
        program.arg(if is_design { "--design" } else { "--environment" });
        program.arg(file);
    }
    let mut child = program.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let notes = notes(&mut child)?;
    let serving = until(&notes, "serving at")?;
    let relay_at = serving
        .split([' ', ','])
        .nth(2)
        .and_then(|address| address.parse().ok())
        .ok_or_else(|| io::Error::other(serving.clone()))?;
    until(&notes, "connected to")?;
    let all = format!("joined, {} now", load.clients);
    let outcome = run(
        load,
        server,
        relay_at,
        || {
            // A client less would be seen in its counts.
            let _ = until(&notes, &all);
        },
        || resident_kb(child.id()),
    );
    let id = child.id().to_string();
    Command::new("kill").args(["-INT", &id]).status()?;
    let mut closing = String::new();
    if let Some(mut stdout) = child.stdout.take() {
        stdout.read_to_string(&mut closing)?;
    }
    child.wait()?;
    print(&load, &outcome, &closing);
    Ok(())
}

fn notes(child: &mut Child) -> io::Result<Receiver<String>> {
    let stderr = child.stderr.take();
    let stderr = stderr.ok_or_else(|| io::Error::other("no standard error"))?;
    let (sender, notes) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stderr).lines().map_while(Result::ok) {
            // Read to its end, so that the program is never held up.
            let _ = sender.send(line);
        }
    });
    Ok(notes)
}

fn until(notes: &Receiver<String>, text: &str) -> io::Result<String> {
    loop {
        let note = notes
            .recv_timeout(Duration::from_secs(20))
            .map_err(|_| io::Error::other(format!("the program never printed {text:?}")))?;
        if note.contains(text) {
            return Ok(note);
        }
    }
}

/// `VmRSS` of a process, in kB; 0 where the system does not report it.
fn resident_kb(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

#[expect(clippy::print_stdout, reason = "the figures are what it is run for")]
fn print(load: &Load, outcome: &Outcome, closing: &str) {
    let all = u64::from(load.tools * outcome.frames);
    let missing = |gaps: &[Gap]| -> u32 { gaps.iter().map(|gap| gap.last - gap.first + 1).sum() };
    println!("{load:?}; no client received frames {:?}", outcome.away);
    for (client, received) in outcome.received.iter().enumerate() {
        let away = outcome.away;
        let outside = received
            .gaps
            .iter()
            .filter(|gap| gap.first < away.first || gap.last > away.last)
            .count();
        println!(
            "client {client}: {} of {all}, {} missing ({outside} gaps while the server was there), {} old, {} not good; from the tracker {:.3} ms median, {:.3} ms p99, {:.3} ms max",
            received.transforms,
            missing(&received.gaps),
            received.old,
            received.not_good,
            1e3 * received.latency.median_s,
            1e3 * received.latency.p99_s,
            1e3 * received.latency.max_s,
        );
    }
    for (second, kb) in &outcome.memory {
        println!("after {second} s: {kb} kB resident");
    }
    println!("{closing}");
}
