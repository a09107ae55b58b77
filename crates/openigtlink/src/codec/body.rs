//! The contents of messages that a tracker sends and that are requested of it.

use super::header::{EncodeError, NAME_BYTES, Reader, counted, put_floats, put_text, text_of};
use super::poses::{Matrix, NotAPose, Orientation, ToolKind};
use trackwright_geometry::pose::Pose;

/// The content of a message of a known type.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    Transform(Matrix),
    Position(Position),
    Tracking(Vec<TrackingElement>),
    QuaternionTracking(Vec<QuaternionElement>),
    Status(Status),
    Text(Text),
    Points(Vec<Point>),
    StartTracking(StartTracking),
    StartQuaternionTracking(StartTracking),
    StopTracking,
    StopQuaternionTracking,
    /// The answer to a start or a stop: 0 where it was done.
    TrackingReply(i8),
    QuaternionTrackingReply(i8),
    GetTransform,
    GetStatus,
}

/// A place in mm and an orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    pub at_mm: [f32; 3],
    pub orientation: Orientation,
}

impl Position {
    /// Place and orientation as a pose.
    pub fn pose(&self) -> Result<Pose, NotAPose> {
        self.orientation.pose(self.at_mm)
    }
}

/// One tool of many in a message.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingElement {
    /// Empty where the sender's was no text.
    pub name: String,
    pub kind: ToolKind,
    pub matrix: Matrix,
}

/// The same with a quaternion: x, y, z, w.
#[derive(Clone, Debug, PartialEq)]
pub struct QuaternionElement {
    pub name: String,
    pub kind: ToolKind,
    pub at_mm: [f32; 3],
    pub quaternion: [f32; 4],
}

/// The codes of the protocol that are used here; any other number is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusCode(pub u16);

impl StatusCode {
    pub const OK: Self = Self(1);
    pub const NOT_FOUND: Self = Self(4);
    pub const TIME_OUT: Self = Self(7);
    pub const RESOURCE_ERROR: Self = Self(11);
    pub const NOT_READY: Self = Self(13);
    pub const NOT_PRESENT: Self = Self(16);
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    pub code: StatusCode,
    /// Of the device's own making.
    pub subcode: i64,
    /// 20 bytes at most.
    pub name: String,
    pub text: String,
}

impl Status {
    /// A device that works.
    pub fn ok(text: impl Into<String>) -> Self {
        Self { code: StatusCode::OK, subcode: 0, name: String::new(), text: text.into() }
    }

    /// A device with a problem.
    pub fn problem(code: StatusCode, name: &str, text: impl Into<String>) -> Self {
        Self { code, subcode: 0, name: name.to_owned(), text: text.into() }
    }
}

/// A text in the character set of a number in IANA's list; 3 is US-ASCII.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    pub encoding: u16,
    pub bytes: Vec<u8>,
}

/// A request for tracking data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartTracking {
    /// The shortest time between two messages.
    pub resolution_ms: u32,
    /// The frame that they should be in; empty for the tracker's own.
    pub frame: String,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    pub name: String,
    pub group: String,
    pub rgba: [u8; 4],
    pub at_mm: [f32; 3],
    pub radius_mm: f32,
    pub owner: String,
}

