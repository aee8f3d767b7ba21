//! What an instrument shows: amplitude and phase over frequency, or over the drive.

use super::{HarmonicDrive, Phasor, solve};
use crate::error::Error;
use crate::oscillator::{Oscillator, above_zero};
use crate::simulate::{Drive, Motion};
use std::f64::consts::{PI, TAU};

/// One reading of a lock-in, with the motion behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Frequency of the drive, Hz.
    pub frequency_hz: f64,
    /// Amplitude of the drive `x_0`.
    pub drive_amplitude: f64,
    /// The fundamental, `x = Re X e^(i phase of the drive)`.
    pub fundamental: Phasor,
    /// Largest excursion of the exact motion.
    pub turning_amplitude: f64,
    /// Stops in a cycle of the exact motion.
    pub stops: usize,
}

impl Reading {
    /// Amplitude of the fundamental, what a lock-in shows as R.
    pub fn amplitude(&self) -> f64 {
        self.fundamental.norm()
    }

    /// Phase of the fundamental against the drive, degrees in (-180, 180]; zero at rest.
    pub fn phase_deg(&self) -> f64 {
        // Without motion what is left is rounding.
        if self.amplitude() <= 1e-14 * self.drive_amplitude {
            0.0
        } else {
            self.fundamental.arg().to_degrees()
        }
    }
}

/// Steady response at one frequency and drive, exact, stops included: what a lock-in
/// shows once it has waited long enough.
///
/// # Errors
/// As [`solve`]; [`Error::Parameter`] for a frequency or drive not above zero.
pub fn reading(oscillator: &Oscillator, drive_amplitude: f64, frequency_hz: f64) -> Result<Reading, Error> {
    above_zero("frequency_hz", frequency_hz)?;
    let state = solve(oscillator, &HarmonicDrive::new(drive_amplitude, TAU * frequency_hz)?)?.state;
    Ok(Reading {
        frequency_hz,
        drive_amplitude,
        fundamental: state.harmonic(1),
        turning_amplitude: state.amplitude(),
        stops: state.stops(),
    })
}

/// Points of a cycle the lock-in sums over.
const POINTS: u32 = 64;

