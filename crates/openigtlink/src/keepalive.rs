//! Finds connections whose other end is gone without a word: a pulled cable, a machine without power.

use socket2::{SockRef, TcpKeepalive};
use std::time::Duration;
use tokio::net::TcpStream;

/// Silence after which the system asks whether the other end is there.
const ASK_AFTER: Duration = Duration::from_secs(3);

const ASK_EVERY: Duration = Duration::from_secs(1);

/// Questions without an answer until the connection is given up, where the system lets that be set.
const QUESTIONS: u32 = 3;

/// Has the system look after a connection. Where it cannot, the connection is as good as any.
pub fn set(stream: &TcpStream) {
    let keepalive = TcpKeepalive::new().with_time(ASK_AFTER).with_interval(ASK_EVERY);
    #[cfg(unix)]
    let keepalive = keepalive.with_retries(QUESTIONS);
    let _ = SockRef::from(stream).set_tcp_keepalive(&keepalive);
}
