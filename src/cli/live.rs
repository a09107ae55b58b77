//! `live`: a tracker's poses received over the network, compensated, recorded and served on.

use super::numbers::above_zero;
use super::prelude::*;
use clap::ArgGroup;
use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use trackwright_field::compensation::Method;
use trackwright_formats::printable::printable;
use trackwright_openigtlink::client::{ClientOptions, server_address};
use trackwright_openigtlink::relay::{ClockChange, Moment, Reason, RelayOptions, ToolState};
use trackwright_openigtlink::server::{LeaveReason, ServerEvent, ServerOptions};
use trackwright_openigtlink::session::{
    LiveDesign, LiveRoom, Session, SessionEvent, SessionSettings,
};

/// Receive a tracker's poses over OpenIGTLink, compensate each, record them and serve them on
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("room").multiple(true)))]
pub struct LiveArgs {
    /// Server that sends the tracker's poses over OpenIGTLink (for example PLUS); it is waited for,
    /// and come back to when it is lost
    #[arg(long, value_name = "HOST:PORT", value_parser = server_address)]
    connect: String,

    /// Room (*.env.ron) that poses are compensated by; without one they are passed on as they are
    #[arg(long, value_name = "ENV", group = "room")]
    environment: Option<PathBuf>,

    /// Design (*.design.ron) whose tool and CRF are among the tools: they are compensated by where
    /// their sensors are instead of as if a sensor were at their origins, in the design's room
    /// unless another one is named
    #[arg(long, value_name = "DESIGN", group = "room")]
    design: Option<PathBuf>,

    /// What happens to positions outside the model's box; rejected ones are not sent on
    #[arg(long, value_parser = OUTSIDE, default_value = "reject", requires = "room")]
    outside: OutsidePolicy,

    /// The tracker's frame, as in StylusToTracker; transforms to other frames are not compensated
    #[arg(long, value_name = "NAME", default_value = RelayOptions::TRACKER_FRAME, requires = "room", value_parser = name)]
    frame: String,

    /// Port to serve the poses on, for 3D Slicer, PLUS or any other client; 18944 is usual, 0 is any
    /// that is free
    #[arg(long, value_name = "PORT")]
    serve: Option<u16>,

    /// Address to serve at: this machine alone can connect unless another one is given, as 0.0.0.0
    #[arg(long, value_name = "ADDR", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST), requires = "serve")]
    bind: IpAddr,

    /// File to record the poses in as they are measured (CSV); one that is there already is an error
    #[arg(long, value_name = "FILE.csv")]
    record: Option<PathBuf>,

    /// Request tracking data from the server (STT_TDATA) at this interval; many send without
    #[arg(long, value_name = "MS")]
    tracking_ms: Option<u32>,

    /// Age from which a pose is never sent as good: how much later than the fastest of its tool it may
    /// arrive, how long it may wait for a client, and how long a tool without a newer one is good
    #[arg(long, visible_alias = "max-latency-ms", value_name = "MS", default_value_t = 1e3 * RelayOptions::STALE_AFTER.as_secs_f64(), value_parser = above_zero)]
    stale_ms: f64,

    /// The tracker's server stamps poses by this machine's clock (it runs here, or both are
    /// synchronised): a delay that is there from the first pose on counts too
    #[arg(long)]
    same_clock: bool,

    /// Take lateness that stays the same for 2 s for a tracker's clock that was set back, and go on by
    /// it; without this such poses are not sent until the connection is made anew
    #[arg(long, conflicts_with = "same_clock")]
    follow_clock: bool,

    /// Header version of the transforms that are served: 2 has metadata with the predicted error, 1 is
    /// for receivers of OpenIGTLink 1 and 2, which cannot read any other
    #[arg(long, value_name = "1|2", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=2), requires = "serve")]
    header_version: u8,

    /// Stop after this time; without it, at Ctrl+C
    #[arg(long, value_name = "S", value_parser = above_zero)]
    seconds: Option<f64>,

