//! Records of amplitudes: a bare envelope, or the two outputs of a lock-in amplifier.

use super::block_amplitudes::BlockAmplitudes;
use super::criteria::{BlockCriteria, Criteria};
use super::measured::MeasuredDecay;
use super::options::Options;
use super::samples::Samples;
use super::window::decide;
use crate::numeric::robust::{median, neighbour_noise};
use crate::signal::blocks::Block;
use crate::signal::criteria::PhaseCriteria;
use crate::signal::phase::{self, PhaseLaw};
use crate::{Error, SignalKind};
use std::f64::consts::{SQRT_2, TAU};
use std::ops::Range;

/// Amplitudes along the free decay of a record of amplitudes.
pub(crate) fn measure(
    samples: &Samples,
    kind: SignalKind,
    options: &Options,
    criteria: &Criteria,
) -> Result<MeasuredDecay, Error> {
    match (kind, samples.quadrature.as_deref()) {
        (SignalKind::Envelope, _) => envelope(samples, options, criteria),
        (_, Some(quadrature)) => lock_in(samples, quadrature, options, criteria),
        (_, None) => {
            Err(Error::MissingParameter { name: "quadrature", hint: "a lock-in record needs both outputs" })
        }
    }
}

/// Whether samples not declared as amplitudes may be such: none is negative, and they fall along the whole
/// record.
pub(crate) fn may_be_amplitudes(signal: &[f64], criteria: &BlockCriteria) -> bool {
    let parts = criteria.recorded_parts.max(1);
    if signal.len() < 2 * parts || signal.iter().any(|v| *v < 0.0) {
        return false;
    }
    let middles: Vec<f64> =
        signal.chunks(signal.len().div_ceil(parts)).filter_map(|part| median(&mut part.to_vec())).collect();
    let (Some(first), Some(last)) = (middles.first(), middles.last()) else { return false };
    let falls = |pair: &[f64]| pair[1] <= pair[0] + criteria.recorded_rise * first;
    *last < criteria.recorded_fall * first && middles.windows(2).all(falls)
}

/// A bare envelope: means of R² over blocks, so that the noise adds a constant (`E[R²] = A² + 2 sigma²`) at
/// any amplitude.
fn envelope(samples: &Samples, options: &Options, criteria: &Criteria) -> Result<MeasuredDecay, Error> {
    let noise_rms = neighbour_noise(samples.signal.windows(3)).unwrap_or(0.0);
    let all: Vec<Block> = ranges(samples, criteria.blocks.recorded_blocks)
        .map(|range| {
            let block = empty_block(samples, &range);
            let square = samples.signal[range].iter().map(|v| v * v).sum::<f64>() / block.dof;
            Block { amplitude: square.sqrt(), omega: f64::NAN, ..block }
        })
        .collect();
    let c = &criteria.blocks;
    let mut sorted: Vec<f64> = all.iter().map(|b| b.amplitude).collect();
    sorted.sort_by(f64::total_cmp);
    let (low, top) = (
        sorted[(sorted.len() / c.envelope_floor_fraction.max(1)).min(sorted.len() - 1)],
        sorted[sorted.len() - 1],
    );
    let floor = |error: f64| low.min(c.envelope_floor_of_top * top) + c.envelope_floor_errors * error;
    let omega = angular_frequency(samples, options);
    let amplitudes = BlockAmplitudes {
        level: SQRT_2 * noise_rms,
        ..BlockAmplitudes::with_floor(&all, omega, noise_rms, floor)
    };
    let window = decide::of_amplitudes(&amplitudes, options, criteria)?;
    let points = all[window.first..window.end].to_vec();
    let time_variance_s2 = time_variance(&points);
    Ok(MeasuredDecay {
        all,
        window,
        points,
        law: constant_frequency(omega),
        phase_follows_law: true,
        noise_rms,
        root_mean_squares: true,
        time_variance_s2,
        periodogram: None,
    })
}

