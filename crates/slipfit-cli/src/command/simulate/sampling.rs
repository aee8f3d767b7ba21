//! Number of rows of a record, and its noise.

use crate::failure::Failure;
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

/// More rows than any table is read with.
pub(super) const MOST_ROWS: f64 = 1e9;

/// White noise with a seed.
pub(crate) struct Noise {
    rng: ChaCha12Rng,
    rms: f64,
}

impl Noise {
    pub(crate) fn new(seed: u64, rms: f64) -> Self {
        Self { rng: ChaCha12Rng::seed_from_u64(seed), rms }
    }

    pub(crate) fn next(&mut self) -> f64 {
        let unit: f64 = StandardNormal.sample(&mut self.rng);
        self.rms * unit
    }
}

/// Number of rows from zero to the duration, both included.
pub(super) fn rows(duration_s: f64, rate_hz: f64) -> Result<u64, Failure> {
    let rows = (duration_s * rate_hz).floor() + 1.0;
    if rows > MOST_ROWS {
        return Err(Failure::new(format!("{rows:.0} rows asked for, at most {MOST_ROWS:.0} are written"))
            .hint("--duration or --rate-hz makes the record shorter"));
    }
    Ok(rows as u64)
}
