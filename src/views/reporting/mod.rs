//! TODO-NOTE

pub mod report;
pub mod survey;
