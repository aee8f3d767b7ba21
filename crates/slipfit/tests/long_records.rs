//! Long records: averaging during reading gives the same results as the whole record, and a decay that is a small
//! part of a record is found.

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use proptest::prelude::*;
use slipfit::Parameter;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::{Drive, Motion};
use slipfit::record::Averaging;
use slipfit::{Oscillator, Record, SignalKind, ringdown};

const ROW_S: f64 = 1e-4;

fn add_noise(signal: &mut [f64], rms: f64) {
    let mut state = 88_172_645_463_325_252_u64;
    for v in signal {
        // Twelve uniform numbers minus their mean: close enough to normal here.
        let mut sum = -6.0;
        for _ in 0..12 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        *v += rms * sum;
    }
}

/// A ring-down of 50 Hz with 1 % noise: 200 rows per cycle.
fn rows(count: usize) -> (Vec<f64>, Vec<f64>) {
    let o = Oscillator::builder()
        .omega_0(std::f64::consts::TAU * 50.0)
        .q_factor(400.0)
        .friction_displacement(4e-4)
        .build()
        .unwrap();
    let time_s: Vec<f64> = (0..count).map(|i| i as f64 * ROW_S).collect();
    let mut signal = vec![0.0; count];
    Motion::new(&o, Drive::none(), 0.0, 1.0, 0.0).unwrap().fill(&time_s, &mut signal).unwrap();
    add_noise(&mut signal, 0.01);
    signal.iter_mut().for_each(|v| *v += 3.0);
    (time_s, signal)
}

/// Result of averaging rows that come in batches of different lengths.
fn averaged(
    time_s: &[f64],
    signal: &[f64],
    most: usize,
    interval_s: Option<f64>,
) -> (Averaging, Vec<f64>, Vec<f64>) {
    let mut averaging = Averaging::new(most, interval_s);
    let (mut t, mut x, mut none) = (Vec::new(), Vec::new(), Vec::new());
    let (mut from, mut batch) = (0, 1);
    while from < signal.len() {
        let to = (from + batch).min(signal.len());
        t.extend(time_s.get(from..to).unwrap_or_default());
        x.extend_from_slice(&signal[from..to]);
        averaging.settle(&mut t, &mut x, &mut none);
        (from, batch) = (to, batch % 977 * 3 + 1);
    }
    let left_out = averaging.finish(&mut t, &mut x, &mut none);
    assert!(left_out < averaging.factor());
    assert!(none.is_empty());
    (averaging, t, x)
}

#[test]
fn friction_and_damping_stay_what_they_are_and_as_sure() {
    let (time_s, signal) = rows(200_000);
    let whole = Record::new(time_s.clone(), signal.clone()).unwrap();
    // The contribution of model selection to an interval varies randomly between records; the fit does not.
    let named = {
        let mut options = ringdown::Options::default();
        options.model = Some(slipfit::LossModel::VISCOUS_SLIDING);
        options
    };
    let by_default = ringdown::analyse(&whole, &ringdown::Options::default()).unwrap();
    let whole = ringdown::analyse(&whole, &named).unwrap();
    for interval_s in [None, Some(ROW_S)] {
        let stamps = if interval_s.is_none() { &time_s[..] } else { &[] };
        let (averaging, t, x) = averaged(stamps, &signal, 40_000, interval_s);
        assert_eq!((averaging.factor(), averaging.stopped()), (8, None));
        assert!((averaging.samples_a_cycle() - 25.0).abs() < 0.1, "{}", averaging.samples_a_cycle());
        let record = match interval_s {
            None => Record::new(t, x).unwrap(),
            Some(s) => Record::uniform(1.0 / (8.0 * s), x).unwrap(),
        };
        assert_eq!(record.len(), 25_000);
        let few = ringdown::analyse(&record, &named).unwrap();
        let few_by_default = ringdown::analyse(&record, &ringdown::Options::default()).unwrap();
        for name in [Parameter::FRICTION_DISPLACEMENT, Parameter::DECAY_RATE, Parameter::Frequency] {
            let (a, b) = (whole.parameter(name).unwrap(), few.parameter(name).unwrap());
            assert!((a.value - b.value).abs() < 0.1 * a.std_error, "{name} {a:?} {b:?}");
            assert!((b.std_error / a.std_error - 1.0).abs() < 0.03, "{name} {a:?} {b:?}");
            let (c, d) = (by_default.parameter(name).unwrap(), few_by_default.parameter(name).unwrap());
            assert!((c.value - d.value).abs() < 0.1 * a.std_error, "{name} {c:?} {d:?}");
        }
    }
}

