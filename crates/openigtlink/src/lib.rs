//! Trackers over the network: an OpenIGTLink client that receives a tracker's poses, a relay that
//! compensates each and judges whether it is good, a server that sends the good ones on, and a
//! session that puts them together and records.
//!
//! A [`session::Session`] is what the command line and the editor hold: three threads (client,
//! session, server), events as they happen, and a state to read whenever a frame is drawn.
//! Nothing here prints, and nothing grows with time: queues, tools, clients and histograms are
//! bounded.
//!
//! ```
//! use trackwright_openigtlink::codec::{Content, Decoded, Decoder, Matrix, Message, Timestamp};
//! use trackwright_geometry::pose::Pose;
//!
//! let pose = Pose::translation(10.0, -20.0, -300.0);
//! let content = Content::Transform(Matrix::from_pose(&pose));
//! let bytes = Message::new("StylusToTracker", Timestamp::now(), content).encode()?;
//!
//! let mut decoder = Decoder::new(1024);
//! let Some(Ok(Decoded::Message(message))) = decoder.next(&mut &bytes[..]) else { panic!() };
//! assert_eq!(message.device, "StylusToTracker");
//! let Content::Transform(matrix) = message.content else { panic!() };
//! assert_eq!(matrix.pose()?.translation, pose.translation);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod client;
mod clock;
pub mod codec;
pub mod latency;
pub mod relay;
pub mod roles;
pub mod server;
pub mod session;
mod thread;
