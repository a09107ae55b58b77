//! Where the tools are now, for clients that ask instead of listening.

use super::outbox::{Encoded, PoseTimes};
use crate::codec::{
    Content, Matrix, Message, QuaternionElement, Timestamp, ToolKind, TrackingElement,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;
use trackwright_geometry::pose::quaternion_to_array;

/// The name of the device that tracking data come from.
pub const DEVICE: &str = "trackwright";

/// The tools that are good, each with what was last sent of it.
#[derive(Default)]
pub struct Served {
    tools: BTreeMap<String, ServedTool>,
    /// Goes up with every pose that came.
    pub revision: u64,
}

struct ServedTool {
    kind: ToolKind,
    matrix: Matrix,
    timestamp: Timestamp,
    encoded: Arc<Encoded>,
    times: PoseTimes,
}

impl Served {
    pub fn set(
        &mut self,
        message: &Message,
        kind: ToolKind,
        encoded: &Arc<Encoded>,
        times: PoseTimes,
    ) {
        let Content::Transform(matrix) = &message.content else {
            return;
        };
        self.revision += 1;
        let tool = ServedTool {
            kind,
            matrix: *matrix,
            timestamp: message.timestamp,
            encoded: Arc::clone(encoded),
            times,
        };
        self.tools.insert(message.device.clone(), tool);
    }

    pub fn remove(&mut self, tool: &str) {
        self.tools.remove(tool);
    }

    /// The last transform of a tool, of all tools where none is named; none that is too old.
    pub fn transforms(&self, name: &str, now: Instant) -> Vec<Arc<Encoded>> {
        self.fresh(now)
            .filter(|(tool, _)| name.is_empty() || name == tool.as_str())
            .map(|(_, tool)| Arc::clone(&tool.encoded))
            .collect()
    }

    fn fresh(&self, now: Instant) -> impl Iterator<Item = (&String, &ServedTool)> {
        (self.tools.iter()).filter(move |(_, tool)| !tool.times.is_too_old(now))
    }

    /// All tools in one message; `None` where there is none.
    pub fn tracking(&self, has_quaternions: bool, now: Instant) -> Option<Message> {
        let newest = self.fresh(now).map(|(_, tool)| tool.timestamp).max()?;
        let content = match has_quaternions {
            false => Content::Tracking(
                self.fresh(now)
                    .map(|(name, tool)| TrackingElement {
                        name: name.clone(),
                        kind: tool.kind,
                        matrix: tool.matrix,
                    })
                    .collect(),
            ),
            true => Content::QuaternionTracking(
                self.fresh(now).filter_map(|(name, tool)| quaternion_element(name, tool)).collect(),
            ),
        };
        Some(Message::new(DEVICE, newest, content))
    }
}

fn quaternion_element(name: &str, tool: &ServedTool) -> Option<QuaternionElement> {
    let pose = tool.matrix.pose().ok()?;
    let [w, x, y, z] = quaternion_to_array(&pose.rotation).map(|v| v as f32);
    let [.., at_x, at_y, at_z] = tool.matrix.0;
    Some(QuaternionElement {
        name: name.to_owned(),
        kind: tool.kind,
        at_mm: [at_x, at_y, at_z],
        quaternion: [x, y, z, w],
    })
}