/// The two outputs of a lock-in, along the smooth phase of their beat.
fn lock_in(
    samples: &Samples,
    quadrature: &[f64],
    options: &Options,
    criteria: &Criteria,
) -> Result<MeasuredDecay, Error> {
    let noise_rms = neighbour_noise(samples.signal.windows(3).chain(quadrature.windows(3))).unwrap_or(0.0);
    let mut all: Vec<Block> = Vec::new();
    for range in ranges(samples, criteria.blocks.recorded_blocks) {
        let block = empty_block(samples, &range);
        let mean = |v: &[f64]| v.iter().sum::<f64>() / block.dof;
        let (p, q) = (mean(&samples.signal[range.clone()]), mean(&quadrature[range]));
        let mut phase = q.atan2(p);
        if let Some(last) = all.last() {
            phase += TAU * ((last.phase - phase) / TAU).round();
        }
        all.push(Block { amplitude: p.hypot(q), phase, ..block });
    }
    let omega = angular_frequency(samples, options);
    let floor = |error: f64| criteria.blocks.floor_errors * error;
    let amplitudes = BlockAmplitudes::with_floor(&all, omega, noise_rms, floor);
    let window = decide::of_amplitudes(&amplitudes, options, criteria)?;
    let mut points = all[window.first..window.end].to_vec();
    let time_variance_s2 = time_variance(&points);
    let phases = beat_phases(&points, omega, noise_rms, &criteria.phase);
    for (point, phase) in points.iter_mut().zip(phases) {
        let turn = point.phase - phase;
        point.quadrature = point.amplitude * turn.sin();
        point.amplitude *= turn.cos();
    }
    Ok(MeasuredDecay {
        all,
        window,
        points,
        law: constant_frequency(omega),
        phase_follows_law: true,
        noise_rms,
        root_mean_squares: false,
        time_variance_s2,
        periodogram: None,
    })
}

/// Smooth phases of a lock-in's blocks: the phase law of the oscillation minus the phase of a reference at
/// `omega`, whichever of the two is faster.
fn beat_phases(points: &[Block], omega: f64, noise_rms: f64, criteria: &PhaseCriteria) -> Vec<f64> {
    let Some(origin) = points.first().map(|b| b.time_s) else { return Vec::new() };
    let reference = |b: &Block| omega * (b.time_s - origin);
    let oscillation: Vec<Block> =
        points.iter().map(|b| Block { phase: b.phase + reference(b), omega, ..*b }).collect();
    let modulus: Vec<f64> = points.iter().map(|b| b.amplitude).collect();
    match phase::smooth(&oscillation, &modulus, noise_rms, criteria) {
        Some(smooth) => smooth.at.iter().zip(points).map(|(at, b)| at.phase - reference(b)).collect(),
        None => points.iter().map(|b| b.phase).collect(),
    }
}

/// Ranges of equal length that contain all samples except possibly the last few.
fn ranges(samples: &Samples, most: usize) -> impl Iterator<Item = Range<usize>> {
    let n = samples.len();
    let width = n.div_ceil(most).max(1);
    (0..n).step_by(width).map(move |first| first..first + width).filter(move |r| r.end <= n)
}

/// A block of independent samples; its amplitude will be their mean.
fn empty_block(samples: &Samples, range: &Range<usize>) -> Block {
    let time = &samples.time[range.clone()];
    let count = range.len() as f64;
    Block {
        span_s: time[time.len() - 1] - time[0],
        unit_variance: 1.0 / count,
        dof: count,
        ..Block::of(range.start, range.end, time.iter().sum::<f64>() / count)
    }
}

/// Variance of the times of a block's samples, evenly spaced, s².
fn time_variance(blocks: &[Block]) -> f64 {
    blocks
        .first()
        .filter(|b| b.dof > 1.0)
        .map_or(0.0, |b| b.span_s.powi(2) * (b.dof + 1.0) / (b.dof - 1.0) / 12.0)
}

/// Angular frequency of the oscillation; if unknown, a value so high that only the loss rate matters.
fn angular_frequency(samples: &Samples, options: &Options) -> f64 {
    options.frequency_hz.map_or(1e6 * samples.len() as f64 / samples.duration(), |f| TAU * f)
}

fn constant_frequency(omega: f64) -> PhaseLaw {
    PhaseLaw { omega, mean_omega: omega, ..PhaseLaw::default() }
}

#[cfg(test)]
mod tests {
    use crate::answer::hint::{Analysis, Hint};
    use crate::motion::decay::AmplitudeLaw;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{EndReason, Options, analyse};
    use crate::{Parameter, Record, SignalKind};

    /// A lock-in at 20 dB, with a slight frequency offset of its reference, followed into the noise: phases
    /// that follow the noise would make the amplitudes fall as friction does.
    #[test]
    fn noise_in_the_phase_of_a_lock_in_is_no_friction() {
        let (samples, decay_times, noise) = (1145, 3.0, 0.07);
        let time: Vec<f64> = (0..samples).map(|i| i as f64).collect();
        let delta = decay_times / samples as f64;
        let record = |repeat: usize| {
            let output = |k: u64, angle: f64| {
                let at = |(i, t): (usize, &f64)| {
                    let phase = 0.7 + 0.4 * delta * t - angle;
                    (-delta * t).exp() * phase.cos() + noise * jitter(repeat * samples + i, k)
                };
                time.iter().enumerate().map(at).collect::<Vec<f64>>()
            };
            let (x, y) = (output(1, 0.0), output(2, std::f64::consts::FRAC_PI_2));
            Record::lock_in(time.clone(), x, y).expect("valid")
        };
        let options = Options { frequency_hz: Some(0.25), ..Options::default() };
        assert_held(record, &options, Parameter::DECAY_RATE, delta);
    }

