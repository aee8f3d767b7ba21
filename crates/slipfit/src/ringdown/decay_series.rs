//! Series along the decay: the fitted motion, amplitudes, losses, frequency and backbone.

use super::envelope::{X_F, averaging_bias};
use super::evidence::Evidence;
use super::fitted::{FittedMotion, Knot};
use super::quantities::frequency_known;
use super::residuals::remaining_fundamental;
use super::waveform::{BACKBONE, CHIRP, OFFSET, OMEGA, Observable};
use super::window_fit::Problem;
use super::{Backbone, EnvelopePoint, LossPoint};
use crate::inference::model_selection::ModelFit;
use crate::motion::decay::AmplitudeLaw;
use crate::motion::decay::backbone::backbone_factors;
use crate::motion::decay::drag::Slowing;
use crate::motion::decay::path::shifted;
use crate::numeric::order::sort_by_value;
use crate::signal::blocks::Block;
use std::f64::consts::{PI, TAU};

/// Number of phase knots along a fitted waveform.
const KNOTS: i32 = 1024;
/// Number of groups of points whose slopes give the losses, and minimum number of points per group.
const LOSS_GROUPS: usize = 24;
const LEAST_IN_GROUP: usize = 3;
/// Fraction of its standard error above which a difference in an amplitude is visible in the residuals.
const VISIBLE_DIFFERENCE: f64 = 0.1;

pub(crate) fn fitted_motion(e: &Evidence, chosen: &ModelFit, law: AmplitudeLaw, omega: f64) -> FittedMotion {
    let p = &chosen.bounded.parameters;
    let knots = match &e.fit.problem {
        Problem::Waveform(problem) => {
            let duration = e.fit.end - e.fit.origin;
            // If phase and offset are linear in time, two knots suffice.
            let straight = law.a2 == 0.0 && [BACKBONE, CHIRP, OFFSET + 2].iter().all(|k| p[*k] == 0.0);
            let count = if straight { 2 } else { KNOTS };
            let step = duration / f64::from(count - 1);
            let slowing = |t: f64| match law.a2 {
                0.0 => 0.0,
                drag => Slowing::new(law.amplitude(t), [law.a1, drag], omega).rate,
            };
            let (mut lag, mut before) = (0.0, slowing(0.0));
            let lead = problem.observable.phase_lead();
            (0..count)
                .map(|i| {
                    let t = duration * f64::from(i) / f64::from(count - 1);
                    let time_s = e.fit.origin + t;
                    let here = slowing(t);
                    if i > 0 {
                        lag += step / 6.0 * (before + 4.0 * slowing(t - 0.5 * step) + here);
                    }
                    before = here;
                    let at = problem.phase_at(p, time_s);
                    let v = (time_s - e.fit.origin) / problem.duration.max(f64::MIN_POSITIVE);
                    let offset = p[OFFSET] + v * (p[OFFSET + 1] + v * p[OFFSET + 2]);
                    Knot { time_s, phase: at.phase - lead - lag, omega: at.omega - here, offset }
                })
                .collect()
        }
        Problem::Envelope(_) if !e.record.kind().oscillates() => Vec::new(),
        Problem::Envelope(_) => e
            .measured
            .points
            .iter()
            .map(|b| Knot { time_s: b.time_s, phase: b.phase, omega: b.omega, offset: b.offset })
            .collect(),
    };
    let floor = match &e.fit.problem {
        Problem::Envelope(problem) if problem.squared => p[super::envelope::FLOOR].max(0.0).sqrt(),
        _ => 0.0,
    };
    let backbone = backbone_terms(e, chosen, omega);
    let (x_f, observable, rate) = match &e.fit.problem {
        Problem::Waveform(problem) => (p[X_F], problem.observable, p[OMEGA]),
        Problem::Envelope(_) => (0.0, Observable::Displacement, omega),
    };
    let mut motion = FittedMotion::new(e.fit.origin, e.fit.end, law, backbone, x_f, knots, floor)
        .observed_as(observable, rate);
    motion.harmonics = e.fit.harmonics;
    motion
}

