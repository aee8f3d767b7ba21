//! What lies along the decay: the fitted motion, backbone, amplitudes, losses, the stop.

use super::assemble::Evidence;
use super::envelope::{X_F, backbone_factors};
use super::fits::Problem;
use super::fitted::{FittedMotion, Knot};
use super::law::LossLaw;
use super::quantities::frequency_known;
use super::segment;
use super::waveform::{BEND, CHIRP, OFFSET};
use super::{Backbone, EnvelopePoint, LossPoint, Stop};
use crate::SignalKind;
use crate::inference::model_selection::ModelFit;
use crate::signal::blocks::Block;
use std::f64::consts::TAU;
pub(crate) fn fitted_motion(e: &Evidence, chosen: &ModelFit, law: LossLaw, omega: f64) -> FittedMotion {
    let p = &chosen.bounded.parameters;
    let knots = match &e.described.problem {
        Problem::Waveform(problem) => {
            let count = 1024;
            (0..count)
                .map(|i| {
                    let time_s = e.described.origin
                        + (e.described.end - e.described.origin) * f64::from(i) / f64::from(count - 1);
                    let at = problem.phase_at(p, time_s);
                    let v = (time_s - e.described.origin) / problem.duration.max(f64::MIN_POSITIVE);
                    let offset = p[OFFSET] + v * (p[OFFSET + 1] + v * p[OFFSET + 2]);
                    Knot { time_s, phase: at.phase, omega: at.omega, offset }
                })
                .collect()
        }
        Problem::Envelope(_) if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) => {
            Vec::new()
        }
        Problem::Envelope(_) => e
            .measured
            .points
            .iter()
            .map(|b| Knot { time_s: b.time_s, phase: b.phase, omega: b.omega, offset: b.offset })
            .collect(),
    };
    let floor = match &e.described.problem {
        Problem::Envelope(problem) if problem.squared => p[super::envelope::FLOOR].max(0.0).sqrt(),
        _ => 0.0,
    };
    let backbone = backbone_terms(e, chosen, omega);
    let x_f = if matches!(e.described.problem, Problem::Waveform(_)) { p[X_F] } else { 0.0 };
    FittedMotion::new(e.described.origin, e.described.end, law, backbone, x_f, knots, floor)
}

/// Relative frequency shift per A² and A⁴.
fn backbone_terms(e: &Evidence, chosen: &ModelFit, omega: f64) -> [f64; 2] {
    match &e.described.problem {
        Problem::Waveform(_) => [chosen.bounded.parameters[BEND] / omega, 0.0],
        Problem::Envelope(problem) => problem.backbone,
    }
}

pub(crate) fn backbone(e: &Evidence, chosen: &ModelFit, law: &LossLaw, omega: f64) -> Option<Backbone> {
    if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
        return None;
    }
    let [quadratic, quartic] = match &e.described.problem {
        Problem::Waveform(_) => backbone_terms(e, chosen, omega),
        Problem::Envelope(_) => [e.measured.law.quadratic, e.measured.law.quartic],
    };
    let drift = match &e.described.problem {
        Problem::Waveform(_) => chosen.bounded.parameters[CHIRP] / omega,
        Problem::Envelope(_) => e.measured.law.drift,
    };
    let s = law.amplitude_0 * law.amplitude_0;
    Some(Backbone {
        frequency_at_zero_hz: omega / TAU,
        frequency_at_start_hz: omega / TAU * (1.0 + s * (quadratic + s * quartic)),
        quadratic,
        quartic,
        drift_per_s: drift,
    })
}

pub(crate) fn envelope_points(e: &Evidence, fit: &FittedMotion) -> Vec<EnvelopePoint> {
    let noise = e.measured.noise_rms;
    let bare = matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    let used = e.measured.points.iter().map(|b| (b, true));
    let [from, to] = [e.measured.points[0].first, e.measured.points[e.measured.points.len() - 1].end];
    let unused = e.measured.all.iter().filter(|b| b.end <= from || b.first >= to).map(|b| (b, false));
    let mut list: Vec<EnvelopePoint> = used
        .chain(unused)
        .map(|(b, used)| EnvelopePoint {
            time_s: b.time_s,
            amplitude: b.amplitude,
            std_error: b.std_error(noise),
            fitted: if bare { fit.signal_at(b.time_s) } else { fit.amplitude_at(b.time_s) },
            frequency_hz: if bare { f64::NAN } else { b.omega / TAU },
            used,
        })
        .collect();
    list.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    list
}