/// Blocks of twenty cycles, as for a record of 8000, would contain the very curvature that reveals the friction.
#[test]
fn a_decay_that_is_a_tenth_of_its_record_is_looked_at_closely() {
    let (rate_hz, noise) = (1.0 / (5.0 * ROW_S), 2e-4);
    let o = Oscillator::builder()
        .omega_0(std::f64::consts::TAU * 50.0)
        .q_factor(523.6)
        .friction_displacement(3e-5)
        .build()
        .unwrap();
    let time_s: Vec<f64> = (0..(160.0 * rate_hz) as usize).map(|i| i as f64 / rate_hz).collect();
    for before_s in [0.0, 40.0] {
        let mut signal = vec![0.0; time_s.len()];
        let silent = (before_s * rate_hz) as usize;
        let mut motion = Motion::new(&o, Drive::none(), 0.0, 1.0, 0.0).unwrap();
        motion.fill(&time_s[..time_s.len() - silent], &mut signal[silent..]).unwrap();
        add_noise(&mut signal, noise);
        // A velocity by name only, so that the amplitudes are used and the fit to the samples is omitted.
        let record = Record::new(time_s.clone(), signal).unwrap().with_kind(SignalKind::Velocity);
        let answer = ringdown::analyse(&record, &ringdown::Options::default()).unwrap();
        let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap();
        assert!((x_f.value - 3e-5).abs() < 4.0 * x_f.std_error, "{x_f:?}");
        let codes: Vec<_> = answer.warnings.iter().map(|w| w.code()).collect();
        assert!(!codes.contains(&"model_misfit"), "{codes:?}");
    }
}

#[test]
fn a_clock_that_halts_or_few_samples_a_cycle_keep_every_row() {
    let (mut time_s, signal) = rows(4000);
    let (averaging, _, x) = averaged(&time_s, &signal, 100, None);
    // 200 rows per cycle: halving three times leaves 25.
    assert_eq!((averaging.factor(), x.len()), (8, 500));
    assert!(averaging.stopped().unwrap().contains("too few samples per cycle"));
    time_s.iter_mut().skip(50).for_each(|t| *t += 1.0);
    let (averaging, _, x) = averaged(&time_s, &signal, 100, None);
    assert_eq!((averaging.factor(), x.len()), (1, 4000));
    assert!(averaging.stopped().unwrap().contains("not uniform"));
}

