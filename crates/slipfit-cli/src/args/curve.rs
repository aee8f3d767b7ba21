//! How a resonance curve is read.

use super::count;
use super::reading::Kind;
use super::value::{FormatName, Positive, Text, number, text};
use clap::Args;
use serde::Deserialize;
use slipfit_io::ReadOptions;

// Columns and units of a curve.
#[derive(Debug, Clone, Default, Args, Deserialize)]
#[serde(default)]
pub(crate) struct CurveArgs {
    /// Format, if the first bytes do not identify it: text, mat, hdf5, parquet, arrow, ...
    #[arg(long, value_name = "NAME", help_heading = "Reading")]
    format: Option<FormatName>,

    /// Column of the frequencies, periods or shifts, by number (from 1) or name
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    frequency: Option<Text>,

    /// Column of the amplitudes (for raw records: of the response)
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    amplitude: Option<Text>,

    /// Column of the phases
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    phase: Option<Text>,

    /// Column of the real part
    #[arg(long, value_name = "COL", conflicts_with_all = ["amplitude", "phase"], help_heading = "Reading")]
    real: Option<Text>,

    /// Column of the imaginary part
    #[arg(long, value_name = "COL", conflicts_with_all = ["amplitude", "phase"], help_heading = "Reading")]
    imaginary: Option<Text>,

    /// Column of the drive: its level at each point, which is divided out (for raw records: its signal); or none
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    drive: Option<Text>,

    /// Column of the standard errors of the amplitudes
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    std_error: Option<Text>,

    /// Unit of the frequencies: Hz, kHz, MHz, rad/s, rpm, s or ms for periods, "log10 Hz" for logarithms, or the
    /// frequency that 1 stands for in a column of ratios, such as "80.1 Hz"
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    frequency_unit: Option<Text>,

    /// Unit of the amplitudes, such as rad, nm, V, dB, dBm
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    unit: Option<Text>,

    /// Unit of the phases: deg, rad, cycles, pi
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    phase_unit: Option<Text>,

    /// Frequency from which shifts are counted [Hz]
    #[arg(long, alias = "center-hz", value_name = "HZ", help_heading = "Reading")]
    #[serde(alias = "center_hz")]
    centre_hz: Option<Positive>,

    /// What the response is: displacement, velocity, acceleration
    #[arg(long, value_enum, value_name = "KIND", help_heading = "Reading", hide_possible_values = true)]
    kind: Option<Kind>,

    /// Which of several sheets, variables or groups: name, part of the name, or number
    #[arg(long, value_name = "NAME", help_heading = "Reading")]
    sheet: Option<Text>,

    /// Which of several curves in groups of columns, from 1
    #[arg(long, value_name = "N", value_parser = count, help_heading = "Reading")]
    run: Option<usize>,

    /// Column of the times of raw records
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    time: Option<Text>,

    /// Unit of those times: s, ms, us, ns, min, h
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    time_unit: Option<Text>,

    /// Samples per second of raw records without times
    #[arg(long, value_name = "RATE", help_heading = "Reading")]
    rate_hz: Option<Positive>,
}

impl CurveArgs {
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.format.as_ref().map(|f| f.format),
            frequency: text(&self.frequency),
            amplitude: text(&self.amplitude),
            phase: text(&self.phase),
            real: text(&self.real),
            imaginary: text(&self.imaginary),
            drive: text(&self.drive),
            std_error: text(&self.std_error),
            frequency_unit: text(&self.frequency_unit),
            unit: text(&self.unit),
            phase_unit: text(&self.phase_unit),
            centre_hz: number(self.centre_hz),
            kind: self.kind.map(Into::into),
            sheet: text(&self.sheet),
            run: self.run,
            time: text(&self.time),
            time_unit: text(&self.time_unit),
            rate_hz: number(self.rate_hz),
            ..ReadOptions::default()
        }
    }
}
