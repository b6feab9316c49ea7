//! Reports on a finished plan: sizes and shares as text and JSON (`report`), and texels per
//! pixel, pixel by pixel (`survey`).

mod answers;
pub mod plan_report;
pub mod survey;
