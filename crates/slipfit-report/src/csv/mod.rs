//! Envelope and fit as tidy CSV.

mod curve;

pub use curve::{levels, resonance};

use crate::AnalysedRingdown;
use crate::Sentence;
use std::io::{self, Write};

/// One row per stretch of the envelope; the parameters stand in the header.
/// A value that does not exist (no fit outside the segment, no frequency of a
/// bare envelope) is an empty cell.
pub fn ringdown(out: &mut dyn Write, analysed: &AnalysedRingdown<'_>) -> io::Result<()> {
    let answer = analysed.answer;
    writeln!(out, "# slipfit {} ringdown", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "# file = {}", analysed.file.display().to_string().replace(['\n', '\r'], " "))?;
    writeln!(out, "# sha256 = {}", analysed.reading.report.sha256)?;
    writeln!(out, "# {}", answer.sentence())?;
    writeln!(out, "# model = {}", answer.model)?;
    for (name, q) in answer.parameters.iter() {
        let [low, high] = q.interval_95;
        writeln!(out, "# {name} = {} +- {} {} (95 %: {low} to {high})", q.value, q.std_error, q.unit)?;
    }
    writeln!(out, "# amplitude, std_error, fitted, residual in {}", unit_or_unknown(&answer.signal_unit))?;
    writeln!(out, "time_s,amplitude,std_error,fitted,residual,frequency_hz,used")?;
    for point in &answer.envelope {
        let cells = [
            point.time_s,
            point.amplitude,
            point.std_error,
            point.fitted,
            point.amplitude - point.fitted,
            point.frequency_hz,
        ];
        for cell in cells {
            if cell.is_finite() {
                write!(out, "{cell}")?;
            }
            out.write_all(b",")?;
        }
        writeln!(out, "{}", point.used)?;
    }
    Ok(())
}

fn unit_or_unknown(unit: &str) -> &str {
    if unit.is_empty() { "the unit of the signal" } else { unit }
}
