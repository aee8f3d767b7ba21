//! Measurement of the amplitudes along the free decay of an oscillating record.

use super::criteria::Criteria;
use super::measured::MeasuredDecay;
use super::options::Options;
use super::samples::Samples;
use super::window::{DecayWindow, StartReason, decide};
use crate::Error;
use crate::signal::blocks::{self, Block, Cut, PhaseAt};
use crate::signal::phase::{self, PhaseLaw};
use crate::signal::spectrum::{self, Periodogram};
use std::ops::Range;
use std::sync::Arc;

/// Amplitudes of blocks along the free decay. If the decay is a small part of the record, the samples are
/// limited to it and its surroundings: the length of a block scales with that of the record, and the law must
/// not change within a block.
pub(crate) fn measure(
    samples: &mut Samples,
    options: &Options,
    criteria: &Criteria,
) -> Result<MeasuredDecay, Error> {
    let periodogram = Periodogram::of(&samples.time, &samples.signal).map(Arc::new);
    let frequency_hz = periodogram
        .as_ref()
        .and_then(|p| {
            spectrum::dominant_of(p, &samples.time, &samples.signal, options.band_hz, &criteria.spectrum)
        })
        .map(|line| line.frequency_hz)
        .filter(|f| *f > 0.0 && f.is_finite())
        .ok_or(Error::NoOscillation {
            reason: "the spectrum has no line apart from that of the record's length",
        })?;
    let mut whole = along_decay(samples, frequency_hz, options, criteria)?;
    whole.periodogram = periodogram;
    let Some(range) = surroundings(&whole, samples, frequency_hz, criteria.blocks.recut_factor) else {
        return Ok(whole);
    };
    let part = samples.part(range);
    match along_decay(&part, frequency_hz, options, criteria) {
        Ok(closer) => {
            *samples = part;
            Ok(closer)
        }
        Err(_) => Ok(whole),
    }
}

/// The same free decay, started at the beginning of the record.
pub(crate) fn from_the_first_block(
    samples: &Samples,
    found: &MeasuredDecay,
    criteria: &Criteria,
) -> Option<MeasuredDecay> {
    let last = found.points.last()?;
    let end = found.all.iter().position(|b| b.end >= last.end)? + 1;
    let window = DecayWindow { first: 0, end, start_reason: StartReason::RecordStart, ..found.window };
    let along = project(samples, &found.all[..end], found.noise_rms, criteria).ok()?;
    let Projected { points, law, follows_law } = along;
    Some(MeasuredDecay {
        all: found.all.clone(),
        window,
        points,
        law,
        phase_follows_law: follows_law,
        periodogram: found.periodogram.clone(),
        ..*found
    })
}

/// The decay with equal lengths before and after it, if blocks chosen for that part alone are shorter by at
/// least `factor`.
fn surroundings(
    found: &MeasuredDecay,
    samples: &Samples,
    frequency_hz: f64,
    factor: f64,
) -> Option<Range<usize>> {
    let decay = &found.all[found.window.first..found.window.end];
    let (first, last) = (decay.first()?.first, decay.last()?.end.min(samples.len()) - 1);
    let (from_s, to_s) = (samples.time[first], samples.time[last]);
    let length_s = to_s - from_s;
    let from = samples.time.partition_point(|t| *t < from_s - length_s);
    let end = samples.time.partition_point(|t| *t <= to_s + length_s);
    let cycles = |samples: usize, span_s: f64| Cut::for_record(span_s, samples, frequency_hz).cycles;
    let whole = cycles(samples.len(), samples.duration());
    let part = cycles(end - from, samples.time[end - 1] - samples.time[from]);
    (factor * part <= whole).then_some(from..end)
}

/// Blocks along the record, its free decay, and the amplitudes of the decay along a smooth phase.
fn along_decay(
    samples: &Samples,
    frequency_hz: f64,
    options: &Options,
    criteria: &Criteria,
) -> Result<MeasuredDecay, Error> {
    let cut = Cut::for_record(samples.duration(), samples.len(), frequency_hz);
    let follow = |cut: Cut| Followed::new(samples, frequency_hz, cut, options, criteria);
    let mut found = follow(cut)?;
    // If single blocks are uncertain, longer ones determine start, end and phase more accurately.
    let longer = (found.relative_error / criteria.blocks.relative_error).powi(2);
    let longest = found.visible as f64 / criteria.blocks.least_visible as f64;
    let longer = longer.min(longest).floor();
    if longer >= 2.0
        && let Ok(surer) = follow(Cut { cycles: cut.cycles * longer, ..cut })
    {
        found = surer;
    }
    let Followed { blocks: all, window, .. } = found;
    let decay = &all[window.first..window.end];
    let noise_rms = |blocks: &[Block]| samples.noise_rms(blocks);
    let Projected { points, law, follows_law } = project(samples, decay, noise_rms(&all), criteria)?;
    let noise_rms = noise_rms(&points);
    let time_variance_s2 = points.first().map_or(0.0, |b| b.span_s.powi(2) / 12.0);
    Ok(MeasuredDecay {
        all,
        window,
        points,
        law,
        phase_follows_law: follows_law,
        noise_rms,
        root_mean_squares: false,
        time_variance_s2,
        periodogram: None,
    })
}

