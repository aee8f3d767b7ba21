//! The slipfit command.
fn main() {}
