//! All that a computation found, in the order in which it is read.

use super::{Note, Row, Table, data};
use serde::Serialize;
use serde_json::{Value, json};
use std::borrow::Cow;

/// Figures and tables that belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// The object that it is for programs; empty where it is part of the section around it. `steps[]` is
    /// one more of the list `steps`.
    pub key: Cow<'static, str>,
    /// A line above, for people; empty where it has none.
    pub heading: String,
    /// Spaces before the lines of a section within another, which then follow what is above without an
    /// empty line; two below a heading where nothing is stated.
    pub indent: Option<usize>,
    pub items: Vec<Item>,
    pub notes: Vec<Note>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Row(Row),
    Table(Table),
    /// A sentence for people.
    Line(String),
    Section(Section),
}

impl Section {
    pub fn of(rows: impl IntoIterator<Item = Row>) -> Self {
        Self { items: rows.into_iter().map(Item::Row).collect(), ..Self::default() }
    }

    /// The fields of a value, which only programs read.
    pub fn of_fields(value: &impl Serialize) -> Self {
        let Value::Object(fields) = json!(value) else { return Self::default() };
        Self::of(fields.into_iter().map(|(key, value)| data(key, value)))
    }

    /// As an object of its own within others.
    pub fn named(self, key: impl Into<Cow<'static, str>>) -> Self {
        Self { key: key.into(), ..self }
    }

    /// Under a line for people.
    pub fn headed(self, heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), ..self }
    }

    /// Its lines directly below what is above, after so many spaces.
    pub fn below(self, indent: usize) -> Self {
        Self { indent: Some(indent), ..self }
    }

    pub fn with(mut self, item: impl Into<Item>) -> Self {
        self.items.push(item.into());
        self
    }

    pub fn with_all<I: Into<Item>>(mut self, items: impl IntoIterator<Item = I>) -> Self {
        self.items.extend(items.into_iter().map(Into::into));
        self
    }

    pub fn noting<N: Into<Note>>(mut self, notes: impl IntoIterator<Item = N>) -> Self {
        self.notes.extend(notes.into_iter().map(Into::into));
        self
    }
}

impl From<Row> for Item {
    fn from(row: Row) -> Self {
        Self::Row(row)
    }
}

impl From<Table> for Item {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl From<String> for Item {
    fn from(line: String) -> Self {
        Self::Line(line)
    }
}

impl From<Section> for Item {
    fn from(section: Section) -> Self {
        Self::Section(section)
    }
}
