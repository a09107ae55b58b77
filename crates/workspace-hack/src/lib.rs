//! One set of features of shared dependencies for every build of the workspace; no code.
