//! The commands, one file each.

pub(crate) mod atlas;
pub(crate) mod inspect;
pub(crate) mod levels;
pub(crate) mod map;
pub(crate) mod paper;
pub(crate) mod resonance;
pub(crate) mod ringdown;
pub(crate) mod series;
pub(crate) mod shell;
pub(crate) mod show;
pub(crate) mod simulate;
