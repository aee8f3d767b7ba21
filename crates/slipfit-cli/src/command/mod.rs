//! The commands, one file each.

pub(crate) mod atlas;
pub(crate) mod paper;
pub(crate) mod ringdown;
pub(crate) mod simulate;
