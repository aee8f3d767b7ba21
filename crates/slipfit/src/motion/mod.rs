//! Exact motion: free decay, any motion event by event, the driven steady state.

pub mod decay;
pub mod simulate;
pub mod steady;