/// A record divided into blocks, and the free decay among them.
struct Followed {
    blocks: Vec<Block>,
    window: DecayWindow,
    /// Relative error of the first amplitude.
    relative_error: f64,
    /// Number of amplitudes above the noise.
    visible: usize,
}

impl Followed {
    fn new(
        samples: &Samples,
        frequency_hz: f64,
        cut: Cut,
        options: &Options,
        criteria: &Criteria,
    ) -> Result<Self, Error> {
        let (low, high) = (criteria.blocks.tracking_low, criteria.blocks.tracking_high);
        let band_hz = options.band_hz.unwrap_or([low * frequency_hz, high * frequency_hz]);
        let blocks = blocks::track(&samples.time, &samples.signal, frequency_hz, band_hz, cut);
        if blocks.len() < criteria.blocks.least_blocks {
            return Err(Error::NotARingDown {
                cycles: samples.duration() * frequency_hz,
                needed: criteria.blocks.least_cycles,
                reason: "too few samples or cycles to follow an oscillation",
            });
        }
        let (window, amplitudes) = decide::of_oscillation(&blocks, samples, frequency_hz, options, criteria)?;
        let relative_error =
            amplitudes.error[window.first] / amplitudes.amplitude(window.first).max(f64::MIN_POSITIVE);
        let visible = (0..blocks.len()).filter(|&i| amplitudes.amplitude(i) > amplitudes.floor[i]).count();
        Ok(Self { window, relative_error, visible, blocks })
    }
}

/// Amplitudes as projections on a smooth phase.
struct Projected {
    points: Vec<Block>,
    law: PhaseLaw,
    follows_law: bool,
}

fn project(
    samples: &Samples,
    blocks: &[Block],
    noise_rms: f64,
    criteria: &Criteria,
) -> Result<Projected, Error> {
    let modulus: Vec<f64> = blocks.iter().map(|b| b.amplitude).collect();
    let smooth = phase::smooth(blocks, &modulus, noise_rms, &criteria.phase)
        .ok_or(Error::NoFit { reason: "the phase of the oscillation cannot be followed" })?;
    let mut phases: Vec<PhaseAt> = smooth.at;
    let mut loss = 0.0;
    for (j, phase) in phases.iter_mut().enumerate() {
        let (a, b) = (j.saturating_sub(2), (j + 2).min(blocks.len() - 1));
        let span = blocks[b].time_s - blocks[a].time_s;
        let slope = (modulus[a].max(f64::MIN_POSITIVE) / modulus[b].max(f64::MIN_POSITIVE)).ln() / span;
        let most = 1.0 / blocks[j].span_s;
        // In the noise the slope of the modulus is meaningless; the last known slope is continued.
        let visible = |i: usize| modulus[i] > criteria.blocks.loss_errors * blocks[i].std_error(noise_rms);
        if visible(a) && visible(b) && slope.is_finite() {
            loss = slope.clamp(-most, most);
        }
        phase.loss = loss.clamp(-most, most);
        if !phase.omega.is_finite() {
            phase.omega = blocks[j].omega;
        }
    }
    let mut points = blocks::demodulate(&samples.time, &samples.signal, blocks, &phases);
    let mut law = smooth.law;
    let order = samples.observable.order();
    if smooth.follows_law && order > 0 {
        at_one_frequency(&mut points, &mut law, order);
    }
    Ok(Projected { points, law, follows_law: smooth.follows_law })
}

/// Fraction of the largest amplitude at which the frequency shift is evaluated in addition to the largest
/// amplitude itself.
const WITHIN: f64 = 0.75;

/// Converts amplitudes of a derivative of this order to those at a constant frequency: a motion of amplitude
/// `A` has the velocity `omega A` and the acceleration `omega² A`, with `omega` that at `A`, and the losses
/// act on the motion.
fn at_one_frequency(points: &mut [Block], law: &mut PhaseLaw, order: i32) {
    let reference = law.reference_omega();
    let largest = points.iter().map(|b| b.amplitude.abs()).fold(0.0, f64::max);
    for b in points {
        let factor = (reference / b.omega).powi(order);
        b.amplitude *= factor;
        b.quadrature *= factor;
        b.unit_variance *= factor * factor;
    }
    // Shift as a function of `a = A (1 + shift)^order`, converted to one of `A`.
    let [(outer, square), (inner, within)] = [largest, WITHIN * largest].map(|a| {
        let shift = law.shift(a);
        let square = (a / (1.0 + shift).powi(order)).powi(2);
        (shift / square, square)
    });
    let quartic = (outer - inner) / (square - within);
    if order != 0 && quartic.is_finite() {
        (law.quadratic, law.quartic) = (outer - quartic * square, quartic);
    }
}

