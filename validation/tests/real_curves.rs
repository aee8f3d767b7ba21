//! Measured resonance curves, analysed with default options, have the lines that others found.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use slipfit::resonance::{Answer, Criteria, Options, analyse, analyse_with};
use slipfit::{Error, Parameter};
use slipfit_io::{ReadOptions, read_sweep};

slipfit_real_data::tests! {
    a_reed_has_its_line,
    a_quartz_in_conductance_and_susceptance_has_its_line,
    a_curve_that_is_no_amplitude_claims_no_friction,
    a_quartz_in_its_impedance_has_its_line,
    less_work_is_enough_for_every_curve,
}

fn analysed(file: &str, options: &ReadOptions) -> Result<Answer, Error> {
    let path = slipfit_real_data::path("sweep").join(file);
    let reading = read_sweep(&[path], options).unwrap_or_else(|e| panic!("{e}"));
    analyse(&reading.curve, &Options::default())
}

fn measured(file: &str) -> Answer {
    analysed(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn column(number: &str) -> Option<String> {
    Some(number.to_owned())
}

fn within(answer: &Answer, parameter: Parameter, low: f64, high: f64) {
    let value = answer.parameter(parameter).unwrap().value;
    assert!((low..=high).contains(&value), "{parameter:?}: {value} not in {low} to {high}");
}

fn a_reed_has_its_line() {
    let answer = measured("reed_four_columns");
    within(&answer, Parameter::NaturalFrequency, 143.8, 144.0);
    within(&answer, Parameter::DECAY_RATE, 40.5, 42.0);
}

fn a_quartz_in_conductance_and_susceptance_has_its_line() {
    let options = ReadOptions { real: column("2"), imaginary: column("3"), ..ReadOptions::default() };
    let answer = analysed("rheoqcm_BCB4.h5", &options).unwrap();
    within(&answer, Parameter::NaturalFrequency, 4_995_318.3, 4_995_318.9);
    within(&answer, Parameter::DECAY_RATE, 128.5, 132.0);
}

/// The conductance alone, taken as an amplitude, falls off with the square of the detuning.
fn a_curve_that_is_no_amplitude_claims_no_friction() {
    let answer = measured("rheoqcm_BCB4.h5");
    within(&answer, Parameter::NaturalFrequency, 4_995_317.0, 4_995_320.0);
    assert!(!answer.sliding.detected, "{:?}", answer.sliding);
}

/// The file names no unit for its frequencies: MHz are taken as Hz, with a note.
fn a_quartz_in_its_impedance_has_its_line() {
    let answer = measured("quartz_impedance.xlsx");
    within(&answer, Parameter::NaturalFrequency, 44.80, 44.82);
}

/// Margin for other platforms, on which math functions round differently and the same search takes a little more or
/// less work.
const ROUNDING_ROOM: f64 = 0.87;

fn less_work_is_enough_for_every_curve() {
    let mut less = Criteria::default();
    for work in [&mut less.search.most_work, &mut less.search.work_per_point] {
        *work = (ROUNDING_ROOM * *work as f64) as usize;
    }
    let codes = |answer: &Answer| answer.warnings.iter().map(|w| w.code()).collect::<Vec<_>>();
    let mut analysed = 0;
    for entry in std::fs::read_dir(slipfit_real_data::path("sweep")).unwrap() {
        // A folder is read as one curve of driven records.
        let path = entry.unwrap().path();
        let Ok(reading) = read_sweep(std::slice::from_ref(&path), &ReadOptions::default()) else { continue };
        let Ok(answer) = analyse(&reading.curve, &Options::default()) else { continue };
        let with_less = analyse_with(&reading.curve, &Options::default(), &less).unwrap();
        assert_eq!(codes(&with_less), codes(&answer), "{}", path.display());
        analysed += 1;
    }
    assert!(analysed >= 10, "{analysed} curves");
}
