//! Keys with their modifiers, and how people write them.

/// A key with its modifiers. Keys are letters in lower case, digits, signs, `escape`, `delete`,
/// `space`, `left`, `right`, `up`, `down`, `home`, `pageup`, `pagedown`, or `f1` to `f12`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keys {
    pub key: &'static str,
    pub control: bool,
    pub shift: bool,
}

impl Keys {
    pub(crate) const fn plain(key: &'static str) -> Self {
        Self { key, control: false, shift: false }
    }

    pub(crate) const fn shift(key: &'static str) -> Self {
        Self { shift: true, ..Self::plain(key) }
    }

    pub(crate) const fn control(key: &'static str) -> Self {
        Self { control: true, ..Self::plain(key) }
    }

    pub(crate) const fn control_shift(key: &'static str) -> Self {
        Self { shift: true, ..Self::control(key) }
    }
}

/// `Ctrl+Shift+Z`.
impl std::fmt::Display for Keys {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.control {
            f.write_str("Ctrl+")?;
        }
        if self.shift {
            f.write_str("Shift+")?;
        }
        match self.key {
            "escape" => f.write_str("Esc"),
            "delete" => f.write_str("Del"),
            "space" => f.write_str("Space"),
            "left" => f.write_str("Left"),
            "right" => f.write_str("Right"),
            "up" => f.write_str("Up"),
            "down" => f.write_str("Down"),
            "home" => f.write_str("Home"),
            "pageup" => f.write_str("Page up"),
            "pagedown" => f.write_str("Page down"),
            key => f.write_str(&key.to_uppercase()),
        }
    }
}
