//! Input of a report: an answer together with what was read and which options were used.

use slipfit::series::{Measurement, Shared};
use slipfit::{levels, resonance, ringdown, series};
use slipfit_io::{LevelReading, Reading, SweepReading};
use std::path::Path;

/// An analysed ring-down.
#[derive(Debug, Clone, Copy)]
pub struct AnalysedRingdown<'a> {
    /// Name of the file, for display.
    pub file: &'a Path,
    /// The record and how it was read.
    pub reading: &'a Reading,
    /// Options of the analysis.
    pub options: &'a ringdown::Options,
    /// The answer of the analysis.
    pub answer: &'a ringdown::Answer,
}

/// An analysed resonance curve.
#[derive(Debug, Clone, Copy)]
pub struct AnalysedCurve<'a> {
    /// The curve and how it was read.
    pub reading: &'a SweepReading,
    /// The friction-free reference, if there is one.
    pub reference: Option<&'a SweepReading>,
    /// Options of the analysis.
    pub options: &'a resonance::Options,
    /// The answer of the analysis.
    pub answer: &'a resonance::Answer,
}

/// An analysed level sweep.
#[derive(Debug, Clone, Copy)]
pub struct AnalysedLevels<'a> {
    /// The levels and how they were read.
    pub reading: &'a LevelReading,
    /// Options of the analysis.
    pub options: &'a levels::Options,
    /// The answer of the analysis.
    pub answer: &'a levels::Answer,
}

/// An analysed series of measurements.
#[derive(Debug, Clone, Copy)]
pub struct AnalysedSeries<'a> {
    /// Description of the series.
    pub heading: &'a SeriesHeading,
    /// Origin of each measurement, in the order of `measurements`.
    pub inputs: &'a [SeriesInput],
    /// The measurements.
    pub measurements: &'a [Measurement],
    /// Options of the analysis.
    pub options: &'a series::Options,
    /// The answer of the analysis.
    pub answer: &'a series::Answer,
}

/// The description of a series, given above its measurements.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SeriesHeading {
    /// Name of the manifest, for display.
    pub path: String,
    /// SHA-256 of the manifest, in hexadecimal.
    pub sha256: String,
    /// Title; may be empty.
    pub title: String,
    /// What varies between measurements, such as `load`.
    pub condition: String,
    /// Unit of the condition; may be empty.
    pub condition_unit: String,
    /// Parameters held in common.
    pub shared: Shared,
}

/// A file of a series as it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesInput {
    /// Name of the file, for display.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// `ringdown`, `sweep` or `levels`.
    pub kind: &'static str,
    /// Unit of its displacements, before scaling.
    pub unit: String,
    /// Remarks made while reading it and building the series.
    pub notes: Vec<String>,
}

/// The program and the call that made a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Version of the program, such as `0.1.0 (0123456789ab)`.
    pub version: String,
    /// How to reproduce the report, such as a command line.
    pub call: String,
}