/// Relative frequency shift per A² and A⁴.
fn backbone_terms(e: &Evidence, chosen: &ModelFit, omega: f64) -> [f64; 2] {
    match &e.fit.problem {
        Problem::Waveform(_) => [chosen.bounded.parameters[BACKBONE] / omega, 0.0],
        Problem::Envelope(problem) => problem.backbone,
    }
}

pub(crate) fn backbone(e: &Evidence, chosen: &ModelFit, law: &AmplitudeLaw, omega: f64) -> Option<Backbone> {
    if !e.record.kind().oscillates() {
        return None;
    }
    let [quadratic, quartic] = match &e.fit.problem {
        Problem::Waveform(_) => backbone_terms(e, chosen, omega),
        Problem::Envelope(_) => [e.measured.law.quadratic, e.measured.law.quartic],
    };
    let drift = match &e.fit.problem {
        Problem::Waveform(_) => chosen.bounded.parameters[CHIRP] / omega,
        Problem::Envelope(_) => e.measured.law.drift,
    };
    // The frequency at vanishing amplitude: with a drift, the amplitudes refer to the mean.
    let omega = match &e.fit.problem {
        Problem::Waveform(_) => omega,
        Problem::Envelope(_) => e.measured.law.omega,
    };
    let s = law.initial * law.initial;
    Some(Backbone {
        frequency_at_zero_hz: omega / TAU,
        frequency_at_start_hz: omega / TAU * (1.0 + s * (quadratic + s * quartic)),
        quadratic,
        quartic,
        drift_per_s: drift,
    })
}

/// Residual fundamental of the fitted motion in each block of the decay, if the loss within a cycle makes the
/// block's amplitude differ from that of the law; otherwise `None`.
fn amplitude_residuals(e: &Evidence, chosen: &ModelFit, law: &AmplitudeLaw) -> Option<Vec<f64>> {
    let Problem::Waveform(problem) = &e.fit.problem else { return None };
    let points = &e.measured.points;
    // The fundamental lags by up to 1.5 times the loss per radian, and the square of the lag adds to the
    // amplitude.
    let differs = |b: &Block| {
        let amplitude = law.amplitude(b.time_s - e.fit.origin);
        let lag = 1.5 * law.rate(amplitude) / (amplitude * b.omega);
        0.5 * lag * lag * amplitude > VISIBLE_DIFFERENCE * b.std_error(e.measured.noise_rms)
    };
    let whole_cycles = points.iter().all(|b| b.span_s * b.omega > PI);
    if !whole_cycles || !points.iter().any(differs) {
        return None;
    }
    let residual = problem.residuals(&chosen.bounded.parameters);
    let first = e.samples.time.partition_point(|&t| t < problem.origin);
    let left = remaining_fundamental(problem, first, &residual, &chosen.bounded, points);
    let unscaled = |((in_phase, _), b): (&(f64, f64), &Block)| in_phase * b.unit_variance.sqrt();
    (left.len() == points.len()).then(|| left.iter().zip(points).map(unscaled).collect())
}

