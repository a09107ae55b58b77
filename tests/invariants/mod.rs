//! What has to hold whatever the numbers are.

mod fitting;
mod joint_fit;
mod markers;
mod studies;
mod support;
mod surveys;
mod uncertainty;
