//! What the program's process has, whatever API draws: settings, log, rig file, clock, other nodes,
//! readers of its pictures, and its end.
//!
//! - [`settings`]: what does the environment say? [`live`]: has the rig file changed?
//! - [`log`]: which warnings are written, and where?
//! - [`clock`]: is the program's time virtual? [`nodes`]: may this frame be shown yet?
//! - [`call_sum`]: do all machines make the same calls?
//! - [`publishing`]: who gets the finished pictures?
//! - [`small_window`]: has the window too few pixels for the outputs?
//! - [`signals`], [`ending`]: does the process end?

pub mod call_sum;
pub mod clock;
pub mod ending;
pub mod file_stamp;
pub mod live;
pub mod log;
pub mod nodes;
pub mod publishing;
pub mod settings;
pub mod signals;
pub mod small_window;
