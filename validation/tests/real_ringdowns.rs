//! Measured ring-downs, analysed with default options: each answer lies in the band of an independent analysis, or
//! the record is refused or flagged.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::ops::RangeInclusive;

use slipfit::ringdown::{Answer, Options, analyse};
use slipfit::{Error, LossModel, LossTerm, Parameter, Record};
use slipfit_io::{ReadOptions, read};

/// Record of a measured file.
fn record(file: &str, rate_hz: Option<f64>) -> Record {
    let path = slipfit_real_data::path("ringdown").join(file);
    read(&path, &ReadOptions { rate_hz, ..ReadOptions::default() }).unwrap_or_else(|e| panic!("{e}")).record
}

/// Expected result of a good analysis of a file. A field left out is not checked.
#[derive(Default)]
struct Expected {
    file: &'static str,
    /// The sampling rate, for files without a time column.
    rate_hz: Option<f64>,
    frequency_hz: Option<RangeInclusive<f64>>,
    /// Decay rate of the chosen model.
    decay_rate_per_s: Option<RangeInclusive<f64>>,
    friction_displacement: Option<RangeInclusive<f64>>,
    /// 1/delta of the purely viscous candidate, whichever model is chosen.
    viscous_tau_s: Option<RangeInclusive<f64>>,
    /// Decay time of a single exponential fitted to the amplitudes of the stretch, whatever the law.
    exponential_tau_s: Option<RangeInclusive<f64>>,
    sliding: Option<bool>,
    /// Whether the chosen model has drag.
    drag: Option<bool>,
    start_s: Option<RangeInclusive<f64>>,
    end_s: Option<RangeInclusive<f64>>,
    /// Time of the stop.
    stop_s: Option<RangeInclusive<f64>>,
    /// Codes of the warnings it must carry.
    warned: &'static [&'static str],
}

/// A single value from the table: within 1 % for a frequency.
fn near_frequency(hz: f64) -> Option<RangeInclusive<f64>> {
    Some(0.99 * hz..=1.01 * hz)
}

/// A single value from the table: within 10 % for a decay time, which depends on the stretch used as soon as the
/// decay is not quite exponential.
fn near_tau(s: f64) -> Option<RangeInclusive<f64>> {
    Some(0.9 * s..=1.1 * s)
}

/// Decay time of one exponential fitted to the amplitudes with equal weights; decays that are not exponential are
/// reported this way.
fn exponential_tau_s(answer: &Answer) -> f64 {
    let points: Vec<(f64, f64)> = answer
        .envelope
        .iter()
        .filter(|p| p.used)
        .map(|p| (p.time_s - answer.segment.start_s, p.amplitude))
        .collect();
    let span = answer.segment.end_s - answer.segment.start_s;
    // The residual sum of squares with the best amplitude.
    let left = |tau: f64| {
        let sums = points.iter().fold([0.0; 3], |[aa, ab, bb], (t, a)| {
            let e = (-t / tau).exp();
            [aa + a * a, ab + a * e, bb + e * e]
        });
        sums[0] - sums[1] * sums[1] / sums[2]
    };
    (1..=5000).map(|k| span * f64::from(k) / 5000.0).min_by(|a, b| left(*a).total_cmp(&left(*b))).unwrap()
}

