//! Exists so that build dependencies have one set of features too.

fn main() {}
