//! What every analysis answers with.

pub mod hint;
pub mod quantity;
