//! What the program's numbers are worth: their error against run time.

pub mod precision;
