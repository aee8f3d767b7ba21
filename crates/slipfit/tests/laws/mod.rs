//! Common functions of the tests of single laws.

use crate::noise::Noise;
use slipfit::ringdown::{Answer, Options};
use slipfit::{Parameter, Record};

/// A motion with noise on it.
pub(crate) fn noisy(time_s: &[f64], motion: &[f64], noise: f64, seed: u64) -> Record {
    let mut n = Noise::of(seed);
    let signal = motion.iter().map(|x| x + noise * n.next()).collect();
    Record::new(time_s.to_vec(), signal).unwrap().with_unit("rad")
}

/// Options that name a model.
pub(crate) fn options(model: &str) -> Options {
    let mut options = Options::default();
    options.model = Some(model.parse().unwrap());
    options
}

/// Whether the estimates of a parameter scatter about the true value in accordance with their errors.
pub(crate) fn scatters_about(what: &str, truth: f64, answers: &[Answer], parameter: Parameter) {
    let found = |a: &Answer| a.parameter(parameter).unwrap().clone();
    let z: Vec<f64> =
        answers.iter().map(|a| (found(a).unbounded_value - truth) / found(a).std_error).collect();
    let mean = z.iter().sum::<f64>() / z.len() as f64;
    assert!(mean.abs() < 4.0 / (z.len() as f64).sqrt(), "{what}: {z:.2?}");
    assert!(z.iter().all(|z| z.abs() < 4.0), "{what}: {z:.2?}");
}
