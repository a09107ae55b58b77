//! Listens to a server of OpenIGTLink and comes back to it when it is lost.

use super::codec::{
    Content, DEFAULT_PORT, DecodeError, Decoded, Decoder, Message, StartTracking, Timestamp,
};
use super::thread::EventThread;
use socket2::{SockRef, TcpKeepalive};
use std::io;
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::runtime::Builder;
use tokio::time::{sleep, timeout};

/// The longest message that is kept: tracking data of 3,700 tools.
const MAX_BODY_BYTES: usize = 256 * 1024;

/// Read at once.
const READ_BYTES: usize = 64 * 1024;

const CONNECT_WITHIN: Duration = Duration::from_secs(5);

/// How long a message may take to arrive whole: the longest that is passed over, at 55 Mbit/s. Where a
/// length lies, what follows is taken for the message's body, and nothing is received.
const WHOLE_WITHIN: Duration = Duration::from_secs(5);

/// The options of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClientOptions {
    /// `HOST:PORT`.
    pub server: String,
    /// Requests tracking data at this interval on every connection; many servers send without.
    pub tracking_ms: Option<u32>,
    /// The wait before the first try to come back, doubled with each up to the longest.
    pub first_wait: Duration,
    pub longest_wait: Duration,
}

impl ClientOptions {
    /// Options for a server, with the usual waits.
    pub fn to(server: impl Into<String>) -> Self {
        Self {
            server: server.into(),
            tracking_ms: None,
            first_wait: Duration::from_millis(100),
            longest_wait: Duration::from_secs(5),
        }
    }
}

/// A host and a port, or what was expected.
pub fn server_address(text: &str) -> Result<String, String> {
    let expected =
        || format!("expected HOST:PORT, as localhost:{DEFAULT_PORT} or [::1]:{DEFAULT_PORT}");
    if text.parse::<SocketAddr>().is_ok() {
        return Ok(text.to_owned());
    }
    let (host, port) = text.rsplit_once(':').ok_or_else(expected)?;
    let is_host = !host.is_empty() && !host.contains([':', '/', ' ']);
    match port.parse::<u16>() {
        Ok(1..) if is_host => Ok(text.to_owned()),
        _ => Err(expected()),
    }
}

/// What happens to a client, reported from its thread.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientEvent {
    /// It tries to reach the server.
    Connecting,
    /// The server accepted the connection.
    Connected { server: SocketAddr },
    /// A message of a known type.
    Received { message: Message, arrived: Instant },
    /// Of a type that is not known, or too long to be of use.
    Skipped { kind: String },
    /// A message that is not used; where that ends the stream, `Lost` follows.
    Unreadable(DecodeError),
    /// It is tried again after a wait.
    Lost { why: DisconnectReason, wait: Duration },
}

/// Why there is no connection.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DisconnectReason {
    #[error("no connection: {0}")]
    NotReached(String),
    #[error("no connection within {} s", CONNECT_WITHIN.as_secs())]
    NotInTime,
    #[error("the server closed the connection")]
    Closed,
    #[error("the server closed the connection within a message")]
    Cut,
    #[error("the connection failed: {0}")]
    Failed(String),
    #[error("closed here: what came cannot be read")]
    Unreadable,
    #[error("closed here: a message was not whole after {} s", WHOLE_WITHIN.as_secs())]
    Unfinished,
}

/// A client that runs as long as this is there.
pub struct Client(EventThread);

impl Client {
    /// Connects, and again whenever the connection is lost. While `on_event`, called from the
    /// client's thread, does not return, nothing is read.
    pub fn start(
        options: ClientOptions,
        on_event: impl FnMut(ClientEvent) + Send + 'static,
    ) -> io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_io().enable_time().build()?;
        let listening = Listening { options, on_event, buffer: vec![0; READ_BYTES] };
        let run = move |stopped| async move {
            tokio::select! {
                // Also when the client was dropped.
                _ = stopped => {}
                () = listening.run() => {}
            }
        };
        EventThread::start("live client", runtime, run).map(Self)
    }

    /// Closes the connection; returns once nothing more is reported.
    pub fn stop(mut self) {
        self.0.end();
    }
}

struct Listening<F> {
    options: ClientOptions,
    on_event: F,
    buffer: Vec<u8>,
}

impl<F: FnMut(ClientEvent)> Listening<F> {
    async fn run(mut self) {
        let mut wait = self.options.first_wait;
        loop {
            (self.on_event)(ClientEvent::Connecting);
            let (why, has_received) = self.connection().await;
            // A server that closes every connection at once is not there either.
            if has_received {
                wait = self.options.first_wait;
            }
            (self.on_event)(ClientEvent::Lost { why, wait });
            sleep(wait).await;
            wait = (wait * 2).min(self.options.longest_wait);
        }
    }

