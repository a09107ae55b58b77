//! What a device says of itself.

/// The codes of the protocol that are used here; any other number is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusCode(pub u16);

impl StatusCode {
    pub const OK: Self = Self(1);
    pub const UNKNOWN_ERROR: Self = Self(2);
    pub const NOT_FOUND: Self = Self(4);
    pub const TIME_OUT: Self = Self(7);
    pub const RESOURCE_ERROR: Self = Self(11);
    pub const UNKNOWN_INSTRUCTION: Self = Self(12);
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
    pub fn ok(text: impl Into<String>) -> Self {
        Self { code: StatusCode::OK, subcode: 0, name: String::new(), text: text.into() }
    }

    pub fn problem(code: StatusCode, name: &str, text: impl Into<String>) -> Self {
        Self { code, subcode: 0, name: name.to_owned(), text: text.into() }
    }
}
