//! Readings of an instrument: amplitude and phase over frequency, or over the drive.

use super::{HarmonicDrive, Phasor, solve_with_friction};
use crate::error::Error;
use crate::model::oscillator::{Oscillator, above_zero};
use crate::motion::simulate::{Drive, EventKind, Friction, Harmonic, Motion};
use std::f64::consts::{PI, TAU};

/// One reading of a lock-in, with properties of the motion.
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
    /// Number of stops per cycle of the exact motion.
    pub stops: usize,
}

impl Reading {
    /// Amplitude of the fundamental, which a lock-in shows as R.
    pub fn amplitude(&self) -> f64 {
        self.fundamental.norm()
    }

    /// Phase of the fundamental relative to the drive, rad in (-pi, pi]; `None` for a mass at rest.
    pub fn phase_rad(&self) -> Option<f64> {
        // Without motion only rounding errors remain.
        (self.amplitude() > 1e-14 * self.drive_amplitude).then(|| self.fundamental.arg())
    }
}

/// Exact steady response at one frequency and drive, including stops: the reading of a lock-in after sufficient
/// waiting time.
///
/// # Errors
/// As [`solve`](super::solve()); [`Error::Parameter`] for a frequency or drive not above zero.
pub fn reading(oscillator: &Oscillator, drive_amplitude: f64, frequency_hz: f64) -> Result<Reading, Error> {
    reading_with_friction(oscillator, Friction::of(oscillator), drive_amplitude, frequency_hz)
}

/// [`reading`] with friction that differs between the directions.
///
/// # Errors
/// As [`reading`].
pub fn reading_with_friction(
    oscillator: &Oscillator,
    friction: Friction,
    drive_amplitude: f64,
    frequency_hz: f64,
) -> Result<Reading, Error> {
    above_zero("frequency_hz", frequency_hz)?;
    let drive = HarmonicDrive::new(drive_amplitude, TAU * frequency_hz)?;
    let state = solve_with_friction(oscillator, friction, &drive)?.state;
    Ok(Reading {
        frequency_hz,
        drive_amplitude,
        fundamental: state.harmonic(1),
        turning_amplitude: state.amplitude(),
        stops: state.stops(),
    })
}

/// Number of points per cycle over which the lock-in sums.
const POINTS: u32 = 64;

/// A slow sweep from one frequency to the other in `duration_s`, up or down, as made by an instrument: the motion
/// never settles completely, which is visible in a fast sweep.
///
/// The motion is exact ([`Drive::chirp`]) and starts from the steady state at the first frequency. `points` readings
/// are equidistant in frequency; each demodulates one cycle of the drive about its time. `turning_amplitude` is the
/// largest excursion in that cycle; `stops` is not counted (zero).
///
/// # Errors
/// [`Error::Parameter`] for values not above zero, fewer than two points, or more points than the sweep has cycles;
/// otherwise as [`solve`](super::solve()).
///
/// ```
/// # use slipfit::{Oscillator, motion::steady::scan};
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
    ends_hz: [f64; 2],
    duration_s: f64,
    points: u32,
) -> Result<Vec<Reading>, Error> {
    chirp_with_friction(oscillator, Friction::of(oscillator), drive_amplitude, ends_hz, duration_s, points)
}

