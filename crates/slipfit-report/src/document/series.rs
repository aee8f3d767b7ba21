//! The report of a series: the paper's Table 1 with uncertainties.

use super::content::{Document, Input, Table, file_name, warnings};
use super::facts::Facts;
use super::method;
use super::reading::counted;
use crate::format::{Rounded, Scale, p_value, plain};
use crate::{AnalysedSeries, Sentence, plot};
use slipfit::Quantity;
use slipfit::answer::hint::Spelling;
use slipfit::series::{ConditionRow, Consistency, Estimate, LawFit, LoadLaw, SingleAnswer};

pub(super) fn document<'a>(analysed: &'a AnalysedSeries<'a>, spell: Spelling<'_>) -> Document<'a> {
    let (answer, heading) = (analysed.answer, analysed.heading);
    let manifest = Input { path: heading.path.clone(), sha256: heading.sha256.clone() };
    let files = analysed.inputs.iter().map(|i| Input { path: i.path.clone(), sha256: i.sha256.clone() });
    let title = Some(heading.title.clone()).filter(|title| !title.is_empty());
    Document {
        command: "series",
        subject: title.clone().unwrap_or_else(|| file_name(&heading.path)),
        title,
        sentence: answer.sentence(),
        parameters: Vec::new(),
        tables: vec![table(analysed)],
        facts: facts(analysed),
        warnings: warnings(&answer.warnings, spell),
        method: method::of_series(answer),
        inputs: std::iter::once(manifest).chain(files).collect(),
        pictures: Box::new(|| plot::series_panels(analysed)),
    }
}

/// Units shared by all rows of a column.
struct Scales {
    friction: Scale,
    damping: Scale,
    /// Whether the columns are forces and coefficients, not x_F and delta.
    forces: bool,
}

impl Scales {
    fn of(analysed: &AnalysedSeries<'_>) -> Self {
        let all =
            || analysed.answer.table.iter().flat_map(|r| [&r.ring_down, &r.resonance, &r.joint]).flatten();
        let most = |of: fn(&Estimate) -> &Quantity| {
            let size = |q: &Quantity| if is_below(q) { q.interval_95[1] } else { q.value.abs() };
            all().map(|c| size(of(c))).filter(|v| v.is_finite()).fold(0.0, f64::max)
        };
        let unit = |of: fn(&Estimate) -> &Quantity| all().next().map_or("", |c| of(c).unit.as_str());
        Self {
            friction: Scale::for_size(most(|c| &c.friction), unit(|c| &c.friction)),
            damping: Scale::for_size(most(|c| &c.damping), unit(|c| &c.damping)),
            forces: analysed.options.calibration.is_some(),
        }
    }

    /// Symbols of friction and damping.
    fn symbols(&self) -> [&'static str; 2] {
        if self.forces { ["F", "γ"] } else { ["x_F", "δ"] }
    }
}

const NONE: &str = "-";

type Method = fn(&ConditionRow) -> &Option<Estimate>;
type Part = fn(&Estimate) -> &Quantity;

