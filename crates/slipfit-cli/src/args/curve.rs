//! How a resonance curve is read.

use super::positive;
use super::reading::Kind;
use clap::Args;
use slipfit_io::ReadOptions;

// Columns and units of a curve.
#[derive(Debug, Args)]
pub(crate) struct CurveArgs {
    /// Column of the frequencies, periods or shifts, by number (from 1) or name
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    frequency: Option<String>,

    /// Column of the amplitudes (of raw records: of the response)
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    amplitude: Option<String>,

    /// Column of the phases
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    phase: Option<String>,

    /// Column of the real part
    #[arg(long, value_name = "COL", conflicts_with_all = ["amplitude", "phase"], help_heading = "Reading")]
    real: Option<String>,

    /// Column of the imaginary part
    #[arg(long, value_name = "COL", conflicts_with_all = ["amplitude", "phase"], help_heading = "Reading")]
    imaginary: Option<String>,

    /// Column of the drive: its level at each point, divided out (of raw records: its signal)
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    drive: Option<String>,

    /// Column of the standard errors of the amplitudes
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    std_error: Option<String>,

    /// Unit of the frequencies: Hz, kHz, MHz, rad/s, rpm, or s, ms of periods
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    frequency_unit: Option<String>,

    /// Unit of the amplitudes, such as rad, nm, V, dB, dBm
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    unit: Option<String>,

    /// Unit of the phases: deg, rad
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    phase_unit: Option<String>,

    /// The frequency shifts are counted from [Hz]
    #[arg(long, alias = "center-hz", value_name = "HZ", value_parser = positive, help_heading = "Reading")]
    centre_hz: Option<f64>,

    /// What the response is: displacement, velocity, acceleration
    #[arg(long, value_enum, value_name = "KIND", help_heading = "Reading", hide_possible_values = true)]
    kind: Option<Kind>,

    /// Which of several sheets, variables or groups: name, part of it, or number
    #[arg(long, value_name = "NAME", help_heading = "Reading")]
    sheet: Option<String>,

    /// Which of several curves in groups of columns, from 1
    #[arg(long, value_name = "N", help_heading = "Reading")]
    run: Option<usize>,

    /// Column of the times of raw records
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    time: Option<String>,

    /// Unit of those times: s, ms, us, ns, min, h
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    time_unit: Option<String>,

    /// Samples per second of raw records without times
    #[arg(long, value_name = "RATE", value_parser = positive, help_heading = "Reading")]
    rate_hz: Option<f64>,
}

impl CurveArgs {
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            frequency: self.frequency.clone(),
            amplitude: self.amplitude.clone(),
            phase: self.phase.clone(),
            real: self.real.clone(),
            imaginary: self.imaginary.clone(),
            drive: self.drive.clone(),
            std_error: self.std_error.clone(),
            frequency_unit: self.frequency_unit.clone(),
            unit: self.unit.clone(),
            phase_unit: self.phase_unit.clone(),
            centre_hz: self.centre_hz,
            kind: self.kind.map(Into::into),
            sheet: self.sheet.clone(),
            run: self.run,
            time: self.time.clone(),
            time_unit: self.time_unit.clone(),
            rate_hz: self.rate_hz,
            ..ReadOptions::default()
        }
    }
}
