//! Any samples give an answer of finite numbers or an error, never a panic or an endless loop.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use proptest::prelude::*;
use slipfit::LossModel;
use slipfit::Parameter;
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit::{Record, SignalKind};

/// A stretch of a record as produced by instruments and accidents.
#[derive(Debug, Clone)]
enum Piece {
    Swing { amplitude: f64, omega: f64, decay: f64 },
    Constant(f64),
    Values(Vec<f64>),
    Ramp(f64),
}

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -1.0..1.0f64,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![0.0, 1e300, -1e300, 1e-300, -1e-308, 5e-324, f64::MAX, f64::NAN]),
    ]
}

fn piece() -> impl Strategy<Value = (Piece, usize)> {
    let scale = prop::sample::select(vec![1.0, 1e-200, 1e-9, 1e9, 1e200]);
    let swing = (scale, 0.05..3.2f64, -0.05..0.3f64).prop_map(|(amplitude, omega, decay)| Piece::Swing {
        amplitude,
        omega,
        decay,
    });
    let piece = prop_oneof![
        4 => swing,
        2 => value().prop_map(Piece::Constant),
        2 => prop::collection::vec(value(), 1..40).prop_map(Piece::Values),
        1 => value().prop_map(Piece::Ramp),
    ];
    (piece, 1..100usize)
}

fn signal() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(piece(), 1..4).prop_map(|pieces| {
        let mut out = Vec::new();
        for (piece, n) in pieces {
            out.extend((0..n).map(|i| {
                let t = i as f64;
                match &piece {
                    Piece::Swing { amplitude, omega, decay } => {
                        amplitude * (-decay * t).exp() * (omega * t).cos()
                    }
                    Piece::Constant(v) => *v,
                    Piece::Values(v) => v[i % v.len()],
                    Piece::Ramp(v) => v * t,
                }
            }));
        }
        out.truncate(200);
        out
    })
}

/// Steps of the clock: uniform, irregular, repeated, with gaps, tiny and huge.
fn steps() -> impl Strategy<Value = Vec<f64>> {
    let step = prop_oneof![
        8 => Just(1.0),
        2 => 0.0..2.0f64,
        1 => Just(0.0),
        1 => prop::sample::select(vec![1e-12, 30.0, 1e6, -1.0, f64::NAN]),
    ];
    let scale = prop::sample::select(vec![1.0, 1e-9, 1e-3, 1e3, 1e150]);
    prop_oneof![
        Just(vec![1.0; 200]),
        (prop::collection::vec(step, 200), scale)
            .prop_map(|(steps, scale)| steps.into_iter().map(|s| s * scale).collect()),
    ]
}

fn options() -> impl Strategy<Value = Options> {
    let instant = || prop::option::weighted(0.1, prop_oneof![-10.0..200.0f64, any::<f64>()]);
    let band = prop::option::weighted(0.1, [0.001..0.3f64, 0.001..0.6f64]);
    let model = prop::option::weighted(0.1, prop::sample::select(LossModel::all().collect::<Vec<_>>()));
    (instant(), instant(), prop::option::weighted(0.1, value()), band, model).prop_map(
        |(start_s, end_s, min_amplitude, band_hz, model)| {
            let mut options = Options::default();
            options.start_s = start_s;
            options.end_s = end_s;
            options.min_amplitude = min_amplitude;
            options.band_hz = band_hz;
            options.model = model;
            options
        },
    )
}

fn check(answer: &Answer) -> Result<(), TestCaseError> {
    for (parameter, quantity) in answer.parameters.iter() {
        let value = quantity.value;
        // Without viscous loss Q may be infinite.
        prop_assert!(
            value.is_finite() || parameter == Parameter::QFactor && value > 0.0,
            "{parameter} = {value}"
        );
        prop_assert!(!quantity.std_error.is_nan(), "{parameter}: {quantity:?}");
    }
    for candidate in &answer.comparison {
        prop_assert!(candidate.bic.is_finite(), "{candidate:?}");
        prop_assert!(candidate.rms.is_finite(), "{candidate:?}");
    }
    let sliding = &answer.sliding;
    prop_assert!((0.0..=1.0).contains(&sliding.p_value), "{sliding:?}");
    for share in [sliding.share_at_highest, sliding.share_at_lowest] {
        prop_assert!((0.0..=1.0).contains(&share), "{sliding:?}");
    }
    prop_assert!(answer.segment.start_s <= answer.segment.end_s, "{:?}", answer.segment);
    for warning in &answer.warnings {
        let said = warning.to_string();
        prop_assert!(!said.contains("NaN"), "{said}");
        prop_assert!(!said.contains("inf"), "{said}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn any_samples_are_analysed_or_refused(
        signal in signal(),
        steps in steps(),
        options in options(),
        kind in prop::sample::select(vec![
            SignalKind::Displacement,
            SignalKind::Displacement,
            SignalKind::Velocity,
            SignalKind::Acceleration,
            SignalKind::Envelope,
        ]),
    ) {
        let time: Vec<f64> = steps
            .iter()
            .take(signal.len())
            .scan(0.0, |t, step| { let now = *t; if !step.is_nan() { *t += step; } Some(now + 0.0 * step) })
            .collect();
        if let Ok(record) = Record::new(time, signal) {
            let signal = if kind == SignalKind::Envelope { record.signal().iter().map(|v| v.abs()).collect() } else { record.signal().to_vec() };
            let time = record.times_s(0..record.len());
            if let Ok(record) = Record::new(time, signal)
                && let Ok(answer) = analyse(&record.with_kind(kind), &options)
            {
                check(&answer)?;
            }
        }
    }

    #[test]
    fn any_lock_in_outputs_are_analysed_or_refused(
        in_phase in signal(),
        quadrature in signal(),
        steps in steps(),
        options in options(),
    ) {
        let n = in_phase.len().min(quadrature.len());
        let time: Vec<f64> =
            steps.iter().take(n).scan(0.0, |t, step| { *t += step.abs(); Some(*t) }).collect();
        if let Ok(record) = Record::lock_in(time, in_phase[..n].to_vec(), quadrature[..n].to_vec())
            && let Ok(answer) = analyse(&record, &options)
        {
            check(&answer)?;
        }
    }
}
