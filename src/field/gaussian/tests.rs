//! The process against closed forms and drawn fields.
