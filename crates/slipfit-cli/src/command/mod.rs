//! The commands, one file each.

pub(crate) mod ringdown;
pub(crate) mod simulate;
