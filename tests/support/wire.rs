//! Both ends of a connection to check against: messages read one by one, and events waited for.

#![allow(dead_code, reason = "tests and a bench share it, and each needs a part")]

use std::io::Read;
use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_openigtlink::codec::{Content, Decoded, Decoder, Matrix, Message, Timestamp};

/// How long anything is waited for before a test gives up; nothing depends on how fast it comes.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Events to be waited for.
pub struct Events<T>(Receiver<T>);

/// A sender of events, and the other end.
pub fn events<T>() -> (Sender<T>, Events<T>) {
    let (sender, events) = channel();
    (sender, Events(events))
}

impl<T: std::fmt::Debug> Events<T> {
    /// The next event that was sent and not read yet.
    pub fn try_next(&self) -> Option<T> {
        self.0.try_recv().ok()
    }

    /// The first event that is wanted; everything before it is thrown away.
    #[track_caller]
    pub fn wait_for<R>(&self, what: &str, mut pick: impl FnMut(T) -> Option<R>) -> R {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            match self.0.recv_timeout(left) {
                Ok(event) => {
                    if let Some(wanted) = pick(event) {
                        return wanted;
                    }
                }
                Err(RecvTimeoutError::Timeout) => panic!("waited for {what} in vain"),
                Err(RecvTimeoutError::Disconnected) => panic!("the end came before {what}"),
            }
        }
    }
}

/// Waits, where no event marks the time.
pub fn rest(time: Duration) {
    let (_sender, events) = channel::<()>();
    let _ = events.recv_timeout(time);
}

/// Looks until something holds; panics where it does not in time.
#[track_caller]
pub fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < end, "waited for {what} in vain");
        rest(Duration::from_millis(5));
    }
}

/// A port that nobody serves on now.
pub fn free_address() -> SocketAddr {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap()
}

/// A client that reads message by message.
pub struct Reader {
    pub stream: TcpStream,
    decoder: Decoder,
    kept: Vec<u8>,
}

impl Reader {
    pub fn connect(address: SocketAddr) -> Self {
        Self::of(TcpStream::connect(address).unwrap())
    }

    pub fn of(stream: TcpStream) -> Self {
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        Self { stream, decoder: Decoder::new(1 << 16), kept: Vec::new() }
    }

    /// The next message; `None` once the connection is closed.
    pub fn next(&mut self) -> Option<Message> {
        loop {
            let mut left = self.kept.as_slice();
            let decoded = self.decoder.next(&mut left);
            let taken = self.kept.len() - left.len();
            self.kept.drain(..taken);
            match decoded {
                Some(Ok(Decoded::Message(message))) => return Some(message),
                Some(Ok(Decoded::Skipped { .. })) => continue,
                Some(Err(error)) => panic!("{error}"),
                None => {}
            }
            let mut bytes = [0; 16_384];
            match self.stream.read(&mut bytes) {
                Ok(0) => return None,
                Ok(count) => self.kept.extend_from_slice(&bytes[..count]),
                Err(error)
                    if [std::io::ErrorKind::ConnectionReset, std::io::ErrorKind::BrokenPipe]
                        .contains(&error.kind()) =>
                {
                    return None;
                }
                Err(error) => panic!("{error}"),
            }
        }
    }

    /// The next transform, whatever else comes before it.
    #[track_caller]
    pub fn next_transform(&mut self) -> Message {
        // A status that is repeated every second is no reason to wait for ever.
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            let message = self.next().expect("a transform before the end");
            if matches!(message.content, Content::Transform(_)) {
                return message;
            }
        }
        panic!("waited for a transform in vain");
    }
}

/// A pose that carries its number: its x, exact in single precision below 2²⁴.
pub fn numbered_pose(number: u32) -> Pose {
    pose_from_parts(
        nalgebra::Vector3::new(f64::from(number), 10.0, -250.0),
        nalgebra::UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3),
    )
}

/// A transform that carries its number, stamped now.
pub fn numbered(tool: &str, number: u32) -> Message {
    let matrix = Matrix::from_pose(&numbered_pose(number));
    Message::new(tool, Timestamp::now(), Content::Transform(matrix))
}

pub fn number_of(message: &Message) -> Option<u32> {
    match &message.content {
        Content::Transform(matrix) => Some(matrix.0[9] as u32),
        _ => None,
    }
}
