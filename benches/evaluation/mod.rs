//! Equation (8): every way of evaluating it beside a plain loop over single poses.

mod peak;
mod plain;
mod scattered;
mod shared;
