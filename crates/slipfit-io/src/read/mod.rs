//! From files to records, curves and levels: open, choose the columns, read, account.

pub(crate) mod curve;
pub(crate) mod driven;
pub(crate) mod glance;
pub(crate) mod levels;
pub(crate) mod open;
mod pick;
pub(crate) mod record;
mod rounded;
