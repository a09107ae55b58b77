//! The source and its pages themselves: who uses whom, words, links. Needs nothing but the files:
//! `CARGO_MANIFEST_DIR=$PWD rustc --test --edition 2024 tests/structure/main.rs` builds it alone.

mod arrows;
mod keys;
mod words;
