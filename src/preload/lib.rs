//! LD_PRELOAD front end.
