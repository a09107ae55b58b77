//! The samples of tools in a message, whatever its type.

use super::counts::Reason;
use crate::codec::{Content, Matrix, Message, NotAPose, Orientation, ToolKind};
use trackwright_geometry::pose::Pose;

/// Keys under which senders state whether they stand by a transform; `OK` where they do.
const STATUS_KEYS: [&str; 2] = ["TransformStatus", "Status"];

/// One tool in a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Incoming {
    pub tool: String,
    pub kind: ToolKind,
    pub pose: Result<Pose, Refusal>,
    /// The matrix as it came, where it came as one.
    pub matrix: Option<Matrix>,
}

/// Why there is no pose, and the sender's word for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    pub reason: Reason,
    pub word: String,
}

impl From<NotAPose> for Refusal {
    fn from(problem: NotAPose) -> Self {
        Self {
            reason: match problem {
                NotAPose::NoOrientation => Reason::NoOrientation,
                _ => Reason::NoPose,
            },
            word: problem.to_string(),
        }
    }
}

/// All tools of a message; of one that has none, nothing.
pub fn incoming(message: &Message) -> Vec<Incoming> {
    let device = || message.device.clone();
    let mut samples = match &message.content {
        Content::Transform(matrix) => vec![of_matrix(device(), ToolKind::SixDof, *matrix)],
        Content::Position(position) => vec![Incoming {
            tool: device(),
            kind: ToolKind::SixDof,
            pose: position.pose().map_err(Refusal::from),
            matrix: None,
        }],
        Content::Tracking(elements) => elements
            .iter()
            .map(|element| of_matrix(element.name.clone(), element.kind, element.matrix))
            .collect(),
        Content::QuaternionTracking(elements) => elements
            .iter()
            .map(|element| {
                let orientation = match element.kind {
                    ToolKind::ThreeDof => Orientation::None,
                    _ => Orientation::Full(element.quaternion),
                };
                Incoming {
                    tool: element.name.clone(),
                    kind: element.kind,
                    pose: orientation.pose(element.at_mm).map_err(Refusal::from),
                    matrix: None,
                }
            })
            .collect(),
        _ => Vec::new(),
    };
    if let Some(word) = objection(message) {
        for sample in &mut samples {
            sample.pose = Err(Refusal { reason: Reason::NotTracked, word: word.to_owned() });
        }
    }
    samples
}

fn of_matrix(tool: String, kind: ToolKind, matrix: Matrix) -> Incoming {
    let pose = match kind {
        ToolKind::ThreeDof => Err(NotAPose::NoOrientation),
        _ => matrix.pose(),
    };
    Incoming { tool, kind, pose: pose.map_err(Refusal::from), matrix: Some(matrix) }
}

/// The sender's word for a transform that it does not stand by.
fn objection(message: &Message) -> Option<&str> {
    let extension = message.extension.as_ref()?;
    STATUS_KEYS
        .iter()
        .filter_map(|key| extension.get(key))
        .find(|word| !word.eq_ignore_ascii_case("OK"))
}
