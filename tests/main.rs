//! All integration tests in one crate, so that what they need is linked once.

mod oracle;
mod support;
