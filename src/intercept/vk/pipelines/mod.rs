//! TODO-NOTE

pub mod create_info;
pub mod dividing_stage;
pub mod layouts;
pub mod matrix_sources;
pub mod program_pipelines;
pub mod stages;
pub mod variants;