/// Slopes of the amplitude over groups of points, times the period.
pub(crate) fn loss_points(e: &Evidence, law: &LossLaw, omega: f64) -> Vec<LossPoint> {
    let points = &e.measured.points;
    if points.len() < 6 {
        return Vec::new();
    }
    let per_group = (points.len() / 24).max(3);
    let backbone = e.measured.law.backbone();
    // Without a frequency the loss is per second.
    let period = if frequency_known(e) { TAU / omega } else { 1.0 };
    points
        .chunks(per_group)
        .filter(|g| g.len() >= 3)
        .filter_map(|group| {
            let n = group.len() as f64;
            let t0 = group.iter().map(|b| b.time_s).sum::<f64>() / n;
            let a0 = group.iter().map(|b| b.amplitude).sum::<f64>() / n;
            let sxx: f64 = group.iter().map(|b| (b.time_s - t0).powi(2)).sum();
            let sxy: f64 = group.iter().map(|b| (b.time_s - t0) * (b.amplitude - a0)).sum();
            let error =
                (group.iter().map(|b| b.unit_variance).sum::<f64>() / n / sxx).sqrt() * e.measured.noise_rms;
            let s = a0 * a0;
            let f = backbone_factors(s * (backbone[0] + s * backbone[1]));
            let parts = [law.a0 * f[0], law.a1 * a0 * f[1], law.a2 * s * f[2]];
            (a0 > 0.0).then(|| LossPoint {
                amplitude: a0,
                loss_per_cycle: -sxy / sxx * period,
                std_error: error * period,
                fitted: parts.iter().sum::<f64>() * period,
                fitted_sliding: parts[0] * period,
            })
        })
        .collect()
}

/// The last sample before a silence: a recorder that writes a row when something
/// moves writes none at rest. After a mere drop-out the swing would go on.
fn silence(time: &[f64], last: &Block, period: f64) -> Option<usize> {
    let n = time.len();
    let silent = (last.first..n - 1).find(|&i| time[i + 1] - time[i] > 3.0 * period)?;
    let in_a_period = (last.end - last.first) as f64 / last.span_s * period;
    ((n - 1 - silent) as f64 <= 0.5 * in_a_period).then_some(silent)
}

/// The rest after the last used block, if the record goes on and holds still.
pub(crate) fn stop(e: &Evidence) -> Option<Stop> {
    if !matches!(e.record.kind(), SignalKind::Displacement) || e.options.end_s.is_some() {
        return None;
    }
    let (time, signal) = (&e.samples.time, &e.samples.signal);
    let last = e.measured.points.last()?;
    let period = TAU / last.omega;
    let n = signal.len();
    if let Some(silent) = silence(time, last, period) {
        return Some(Stop {
            time_s: time[silent],
            position: signal[silent] - last.offset,
            position_std_error: e.measured.noise_rms.hypot(super::measure::quantum(signal)),
            static_displacement: None,
        });
    }
    let tail = (n - last.end) / 4;
    if tail < 8 || time[n - 1] - time[last.end.min(n - 1)] < 2.0 * period {
        return None;
    }
    let rest = &signal[n - tail..];
    let position = rest.iter().sum::<f64>() / tail as f64;
    let scatter = (rest.iter().map(|v| (v - position).powi(2)).sum::<f64>() / tail as f64).sqrt();
    let tolerance = (4.0 * scatter.max(e.measured.noise_rms.min(scatter * 3.0)))
        .max(2.0 * super::measure::quantum(signal))
        .max(1e-9 * e.measured.points[0].amplitude);
    let moving = (last.first..n).rev().find(|&i| (signal[i] - position).abs() > tolerance)?;
    if moving + 1 >= n || time[n - 1] - time[moving] < 1.5 * period {
        return None;
    }
    // A rest is entered within a swing or two; a fading one only sinks below the noise.
    let before = time.partition_point(|&t| t < time[moving] - period);
    let swing = signal[before..=moving].iter().map(|v| (v - position).abs()).fold(0.0, f64::max);
    if swing < 3.0 * tolerance && e.measured.stretch.end_reason != segment::REST {
        return None;
    }
    let offset = last.offset;
    let error = scatter / (tail as f64).sqrt();
    Some(Stop {
        time_s: time[moving + 1],
        position: position - offset,
        position_std_error: error.hypot(e.measured.noise_rms * last.unit_variance.sqrt()),
        static_displacement: None,
    })
}