/// One row for each condition.
fn table(analysed: &AnalysedSeries<'_>) -> Table {
    let scales = Scales::of(analysed);
    let [friction, damping] = scales.symbols();
    // A method that was not used has no column; a single method has nothing to be compared with.
    let methods: Vec<(&str, Method)> =
        [("ring-down", (|r| &r.ring_down) as Method), ("resonance", |r| &r.resonance)]
            .into_iter()
            .zip(analysed.answer.methods())
            .filter_map(|(method, used)| used.then_some(method))
            .collect();
    let both = methods.len() > 1;
    let compared = |cell: String| both.then_some(cell);
    let heads = || methods.iter().map(|(name, _)| (*name).to_owned()).chain(compared("z".to_owned()));
    let condition = analysed.heading.condition.clone();
    let mut rows: Vec<Vec<String>> = vec![
        std::iter::once(condition).chain(heads()).chain(heads()).chain(compared("p".to_owned())).collect(),
    ];
    for row in &analysed.answer.table {
        let z =
            |pair: &Option<Consistency>| pair.as_ref().map_or(NONE.to_owned(), |p| format!("{:+.1}", p.z));
        let mut cells = vec![row.condition.clone()];
        let parts: [(Part, &Scale, &Option<Consistency>); 2] = [
            (|c| &c.friction, &scales.friction, &row.friction),
            (|c| &c.damping, &scales.damping, &row.damping),
        ];
        for (of, scale, pair) in parts {
            let value = |(_, method): &(&str, Method)| {
                method(row).as_ref().map_or(NONE.to_owned(), |cell| shown(of(cell), scale))
            };
            cells.extend(methods.iter().map(value).chain(compared(z(pair))));
        }
        let p = row
            .p_value
            .map_or(NONE.to_owned(), |p| p_value(p).trim_start_matches(['p', ' ', '=']).to_owned());
        cells.extend(compared(p));
        rows.push(cells);
    }
    let columns = methods.len() + usize::from(both);
    let mut table = Table::new("Friction and damping at each condition", rows);
    table.groups = vec![
        (String::new(), 1),
        (scales.friction.titled(friction), columns),
        (scales.damping.titled(damping), columns),
    ];
    table.groups.extend(compared(String::new()).map(|empty| (empty, 1)));
    if both {
        table.note = "z: difference of the two methods over its standard error.".to_owned();
    }
    if let Some(relative) = analysed.options.calibration.map(|c| c.quantity()).map(|q| q.std_error / q.value)
        && relative > 0.0
    {
        let share = plain(100.0 * relative, 2, "%");
        table.note.push_str(&format!(
            " ± includes the error of the constant, {share} of every {friction} and {damping}{}.",
            if both { "; z and p do not, as both methods share it" } else { "" }
        ));
    }
    if table.rows.iter().flatten().any(|cell| cell.starts_with(BELOW)) {
        table.note.push_str(" <: upper limit (95 %) of a value that may be zero.");
    }
    table
}

/// Prefix of an upper limit.
const BELOW: &str = "< ";

/// Whether a value within its error of zero is shown as an upper limit.
fn is_below(q: &Quantity) -> bool {
    let [low, high] = q.interval_95;
    low <= 0.0 && high > 0.0 && high.is_finite() && q.value <= q.std_error
}

/// A value in the unit of its column, rounded by its uncertainty, or an upper limit if it is close to zero.
fn shown(q: &Quantity, scale: &Scale) -> String {
    if is_below(q) {
        return format!("{BELOW}{}", plain(q.interval_95[1] * scale.factor, 2, ""));
    }
    let (value, error) = (q.value * scale.factor, q.std_error * scale.factor);
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if !(error.is_finite() && error > 0.0) {
        return plain(value, 4, "");
    }
    // Two digits of the uncertainty if its first digit is one or two, else one.
    let decade = error.log10().floor();
    let two = error / 10f64.powf(decade) < 2.95;
    let decimals = (if two { 1.0 - decade } else { -decade }).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$} ± {error:.decimals$}")
}

/// A symbol with its value or upper limit.
fn equation(symbol: &str, shown: &str) -> String {
    if shown.starts_with(BELOW) { format!("{symbol} {shown}") } else { format!("{symbol} = {shown}") }
}

/// What the table is built from and what follows from it.
fn facts(analysed: &AnalysedSeries<'_>) -> Facts {
    let mut facts = Facts::default();
    joint(&mut facts, analysed);
    laws(&mut facts, analysed);
    alone(&mut facts, analysed);
    facts
}

fn joint(facts: &mut Facts, analysed: &AnalysedSeries<'_>) {
    let answer = analysed.answer;
    if let Some(joint) = &answer.joint {
        let mut parts = Vec::new();
        for (name, q) in [
            ("f₀", &joint.natural_frequency_hz),
            ("x₀", &joint.drive_amplitude),
            ("δ", &joint.decay_rate_per_s),
        ] {
            if let Some(q) = q {
                parts.push(format!("{name} = {}", Rounded::new(q.value, q.std_error, &q.unit)));
            }
        }
        parts.push(format!(
            "chi square {} for {} of freedom, {}",
            plain(joint.chi_square, 3, ""),
            counted(joint.degrees_of_freedom as u64, "degree"),
            p_value(joint.p_value)
        ));
        facts.add("joint", parts.join(", "));
    }
    let scales = Scales::of(analysed);
    let symbols = scales.symbols();
    if let Some(scatter) = &answer.scatter {
        let parts =
            [(symbols[0], scatter.friction, answer.has_friction()), (symbols[1], scatter.damping, true)];
        let parts: Vec<String> = parts
            .into_iter()
            .filter(|&(_, relative, seen)| seen && relative > 0.0)
            .map(|(symbol, relative, _)| format!("{symbol} by {}", plain(100.0 * relative, 2, "%")))
            .collect();
        if !parts.is_empty() {
            let repeats =
                format!("repeats scatter beyond their errors, {}; included in the errors", parts.join(", "));
            facts.add("scatter", repeats);
        }
    }
    let value = |row: &ConditionRow| {
        let joint = row.joint.as_ref()?;
        Some(format!(
            "{}: {} {}, {} {}",
            row.condition,
            equation(symbols[0], &shown(&joint.friction, &scales.friction)),
            scales.friction.unit,
            equation(symbols[1], &shown(&joint.damping, &scales.damping)),
            scales.damping.unit
        ))
    };
    // With a single method, the table already shows it.
    let both = answer.methods() == [true; 2];
    for (i, line) in answer.table.iter().filter(|_| both).filter_map(value).enumerate() {
        facts.add(if i == 0 { "both" } else { "" }, line);
    }
}

