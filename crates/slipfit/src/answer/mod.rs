//! What every analysis answers with.

pub mod quantity;
