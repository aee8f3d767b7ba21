//! Columns of a table: their headers and numbers, and the choice of those that make a record, a curve or drive levels.

mod chooser;
pub(crate) mod clock;
mod content;
pub(crate) mod curve;
mod drive;
mod frequency;
mod groups;
pub(crate) mod head;
mod multiple;
pub(crate) mod name;
pub(crate) mod named;
pub(crate) mod points;
pub(crate) mod quadrature;
pub(crate) mod record;
mod response;
pub(crate) mod role;
pub(crate) mod rows;
pub(crate) mod scale;
mod scattering;
pub(crate) mod sentinel;
mod signal;
mod split;
pub(crate) mod stated;
pub(crate) mod units;
mod unnamed;

pub(crate) use chooser::{Chooser, ChosenColumn};
pub(crate) use response::PEAK;
