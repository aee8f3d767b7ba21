//! A table to be written: its title, the parameters of the simulation, its rows.

use crate::args::SampleArgs;
use crate::failure::Failure;
use slipfit::Oscillator;
use slipfit::model::displacement::{Coordinate, MechanicalUnits};
use slipfit::motion::simulate::Friction;

/// Fills a row.
pub(super) type Fill<'a> = Box<dyn FnMut(u64, &mut Vec<f64>) -> Result<Step, Failure> + 'a>;

/// Result of filling a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    Row,
    LeftOut,
    /// There is no such row, nor any after it.
    End,
}

/// Everything a writer needs.
pub(super) struct Sheet<'a> {
    /// `slipfit simulate` …
    pub(super) command: &'static str,
    pub(super) title: &'static str,
    pub(super) parameters: Vec<Parameter>,
    pub(super) columns: Vec<Column>,
    /// Maximum number of rows; a table of unknown length ends by itself.
    pub(super) rows: u64,
    pub(super) fill: Fill<'a>,
    /// Samples per second of a uniformly sampled trace that starts at zero, which a sound file can hold.
    pub(super) even_rate_hz: Option<f64>,
}

/// A line of the header.
pub(super) struct Parameter {
    pub(super) name: &'static str,
    pub(super) value: Value,
    pub(super) unit: String,
}

pub(super) enum Value {
    Number(f64),
    Text(String),
}

pub(super) struct Column {
    pub(super) name: &'static str,
    pub(super) unit: String,
    pub(super) digits: Digits,
}

/// How a column is written as text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Digits {
    /// The shortest form that reads back to the same number.
    Shortest,
    /// The same with a power of ten.
    ShortestPower,
    /// This many significant digits, with a power of ten.
    Significant(usize),
}

impl Column {
    pub(super) fn new(name: &'static str, unit: &str, digits: Digits) -> Self {
        Self { name, unit: unit.to_owned(), digits }
    }

    /// The samples of a waveform or an envelope, with as many digits as requested.
    pub(super) fn of_samples(name: &'static str, unit: &str, digits: Option<u8>) -> Self {
        let digits = digits.map_or(Digits::ShortestPower, |digits| Digits::Significant(digits.into()));
        Self::new(name, unit, digits)
    }

    /// Name and unit.
    pub(super) fn heading(&self) -> String {
        if self.unit.is_empty() { self.name.to_owned() } else { format!("{} ({})", self.name, self.unit) }
    }
}

impl Sheet<'_> {
    /// Passes on each row as it is computed.
    pub(super) fn for_each(
        &mut self,
        mut give: impl FnMut(&Self, &[f64]) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let mut row = Vec::new();
        for i in 0..self.rows {
            row.clear();
            match (self.fill)(i, &mut row)? {
                Step::Row => give(self, &row)?,
                Step::LeftOut => {}
                Step::End => break,
            }
        }
        Ok(())
    }
}

/// The parameters of a record, in the order of its header.
pub(super) struct Parameters(pub(super) Vec<Parameter>);

impl Parameters {
    /// The parameters of the oscillator.
    pub(super) fn of(o: &Oscillator, unit: &str) -> Self {
        let mut all = Self(Vec::new());
        all.number("frequency_hz", o.frequency_hz(), "");
        all.number("decay_rate_per_s", o.decay_rate_per_s(), "");
        all.number("q_factor", o.q_factor(), "");
        all.number("friction_displacement", o.friction_displacement(), unit);
        all.number("static_displacement", o.static_displacement(), unit);
        let units = units(o);
        for (name, value, unit) in [
            ("mass", o.mass(), units.mass),
            ("stiffness", o.stiffness(), units.stiffness),
            ("viscous_coefficient", o.viscous_coefficient(), units.viscous_coefficient),
            ("coulomb_force", o.coulomb_force(), units.force),
            ("static_force", o.static_force(), units.force),
        ] {
            if let Some(value) = value {
                all.number(name, value, unit);
            }
        }
        all
    }

    /// The parameters of friction, if it differs by direction.
    pub(super) fn uneven(&mut self, friction: Friction, o: &Oscillator, unit: &str) {
        if friction == Friction::of(o) {
            return;
        }
        let ([_, kinetic], [_, holding]) = (friction.kinetic(), friction.holding());
        self.number("friction_displacement_minus", kinetic, unit);
        self.number("static_displacement_minus", holding, unit);
        for (name, displacement) in [("coulomb_force_minus", kinetic), ("static_force_minus", holding)] {
            if let Some(force) = o.force_at(displacement) {
                self.force(name, force, o);
            }
        }
    }

    /// A force, or the torque of a rotation.
    pub(super) fn force(&mut self, name: &'static str, value: f64, o: &Oscillator) {
        self.number(name, value, units(o).force);
    }

    pub(super) fn number(&mut self, name: &'static str, value: f64, unit: &str) {
        self.0.push(Parameter { name, value: Value::Number(value), unit: unit.to_owned() });
    }

    pub(super) fn text(&mut self, name: &'static str, text: impl Into<String>) {
        self.0.push(Parameter { name, value: Value::Text(text.into()), unit: String::new() });
    }

    /// The parameters of the sensor; `full_scale` is the amplitude its converter is set to.
    pub(super) fn sensor(&mut self, sample: &SampleArgs, full_scale: f64) {
        let unit = &sample.unit;
        self.number("noise_rms", sample.noise_rms, unit);
        self.text("seed", format!("{} (ChaCha12, normal)", sample.seed));
        if let Some(bits) = sample.quantize_bits {
            let step = number(quantum(sample, full_scale, bits));
            self.text("quantize_bits", format!("{bits} (step {step} {unit})"));
        }
    }
}

/// Units of the constants; those of a length if the unit is neither a length nor an angle.
fn units(o: &Oscillator) -> MechanicalUnits {
    o.displacement_unit().map_or(Coordinate::Length, |unit| unit.coordinate).mechanical_units()
}

fn quantum(sample: &SampleArgs, full_scale: f64, bits: u32) -> f64 {
    2.0 * (full_scale.abs() + 5.0 * sample.noise_rms) / 2f64.powi(bits as i32)
}

/// A value after the converter.
pub(super) fn converted(sample: &SampleArgs, full_scale: f64, value: f64) -> f64 {
    match sample.quantize_bits {
        Some(bits) => {
            let step = quantum(sample, full_scale, bits);
            if step > 0.0 { (value / step).round() * step } else { value }
        }
        None => value,
    }
}

/// Shortest form of the value rounded to twelve digits.
pub(super) fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_numbers_read_well_and_back() {
        assert_eq!(number(32700.000000000004), "32700");
        assert_eq!(number(1.5e-12), "1.5e-12");
        assert_eq!(number(0.0), "0");
        assert_eq!(number(f64::INFINITY), "inf");
    }
}