    #[test]
    fn unlabelled_amplitudes_are_refused_with_a_hint() {
        let time: Vec<f64> = (0..600).map(|i| 0.05 * f64::from(i)).collect();
        let falls = |t: f64, friction: f64| (10.0 * (-0.1 * t).exp() - friction * t).max(0.0);
        let error_of = |value: &dyn Fn(usize, f64) -> f64| {
            let signal: Vec<f64> = time.iter().enumerate().map(|(i, t)| value(i, *t)).collect();
            let record = Record::new(time.clone(), signal).expect("valid");
            analyse(&record, &Options::default()).err()
        };
        for friction in [0.0, 0.02, 0.4] {
            for noise in [0.0, 0.05] {
                let error = error_of(&|i, t| (falls(t, friction) + noise * jitter(i, 7)).abs())
                    .expect("no oscillation");
                let advice = Hint::new("kind", "takes them as amplitudes").with("envelope");
                assert_eq!(error.hints(Analysis::Ringdown)[0], advice, "{friction} {noise}");
            }
        }
        // A level that falls through zero, a constant level, and a rising level.
        for other in [
            &|i: usize, t: f64| falls(t, 0.0) - 4.0 + 0.05 * jitter(i, 7),
            &|i: usize, _: f64| 5.0 + 0.05 * jitter(i, 7),
            &|i: usize, t: f64| 5.0 + t + 0.05 * jitter(i, 7),
        ] as [&dyn Fn(usize, f64) -> f64; 3]
        {
            let error = error_of(other).expect("no oscillation");
            assert!(!error.hints(Analysis::Ringdown).iter().any(|hint| hint.value.is_some()), "{error}");
        }
        assert!(error_of(&|_, t| 20.0 + falls(t, 0.0) * (6.0 * t).cos()).is_none());
    }

    /// Many amplitudes per block, at 35 dB, long after friction has stopped the motion: the readings due to
    /// noise must not be taken for a slower decay.
    #[test]
    fn the_noise_after_a_stop_is_no_slow_tail() {
        let (samples, noise) = (54_000, 0.017);
        let (delta, friction) = (3.8e-3, 1.5e-2);
        let law = AmplitudeLaw::new(1.0, friction, delta, 0.0).expect("valid");
        let time: Vec<f64> = (0..samples).map(|i| f64::from(i) / 46.0).collect();
        let misses = |repeat: usize| {
            let output = |i: usize, k: u64| noise * jitter(repeat * time.len() + i, k);
            let at = |(i, t): (usize, &f64)| (law.amplitude(*t).max(0.0) + output(i, 3)).hypot(output(i, 4));
            let amplitudes = time.iter().enumerate().map(at).collect();
            let record =
                Record::new(time.clone(), amplitudes).expect("valid").with_kind(SignalKind::Envelope);
            let answer = analyse(&record, &Options::default()).expect("fits");
            let end = answer.segment.end_reason;
            assert!(matches!(end, EndReason::Noise | EndReason::Rest), "record {repeat}: {end:?}");
            let found = answer.parameter(Parameter::SlidingRate).expect("always reported");
            !(found.interval_95[0]..=found.interval_95[1]).contains(&friction)
        };
        assert!((0..12).filter(|repeat| misses(*repeat)).count() <= 3);
    }

    /// Amplitudes at 20 dB, followed far into the noise; the last one is twice the level of the rest, as is
    /// one in twenty.
    #[test]
    fn the_rest_of_an_envelope_is_no_part_of_its_fall() {
        let (samples, share, noise) = (286, 0.25, 0.1);
        let delta = 6.0 / samples as f64;
        let friction = share * delta * std::f64::consts::PI / (2.0 * std::f64::consts::TAU);
        let law = AmplitudeLaw::new(1.0, share * delta, delta, 0.0).expect("valid");
        let time: Vec<f64> = (0..samples).map(|i| i as f64).collect();
        let record = |repeat: usize| {
            let output = |i: usize, k: u64| noise * jitter(repeat * samples + i, k);
            let at = |(i, t): (usize, &f64)| (law.amplitude(*t).max(0.0) + output(i, 3)).hypot(output(i, 4));
            let mut amplitudes: Vec<f64> = time.iter().enumerate().map(at).collect();
            amplitudes[samples - 1] = 2.5 * noise;
            Record::new(time.clone(), amplitudes).expect("valid").with_kind(SignalKind::Envelope)
        };
        let options = Options { frequency_hz: Some(1.0), ..Options::default() };
        assert_held(record, &options, Parameter::FRICTION_DISPLACEMENT, friction);
    }
}