    /// One connection from its beginning to its end, and whether a message came of it.
    async fn connection(&mut self) -> (DisconnectReason, bool) {
        let mut has_received = false;
        let why = match timeout(CONNECT_WITHIN, TcpStream::connect(&self.options.server)).await {
            Err(_) => DisconnectReason::NotInTime,
            Ok(Err(error)) => DisconnectReason::NotReached(error.to_string()),
            Ok(Ok(stream)) => self.listen(stream, &mut has_received).await,
        };
        (why, has_received)
    }

    async fn listen(&mut self, mut stream: TcpStream, has_received: &mut bool) -> DisconnectReason {
        let failed = |error: io::Error| DisconnectReason::Failed(error.to_string());
        keep_alive(&stream);
        let server = match stream.peer_addr() {
            Ok(server) => server,
            Err(error) => return failed(error),
        };
        (self.on_event)(ClientEvent::Connected { server });
        if let Some(bytes) = self.request()
            && let Err(error) = stream.write_all(&bytes).await
        {
            return failed(error);
        }
        let mut decoder = Decoder::new(MAX_BODY_BYTES);
        let mut begun: Option<Instant> = None;
        loop {
            // Only part of a message has a time to end.
            let longest =
                begun.map_or(Duration::MAX, |begun| WHOLE_WITHIN.saturating_sub(begun.elapsed()));
            let count = match timeout(longest, stream.read(&mut self.buffer)).await {
                Err(_) => return DisconnectReason::Unfinished,
                Ok(Ok(0)) if decoder.is_between_messages() => return DisconnectReason::Closed,
                Ok(Ok(0)) => return DisconnectReason::Cut,
                Ok(Ok(count)) => count,
                Ok(Err(error)) => return failed(error),
            };
            let now = Instant::now();
            let was_begun = begun.take();
            let mut is_another = false;
            let mut arrived = self.buffer.get(..count).unwrap_or_default();
            while let Some(decoded) = decoder.next(&mut arrived) {
                is_another = true;
                let event = match decoded {
                    Ok(Decoded::Message(message)) => {
                        ClientEvent::Received { message, arrived: now }
                    }
                    Ok(Decoded::Skipped { kind, .. }) => ClientEvent::Skipped { kind },
                    Err(error) if error.ends_the_stream() => {
                        (self.on_event)(ClientEvent::Unreadable(error));
                        return DisconnectReason::Unreadable;
                    }
                    Err(error) => ClientEvent::Unreadable(error),
                };
                *has_received |= matches!(event, ClientEvent::Received { .. });
                (self.on_event)(event);
            }
            if !decoder.is_between_messages() {
                begun = was_begun.filter(|_| !is_another).or(Some(now));
                if begun.is_some_and(|begun| begun.elapsed() > WHOLE_WITHIN) {
                    return DisconnectReason::Unfinished;
                }
            }
        }
    }

    /// The request for tracking data.
    fn request(&self) -> Option<Vec<u8>> {
        let start =
            StartTracking { resolution_ms: self.options.tracking_ms?, frame: String::new() };
        let content = Content::StartTracking(start);
        Message::new("", Timestamp::now(), content).encode().ok()
    }
}

/// Silence after which the system probes the other end.
const PROBE_AFTER: Duration = Duration::from_secs(3);

const PROBE_EVERY: Duration = Duration::from_secs(1);

/// Probes without an answer until the connection is given up, where the system lets that be set.
const PROBES: u32 = 3;

/// Has the system find out when the other end is gone without a word: a pulled cable, a machine without
/// power. Where it cannot, the connection is as good as any.
pub(crate) fn keep_alive(stream: &TcpStream) {
    let keepalive = TcpKeepalive::new().with_time(PROBE_AFTER).with_interval(PROBE_EVERY);
    #[cfg(unix)]
    let keepalive = keepalive.with_retries(PROBES);
    let _ = SockRef::from(stream).set_tcp_keepalive(&keepalive);
}

#[cfg(test)]
mod tests {
    use super::server_address;

    #[test]
    fn a_server_is_a_host_and_a_port() {
        for good in ["localhost:18944", "10.0.0.7:1", "[::1]:18944", "tracker.or-3:65535"] {
            assert_eq!(server_address(good).as_deref(), Ok(good));
        }
        for bad in ["localhost", ":18944", "a:0", "a:65536", "::1:x", "a b:1", "http://a:1", ""] {
            assert!(server_address(bad).is_err(), "{bad}");
        }
    }
}