/// What is wrong with a body whose checksum is right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BodyError {
    #[error("found {found} bytes, expected {expected}")]
    Length { found: usize, expected: &'static str },
    #[error("found a {field} that is no text, expected UTF-8")]
    NotText { field: &'static str },
    #[error("found {found}, expected {expected}")]
    Extension { found: String, expected: String },
}

const FRAME_BYTES: usize = 32;
const POINT_NAME_BYTES: usize = 64;
const GROUP_BYTES: usize = 32;

/// Most tools, or points, in one message.
const MAX_ELEMENTS: u64 = 1024;

/// Longest text of a status.
const MAX_STATUS_TEXT_BYTES: u64 = 4096;

/// The least limit: a body of a few bytes too many is one wrong message, no end of the stream.
const SHORTEST_LIMIT: u64 = 1024;

/// The longest content that a type of [`Content`] may have; `None` for any other type.
pub fn longest_content(kind: &str) -> Option<u64> {
    let bytes = match kind {
        "TRANSFORM" => 48,
        "POSITION" | "QTRANS" => 28,
        "TDATA" => 70 * MAX_ELEMENTS,
        "QTDATA" => 50 * MAX_ELEMENTS,
        "POINT" => 136 * MAX_ELEMENTS,
        "STATUS" => 30 + MAX_STATUS_TEXT_BYTES,
        "STRING" => 4 + u64::from(u16::MAX),
        "STT_TDATA" | "STT_QTDATA" => 36,
        "RTS_TDATA" | "RTS_QTDATA" => 1,
        "STP_TDATA" | "STP_QTDATA" | "GET_TRANS" | "GET_TRANSFOR" | "GET_STATUS" => 0,
        _ => return None,
    };
    Some(bytes.max(SHORTEST_LIMIT))
}

impl Content {
    /// The name of the type in the header.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Transform(_) => "TRANSFORM",
            Self::Position(_) => "POSITION",
            Self::Tracking(_) => "TDATA",
            Self::QuaternionTracking(_) => "QTDATA",
            Self::Status(_) => "STATUS",
            Self::Text(_) => "STRING",
            Self::Points(_) => "POINT",
            Self::StartTracking(_) => "STT_TDATA",
            Self::StartQuaternionTracking(_) => "STT_QTDATA",
            Self::StopTracking => "STP_TDATA",
            Self::StopQuaternionTracking => "STP_QTDATA",
            Self::TrackingReply(_) => "RTS_TDATA",
            Self::QuaternionTrackingReply(_) => "RTS_QTDATA",
            Self::GetTransform => "GET_TRANS",
            Self::GetStatus => "GET_STATUS",
        }
    }

    /// The content of a type; `None` for one that is not known here.
    pub fn decode(kind: &str, bytes: &[u8]) -> Option<Result<Self, BodyError>> {
        let wrong_length = |expected| BodyError::Length { found: bytes.len(), expected };
        let empty = |content| match bytes {
            [] => Ok(content),
            _ => Err(wrong_length("none")),
        };
        let reply = || match bytes {
            // A signed byte; some senders write none.
            [] => Ok(0),
            [status] => Ok(status.cast_signed()),
            _ => Err(wrong_length("1")),
        };
        Some(match kind {
            "TRANSFORM" => match Reader(bytes).floats() {
                Some(values) if bytes.len() == 48 => Ok(Self::Transform(Matrix(values))),
                _ => Err(wrong_length("48")),
            },
            // Its name before version 1 of the protocol.
            "POSITION" | "QTRANS" => decode_position(bytes)
                .map(Self::Position)
                .ok_or_else(|| wrong_length("12, 24 or 28")),
            "TDATA" => {
                elements::<70, _>(bytes, "a multiple of 70", tracking_element).map(Self::Tracking)
            }
            "QTDATA" => elements::<50, _>(bytes, "a multiple of 50", quaternion_element)
                .map(Self::QuaternionTracking),
            "POINT" => elements::<136, _>(bytes, "a multiple of 136", point).map(Self::Points),
            "STATUS" => decode_status(bytes).map(Self::Status),
            "STRING" => decode_string(bytes)
                .map(Self::Text)
                .ok_or_else(|| wrong_length("4 and as many as they announce")),
            "STT_TDATA" => decode_start(bytes).map(Self::StartTracking),
            "STT_QTDATA" => decode_start(bytes).map(Self::StartQuaternionTracking),
            "STP_TDATA" => empty(Self::StopTracking),
            "STP_QTDATA" => empty(Self::StopQuaternionTracking),
            "RTS_TDATA" => reply().map(Self::TrackingReply),
            "RTS_QTDATA" => reply().map(Self::QuaternionTrackingReply),
            "GET_TRANS" | "GET_TRANSFOR" => empty(Self::GetTransform),
            "GET_STATUS" => empty(Self::GetStatus),
            _ => return None,
        })
    }

    /// Writes the body.
    pub fn encode(&self, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        match self {
            Self::Transform(matrix) => put_floats(out, &matrix.0),
            Self::Position(position) => {
                put_floats(out, &position.at_mm);
                match &position.orientation {
                    Orientation::None => {}
                    Orientation::Vector(vector) => put_floats(out, vector),
                    Orientation::Full(quaternion) => put_floats(out, quaternion),
                }
            }
            Self::Tracking(elements) => {
                for element in elements {
                    put_text(out, &element.name, NAME_BYTES, "tool name")?;
                    out.extend_from_slice(&[element.kind.into(), 0]);
                    put_floats(out, &element.matrix.0);
                }
            }
            Self::QuaternionTracking(elements) => {
                for element in elements {
                    put_text(out, &element.name, NAME_BYTES, "tool name")?;
                    out.extend_from_slice(&[element.kind.into(), 0]);
                    put_floats(out, &element.at_mm);
                    put_floats(out, &element.quaternion);
                }
            }
            Self::Status(status) => {
                out.extend_from_slice(&status.code.0.to_be_bytes());
                out.extend_from_slice(&status.subcode.to_be_bytes());
                put_text(out, &status.name, NAME_BYTES, "status name")?;
                out.extend_from_slice(status.text.as_bytes());
                out.push(0);
            }
            Self::Text(text) => {
                let length: u16 = counted(text.bytes.len(), "text", u16::MAX.into())?;
                out.extend_from_slice(&text.encoding.to_be_bytes());
                out.extend_from_slice(&length.to_be_bytes());
                out.extend_from_slice(&text.bytes);
            }
            Self::Points(points) => {
                for point in points {
                    put_text(out, &point.name, POINT_NAME_BYTES, "point name")?;
                    put_text(out, &point.group, GROUP_BYTES, "point group")?;
                    out.extend_from_slice(&point.rgba);
                    put_floats(out, &point.at_mm);
                    put_floats(out, &[point.radius_mm]);
                    put_text(out, &point.owner, NAME_BYTES, "point owner")?;
                }
            }
            Self::StartTracking(start) | Self::StartQuaternionTracking(start) => {
                out.extend_from_slice(&start.resolution_ms.to_be_bytes());
                put_text(out, &start.frame, FRAME_BYTES, "coordinate frame")?;
            }
            Self::TrackingReply(status) | Self::QuaternionTrackingReply(status) => {
                out.push(status.cast_unsigned());
            }
            Self::StopTracking
            | Self::StopQuaternionTracking
            | Self::GetTransform
            | Self::GetStatus => {}
        }
        Ok(())
    }
}

