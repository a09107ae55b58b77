//! How accurate the program's numbers are: error against run time ([`precision`]), and stiff and
//! extreme cases against references of 192 bits ([`stability`]).
//!
//! ```
//! use trackwright_accuracy::stability::case::{Extent, Methods};
//! use trackwright_accuracy::stability::{families, run};
//! use trackwright_task::Task;
//! let mut families = families(Extent::Reduced);
//! families.retain(|family| family.name == "singular values");
//! let rows = run(&families, &Methods::OWN, &Task::default())?;
//! assert!(rows.iter().all(|row| row.error <= row.bound));
//! # Ok::<(), trackwright_task::Cancelled>(())
//! ```

mod high;
mod high_linear;
pub mod precision;
mod references;
pub mod stability;
