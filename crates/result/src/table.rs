//! Tables: a column names what it has of each item, for programs and for people.

use serde::Serialize;
use serde_json::{Value, json};
use std::borrow::Cow;

/// Rows of the same kind. Programs read a list of objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    pub key: Cow<'static, str>,
    pub columns: Vec<Column>,
    /// A value for each column.
    pub rows: Vec<Vec<Value>>,
}

/// What a table has of each of its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name for programs, unit included; a dot leads into an object. Empty where only people read it.
    pub key: Cow<'static, str>,
    /// Name for people, with the unit where it is not that of the column before; empty where only
    /// programs read it.
    pub label: Cow<'static, str>,
    /// Of numbers that are not counts.
    pub decimals: usize,
    /// Whether it has words rather than numbers.
    pub is_text: bool,
}

/// A table that is filled column by column from a list of items.
#[derive(Debug)]
pub struct Columns<'a, T> {
    items: &'a [T],
    table: Table,
}

impl Table {
    /// A row for each item; the columns follow.
    ///
    /// ```
    /// use trackwright_result::Table;
    /// let table = Table::of("points", &[0.5, 1.5]).number("off_mm", "off, mm", 2, |mm| *mm).done();
    /// assert_eq!(table.to_json()[1]["off_mm"], 1.5);
    /// ```
    pub fn of<T>(key: impl Into<Cow<'static, str>>, items: &[T]) -> Columns<'_, T> {
        let rows = vec![Vec::new(); items.len()];
        Columns { items, table: Self { key: key.into(), columns: Vec::new(), rows } }
    }
}

impl<T> Columns<'_, T> {
    fn column<V: Serialize>(
        mut self,
        (key, label): (impl Into<Cow<'static, str>>, impl Into<Cow<'static, str>>),
        (decimals, is_text): (usize, bool),
        value: impl Fn(&T) -> V,
    ) -> Self {
        let (key, label) = (key.into(), label.into());
        self.table.columns.push(Column { key, label, decimals, is_text });
        for (row, item) in self.table.rows.iter_mut().zip(self.items) {
            row.push(json!(value(item)));
        }
        self
    }

    /// Numbers, of so many decimals for people, and counts, which have none.
    pub fn number<V: Serialize>(
        self,
        key: impl Into<Cow<'static, str>>,
        label: impl Into<Cow<'static, str>>,
        decimals: usize,
        value: impl Fn(&T) -> V,
    ) -> Self {
        self.column((key, label), (decimals, false), value)
    }

    /// Words.
    pub fn text<V: Serialize>(
        self,
        key: impl Into<Cow<'static, str>>,
        label: impl Into<Cow<'static, str>>,
        value: impl Fn(&T) -> V,
    ) -> Self {
        self.column((key, label), (0, true), value)
    }

    /// What only programs read.
    pub fn data<V: Serialize>(
        self,
        key: impl Into<Cow<'static, str>>,
        value: impl Fn(&T) -> V,
    ) -> Self {
        self.column((key, ""), (0, true), value)
    }

    pub fn done(self) -> Table {
        self.table
    }
}
