//! Every row holds, and naive methods are found out.

use super::methods::{Methods, Own};
use super::row::Row;
use super::{Extent, families, page, run};
use crate::task::Task;

fn rows(methods: &dyn Methods, family: &str) -> Vec<Row> {
    let families: Vec<_> = families(Extent::Reduced)
        .into_iter()
        .filter(|f| family.is_empty() || f.name == family)
        .collect();
    assert!(!families.is_empty(), "no family {family}");
    run(&families, methods, &Task::default()).unwrap()
}

#[test]
fn every_row_of_the_reduced_battery_holds() {
    let rows = rows(&Own, "");
    eprintln!("{}", page::text(&rows));
    assert!(rows.iter().all(|r| r.holds), "{}", page::text(&rows));
}
