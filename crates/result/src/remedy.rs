//! Refusals and reserves, and the settings that lift them.

use std::error::Error;

/// The setting that lifts a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Remedy {
    /// Its name as a keyword: `min_poses`.
    setting: &'static str,
    /// A sentence with `{}` where the setting is named.
    sentence: &'static str,
}

impl Remedy {
    pub const fn new(setting: &'static str, sentence: &'static str) -> Self {
        Self { setting, sentence }
    }

    /// As an option of the command line.
    ///
    /// ```
    /// let remedy = trackwright_result::Remedy::new("min_poses", "{} accepts fewer");
    /// assert_eq!(remedy.as_option(), "--min-poses accepts fewer");
    /// assert_eq!(remedy.as_keyword(), "min_poses accepts fewer");
    /// ```
    pub fn as_option(&self) -> String {
        self.sentence.replace("{}", &format!("--{}", self.setting.replace('_', "-")))
    }

    /// As a keyword of a function.
    pub fn as_keyword(&self) -> String {
        self.sentence.replace("{}", self.setting)
    }
}

/// An error that a setting may lift.
pub trait Refusal: Error {
    /// `None` where no setting helps.
    fn remedy(&self) -> Option<Remedy>;

    /// The error with what would lift it, the setting named by `name`.
    fn with_remedy(&self, name: fn(&Remedy) -> String) -> String {
        match self.remedy() {
            Some(remedy) => format!("{self}; {}", name(&remedy)),
            None => self.to_string(),
        }
    }
}

/// What holds only with a reserve.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    text: String,
    remedy: Option<Remedy>,
    /// Something is probably wrong.
    pub is_warning: bool,
}

impl Note {
    pub fn warning(text: impl Into<String>) -> Self {
        Self { text: text.into(), remedy: None, is_warning: true }
    }

    pub fn lifted_by(self, remedy: Remedy) -> Self {
        Self { remedy: Some(remedy), ..self }
    }

    /// The sentence, the setting named by `name`.
    pub fn sentence(&self, name: fn(&Remedy) -> String) -> String {
        match &self.remedy {
            Some(remedy) => format!("{} {}", self.text, name(remedy)),
            None => self.text.clone(),
        }
    }
}

impl<T: Into<String>> From<T> for Note {
    fn from(text: T) -> Self {
        Self { text: text.into(), remedy: None, is_warning: false }
    }
}
