//! Why a thread of the workspace has no result.

/// How work ended without the requested result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    Cancelled,
    /// In the words of the command line.
    Because(String),
}
