//! An answer made by hand, for tests of wording and output.

use super::law::LossLaw;
use super::{Answer, Backbone, Diagnostics, EnvelopePoint, FittedMotion, LossPoint, Segment};
use crate::Quantity;
use crate::answer::{Candidate, Correlation, Parameter, SlidingEvidence};
use crate::model::loss::LossModel;
use crate::ringdown::fitted::Knot;

/// A pendulum at 1.29 Hz for 40 s: half of its loss sliding at the start.
pub(crate) fn answer() -> Answer {
    let (f_hz, delta, x_f, start) = (1.29, 0.03, 0.0019, 0.35);
    let a0 = 4.0 * f_hz * x_f;
    let law = LossLaw { amplitude_0: start, a0, a1: delta, a2: 0.0 };
    let end_s = 30.0f64.min(0.98 * law.stop_time());
    let knot = |time_s: f64| Knot {
        time_s,
        phase: std::f64::consts::TAU * f_hz * time_s,
        omega: std::f64::consts::TAU * f_hz,
        offset: 0.002,
    };
    let knots = (0..=10).map(|i| knot(end_s * f64::from(i) / 10.0)).collect();
    let fit = FittedMotion::new(0.0, end_s, law, [0.0; 2], x_f, knots, 0.0);
    let wiggle = |i: i32| 4e-4 * (f64::from(i) * 12.9898).sin();
    let envelope = (0..60)
        .map(|i| {
            let time_s = end_s * f64::from(i) / 50.0;
            let used = time_s <= end_s;
            EnvelopePoint {
                time_s,
                amplitude: (law.amplitude(time_s) + wiggle(i)).abs(),
                std_error: 3e-4,
                fitted: fit.amplitude_at(time_s),
                frequency_hz: f_hz,
                used,
            }
        })
        .collect();
    let loss = (1..20)
        .map(|i| {
            let amplitude = start * f64::from(i) / 20.0;
            let fitted = law.rate(amplitude) / f_hz;
            let share = law.shares(amplitude)[0];
            LossPoint {
                amplitude,
                loss_per_cycle: fitted + 5.0 * wiggle(i),
                std_error: 1.5e-3,
                fitted,
                fitted_sliding: share * fitted,
            }
        })
        .collect();
    let candidate = |model: LossModel, delta_bic, rms, delta, x_f| Candidate {
        model,
        bic: -9000.0 + delta_bic,
        delta_bic,
        rms,
        free_parameters: 6,
        converged: true,
        at_limit: None,
        values: [
            (Parameter::InitialAmplitude, start),
            (Parameter::DECAY_RATE, delta),
            (Parameter::FRICTION_DISPLACEMENT, x_f),
        ]
        .into_iter()
        .collect(),
    };
    let quantity = |parameter: Parameter, value, std_error| {
        (parameter, Quantity::normal(value, std_error, parameter.unit("rad")))
    };
    Answer {
        model: LossModel::VISCOUS_SLIDING,
        parameters: [
            quantity(Parameter::Frequency, f_hz, 3e-5),
            quantity(Parameter::DECAY_RATE, delta, 8e-4),
            quantity(Parameter::FRICTION_DISPLACEMENT, x_f, 4e-5),
            quantity(Parameter::InitialAmplitude, start, 3e-4),
        ]
        .into_iter()
        .collect(),
        comparison: vec![
            candidate(LossModel::VISCOUS_SLIDING, 0.0, 3.1e-4, delta, x_f),
            candidate(LossModel::SLIDING, 412.0, 9e-4, 0.0, 0.0029),
            candidate(LossModel::VISCOUS, 1530.0, 2.2e-3, 0.05, 0.0),
        ],
        sliding: SlidingEvidence {
            detected: true,
            p_value: 0.0,
            delta_bic: 1530.0,
            share_at_highest: law.shares(start)[0],
            share_at_lowest: 0.9,
            dominates_from_s: None,
            viscous_only_p_value: 0.0,
        },
        correlations: vec![Correlation {
            parameters: [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT],
            value: -0.93,
        }],
        segment: Segment {
            start_s: 0.0,
            end_s,
            samples: 3000,
            start_reason: "the record starts",
            end_reason: "the motion comes to rest",
            cycles: end_s * f_hz,
        },
        envelope,
        loss,
        backbone: Some(Backbone {
            frequency_at_zero_hz: f_hz,
            frequency_at_start_hz: f_hz,
            quadratic: 0.0,
            quartic: 0.0,
            drift_per_s: 0.0,
        }),
        stop: None,
        diagnostics: Diagnostics {
            method: "waveform",
            noise_rms: 3e-4,
            residual_rms: 3.1e-4,
            residual_excess: 1.02,
            residual_autocorrelation: 0.01,
            signal_to_noise_db: 58.0,
            decay_times: 4.0,
            left_out: 0,
            other_modes: Vec::new(),
            distortion: None,
        },
        warnings: Vec::new(),
        signal_unit: "rad".to_owned(),
        fit,
    }
}