fn laws(facts: &mut Facts, analysed: &AnalysedSeries<'_>) {
    // Without friction the laws cannot be distinguished: only an upper limit of the coefficient remains.
    let friction = analysed.answer.has_friction();
    let told = |law: &&LawFit| friction || law.law == LoadLaw::Proportional;
    for (i, law) in analysed.answer.laws.iter().filter(told).enumerate() {
        let c = &law.coefficient;
        let [low, high] = c.interval_95;
        let offset = law.offset.as_ref().map_or_else(String::new, |q| {
            format!(", offset {}", Rounded::new(q.value, q.std_error, &q.unit))
        });
        let fit = law.p_value.map_or_else(String::new, |p| format!(", {}", p_value(p)));
        let tested = match law.degrees_of_freedom {
            0 => "as many parameters as loads".to_owned(),
            free => format!(
                "chi square {} for {} of freedom{fit}",
                plain(law.chi_square, 3, ""),
                counted(free as u64, "degree")
            ),
        };
        let shown = Rounded::new(c.value, c.std_error, &c.unit);
        let said = format!(
            "{}: {shown} (95 %: {} to {}){offset}; {tested}{}",
            law.law,
            shown.also(low),
            shown.also(high),
            if friction { format!(", ΔBIC {:.1}", law.delta_bic) } else { String::new() }
        );
        facts.add(if i == 0 { "load" } else { "" }, said);
    }
}

/// Each measurement on its own, in its own words.
fn alone(facts: &mut Facts, analysed: &AnalysedSeries<'_>) {
    for (((name, single), input), m) in
        analysed.answer.singles.iter().zip(analysed.inputs).zip(analysed.measurements)
    {
        let said = match single {
            Ok(SingleAnswer::RingDown(a)) => a.sentence(),
            Ok(SingleAnswer::Sweep(a)) => a.sentence(),
            Ok(SingleAnswer::Levels(a)) => a.sentence(),
            Ok(_) => "analysed".to_owned(),
            Err(error) => format!("could not be analysed: {error}"),
        };
        let names_kind = name.replace('-', "").contains(input.kind);
        let place = if names_kind && name.contains(&m.condition.label) {
            String::new()
        } else {
            format!(" ({}, {})", input.kind, m.condition.label)
        };
        facts.add("alone", format!("{name}{place}: {said}"));
        let warned = match single {
            Ok(SingleAnswer::RingDown(a)) => Some(("ringdown", &a.warnings)),
            Ok(SingleAnswer::Sweep(a)) => Some(("resonance", &a.warnings)),
            Ok(SingleAnswer::Levels(a)) => Some(("levels", &a.warnings)),
            _ => None,
        };
        if let Some((command, list)) = warned.filter(|(_, list)| !list.is_empty()) {
            let codes: Vec<&str> = list.iter().map(|w| w.code()).collect();
            let codes = codes.join(", ");
            facts.add("", format!("warnings: {codes} (explained by slipfit {command} on this file)"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_be_none_is_an_upper_limit() {
        let scale = Scale::for_size(1.0, "nm");
        let of = |value: f64, low: f64, high: f64| {
            let q = Quantity { interval_95: [low, high], ..Quantity::normal(value, 0.0691, "nm") };
            (shown(&q, &scale), equation("x_F", &shown(&q, &scale)))
        };
        assert_eq!(of(0.0378, 0.0, 0.171), ("< 0.17".to_owned(), "x_F < 0.17".to_owned()));
        assert_eq!(of(0.378, 0.24, 0.51).0, "0.38 ± 0.07");
        // Not close to zero.
        assert_eq!(of(0.12, 0.0, 0.25).0, "0.12 ± 0.07");
    }
}