fn decode_position(bytes: &[u8]) -> Option<Position> {
    let mut reader = Reader(bytes);
    Some(Position {
        at_mm: reader.floats()?,
        orientation: match bytes.len() {
            12 => Orientation::None,
            24 => Orientation::Vector(reader.floats()?),
            28 => Orientation::Full(reader.floats()?),
            _ => return None,
        },
    })
}

/// A body of equal parts of `N` bytes.
fn elements<const N: usize, T>(
    bytes: &[u8],
    expected: &'static str,
    element: impl Fn(&[u8; N]) -> Result<T, BodyError>,
) -> Result<Vec<T>, BodyError> {
    let (parts, rest) = bytes.as_chunks::<N>();
    if !rest.is_empty() {
        return Err(BodyError::Length { found: bytes.len(), expected });
    }
    parts.iter().map(element).collect()
}

/// The next text of fixed width.
fn text(reader: &mut Reader, width: usize, field: &'static str) -> Result<String, BodyError> {
    reader.take(width).and_then(text_of).ok_or(BodyError::NotText { field })
}

/// The name of a tool in a list; empty where it is no text, so that other tools are kept.
fn tool_name(reader: &mut Reader) -> String {
    let text = reader.take(NAME_BYTES).and_then(text_of);
    text.unwrap_or_default()
}

/// What cannot be missing, because the length was looked at.
const CUT: BodyError = BodyError::Length { found: 0, expected: "a whole element" };

fn tracking_element(bytes: &[u8; 70]) -> Result<TrackingElement, BodyError> {
    let mut reader = Reader(bytes);
    let name = tool_name(&mut reader);
    let [kind, _] = reader.array().ok_or(CUT)?;
    Ok(TrackingElement { name, kind: kind.into(), matrix: Matrix(reader.floats().ok_or(CUT)?) })
}

fn quaternion_element(bytes: &[u8; 50]) -> Result<QuaternionElement, BodyError> {
    let mut reader = Reader(bytes);
    let name = tool_name(&mut reader);
    let [kind, _] = reader.array().ok_or(CUT)?;
    Ok(QuaternionElement {
        name,
        kind: kind.into(),
        at_mm: reader.floats().ok_or(CUT)?,
        quaternion: reader.floats().ok_or(CUT)?,
    })
}

fn point(bytes: &[u8; 136]) -> Result<Point, BodyError> {
    let mut reader = Reader(bytes);
    let name = text(&mut reader, POINT_NAME_BYTES, "point name")?;
    let group = text(&mut reader, GROUP_BYTES, "point group")?;
    let rgba = reader.array().ok_or(CUT)?;
    let at_mm = reader.floats().ok_or(CUT)?;
    let [radius_mm] = reader.floats().ok_or(CUT)?;
    Ok(Point {
        name,
        group,
        rgba,
        at_mm,
        radius_mm,
        owner: text(&mut reader, NAME_BYTES, "point owner")?,
    })
}

fn decode_status(bytes: &[u8]) -> Result<Status, BodyError> {
    let mut reader = Reader(bytes);
    let mut numbers = || Some((reader.u16()?, reader.i64()?, reader.take(NAME_BYTES)?));
    let (code, subcode, name) =
        numbers().ok_or(BodyError::Length { found: bytes.len(), expected: "30 at least" })?;
    // The text is for people: what is no UTF-8 in it is shown as such.
    let end = reader.0.iter().position(|&b| b == 0);
    let content = reader.0.get(..end.unwrap_or(reader.0.len()));
    Ok(Status {
        code: StatusCode(code),
        subcode,
        name: text_of(name).ok_or(BodyError::NotText { field: "status name" })?,
        text: String::from_utf8_lossy(content.unwrap_or_default()).into_owned(),
    })
}

fn decode_string(bytes: &[u8]) -> Option<Text> {
    let mut reader = Reader(bytes);
    let encoding = reader.u16()?;
    let length = reader.u16()?;
    let content = reader.take(length.into())?;
    reader.0.is_empty().then(|| Text { encoding, bytes: content.to_vec() })
}

fn decode_start(bytes: &[u8]) -> Result<StartTracking, BodyError> {
    let mut reader = Reader(bytes);
    match (reader.u32(), bytes.len()) {
        (Some(resolution_ms), 36) => Ok(StartTracking {
            resolution_ms,
            frame: text(&mut reader, FRAME_BYTES, "coordinate frame")?,
        }),
        _ => Err(BodyError::Length { found: bytes.len(), expected: "36" }),
    }
}
