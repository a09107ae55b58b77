//! OpenIGTLink messages: bytes to send, and what arrived bytes are.

use crate::arrays::{pose, pose_array};
use crate::errors::{Done, TrackwrightError};
use crate::pose_tables::pose_rows;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use trackwright_geometry::pose::Pose;
use trackwright_openigtlink::codec::{
    Content, Decoded, Decoder, Matrix, Message, NotAPose, Orientation, Status, StatusCode,
    Timestamp, ToolKind, TrackingElement,
};

/// Longest body that is kept: a thousand tools are less.
const MAX_BODY_BYTES: usize = 1 << 20;

/// A message that arrived.
#[pyclass(frozen, get_all, module = "trackwright")]
pub struct IgtlMessage {
    kind: String,
    device: String,
    timestamp_s: Option<f64>,
    poses: Py<PyDict>,
    text: Option<String>,
    code: Option<i64>,
    problem: Option<String>,
}

/// Takes bytes as they arrive, and gives messages as they are whole.
#[pyclass(frozen, module = "trackwright")]
pub struct IgtlDecoder(Mutex<Decoder>);

fn timestamp(seconds: Option<f64>) -> Done<Timestamp> {
    match seconds.map(Duration::try_from_secs_f64) {
        None => Ok(Timestamp::now()),
        Some(Ok(since_epoch)) => Ok(Timestamp::from_unix(since_epoch)),
        Some(Err(problem)) => {
            Err(TrackwrightError::new_err(format!("timestamp_s: {problem}")).into())
        }
    }
}

fn encoded<'py>(
    py: Python<'py>,
    device: &str,
    timestamp_s: Option<f64>,
    content: Content,
) -> Done<Bound<'py, PyBytes>> {
    let message = Message::new(device, timestamp(timestamp_s)?, content);
    Ok(PyBytes::new(py, &message.encode()?))
}

/// A TRANSFORM message: a tool's pose, shape (7,), mm. Its time is now where timestamp_s (seconds since
/// 1970) is None.
#[pyfunction]
#[pyo3(signature = (device, pose, *, timestamp_s = None))]
pub fn encode_transform<'py>(
    py: Python<'py>,
    device: &str,
    pose: &Bound<'_, PyAny>,
    timestamp_s: Option<f64>,
) -> Done<Bound<'py, PyBytes>> {
    let pose = self::pose(pose, "pose")?;
    encoded(py, device, timestamp_s, Content::Transform(Matrix::from_pose(&pose)))
}

/// A TDATA message: poses of tools, shape (n, 7), mm, by their names.
#[pyfunction]
#[pyo3(signature = (device, names, poses, *, timestamp_s = None))]
pub fn encode_tracking<'py>(
    py: Python<'py>,
    device: &str,
    names: Vec<String>,
    poses: &Bound<'_, PyAny>,
    timestamp_s: Option<f64>,
) -> Done<Bound<'py, PyBytes>> {
    let poses = pose_rows(poses, "poses")?;
    if names.len() != poses.len() {
        let text =
            format!("names: found {}, expected one for each of {} poses", names.len(), poses.len());
        return Err(TrackwrightError::new_err(text).into());
    }
    let elements = names.into_iter().zip(&poses).map(|(name, pose)| TrackingElement {
        name,
        kind: ToolKind::SixDof,
        matrix: Matrix::from_pose(pose),
    });
    encoded(py, device, timestamp_s, Content::Tracking(elements.collect()))
}

/// A STATUS message; code 1 is that all is well.
#[pyfunction]
#[pyo3(signature = (device, text = "", *, code = 1, timestamp_s = None))]
pub fn encode_status<'py>(
    py: Python<'py>,
    device: &str,
    text: &str,
    code: u16,
    timestamp_s: Option<f64>,
) -> Done<Bound<'py, PyBytes>> {
    let status = Status { code: StatusCode(code), ..Status::ok(text) };
    encoded(py, device, timestamp_s, Content::Status(status))
}

#[pymethods]
impl IgtlDecoder {
    #[new]
    fn new() -> Self {
        Self(Mutex::new(Decoder::new(MAX_BODY_BYTES)))
    }

    /// Takes bytes as they arrive, in pieces of any size, and returns the messages that are whole.
    ///
    /// A message that cannot be used has a `problem`. Raises TrackwrightError where no message can be found any more.
    fn feed(&self, py: Python<'_>, bytes: &[u8]) -> Done<Vec<IgtlMessage>> {
        let mut decoder = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut arrived = bytes;
        let mut messages = Vec::new();
        while let Some(found) = decoder.next(&mut arrived) {
            messages.push(match found {
                Ok(Decoded::Message(message)) => IgtlMessage::of(py, message)?,
                Ok(Decoded::Skipped { kind, device, body_bytes }) => IgtlMessage {
                    kind,
                    device,
                    problem: Some(format!("{body_bytes} bytes of a kind that is not read")),
                    ..IgtlMessage::empty(py)
                },
                Err(problem) if problem.ends_the_stream() => return Err(problem.into()),
                Err(problem) => {
                    IgtlMessage { problem: Some(problem.to_string()), ..IgtlMessage::empty(py) }
                }
            });
        }
        Ok(messages)
    }
}

impl IgtlMessage {
    fn empty(py: Python<'_>) -> Self {
        Self {
            kind: String::new(),
            device: String::new(),
            timestamp_s: None,
            poses: PyDict::new(py).unbind(),
            text: None,
            code: None,
            problem: None,
        }
    }

    fn of(py: Python<'_>, message: Message) -> Done<Self> {
        let device = message.device;
        let mut text = None;
        let mut code = None;
        let one = |pose: Result<Pose, NotAPose>| vec![(device.clone(), pose)];
        let kind = message.content.kind().to_owned();
        let poses: Vec<(String, Result<Pose, NotAPose>)> = match message.content {
            Content::Transform(matrix) => one(matrix.pose()),
            Content::Position(position) => one(position.pose()),
            Content::Tracking(elements) => {
                elements.into_iter().map(|tool| (tool.name, tool.matrix.pose())).collect()
            }
            Content::QuaternionTracking(elements) => elements
                .into_iter()
                .map(|tool| {
                    let pose = Orientation::Full(tool.quaternion).pose(tool.at_mm);
                    (tool.name, pose)
                })
                .collect(),
            Content::Status(status) => {
                code = Some(i64::from(status.code.0));
                text = Some(status.text);
                Vec::new()
            }
            Content::Text(found) => {
                text = Some(String::from_utf8_lossy(&found.bytes).into_owned());
                Vec::new()
            }
            _ => Vec::new(),
        };
        let found = PyDict::new(py);
        let mut problem = None;
        for (name, pose) in poses {
            match pose {
                Ok(pose) => {
                    let row: Bound<'_, PyArray1<f64>> = pose_array(py, &pose);
                    found.set_item(name, row)?;
                }
                Err(why) => problem = Some(format!("{name}: {why}")),
            }
        }
        Ok(Self {
            kind,
            timestamp_s: message.timestamp.is_stated().then(|| message.timestamp.seconds()),
            poses: found.unbind(),
            text,
            code,
            problem,
            device,
        })
    }
}
