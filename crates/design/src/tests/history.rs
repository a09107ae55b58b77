//! Steps, and the ways back and forth between them.

use super::*;
use proptest::prelude::*;

#[test]
fn a_drag_is_one_step_undone_exactly() {
    let mut document = document();
    document.begin("Drag sensor a");
    for step in 1..=10 {
        assert!(document.apply(move_to(0.1 + 0.1 * f64::from(step))).unwrap());
    }
    assert!(document.commit());
    assert!(document.is_dirty());
    let dragged = z_mm(&document);
    assert_eq!(document.undo().as_deref(), Some("Drag sensor a"));
    assert_eq!(z_mm(&document).to_bits(), 0.1_f64.to_bits());
    assert!(!document.is_dirty());
    assert_eq!(document.undo(), None);
    assert_eq!(document.redo_label(), Some("Drag sensor a"));
    assert_eq!(document.redo().as_deref(), Some("Drag sensor a"));
    assert_eq!(z_mm(&document).to_bits(), dragged.to_bits());
}

#[test]
fn cancel_takes_a_step_back_and_leaves_no_trace() {
    let mut document = document();
    document.begin("Drag");
    document.apply(move_to(9.0)).unwrap();
    assert!(document.is_in_step());
    assert!(document.undo().is_none() && document.redo().is_none());
    let revision = document.revision();
    assert!(document.cancel());
    assert!(document.revision() > revision);
    assert_eq!(document.design(), &design());
    assert_eq!(document.undo_label(), None);
    assert!(!document.is_in_step() && !document.is_dirty() && !document.cancel());
}

#[test]
fn a_step_that_ends_where_it_began_is_none() {
    let mut document = document();
    document.begin("Drag");
    document.apply(move_to(9.0)).unwrap();
    document.apply(move_to(0.1)).unwrap();
    assert!(!document.commit());
    assert_eq!(document.undo_label(), None);
    assert!(!document.apply(move_to(0.1)).unwrap());
}

#[test]
fn only_a_new_edit_clears_redo() {
    let mut document = document();
    document.apply(move_to(1.0)).unwrap();
    document.undo();
    document.begin("Drag");
    document.apply(move_to(2.0)).unwrap();
    document.cancel();
    assert_eq!(document.redo_label(), Some("Move sensor a"));
    document.apply(move_to(3.0)).unwrap();
    assert_eq!(document.redo_label(), None);
}

#[test]
fn a_step_that_begins_within_another_ends_it() {
    let mut document = document();
    document.begin("First");
    document.apply(move_to(1.0)).unwrap();
    document.begin("Second");
    document.apply(move_to(2.0)).unwrap();
    document.cancel();
    assert_eq!(z_mm(&document), 1.0);
    assert_eq!(document.undo_label(), Some("First"));
}

#[test]
fn undo_past_a_save_is_dirty() {
    let mut document = document();
    document.apply(move_to(1.0)).unwrap();
    document.mark_saved();
    assert!(!document.is_dirty());
    document.undo();
    assert!(document.is_dirty());
    document.redo();
    assert!(!document.is_dirty());
}

#[test]
fn history_lists_the_present_and_saved_state() {
    let mut document = document();
    document.apply(move_to(1.0)).unwrap();
    document.mark_saved();
    document.apply(arrange(&[0], Arrangement::Duplicate)).unwrap();
    document.undo();
    document.undo();
    let history = document.history();
    let labels: Vec<_> = history.states.iter().map(|s| s.label).collect();
    assert_eq!(labels, [None, Some("Move sensor a"), Some("Duplicate sensor a")]);
    let saved: Vec<_> = history.states.iter().map(|s| s.is_saved).collect();
    assert_eq!(saved, [false, true, false]);
    assert_eq!(history.present, 0);
    assert!(document.jump_to(2));
    assert_eq!((document.history().present, tool_names(&document).len()), (2, 3));
    assert!(!document.jump_to(2) && !document.jump_to(3));
    document.begin("Drag");
    assert!(!document.jump_to(0));
}

/// Anything a person can do to a document.
#[derive(Clone, Debug)]
enum Act {
    Apply(f64),
    Begin,
    Commit,
    Cancel,
    Undo,
    Redo,
    Jump(usize),
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        3 => (0..5).prop_map(|z| Act::Apply(f64::from(z) / 3.0)),
        1 => Just(Act::Begin),
        1 => Just(Act::Commit),
        1 => Just(Act::Cancel),
        2 => Just(Act::Undo),
        1 => Just(Act::Redo),
        1 => (0..8_usize).prop_map(Act::Jump),
    ]
}

proptest! {
    /// Undoing everything gives the first state, redoing everything the last, and the revision
    /// grows exactly when the design changes.
    #[test]
    fn any_history_can_be_walked_back_and_forth(acts in prop::collection::vec(act(), 0..60)) {
        let mut document = document();
        for act in acts {
            let before = (document.design().clone(), document.revision());
            match act {
                Act::Apply(z) => { document.apply(move_to(z)).unwrap(); }
                Act::Begin => document.begin("step"),
                Act::Commit => { document.commit(); }
                Act::Cancel => { document.cancel(); }
                Act::Undo => { document.undo(); }
                Act::Redo => { document.redo(); }
                Act::Jump(state) => { document.jump_to(state); }
            }
            prop_assert!(document.revision() >= before.1);
            if *document.design() != before.0 {
                prop_assert!(document.revision() > before.1);
            }
        }
        document.commit();
        while document.redo().is_some() {}
        let last = document.design().clone();
        let mut steps = 0;
        while document.undo().is_some() { steps += 1; }
        prop_assert_eq!(document.design(), &design());
        prop_assert!(!document.is_dirty());
        for _ in 0..steps { document.redo(); }
        prop_assert_eq!(document.design(), &last);
    }

    /// Wherever one jumps, each state is the one that was there before, and so is the way back.
    #[test]
    fn a_jump_back_and_forth_is_exact(
        heights_mm in prop::collection::vec(any::<f64>().prop_filter("a coordinate", |z| z.abs() <= 1e6), 1..12),
        jumps in prop::collection::vec(any::<prop::sample::Index>(), 1..20),
    ) {
        let mut document = document();
        let mut states = vec![z_mm(&document).to_bits()];
        for z in heights_mm {
            if document.apply(move_to(z)).unwrap() {
                states.push(z_mm(&document).to_bits());
            }
        }
        let labels = |document: &Document| -> Vec<Option<String>> {
            let history = document.history();
            history.states.iter().map(|s| s.label.map(str::to_owned)).collect()
        };
        let before = labels(&document);
        prop_assert_eq!(before.len(), states.len());
        for jump in jumps {
            let (from, to) = (document.history().present, jump.index(states.len()));
            let revision = document.revision();
            prop_assert_eq!(document.jump_to(to), from != to);
            prop_assert_eq!(document.revision() > revision, from != to);
            prop_assert_eq!(document.history().present, to);
            prop_assert_eq!(z_mm(&document).to_bits(), states[to]);
            prop_assert_eq!(labels(&document), before.clone());
            document.jump_to(from);
            prop_assert_eq!(z_mm(&document).to_bits(), states[from]);
            document.jump_to(to);
        }
    }
}
