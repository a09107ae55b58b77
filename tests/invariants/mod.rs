//! What has to hold whatever the numbers are.

mod comparison;
mod doubts;
mod field_draws;
mod fitting;
mod joint_fit;
mod markers;
mod mistakes;
mod row_order;
mod studies;
mod support;
mod surveys;
mod uncertainty;
