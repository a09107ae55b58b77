//! Trackers over the network: an OpenIGTLink client that hears a tracker's poses, a relay that
//! compensates each and judges whether it is good, a server that sends the good ones on, and a
//! session that puts them together and records.
//!
//! A [`session::Session`] is what the command line and the editor hold: three threads (client,
//! session, server), events as they happen, and a state to look at whenever a frame is drawn.
//! Nothing here prints, and nothing grows with time: queues, tools, clients and histograms are
//! bounded.

pub mod client;
mod clock;
pub mod codec;
mod keepalive;
pub mod latency;
pub mod relay;
pub mod roles;
pub mod server;
pub mod session;