    /// How to print the closing figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs until it is stopped, then prints a summary.
///
/// # Errors
/// Files that can't be used, a port that is in use.
pub fn run(args: &LiveArgs, files: &Files) -> anyhow::Result<()> {
    let settings = settings(args, files)?;
    let (stop, stopped) = channel();
    // Before anything runs that should end well.
    ctrlc::set_handler(move || {
        // Once is enough.
        let _ = stop.send(());
    })
    .context("Ctrl+C cannot be listened for")?;
    let started = Instant::now();
    let log = Arc::new(Mutex::new(ClientLog::default()));
    let session = Session::start(settings, {
        let log = log.clone();
        move |event| {
            let words = match event {
                SessionEvent::Server(event) => lock(&log).in_words(event),
                event => in_words(event),
            };
            if let Some(words) = words {
                output::note(&words);
            }
        }
    })?;
    if let Some(address) = session.address() {
        output::note(&format!("serving at {address}{}", warning(address.ip())));
    }
    match args.seconds {
        Some(seconds) => {
            // Both what was waited for and a time that is over end it.
            let longest = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
            let _ = stopped.recv_timeout(longest);
        }
        None => {
            let _ = stopped.recv();
        }
    }
    let state = session.stop();
    lock(&log).unprinted().iter().for_each(|line| output::note(line));
    output::print_section(args.format, &state.section(started.elapsed()))
}

fn settings(args: &LiveArgs, files: &Files) -> anyhow::Result<SessionSettings> {
    let room = room(args, files)?;
    let mut client = ClientOptions::to(&args.connect);
    client.tracking_ms = args.tracking_ms;
    Ok(SessionSettings {
        client,
        relay: RelayOptions {
            stale_after: Duration::try_from_secs_f64(args.stale_ms / 1e3).unwrap_or(Duration::MAX),
            shared_clock: args.same_clock.then(Moment::now),
            follows_clock_steps: args.follow_clock,
            tracker_frame: args.frame.clone(),
        },
        room,
        server: args.serve.map(|port| ServerOptions {
            is_version_one: args.header_version == 1,
            ..ServerOptions::at(SocketAddr::new(args.bind, port))
        }),
        record: args.record.clone(),
    })
}

fn room(args: &LiveArgs, files: &Files) -> anyhow::Result<Option<LiveRoom>> {
    let named = args.environment.as_ref().map(|file| files.read_environment(file)).transpose()?;
    let named = named.map(Arc::new);
    let world = args.design.as_ref().map(|file| files.open_design_without_meshes(file));
    let world = world.transpose()?;
    let Some(environment) = named.or(world.as_ref().map(|world| world.environment.clone())) else {
        return Ok(None);
    };
    let design = world.map(|world| {
        LiveDesign::of(&trackwright_project::resolve(world.document.design(), &environment))
    });
    Ok(Some(LiveRoom {
        method: Method::of(environment.model.map()),
        environment,
        outside: args.outside,
        design,
    }))
}

fn name(text: &str) -> Result<String, String> {
    if text.trim().is_empty() {
        return Err("found an empty name, expected one as Tracker in StylusToTracker".to_owned());
    }
    Ok(text.to_owned())
}

fn warning(address: IpAddr) -> &'static str {
    if address.is_loopback() {
        ", for this machine alone"
    } else {
        ": NOT for this machine alone, whoever reaches this address can read the poses"
    }
}

/// The message of an event; none of single poses.
fn in_words(event: &SessionEvent) -> Option<String> {
    Some(match event {
        SessionEvent::Connecting
        | SessionEvent::Measured { .. }
        | SessionEvent::Pose(_)
        | SessionEvent::Server(_) => return None,
        SessionEvent::Connected { server } => format!("connected to {server}"),
        SessionEvent::Lost { why, wait } => {
            format!("lost: {why}; next try in {:.1} s", wait.as_secs_f64())
        }
        SessionEvent::Unreadable(error) => format!("not used: {error}"),
        SessionEvent::Skipped { kind } => {
            format!("{kind} messages are passed over: no poses of a known kind")
        }
        SessionEvent::TrackerStatus { device, status } => format!(
            "the tracker reports of \"{}\": {} {} (code {})",
            printable(device),
            printable(&status.name),
            printable(&status.text),
            status.code.0
        ),
        SessionEvent::Tool { tool, state } => match state {
            ToolState::Good => format!("{}: good", printable(tool)),
            ToolState::NotGood(Reason::SessionEnds) => return None,
            ToolState::NotGood(reason) => format!("{}: not good, {reason}", printable(tool)),
        },
        SessionEvent::Clock { tool, change } => {
            format!("warning: {}: {}", printable(tool), clock_in_words(*change))
        }
        SessionEvent::Refused { tool, reason } => {
            format!("warning: samples of \"{}\" are not used: {reason}", printable(tool))
        }
        SessionEvent::NotRecorded { why } => format!("nothing more is recorded: {why}"),
    })
}

fn clock_in_words(change: ClockChange) -> String {
    match change {
        ClockChange::Step { by_s } if by_s > 0.0 => format!(
            "its clock was set back by {by_s:.3} s, or its poses are as much older from now on: \
             which of the two is undetermined"
        ),
        ClockChange::Step { by_s } => format!(
            "its clock was set ahead by {:.3} s, or its poses were as much older until now",
            -by_s
        ),
        ClockChange::Drift { shift_s } => format!(
            "its clock has drifted by {:.0} ms against this machine's, or its poses have become as \
             much older as slowly: which of the two is undetermined",
            1e3 * shift_s
        ),
        ClockChange::Late { by_s } => format!(
            "its samples come {by_s:.3} s later than the fastest did, and are not sent: they are held \
             up, or its clock was set back, in which case this session has to be started anew \
             (or with --follow-clock)"
        ),
        ClockChange::Early { by_s } => format!(
            "its timestamps are {by_s:.3} s ahead of those before, and its samples are not sent"
        ),
    }
}

