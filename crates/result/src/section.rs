//! All that a computation found, in the order in which it is read.

use super::{Note, Row, Table, data};
use serde::Serialize;
use serde_json::{Value, json};
use std::borrow::Cow;

/// Figures and tables that belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// The object that it is for programs; empty where it is part of the section around it.
    pub key: Cow<'static, str>,
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
