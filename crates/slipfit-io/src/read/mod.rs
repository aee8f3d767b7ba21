//! From files to records, curves and levels: opening, choice of the columns, reading and reports.

pub(crate) mod curve;
pub(crate) mod driven;
pub(crate) mod glance;
pub(crate) mod levels;
pub(crate) mod open;
mod pick;
pub(crate) mod record;
mod rounded;
