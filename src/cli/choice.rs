//! Options with a few named values.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};
use std::ffi::OsStr;

/// A parser of one of a few values: its name, what it is for, the value.
#[derive(Clone, Copy)]
pub struct Choice<T: 'static>(pub &'static [(&'static str, &'static str, T)]);

impl<T: Clone + Send + Sync + 'static> TypedValueParser for Choice<T> {
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, text: &OsStr) -> Result<T, Error> {
        let names = PossibleValuesParser::new(self.0.iter().map(|(name, ..)| *name));
        let found = names.parse_ref(command, arg, text)?;
        let value =
            self.0.iter().find(|(name, ..)| *name == found).map(|(.., value)| value.clone());
        value.ok_or_else(|| Error::new(ErrorKind::InvalidValue).with_cmd(command))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.0.iter().map(|(name, help, _)| match *help {
            "" => PossibleValue::new(*name),
            help => PossibleValue::new(*name).help(help),
        })))
    }
}
