//! TODO-NOTE

pub mod create_info;
pub mod dividing_stage;
pub mod division_counter;
pub mod layouts;
pub mod program_pipelines;
pub mod variants;
