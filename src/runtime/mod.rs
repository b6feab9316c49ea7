//! One window's Cupola: rig, plan and backend.