/// Lists every way in which the answer misses the expected values.
fn misses(answer: &Answer, want: &Expected) -> Vec<String> {
    let value = |name: Parameter| answer.parameter(name).map_or(f64::NAN, |q| q.value);
    let tau = answer
        .comparison
        .iter()
        .find(|c| c.model == LossModel::VISCOUS)
        .map_or(f64::NAN, |c| 1.0 / c.value(Parameter::DECAY_RATE));
    let numbers = [
        ("frequency_hz", &want.frequency_hz, value(Parameter::Frequency)),
        ("decay_rate_per_s", &want.decay_rate_per_s, value(Parameter::DECAY_RATE)),
        ("friction_displacement", &want.friction_displacement, value(Parameter::FRICTION_DISPLACEMENT)),
        ("tau of the viscous model", &want.viscous_tau_s, tau),
        ("tau of one exponential", &want.exponential_tau_s, exponential_tau_s(answer)),
        ("start", &want.start_s, answer.segment.start_s),
        ("end", &want.end_s, answer.segment.end_s),
        ("stop", &want.stop_s, answer.stop.as_ref().map_or(f64::NAN, |s| s.time_s)),
    ];
    let mut list: Vec<String> = numbers
        .into_iter()
        .filter_map(|(name, band, found)| {
            let band = band.as_ref()?;
            (!band.contains(&found)).then(|| format!("{name} {found} is outside {band:?}"))
        })
        .collect();
    let signs = [
        ("sliding detected", want.sliding, answer.sliding.detected),
        ("drag in the model", want.drag, answer.model.has(LossTerm::Drag)),
    ];
    for (name, wanted, found) in signs {
        if wanted.is_some_and(|w| w != found) {
            list.push(format!("{name}: {found}"));
        }
    }
    let codes: Vec<&str> = answer.warnings.iter().map(slipfit::answer::Warning::code).collect();
    list.extend(
        want.warned.iter().filter(|w| !codes.contains(w)).map(|w| format!("no warning {w} in {codes:?}")),
    );
    list
}

fn lands(want: &Expected) {
    let record = record(want.file, want.rate_hz);
    let answer = analyse(&record, &Options::default()).unwrap_or_else(|e| panic!("{}: {e}", want.file));
    let misses = misses(&answer, want);
    assert!(
        misses.is_empty(),
        "{}: {}, {:.3} s to {:.3} s ({}; {})\n  {}",
        want.file,
        answer.model,
        answer.segment.start_s,
        answer.segment.end_s,
        answer.segment.start_reason,
        answer.segment.end_reason,
        misses.join("\n  ")
    );
}

/// One test per file, so that a failure does not hide others.
macro_rules! files {
    ($($name:ident => { $($field:ident: $value:expr),* $(,)? })*) => {
        $(
            fn $name() {
                lands(&Expected { $($field: $value,)* ..Expected::default() });
            }
        )*
        slipfit_real_data::tests! { $($name,)* a_near_critical_record_is_no_ring_down }
    };
}