#[cfg(test)]
mod tests {
    use super::at_one_frequency;
    use crate::noise::{assert_held, jitter, motion};
    use crate::ringdown::{Options, analyse};
    use crate::signal::blocks::Block;
    use crate::signal::phase::PhaseLaw;
    use crate::{Parameter, Record, SignalKind};
    use std::f64::consts::TAU;

    /// Acceleration of a pendulum of 3.27 rad/s released at 40°, 60 s at 50 samples per second.
    fn acceleration(delta: f64) -> Vec<f64> {
        let force = |x: f64, v: f64| -2.0 * delta * v - 10.7 * x.sin();
        motion(force, 0.7, 3000, 1.0 / 50.0, 4).iter().map(|[x, v]| force(*x, *v)).collect()
    }

    /// As the amplitude falls, the frequency rises by 3 % and an acceleration by 6 %, which is not a loss.
    #[test]
    fn the_acceleration_of_a_pendulum_falls_by_its_losses_alone() {
        for delta in [0.009, 0.03] {
            let clean = acceleration(delta);
            let record = |repeat: usize| {
                let noisy = |(i, a): (usize, &f64)| a + 0.03 * jitter(i + clean.len() * repeat, 5);
                let signal = clean.iter().enumerate().map(noisy).collect();
                Record::uniform(50.0, signal).expect("valid").with_kind(SignalKind::Acceleration)
            };
            let options = Options::default();
            assert_held(record, &options, Parameter::DECAY_RATE, delta);
            assert_held(record, &options, Parameter::FRICTION_DISPLACEMENT, 0.0);
        }
    }

    /// Three hundred cycles from 60° at 46 dB: loss and frequency matter to second order, and the phase
    /// reaches two thousand radians, with each value known to a hundredth.
    #[test]
    fn a_pendulum_from_sixty_degrees_has_no_friction_and_no_drift() {
        let delta = 0.008;
        let clean = motion(|x, v| -2.0 * delta * v - 39.5 * x.sin(), 1.05, 7500, 0.04, 12);
        let record = |repeat: usize| {
            let noisy = |(i, [x, _]): (usize, &[f64; 2])| x + 5e-3 * jitter(i + clean.len() * repeat, 5);
            Record::uniform(25.0, clean.iter().enumerate().map(noisy).collect()).expect("valid")
        };
        let options = Options::default();
        let answer = analyse(&record(0), &options).expect("a ring-down");
        let backbone = answer.backbone.as_ref().expect("it swings");
        assert_eq!(backbone.drift_per_s, 0.0);
        assert!((backbone.quadratic * 16.0 + 1.0).abs() < 5e-3, "{backbone:?}");
        assert!((backbone.frequency_at_zero_hz / (39.5f64.sqrt() / TAU) - 1.0).abs() < 1e-4, "{backbone:?}");
        assert!(!answer.sliding.detected);
        // To first order the error would be 2 %.
        let found = answer.parameter(Parameter::DECAY_RATE).expect("always reported").value;
        assert!((found / delta - 1.0).abs() < 3e-3, "{found}");
        assert_held(record, &options, Parameter::FRICTION_DISPLACEMENT, 0.0);
    }

    /// Velocity and acceleration of a pendulum from 60°: the shift as a function of the amplitude of the
    /// motion, between the two amplitudes at which it is evaluated and below.
    #[test]
    fn the_shift_by_a_derivative_is_one_by_the_motion() {
        for (order, tolerance) in [(0, 1e-12), (1, 2e-4), (2, 7e-4)] {
            let recorded =
                PhaseLaw { omega: 6.0, quadratic: -0.0625, quartic: 9.5e-4, ..PhaseLaw::default() };
            // Amplitude of the motion, from that of the derivative divided by its rate at rest.
            let of_motion = |a: f64| a / (1.0 + recorded.shift(a)).powi(order);
            let largest = 1.05;
            let block = Block {
                amplitude: largest,
                omega: 6.0 * (1.0 + recorded.shift(largest)),
                ..Block::of(0, 1, 0.0)
            };
            let (mut points, mut law) = ([block], recorded);
            at_one_frequency(&mut points, &mut law, order);
            assert!((points[0].amplitude / of_motion(largest) - 1.0).abs() < 1e-12);
            for part in [0.2, 0.4, 0.6, 0.8, 1.0] {
                let a = part * largest;
                let (found, shift) = (law.shift(of_motion(a)), recorded.shift(a));
                assert!((found - shift).abs() < tolerance, "{order}, {part}: {found} for {shift}");
            }
        }
    }
}
