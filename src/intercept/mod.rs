//! Between an unmodified program and its driver.
