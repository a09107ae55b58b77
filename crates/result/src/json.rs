//! Results as programs read them.

use super::{Item, Section, Table};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

impl Section {
    /// An object of all that has a name for programs.
    pub fn to_json(&self) -> Value {
        let mut object = Map::new();
        self.put_into(&mut object);
        Value::Object(object)
    }

    fn put_into(&self, object: &mut Map<String, Value>) {
        for item in &self.items {
            match item {
                Item::Row(row) => put(object, &row.key, row.value.clone()),
                Item::Table(table) => put(object, &table.key, table.to_json()),
                Item::Line(_) => {}
                Item::Section(section) if section.key.is_empty() => section.put_into(object),
                Item::Section(section) => put(object, &section.key, section.to_json()),
            }
        }
    }
}

impl Table {
    /// A list of objects.
    pub fn to_json(&self) -> Value {
        let object = |row: &Vec<Value>| {
            let mut object = Map::new();
            for (column, value) in self.columns.iter().zip(row) {
                put(&mut object, &column.key, value.clone());
            }
            Value::Object(object)
        };
        self.rows.iter().map(object).collect()
    }
}

impl Serialize for Section {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_json().serialize(serializer)
    }
}

/// Puts a value where its key leads; nowhere without a key.
fn put(object: &mut Map<String, Value>, key: &str, value: Value) {
    match key.split_once('.') {
        None if key.is_empty() => {}
        None => match key.strip_suffix("[]") {
            Some(list) => {
                let list = object.entry(list).or_insert_with(|| Value::Array(Vec::new()));
                if let Value::Array(list) = list {
                    list.push(value);
                }
            }
            None => {
                object.insert(key.to_owned(), value);
            }
        },
        Some((first, rest)) => {
            let inner = object.entry(first).or_insert(Value::Null);
            // A null stands for an object that is not always there.
            if inner.is_null() {
                *inner = Value::Object(Map::new());
            }
            if let Value::Object(inner) = inner {
                put(inner, rest, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Section, Table, count, data, mm, number};
    use serde_json::json;

    #[test]
    fn keys_lead_into_objects() {
        let table = Table::of("each", &[1.0, f64::NAN])
            .text("", "name", |_| "only for people")
            .number("off.mm", "mm", 2, |v| *v)
            .done();
        let found = Section::of([
            count("poses", "poses", 3),
            mm("of.all_mm", "all", 0.1),
            number("", "only for people", 7.0, 1, ""),
            data("of.matrix", [[1, 2], [3, 4]]),
            data("seldom", ()),
            data("never", ()),
            count("seldom.there", "", 4),
        ])
        .with(Section::of([mm("rms_mm", "RMS", None)]).named("inner"))
        .with(Section::of([count("outer", "", 1)]))
        .with(Section::of([count("step", "", 1)]).named("steps[]"))
        .with(Section::of([count("step", "", 2)]).named("steps[]"))
        .with(table)
        .with("a sentence".to_owned());
        let expected = json!({
            "poses": 3,
            "of": {"all_mm": 0.1, "matrix": [[1, 2], [3, 4]]},
            "seldom": {"there": 4},
            "never": null,
            "inner": {"rms_mm": null},
            "outer": 1,
            "steps": [{"step": 1}, {"step": 2}],
            "each": [{"off": {"mm": 1.0}}, {"off": {"mm": null}}],
        });
        assert_eq!(found.to_json(), expected);
    }
}
