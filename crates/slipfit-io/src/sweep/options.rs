//! What the person reading a resonance curve may decide.

use slipfit::SignalKind;

/// Choices that override what the file itself suggests. The default leaves
/// everything to the file.
///
/// A column is given by its number, from 1, or by its name: the whole header
/// or the header without its unit, in any case, or a part of it that no other
/// header has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SweepOptions {
    /// Column of the frequencies, periods or shifts.
    pub frequency: Option<String>,
    /// Column of the amplitudes; of raw records, of the response.
    pub amplitude: Option<String>,
    /// Column of the phases.
    pub phase: Option<String>,
    /// Column of the real part.
    pub real: Option<String>,
    /// Column of the imaginary part.
    pub imaginary: Option<String>,
    /// Column of the drive: its level at each point, or in raw records its signal.
    pub drive: Option<String>,
    /// Column of the standard errors of the amplitudes.
    pub std_error: Option<String>,
    /// Unit of the frequency column: `Hz`, `kHz`, `MHz`, `rad/s`, `rpm`, or `s`,
    /// `ms` of a period.
    pub frequency_unit: Option<String>,
    /// Unit of the amplitude. `dB` and `dBm` are made linear.
    pub unit: Option<String>,
    /// Unit of the phase: `deg` or `rad`.
    pub phase_unit: Option<String>,
    /// The frequency (Hz) the shifts are counted from.
    pub centre_hz: Option<f64>,
    /// What the response is: displacement, velocity or acceleration. The two
    /// latter are divided by `i omega` once or twice.
    pub kind: Option<SignalKind>,
    /// Which of several sheets, variables, groups or data sets.
    pub sheet: Option<String>,
    /// Which of several curves in groups of columns, from 1.
    pub run: Option<usize>,
    /// Column of the times of raw records.
    pub time: Option<String>,
    /// Unit of those times.
    pub time_unit: Option<String>,
    /// Samples per second of raw records without times.
    pub rate_hz: Option<f64>,
}