/// A slow sweep from one frequency to the other in `duration_s`, up or down, as an
/// instrument makes it: the motion never settles, and a fast sweep shows it.
///
/// The motion is exact ([`Drive::chirp`]) from the steady state of the first frequency on.
/// `points` readings lie evenly in frequency; each demodulates one cycle of the drive
/// about its instant. `turning_amplitude` is the largest excursion seen there, `stops` is
/// not counted (zero).
///
/// # Errors
/// [`Error::Parameter`] for values not above zero, fewer than two points, or more points
/// than the sweep has cycles; else as [`solve`].
///
/// ```
/// # use slipfit::{Oscillator, steady::scan};
/// let o = Oscillator::builder().frequency_hz(1.0).q_factor(50.0).friction_displacement(0.5).build()?;
/// // Slow enough, a sweep shows the steady curve.
/// let swept = scan::chirp(&o, 1.0, [0.97, 1.03], 20_000.0, 21)?;
/// let steady = scan::reading(&o, 1.0, swept[10].frequency_hz)?;
/// assert!((swept[10].amplitude() / steady.amplitude() - 1.0).abs() < 1e-3);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn chirp(
    oscillator: &Oscillator,
    drive_amplitude: f64,
    [start_hz, stop_hz]: [f64; 2],
    duration_s: f64,
    points: u32,
) -> Result<Vec<Reading>, Error> {
    above_zero("start_hz", start_hz)?;
    above_zero("stop_hz", stop_hz)?;
    above_zero("sweep_time_s", duration_s)?;
    if points < 2 {
        return Err(Error::Parameter { name: "points", value: f64::from(points), range: "2 or more" });
    }
    let (from, to) = (TAU * start_hz, TAU * stop_hz);
    // Half a cycle is kept free at both ends, a whole one between readings.
    let (first, last) = (0.5 / start_hz, duration_s - 0.5 / stop_hz);
    let lowest = start_hz.min(stop_hz);
    if last - first < f64::from(points - 1) / lowest {
        return Err(Error::Parameter {
            name: "points",
            value: f64::from(points),
            range: "at most one for each cycle of the sweep (raise sweep_time_s)",
        });
    }
    let begin = solve(oscillator, &HarmonicDrive::new(drive_amplitude, from)?)?.state.state(0.0);
    let drive = Drive::chirp(drive_amplitude, from, to, 0.0, duration_s)?;
    let mut motion = Motion::new(oscillator, drive, 0.0, begin.0, begin.1)?;
    let rate = (to - from) / duration_s;
    let phase_at = |t: f64| t * (from + 0.5 * rate * t);
    // The root of rate t²/2 + from t = phase that lies in the sweep, without cancellation.
    let time_of = |phase: f64| 2.0 * phase / (from + (from * from + 2.0 * rate * phase).max(0.0).sqrt());
    let n = f64::from(POINTS);
    (0..points)
        .map(|i| {
            let middle = first + (last - first) * f64::from(i) / f64::from(points - 1);
            let centre = phase_at(middle);
            let (mut sum, mut largest) = (Phasor::default(), 0.0f64);
            for j in 0..POINTS {
                let phase = centre + TAU * ((f64::from(j) + 0.5) / n) - PI;
                let x = motion.state_at(time_of(phase))?.position;
                largest = largest.max(x.abs());
                sum += Phasor::from_polar(x, -phase);
            }
            Ok(Reading {
                frequency_hz: (from + rate * middle) / TAU,
                drive_amplitude,
                fundamental: sum * (2.0 / n),
                turning_amplitude: largest,
                stops: 0,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn oscillator() -> Oscillator {
        Oscillator::builder().frequency_hz(2.0).q_factor(30.0).friction_displacement(0.4).build().unwrap()
    }

    #[test]
    fn a_level_below_the_threshold_reads_zero() {
        let r = reading(&oscillator(), 0.3, 2.0).unwrap();
        assert_eq!((r.turning_amplitude, r.phase_deg()), (0.0, 0.0));
        assert!(r.amplitude() < 1e-15);
    }

    #[test]
    fn at_resonance_the_response_lags_by_a_quarter() {
        let r = reading(&Oscillator::builder().frequency_hz(2.0).q_factor(30.0).build().unwrap(), 1.0, 2.0);
        let r = r.unwrap();
        assert!((r.phase_deg() + 90.0).abs() < 1e-9 && (r.amplitude() - 30.0).abs() < 1e-9);
    }

    #[test]
    fn sweeps_up_and_down_meet_the_steady_curve_when_slow() {
        let o = oscillator();
        for ends in [[1.9, 2.1], [2.1, 1.9]] {
            for r in chirp(&o, 1.0, ends, 20_000.0, 9).unwrap() {
                let s = reading(&o, 1.0, r.frequency_hz).unwrap();
                let off = (r.fundamental - s.fundamental).norm() / s.amplitude();
                assert!(off < 5e-3, "{} {off}", r.frequency_hz);
            }
        }
    }

    #[test]
    fn a_fast_sweep_lags_behind() {
        let o = oscillator();
        let top = |ends| {
            let all = chirp(&o, 1.0, ends, 100.0, 101).unwrap();
            all.into_iter().max_by(|a, b| a.amplitude().total_cmp(&b.amplitude())).unwrap().frequency_hz
        };
        assert!(top([1.8, 2.2]) > top([2.2, 1.8]) + 0.005);
    }

    #[test]
    fn more_readings_than_cycles_are_refused() {
        let e = chirp(&oscillator(), 1.0, [1.9, 2.1], 10.0, 100).unwrap_err();
        assert!(matches!(e, Error::Parameter { name: "points", .. }), "{e}");
        assert!(chirp(&oscillator(), 1.0, [1.9, f64::NAN], 10.0, 3).is_err());
    }
}