/// Problems of the clients of one address that are printed, with all else about them.
const PRINTED_PROBLEMS: u64 = 5;

/// Addresses that are counted each; those beyond are counted together.
const MOST_ADDRESSES: usize = 64;

/// What is printed of the server's clients: one that sends rubbish again and again does not fill the log.
#[derive(Default)]
struct ClientLog {
    /// Problems, and lines that were not printed, by address.
    counts: BTreeMap<Option<IpAddr>, [u64; 2]>,
}

impl ClientLog {
    /// The message of an event, where it is printed: after some problems of an address only their number, and
    /// that more and more seldom.
    fn in_words(&mut self, event: &ServerEvent) -> Option<String> {
        let words = served_in_words(event);
        let (client, is_problem) = match event {
            ServerEvent::NotAccepted { .. } => return Some(words),
            ServerEvent::Left { client, why, .. } => {
                (client, !matches!(why, LeaveReason::Closed | LeaveReason::Stopped))
            }
            ServerEvent::Refused { client, .. } | ServerEvent::FellBehind { client } => {
                (client, true)
            }
            ServerEvent::Joined { client, .. } | ServerEvent::CaughtUp { client, .. } => {
                (client, false)
            }
        };
        let address = Some(client.ip());
        let is_known = self.counts.len() < MOST_ADDRESSES || self.counts.contains_key(&address);
        let address = address.filter(|_| is_known);
        let [problems, unprinted] = self.counts.entry(address).or_default();
        *problems += u64::from(is_problem);
        if *problems <= PRINTED_PROBLEMS {
            return Some(words);
        }
        *unprinted += 1;
        let is_milestone = is_problem && problems.is_power_of_two();
        is_milestone.then(|| format!("{}: {problems} problems so far", clients_of(address)))
    }

    /// What of each address was not printed.
    fn unprinted(&self) -> Vec<String> {
        let counts = self.counts.iter().filter(|(_, [_, unprinted])| *unprinted > 0);
        let line = |(address, [problems, unprinted]): (&Option<IpAddr>, &[u64; 2])| {
            let clients = clients_of(*address);
            format!("{clients}: {problems} problems, {unprinted} messages about them not printed")
        };
        counts.map(line).collect()
    }
}

fn clients_of(address: Option<IpAddr>) -> String {
    address.map_or("clients of other addresses".to_owned(), |ip| format!("clients of {ip}"))
}

fn lock(log: &Mutex<ClientLog>) -> MutexGuard<'_, ClientLog> {
    log.lock().unwrap_or_else(PoisonError::into_inner)
}

fn served_in_words(event: &ServerEvent) -> String {
    match event {
        ServerEvent::Joined { client, clients } => format!("client {client} joined, {clients} now"),
        ServerEvent::Left { client, why, clients } => {
            format!("client {client} left, {clients} now: {why}")
        }
        ServerEvent::Refused { client, why } => format!("client {client} refused: {why}"),
        ServerEvent::FellBehind { client } => format!(
            "warning: client {client} does not read as fast as poses come: it does not get those \
             that have become too old"
        ),
        ServerEvent::CaughtUp { client, dropped } => {
            format!("client {client} reads again: it did not get {dropped} messages")
        }
        ServerEvent::NotAccepted { why } => format!("a client cannot be accepted: {why}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rubbish_of_a_client_does_not_fill_the_log() {
        let mut log = ClientLog::default();
        let (mut bad, mut good) = (0, 0);
        for round in 0..10_000 {
            let client = SocketAddr::from(([10, 0, 0, 1], 1024 + round));
            let why = LeaveReason::TooSlow;
            let left = ServerEvent::Left { client, why, clients: 0 };
            bad += [ServerEvent::Joined { client, clients: 1 }, left]
                .iter()
                .filter_map(|event| log.in_words(event))
                .count();
            let client = SocketAddr::from(([10, 0, 0, 2], 1024 + round));
            let left = ServerEvent::Left { client, why: LeaveReason::Closed, clients: 0 };
            good += log.in_words(&left).iter().count();
        }
        // Five that join and leave, the sixth that joins, then one line each doubling from 8 to 8,192.
        assert_eq!((bad, good), (22, 10_000));
        let expected = "clients of 10.0.0.1: 10000 problems, 19989 messages about them not printed";
        assert_eq!(log.unprinted(), [expected]);
        for other in 0..1000_u32 {
            let client = SocketAddr::from((Ipv4Addr::from(other), 1));
            log.in_words(&ServerEvent::FellBehind { client });
        }
        assert!(log.counts.len() <= MOST_ADDRESSES + 1);
    }
}