pub(crate) fn envelope_points(e: &Evidence, chosen: &ModelFit, fit: &FittedMotion) -> Vec<EnvelopePoint> {
    let noise = e.measured.noise_rms;
    let squared = e.measured.root_mean_squares;
    // The fitted amplitude is instantaneous, a recorded amplitude is the mean over its samples.
    let fitted = |b: &Block| {
        let middle = fit.amplitude_at(b.time_s);
        let bias = averaging_bias(&fit.law, middle, squared, e.measured.time_variance_s2);
        if squared { (fit.signal_at(b.time_s).powi(2) + bias).sqrt() } else { middle + bias }
    };
    let oscillates = e.record.kind().oscillates();
    let left = amplitude_residuals(e, chosen, &fit.law);
    let used = e.measured.points.iter().enumerate().map(|(i, b)| {
        let along_motion = left.as_ref().map(|left| b.amplitude - left[i]);
        (b, along_motion.unwrap_or_else(|| fitted(b)), true)
    });
    let [from, to] = [e.measured.points[0].first, e.measured.points[e.measured.points.len() - 1].end];
    let unused =
        e.measured.all.iter().filter(|b| b.end <= from || b.first >= to).map(|b| (b, fitted(b), false));
    let mut list: Vec<EnvelopePoint> = used
        .chain(unused)
        .map(|(b, fitted, used)| EnvelopePoint {
            time_s: b.time_s,
            amplitude: b.amplitude,
            std_error: b.std_error(noise),
            fitted,
            frequency_hz: if oscillates { b.omega / TAU } else { f64::NAN },
            used,
        })
        .collect();
    sort_by_value(&mut list, |p| p.time_s);
    list
}

/// Slopes of the amplitude over groups of points, multiplied by the period.
pub(crate) fn loss_points(e: &Evidence, law: &AmplitudeLaw, omega: f64) -> Vec<LossPoint> {
    let points = &e.measured.points;
    if points.len() < 2 * LEAST_IN_GROUP {
        return Vec::new();
    }
    let per_group = (points.len() / LOSS_GROUPS).max(LEAST_IN_GROUP);
    let backbone = e.measured.law.backbone();
    // If no frequency is known, the loss is per second.
    let period = if frequency_known(e) { TAU / omega } else { 1.0 };
    points
        .chunks(per_group)
        .filter(|g| g.len() >= LEAST_IN_GROUP)
        .filter_map(|group| {
            let n = group.len() as f64;
            let t0 = group.iter().map(|b| b.time_s).sum::<f64>() / n;
            let a0 = group.iter().map(|b| b.amplitude).sum::<f64>() / n;
            let sxx: f64 = group.iter().map(|b| (b.time_s - t0).powi(2)).sum();
            let sxy: f64 = group.iter().map(|b| (b.time_s - t0) * (b.amplitude - a0)).sum();
            let error =
                (group.iter().map(|b| b.unit_variance).sum::<f64>() / n / sxx).sqrt() * e.measured.noise_rms;
            let s = a0 * a0;
            let f = backbone_factors(a0, backbone);
            let parts = [law.a0 * f[0], law.a1 * a0 * f[1], law.a2 * s * f[2]];
            let further = shifted(law, &f).further_rate(a0);
            (a0 > 0.0).then(|| LossPoint {
                amplitude: a0,
                loss_per_cycle: -sxy / sxx * period,
                std_error: error * period,
                fitted: (parts.iter().sum::<f64>() + further) * period,
                fitted_sliding: parts[0] * period,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};
    use std::f64::consts::{PI, TAU};

    /// A loss of a third of the amplitude per cycle, at 66 dB: the fundamental of a block and the amplitude
    /// at a turning point differ by many standard errors.
    #[test]
    fn fitted_amplitudes_are_those_that_were_measured() {
        for (q, x_f) in [(10.0, 0.0), (10.0, 0.02), (30.0, 0.01)] {
            let oscillator = Oscillator::kinematic(TAU, PI / q, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let time: Vec<f64> = (0..240).map(|i| f64::from(i) / 30.0).collect();
            let noisy = |(i, &t): (usize, &f64)| decay.displacement(t) + 5e-4 * jitter(i, 5);
            let signal = time.iter().enumerate().map(noisy).collect();
            let record = Record::new(time.clone(), signal).expect("valid");
            let answer = analyse(&record, &Options::default()).expect("a ring-down");
            let used: Vec<_> = answer.envelope.iter().filter(|p| p.used).collect();
            assert!(used.len() >= 4);
            for point in used {
                let errors = (point.amplitude - point.fitted) / point.std_error;
                assert!(
                    errors.abs() < 4.0,
                    "Q {q}, {x_f} m: {errors:.1} standard errors at {} s",
                    point.time_s
                );
            }
        }
    }
}