proptest! {
    #[test]
    fn no_sample_stands_for_rows_on_both_sides_of_a_gap(most in 64..400_usize, gap_at in 500..2500_usize) {
        let time_s: Vec<f64> = (0..3000).map(|i| i as f64 + if i > gap_at { 50.0 } else { 0.0 }).collect();
        let signal: Vec<f64> = time_s.iter().map(|t| 10.0 * t).collect();
        let (averaging, t, x) = averaged(&time_s, &signal, most, None);
        prop_assert!(averaging.factor().is_power_of_two());
        prop_assert!(t.len() == x.len());
        prop_assert!(t.is_sorted());
        let (before, after) = (gap_at as f64, gap_at as f64 + 51.0);
        prop_assert!(t.iter().all(|t| *t <= before || *t >= after));
        prop_assert!(t.iter().zip(&x).all(|(t, x)| (x - 10.0 * t).abs() < 1.0));
    }

    #[test]
    fn missing_values_are_left_out_of_a_mean(
        most in 64..400_usize,
        missing in prop::collection::vec(0..3000_usize, 0..40),
    ) {
        let mut signal: Vec<f64> = (0..3000).map(|i| 10.0 * i as f64).collect();
        missing.iter().for_each(|&i| signal[i] = f64::NAN);
        let (averaging, _, x) = averaged(&[], &signal, most, Some(1.0));
        let factor = averaging.factor();
        prop_assert_eq!(x.len(), 3000 / factor);
        // The amplitude correction is undone.
        let finite: Vec<f64> = x.iter().copied().filter(|v| v.is_finite()).collect();
        let mean = finite.iter().sum::<f64>() / finite.len() as f64;
        for (rows, x) in signal.chunks(factor).zip(&x) {
            let x = mean + (x - mean) * averaging.gain();
            let finite: Vec<f64> = rows.iter().copied().filter(|v| v.is_finite()).collect();
            prop_assert_eq!(finite.is_empty(), x.is_nan());
            let within = |v: &f64| *v >= x - 10.0 * factor as f64 && *v <= x + 10.0 * factor as f64;
            prop_assert!(finite.iter().all(within), "{rows:?} {x}");
        }
    }
}

/// A lossy compression omits weak signals, which ends a decay as friction does.
#[test]
fn friction_in_lossily_compressed_samples_has_a_warning() {
    let o = Oscillator::builder()
        .frequency_hz(440.0)
        .q_factor(900.0)
        .friction_displacement(2e-4)
        .build()
        .unwrap();
    let time_s: Vec<f64> = (0..20_000).map(|i| f64::from(i) / 8000.0).collect();
    let mut signal = vec![0.0; time_s.len()];
    Motion::new(&o, Drive::none(), 0.0, 1.0, 0.0).unwrap().fill(&time_s, &mut signal).unwrap();
    add_noise(&mut signal, 1e-3);
    let record = Record::uniform(8000.0, signal).unwrap();
    let warned = |record: &Record| {
        let answer = ringdown::analyse(record, &ringdown::Options::default()).unwrap();
        assert!(answer.sliding.detected);
        answer.warnings.iter().any(|w| w.code() == "lossy_compression")
    };
    assert!(!warned(&record));
    assert!(warned(&record.with_lossy_compression(true)));
}

/// A simulated decay without noise: rounding is not a misfit, and the minimum of its sum of squares is found.
#[test]
fn an_exact_decay_is_described_without_a_warning() {
    let o =
        Oscillator::builder().frequency_hz(1.7).q_factor(80.0).friction_displacement(0.0).build().unwrap();
    for n in [5000, 40_000] {
        let time_s: Vec<f64> = (0..n).map(|i| 60.0 * f64::from(i) / f64::from(n)).collect();
        let mut signal = vec![0.0; time_s.len()];
        FreeDecay::from_rest(&o, 1.0).unwrap().fill(&time_s, &mut signal).unwrap();
        let record = Record::new(time_s, signal).unwrap();
        let answer = ringdown::analyse(&record, &ringdown::Options::default()).unwrap();
        let codes: Vec<&str> = answer.warnings.iter().map(|w| w.code()).collect();
        assert!(codes.is_empty(), "{n}: {codes:?}");
        let reported = answer.comparison.iter().find(|c| c.model == answer.model).unwrap();
        assert!(reported.converged, "{n}");
        let delta = answer.parameter(Parameter::DECAY_RATE).unwrap();
        assert!((delta.value / o.decay_rate_per_s() - 1.0).abs() < 1e-12, "{n}: {delta:?}");
        assert!(delta.std_error < 1e-12 * delta.value, "{n}: {delta:?}");
        let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap();
        assert!(x_f.interval_95[1] < 1e-12 && !answer.sliding.detected, "{n}: {x_f:?}");
    }
}
