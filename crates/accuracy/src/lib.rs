//! What the program's numbers are worth: their error against run time, and how they hold in
//! extreme cases, against references of higher precision.

pub mod high;
pub mod high_linear;
pub mod precision;
pub mod stability;