/// [`chirp`] with friction that differs between the directions.
///
/// # Errors
/// As [`chirp`].
pub fn chirp_with_friction(
    oscillator: &Oscillator,
    friction: Friction,
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
    // Half a cycle is kept free at both ends, and a whole one between readings.
    let (first, last) = (0.5 / start_hz, duration_s - 0.5 / stop_hz);
    let lowest = start_hz.min(stop_hz);
    if last - first < f64::from(points - 1) / lowest {
        return Err(Error::Parameter {
            name: "points",
            value: f64::from(points),
            range: "at most one for each cycle of the sweep (raise sweep_time_s)",
        });
    }
    let first_drive = HarmonicDrive::new(drive_amplitude, from)?;
    let begin = solve_with_friction(oscillator, friction, &first_drive)?.state.state(0.0);
    let drive = Drive::chirp(drive_amplitude, from, to, 0.0, duration_s)?;
    let mut motion = Motion::with_friction(oscillator, friction, drive, 0.0, begin.0, begin.1)?;
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

/// Steps of frequency or amplitude with a finite wait at each, as made by an instrument. The motion continues from
/// step to step, so that incomplete settling is visible.
///
/// At each step, `(drive_amplitude, frequency_hz)`, the drive changes at once with continuous phase; after `wait_s`
/// one cycle is demodulated, and the next step follows. Before the first step the motion has settled at it.
/// `turning_amplitude` and `stops` are those of the demodulated cycle.
///
/// # Errors
/// [`Error::Parameter`] for a drive or frequency not above zero, or a negative wait; otherwise as
/// [`solve`](super::solve()).
///
/// ```
/// # use slipfit::{Oscillator, motion::simulate::Friction, motion::steady::scan};
/// let o = Oscillator::builder().frequency_hz(1.0).q_factor(50.0).friction_displacement(0.3).build()?;
/// let steps: Vec<_> = (0..21).map(|i| (1.0, 0.97 + 0.003 * f64::from(i))).collect();
/// let friction = Friction::of(&o);
/// let top = |wait_s| -> Result<f64, slipfit::Error> {
///     let all = scan::stepped(&o, friction, &steps, wait_s)?;
///     Ok(all.iter().map(|r| r.amplitude()).fold(0.0, f64::max))
/// };
/// // Too short a wait, and the resonance is never reached.
/// assert!(top(2.0)? < 0.9 * top(200.0)?);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn stepped(
    oscillator: &Oscillator,
    friction: Friction,
    steps: &[(f64, f64)],
    wait_s: f64,
) -> Result<Vec<Reading>, Error> {
    crate::model::oscillator::at_least_zero("wait_s", wait_s)?;
    let Some(&(drive_amplitude, frequency_hz)) = steps.first() else { return Ok(Vec::new()) };
    above_zero("frequency_hz", frequency_hz)?;
    let first = HarmonicDrive::new(drive_amplitude, TAU * frequency_hz)?;
    let mut state = solve_with_friction(oscillator, friction, &first)?.state.state(0.0);
    let mut phase = 0.0f64;
    let n = f64::from(POINTS);
    steps
        .iter()
        .map(|&(drive_amplitude, frequency_hz)| {
            above_zero("frequency_hz", frequency_hz)?;
            let omega = HarmonicDrive::new(drive_amplitude, TAU * frequency_hz)?.omega();
            let drive = Drive::harmonics(0.0, &[Harmonic { amplitude: drive_amplitude, omega, phase }])?;
            // Each step counts its own time, so that no phase accuracy is lost over a long scan.
            let mut motion = Motion::with_friction(oscillator, friction, drive, 0.0, state.0, state.1)?;
            let end = wait_s + 1.0 / frequency_hz;
            let mut events = motion.clone();
            let (mut stops, mut largest) = (0, 0.0f64);
            while let Some(e) = events.next_event(end) {
                if e.time_s >= wait_s {
                    stops += usize::from(matches!(e.kind, EventKind::Stop | EventKind::Rest));
                    largest = largest.max(e.position.abs());
                }
            }
            let mut sum = Phasor::default();
            for j in 0..POINTS {
                let t = wait_s + (f64::from(j) + 0.5) / n / frequency_hz;
                let x = motion.state_at(t)?.position;
                largest = largest.max(x.abs());
                sum += Phasor::from_polar(x, -(omega * t + phase) % TAU);
            }
            let last = motion.state_at(end)?;
            state = (last.position, last.velocity);
            phase = (omega * end + phase) % TAU;
            Ok(Reading {
                frequency_hz,
                drive_amplitude,
                fundamental: sum * (2.0 / n),
                turning_amplitude: largest,
                stops,
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
        assert_eq!((r.turning_amplitude, r.phase_rad()), (0.0, None));
        assert!(r.amplitude() < 1e-15);
    }

    #[test]
    fn at_resonance_the_response_lags_by_a_quarter() {
        let r = reading(&Oscillator::builder().frequency_hz(2.0).q_factor(30.0).build().unwrap(), 1.0, 2.0);
        let r = r.unwrap();
        assert!((r.phase_rad().unwrap().to_degrees() + 90.0).abs() < 1e-9);
        assert!((r.amplitude() - 30.0).abs() < 1e-9);
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
    fn steps_with_a_long_wait_are_settled_and_with_a_short_one_are_not() {
        let o = oscillator();
        let steps: Vec<(f64, f64)> = (0..9).map(|i| (1.0, 1.9 + 0.025 * f64::from(i))).collect();
        let off = |wait_s: f64| {
            let all = stepped(&o, Friction::of(&o), &steps, wait_s).unwrap();
            let far = |r: &Reading| {
                let s = reading(&o, 1.0, r.frequency_hz).unwrap();
                // 64 points per cycle resolve a sine; the kinks of friction leave an error of about 1e-5.
                (r.fundamental - s.fundamental).norm() / s.amplitude()
            };
            all.iter().map(far).fold(0.0, f64::max)
        };
        assert!(off(200.0) < 1e-4, "{}", off(200.0));
        assert!(off(1.0) > 0.1, "{}", off(1.0));
        let levels: Vec<(f64, f64)> = (1..6).map(|i| (0.3 * f64::from(i), 2.0)).collect();
        let all = stepped(&o, Friction::of(&o), &levels, 100.0).unwrap();
        assert!(all[0].amplitude() < 1e-12, "below the threshold");
        assert!((all[4].amplitude() / reading(&o, 1.5, 2.0).unwrap().amplitude() - 1.0).abs() < 1e-4);
        assert!(stepped(&o, Friction::of(&o), &steps, -1.0).is_err());
        assert!(stepped(&o, Friction::of(&o), &[], 1.0).unwrap().is_empty());
    }

    #[test]
    fn asymmetric_friction_of_one_value_changes_little_more_than_the_mean() {
        // At resonance the loss depends on the mean of the two, the mid-line on their difference.
        let o = oscillator();
        let uneven = Friction::asymmetric([0.5, 0.3], [0.5, 0.3]).unwrap();
        let a = reading_with_friction(&o, uneven, 1.0, 2.0).unwrap();
        let b = reading(&o, 1.0, 2.0).unwrap();
        assert!((a.amplitude() / b.amplitude() - 1.0).abs() < 1e-3, "{a:?} {b:?}");
        let drive = HarmonicDrive::new(1.0, TAU * 2.0).unwrap();
        let state = solve_with_friction(&o, uneven, &drive).unwrap().state;
        assert!((state.harmonic(0).re + 0.1).abs() < 1e-12, "{}", state.harmonic(0));
        let loss = state.loss();
        assert!((loss.total() / state.work() - 1.0).abs() < 1e-9, "{loss:?} {}", state.work());
    }

    #[test]
    fn more_readings_than_cycles_are_refused() {
        let e = chirp(&oscillator(), 1.0, [1.9, 2.1], 10.0, 100).unwrap_err();
        assert!(matches!(e, Error::Parameter { name: "points", .. }), "{e}");
        assert!(chirp(&oscillator(), 1.0, [1.9, f64::NAN], 10.0, 3).is_err());
    }
}
