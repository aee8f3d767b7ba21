//! Decays with known losses; every contestant gets the same numbers.

use std::f64::consts::{PI, TAU};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use slipfit::Oscillator;
use slipfit::motion::decay::FreeDecay;

use crate::Failure;

/// Noise added to every sample; the decay starts at amplitude 1.
const NOISE_RMS: f64 = 0.01;
/// Seed of the noise.
const SEED: u64 = 0x5113_f175;
/// Offset of the waveforms.
const OFFSET: f64 = 0.02;

/// A simulated record and its true parameters.
pub(super) struct Signal {
    pub(super) time_s: Vec<f64>,
    pub(super) values: Vec<f64>,
    pub(super) truth: Truth,
}

/// A decay over one decay time of its viscous loss. Two sevenths of the loss at its start are sliding, and it does
/// not stop within the record.
#[derive(Clone, Copy)]
pub(super) struct Truth {
    pub(super) decay_rate_per_s: f64,
    /// Frequency of the damped motion, omega_d / 2 pi.
    pub(super) frequency_hz: f64,
    /// C of `|X_n| + C = eps^n (|X_0| + C)`.
    pub(super) offset_amplitude: f64,
}

impl Truth {
    fn of(duration_s: f64, frequency_hz: f64) -> Truth {
        Truth { decay_rate_per_s: 1.0 / duration_s, frequency_hz, offset_amplitude: 0.4 }
    }

    pub(super) fn omega(&self) -> f64 {
        TAU * self.frequency_hz
    }

    /// x_F from `C = x_F coth(pi delta / 2 omega_d)`.
    pub(super) fn friction_displacement(&self) -> f64 {
        friction_displacement(self.offset_amplitude, self.decay_rate_per_s, self.omega())
    }

    /// The decay released at rest from amplitude 1.
    fn free_decay(&self) -> Result<FreeDecay, slipfit::Error> {
        let omega_0 = self.omega().hypot(self.decay_rate_per_s);
        let oscillator = Oscillator::kinematic(omega_0, self.decay_rate_per_s, self.friction_displacement())?;
        FreeDecay::from_rest(&oscillator, 1.0)
    }

    pub(super) fn amplitude(&self, time_s: f64) -> f64 {
        (1.0 + self.offset_amplitude) * (-self.decay_rate_per_s * time_s).exp() - self.offset_amplitude
    }
}

/// x_F from the offset amplitude C of a fitted envelope.
pub(super) fn friction_displacement(offset_amplitude: f64, decay_rate_per_s: f64, omega: f64) -> f64 {
    offset_amplitude * (PI * decay_rate_per_s / (2.0 * omega)).tanh()
}

impl Signal {
    /// A waveform with about 100 samples per cycle. Its number of cycles is an integer plus one third, so that its
    /// frequency lies between two lines of a spectrum.
    pub(super) fn waveform(samples: usize) -> Result<Signal, Failure> {
        Signal::waveform_of(samples, 0)
    }

    /// The same with independent noise for each number.
    pub(super) fn waveform_of(samples: usize, number: u64) -> Result<Signal, Failure> {
        let rate_hz = 1e5;
        let duration_s = samples as f64 / rate_hz;
        let truth = Truth::of(duration_s, rate_hz / 100.0 + 1.0 / (3.0 * duration_s));
        let decay = truth.free_decay()?;
        let value = |time_s| OFFSET + decay.displacement(time_s);
        Ok(Signal::sampled(samples, rate_hz, truth, Noise::new(SEED + number), value))
    }

    /// An amplitude trace of one second.
    pub(super) fn envelope(samples: usize) -> Signal {
        let truth = Truth::of(1.0, 1_000.0);
        let value = |time_s| truth.amplitude(time_s);
        Signal::sampled(samples, samples as f64, truth, Noise::new(SEED), value)
    }

    fn sampled(
        samples: usize,
        rate_hz: f64,
        truth: Truth,
        mut noise: Noise,
        value: impl Fn(f64) -> f64,
    ) -> Signal {
        let time_s: Vec<f64> = (0..samples).map(|i| i as f64 / rate_hz).collect();
        let values = time_s.iter().map(|&time_s| value(time_s) + NOISE_RMS * noise.normal()).collect();
        Signal { time_s, values, truth }
    }

    /// Start values of a waveform fit, in the peers' order, as read off the data and the highest line of the
    /// spectrum.
    pub(super) fn waveform_start(&self) -> [f64; 6] {
        let [amplitude, offset_amplitude, decay_rate_per_s] = self.envelope_start();
        let line_spacing_hz = self.truth.decay_rate_per_s;
        let highest_hz = (self.truth.frequency_hz / line_spacing_hz).round() * line_spacing_hz;
        [amplitude, offset_amplitude, decay_rate_per_s, TAU * highest_hz, 0.0, 0.0]
    }

    /// Start values of an envelope fit, in the peers' order.
    pub(super) fn envelope_start(&self) -> [f64; 3] {
        [1.0, 0.1, 0.5 * self.truth.decay_rate_per_s]
    }

    /// All times, then all values, as doubles.
    pub(super) fn write_doubles(&self, path: &Path) -> Result<(), Failure> {
        let mut file = BufWriter::new(File::create(path)?);
        for value in self.time_s.iter().chain(&self.values) {
            file.write_all(&value.to_le_bytes())?;
        }
        Ok(file.flush()?)
    }

    /// Two columns with a header.
    pub(super) fn write_csv(&self, path: &Path) -> Result<(), Failure> {
        let mut file = BufWriter::new(File::create(path)?);
        writeln!(file, "time_s,displacement_m")?;
        for (time_s, value) in self.time_s.iter().zip(&self.values) {
            writeln!(file, "{time_s:.5},{value:.8}")?;
        }
        Ok(file.flush()?)
    }
}

/// Gaussian noise by SplitMix64 and the Box-Muller transform: the same on every machine.
pub(super) struct Noise(u64);

impl Noise {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_waveform_meets_the_envelope_at_its_turning_points() {
        let truth = Truth::of(0.1, 1_000.0);
        let decay = truth.free_decay().unwrap();
        for point in decay.turning_points().take(150) {
            let envelope = truth.amplitude(point.time_s);
            assert!((point.position.abs() - envelope).abs() < 1e-12, "{point:?}, {envelope}");
        }
    }

    #[test]
    fn the_noise_has_unit_variance_and_no_mean() {
        let mut noise = Noise(1);
        let draws: Vec<f64> = (0..100_000).map(|_| noise.normal()).collect();
        let mean = draws.iter().sum::<f64>() / 1e5;
        let variance = draws.iter().map(|z| z * z).sum::<f64>() / 1e5;
        // Five standard errors of mean and variance.
        assert!(mean.abs() < 0.016, "{mean} {variance}");
        assert!((variance - 1.0).abs() < 0.023, "{mean} {variance}");
    }
}