files! {
    pohl_wheel_without_brake => {
        file: "pohl_brake_0mA.csv",
        frequency_hz: Some(0.518..=0.520),
        decay_rate_per_s: Some(0.0010..=0.0024),
        friction_displacement: Some(1.0e-3..=2.2e-3),
        sliding: Some(true),
        warned: &["law_changes"],
        // The law of the loss changes at 290 s; there are blocks of some seconds before it.
        end_s: Some(280.0..=300.0),
    }
    pohl_wheel_with_100_ma => {
        file: "pohl_brake_100mA.csv",
        frequency_hz: Some(0.518..=0.520),
        decay_rate_per_s: Some(0.0135..=0.0158),
        friction_displacement: Some(2.1e-3..=2.7e-3),
        sliding: Some(true),
    }
    pohl_wheel_with_400_ma => {
        file: "pohl_brake_400mA.csv",
        decay_rate_per_s: Some(0.200..=0.212),
        friction_displacement: Some(1.7e-3..=3.0e-3),
        sliding: Some(true),
    }
    pohl_wheel_with_700_ma => {
        file: "pohl_brake_700mA.csv",
        warned: &["too_few_cycles"],
    }
    bearing_pendulum => {
        file: "bearing_pendulum_encoder.csv",
        frequency_hz: Some(1.286..=1.292),
        decay_rate_per_s: Some(0.025..=0.034),
        friction_displacement: Some(1.7e-3..=2.0e-3),
        sliding: Some(true),
        stop_s: Some(42.0..=44.0),
    }
    video_pendulum => {
        file: "video_pendulum_43cm.txt",
        friction_displacement: Some(0.8e-3..=1.1e-3),
        sliding: Some(true),
        warned: &["slow_tail"],
    }
    video_pendulum_with_its_columns_swapped => {
        file: "video_pendulum_swapped_columns.txt",
        // If read correctly, there are 416 cycles in its 651 s; with swapped columns there would be none.
        frequency_hz: near_frequency(0.646),
    }
    rotary_pendulum => {
        file: "rotary_pendulum_no_time_column.txt",
        rate_hz: Some(1000.0),
        frequency_hz: near_frequency(1.71),
        friction_displacement: Some(0.85..=1.3),
        sliding: Some(true),
    }
    seismometer => {
        file: "seismometer.txt",
        frequency_hz: near_frequency(0.097),
        viscous_tau_s: Some(49.0..=58.0),
    }
    seismometer_at_75_mm => {
        file: "seismometer_75mm.txt",
        frequency_hz: near_frequency(0.068),
        viscous_tau_s: near_tau(39.0),
    }
    string_pendulum => {
        file: "string_pendulum.txt",
        frequency_hz: near_frequency(0.608),
        friction_displacement: Some(0.0..=0.25e-3),
        drag: Some(true),
    }
    driven_then_free_pendulum => {
        file: "driven_then_free_pendulum.csv",
        // The motor runs until about 6 s.
        start_s: Some(6.0..=7.5),
        frequency_hz: near_frequency(1.607),
        friction_displacement: Some(2.9e-3..=4.9e-3),
        sliding: Some(true),
        drag: Some(true),
        stop_s: Some(24.0..=26.0),
    }
    torsion_pendulum_after_its_drive => {
        file: "torsion_driven_103s_then_free.txt",
        // One cycle either way.
        start_s: Some(102.0..=104.0),
        frequency_hz: near_frequency(0.955),
        viscous_tau_s: near_tau(21.3),
        sliding: Some(false),
    }
    membrane_in_dbm => {
        file: "membrane_dBm.txt",
        // The drive stops at 28 s, by eye.
        start_s: Some(27.0..=29.0),
        viscous_tau_s: Some(14.0..=15.5),
        sliding: Some(false),
    }
    bell => {
        file: "bell_440hz.wav",
        frequency_hz: near_frequency(439.1),
        // The recorder's limiter flattens the first 6 s.
        start_s: Some(5.5..=9.0),
        viscous_tau_s: near_tau(6.1),
    }
    phyphox_pendulum => {
        file: "phyphox_pendulum.csv",
        frequency_hz: near_frequency(0.627),
        viscous_tau_s: near_tau(244.0),
        // Quiet until 3.2 s, a jolt at 321 s.
        start_s: Some(3.2..=100.0),
        end_s: Some(200.0..=321.6),
    }
    spring_by_sonar => {
        file: "spring_sonar_decimal_comma.csv",
        frequency_hz: near_frequency(1.343),
        sliding: Some(false),
        drag: Some(true),
    }
    phone_on_a_tower => {
        file: "phone_accelerometer.txt",
        frequency_hz: near_frequency(1.107),
        exponential_tau_s: near_tau(3.3),
    }
    beats_of_two_modes => {
        file: "two_mode_beats.txt",
        warned: &["several_modes"],
    }
    spring_without_a_time_column => {
        file: "spring_no_time_column.csv",
        rate_hz: Some(100.0),
        // 38 cycles counted in its 30.4 s.
        frequency_hz: Some(1.2..=1.3),
    }
    triple_pendulum_in_water => {
        file: "triple_pendulum_in_water.csv",
        frequency_hz: near_frequency(0.596),
        drag: Some(true),
    }
}

fn a_near_critical_record_is_no_ring_down() {
    let record = record("seismometer_near_critical.txt", None);
    let refusal = analyse(&record, &Options::default()).unwrap_err();
    assert!(matches!(refusal, Error::NotARingDown { .. }), "{refusal}");
}
