//! The commands, one file each.

#[cfg(feature = "app")]
pub(crate) mod app;
#[cfg(not(feature = "app"))]
#[path = "no_app.rs"]
pub(crate) mod app;
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
