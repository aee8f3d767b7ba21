//! Loss models compared on the same data, as a table.

use super::content::Table;
use super::parameter::significant;
use crate::format::Scale;
use slipfit::answer::Candidate;
use slipfit::{LossModel, LossTerm, Parameter, Parameters};

/// Meaning of an asterisk after a model.
const NOT_CONVERGED_NOTE: &str = "the fit did not converge to its tolerance";

/// Why the reported model has one loss more than the model of least BIC.
const EXTRA_LOSS_NOTE: &str = "a loss left out is not known to be zero";

/// The models compared, the data they were fitted to, and the reported model.
pub(super) struct Comparison<'a> {
    pub(super) candidates: &'a [Candidate],
    pub(super) reported: LossModel,
    pub(super) parameters: &'a Parameters,
    /// Unit of the signal.
    pub(super) unit: &'a str,
    /// Heading of the first column.
    pub(super) heading: &'static str,
}

impl Comparison<'_> {
    /// One row for each model. `more` are parameters shown after those of the loss terms.
    pub(super) fn table(&self, more: &[Parameter]) -> Table {
        let losses = LossTerm::ALL.iter().map(|&term| Column::loss(self, term));
        let others = more.iter().map(|&parameter| Column::new(self, parameter, true));
        let columns: Vec<Column> = losses.chain(others).collect();
        let rms = Scale::for_size(self.candidates.first().map_or(0.0, |c| c.rms), self.unit);
        let mut rows = vec![vec![self.heading.to_owned(), "ΔBIC".to_owned(), rms.titled("rms")]];
        rows[0].extend(columns.iter().map(Column::heading));
        for c in self.candidates {
            let settled = if c.converged { "" } else { " *" };
            let rms = significant(c.rms * rms.factor, 3);
            let mut row = vec![format!("{}{settled}", c.model), delta_bic(c.delta_bic), rms];
            row.extend(columns.iter().map(|column| column.cell(c)));
            rows.push(row);
        }
        let mut table = Table::new("Models on the same data", rows);
        table.chosen = self.candidates.iter().position(|c| c.model == self.reported);
        let best = self.candidates.first().map(|c| c.model);
        if self.candidates.iter().any(|c| !c.converged) {
            table.note = format!("* {NOT_CONVERGED_NOTE}");
        } else if best.is_some_and(|best| best != self.reported && best.is_within(self.reported)) {
            table.note = format!("{} is reported, as {EXTRA_LOSS_NOTE}", self.reported);
        }
        table
    }
}

fn delta_bic(delta: f64) -> String {
    if delta < 100.0 { format!("{delta:.1}") } else { format!("{delta:.0}") }
}

/// One parameter across the models.
struct Column {
    parameter: Parameter,
    scale: Scale,
    /// Whether any model has it and the data determine it.
    shown: bool,
}

impl Column {
    fn loss(comparison: &Comparison<'_>, term: LossTerm) -> Self {
        let parameter = Parameter::Loss(term);
        // Amplitudes without a frequency give no friction displacement.
        let reported = term != LossTerm::Sliding || comparison.parameters.get(parameter).is_some();
        Self::new(comparison, parameter, reported)
    }

    fn new(comparison: &Comparison<'_>, parameter: Parameter, reported: bool) -> Self {
        let with = comparison.candidates.iter().filter(|c| has(c.model, parameter));
        let largest = with.map(|c| c.value(parameter)).filter(|v| v.is_finite()).fold(0.0, f64::max);
        // For a velocity signal, the friction displacement has a different unit from the amplitude.
        let reported_unit = comparison.parameters.get(parameter).map(|q| q.unit.clone());
        let unit = reported_unit.unwrap_or_else(|| parameter.unit(comparison.unit));
        let scale = Scale::for_size(largest, &unit);
        Self { parameter, scale, shown: reported && largest > 0.0 }
    }

    fn heading(&self) -> String {
        if self.shown { self.scale.titled(self.parameter.symbol()) } else { String::new() }
    }

    fn cell(&self, candidate: &Candidate) -> String {
        match has(candidate.model, self.parameter) {
            _ if !self.shown => String::new(),
            false => "-".to_owned(),
            true if candidate.at_limit.is_some() && candidate.value(self.parameter) == 0.0 => {
                "at 0".to_owned()
            }
            true => significant(candidate.value(self.parameter) * self.scale.factor, 3),
        }
    }
}

fn has(model: LossModel, parameter: Parameter) -> bool {
    match parameter {
        Parameter::Loss(term) => model.has(term),
        _ => true,
    }
}
