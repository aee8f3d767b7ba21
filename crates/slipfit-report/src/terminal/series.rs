//! The paper's Table 1 for a series, on the screen and for papers.

use super::facts::Facts;
use super::table::{Align, columns};
use super::{ANSWER, HEADING, WIDTH, labelled, wrap};
use crate::AnalysedSeries;
use crate::Sentence;
use crate::format::{Rounded, Scale, p_value, plain};
use slipfit::Quantity;
use slipfit::series::{ConditionRow, Consistency, Estimate, SingleAnswer};
use std::fmt::Write as _;
use std::path::Path;

/// What a table is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Tidy rows.
    Csv,
    /// A table of a README or a notebook.
    Markdown,
    /// A `tabular`.
    Latex,
}

/// The whole report, styled.
pub fn series(analysed: &AnalysedSeries<'_>, written: &[&Path]) -> String {
    let answer = analysed.answer;
    let mut text = String::new();
    if !analysed.heading.title.is_empty() {
        let _ = writeln!(text, "{HEADING}{}{HEADING:#}", analysed.heading.title);
    }
    for line in wrap(&answer.sentence(), WIDTH) {
        let _ = writeln!(text, "{ANSWER}{line}{ANSWER:#}");
    }
    text.push('\n');
    let rows = cells(analysed, &Style::PLAIN);
    let right = Align::Right;
    let align = [Align::Left, right, right, right, right, right, right, right];
    for (i, line) in columns(&rows, &align).iter().enumerate() {
        text += &if i < 2 { format!("  {HEADING}{line}{HEADING:#}\n") } else { format!("  {line}\n") };
    }
    text.push('\n');
    text += &account(analysed).told();
    if !written.is_empty() {
        let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
        text += &labelled("wrote", &names.join(", "));
    }
    text
}

/// How a table spells its symbols.
struct Style {
    plus_minus: &'static str,
    friction: [&'static str; 2],
    damping: [&'static str; 2],
    z: &'static str,
    p: &'static str,
    none: &'static str,
}

impl Style {
    const PLAIN: Self =
        Self { plus_minus: " ± ", friction: ["x_F", "F"], damping: ["δ", "γ"], z: "z", p: "p", none: "-" };
    const MARKDOWN: Self = Self {
        plus_minus: " ± ",
        friction: ["*x*<sub>F</sub>", "*F*"],
        damping: ["δ", "γ"],
        z: "*z*",
        p: "*p*",
        none: "–",
    };
    const LATEX: Self = Self {
        plus_minus: r" \pm ",
        friction: ["$x_F$", "$F$"],
        damping: [r"$\delta$", r"$\gamma$"],
        z: "$z$",
        p: "$p$",
        none: "--",
    };
}

/// Units all rows of a column share.
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
            all().map(|c| of(c).value.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max)
        };
        let unit = |of: fn(&Estimate) -> &Quantity| all().next().map_or("", |c| of(c).unit.as_str());
        Self {
            friction: Scale::for_size(most(|c| &c.friction), unit(|c| &c.friction)),
            damping: Scale::for_size(most(|c| &c.damping), unit(|c| &c.damping)),
            forces: analysed.options.calibration.is_some(),
        }
    }
}

/// Head of two lines, then one row for each condition.
fn cells(analysed: &AnalysedSeries<'_>, style: &Style) -> Vec<Vec<String>> {
    let scales = Scales::of(analysed);
    let which = usize::from(scales.forces);
    let friction = with_unit(style.friction[which], &scales.friction);
    let damping = with_unit(style.damping[which], &scales.damping);
    let text = |s: &str| s.to_owned();
    let mut rows = vec![
        vec![text(""), friction.clone(), friction, text(""), damping.clone(), damping, text(""), text("")],
        vec![
            analysed.heading.condition.clone(),
            text("ring-down"),
            text("resonance"),
            text(style.z),
            text("ring-down"),
            text("resonance"),
            text(style.z),
            text(style.p),
        ],
    ];
    for row in &analysed.answer.table {
        let value = |cell: &Option<Estimate>, of: fn(&Estimate) -> &Quantity, scale: &Scale| match cell {
            Some(cell) => shown(of(cell), scale, style),
            None => text(style.none),
        };
        let z =
            |pair: &Option<Consistency>| pair.as_ref().map_or(text(style.none), |p| format!("{:+.1}", p.z));
        rows.push(vec![
            row.condition.clone(),
            value(&row.ring_down, |c| &c.friction, &scales.friction),
            value(&row.resonance, |c| &c.friction, &scales.friction),
            z(&row.friction),
            value(&row.ring_down, |c| &c.damping, &scales.damping),
            value(&row.resonance, |c| &c.damping, &scales.damping),
            z(&row.damping),
            row.p_value.map_or(text(style.none), plain_p),
        ]);
    }
    rows
}

/// The table for a page: one line of headings, then one row for each condition.
pub(crate) fn rows(analysed: &AnalysedSeries<'_>) -> Vec<Vec<String>> {
    let mut rows = cells(analysed, &Style::PLAIN);
    let top = rows.remove(0);
    for (heading, above) in rows[0].iter_mut().zip(top) {
        if !above.is_empty() {
            *heading = format!("{above}, {heading}");
        }
    }
    rows
}

fn with_unit(name: &str, scale: &Scale) -> String {
    let unit = scale.unit.trim_start_matches('×');
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

fn plain_p(p: f64) -> String {
    p_value(p).replace("p = ", "").replace("p < ", "< ").replace("p <", "<")
}

/// A value in the unit of its column, rounded by its uncertainty.
fn shown(q: &Quantity, scale: &Scale, style: &Style) -> String {
    let (value, error) = (q.value * scale.factor, q.std_error * scale.factor);
    if !value.is_finite() {
        return style.none.to_owned();
    }
    if !(error.is_finite() && error > 0.0) {
        return plain(value, 4, "");
    }
    // Two digits of the uncertainty where it begins with one or two, else one.
    let decade = error.log10().floor();
    let two = error / 10f64.powf(decade) < 2.95;
    let decimals = (if two { 1.0 - decade } else { -decade }).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$}{}{error:.decimals$}", style.plus_minus)
}

/// The table for a file.
pub fn table(analysed: &AnalysedSeries<'_>, form: Form) -> String {
    match form {
        Form::Csv => csv(analysed),
        Form::Markdown => markdown(analysed),
        Form::Latex => latex(analysed),
    }
}

fn markdown(analysed: &AnalysedSeries<'_>) -> String {
    let rows = cells(analysed, &Style::MARKDOWN);
    let head: Vec<String> =
        rows[0].iter().zip(&rows[1]).map(|(a, b)| format!("{a} {b}").trim().to_owned()).collect();
    let line = |cells: &[String]| {
        let escaped: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
        format!("| {} |\n", escaped.join(" | "))
    };
    let mut text = String::new();
    if !analysed.heading.title.is_empty() {
        let _ = writeln!(text, "**{}**\n", analysed.heading.title);
    }
    text += &line(&head);
    text += "|---|--:|--:|--:|--:|--:|--:|--:|\n";
    rows[2..].iter().for_each(|r| text += &line(r));
    let _ = writeln!(text, "\n{} z: difference over its standard error.", analysed.answer.sentence());
    let _ = writeln!(text, "\nslipfit {}", env!("CARGO_PKG_VERSION"));
    text
}

fn latex(analysed: &AnalysedSeries<'_>) -> String {
    let rows = cells(analysed, &Style::LATEX);
    let escape = |text: &str| {
        text.replace('\\', r"\textbackslash{}")
            .replace('&', r"\&")
            .replace('%', r"\%")
            .replace('_', r"\_")
            .replace('#', r"\#")
            .replace('µ', r"\textmu{}")
            .replace('±', r"$\pm$")
            .replace('°', r"$^\circ$")
            .replace('²', "$^2$")
            .replace('√', r"$\surd$")
    };
    // Units stand in brackets behind symbols that are LaTeX already.
    let head = |text: &str| match text.split_once(" [") {
        Some((symbol, unit)) => format!("{symbol} [{}]", escape(unit.trim_end_matches(']'))),
        None => text.to_owned(),
    };
    let mut text = String::from("% Needs no package. z: difference over its standard error.\n");
    let _ = writeln!(text, "% {}", analysed.answer.sentence());
    let _ = writeln!(text, "% slipfit {}", env!("CARGO_PKG_VERSION"));
    text += "\\begin{tabular}{lrrrrrrr}\n\\hline\n";
    let _ = writeln!(
        text,
        " & \\multicolumn{{3}}{{c}}{{{}}} & \\multicolumn{{3}}{{c}}{{{}}} & \\\\",
        head(&rows[0][1]),
        head(&rows[0][4])
    );
    let mut names: Vec<String> = rows[1].clone();
    names[0] = escape(&names[0]);
    let _ = writeln!(text, "{} \\\\\n\\hline", names.join(" & "));
    for row in &rows[2..] {
        let mut cells = vec![escape(&row[0])];
        cells.extend(row[1..].iter().map(|c| if c == "--" { c.clone() } else { format!("${c}$") }));
        let _ = writeln!(text, "{} \\\\", cells.join(" & "));
    }
    text += "\\hline\n\\end{tabular}\n";
    text
}

/// Unrounded, in the units of the core.
fn csv(analysed: &AnalysedSeries<'_>) -> String {
    let quote = |text: &str| {
        if text.contains([',', '"', '\n']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let scales = Scales::of(analysed);
    let unit_of = |of: fn(&Estimate) -> &Quantity| {
        let all = analysed.answer.table.iter().flat_map(|r| [&r.ring_down, &r.resonance, &r.joint]).flatten();
        all.map(|c| of(c).unit.clone()).next().unwrap_or_default()
    };
    let mut text = format!("# slipfit {} series\n", env!("CARGO_PKG_VERSION"));
    let _ = writeln!(text, "# manifest = {}", analysed.heading.path.replace(['\n', '\r'], " "));
    let _ = writeln!(text, "# {}", analysed.answer.sentence());
    let names = if scales.forces {
        ["sliding friction force F", "viscous coefficient gamma"]
    } else {
        ["friction displacement x_F", "decay rate delta"]
    };
    let _ = writeln!(
        text,
        "# friction: {} [{}]; damping: {} [{}]; z: difference over its standard error",
        names[0],
        unit_of(|c| &c.friction),
        names[1],
        unit_of(|c| &c.damping)
    );
    text += "condition,value,value_std_error";
    for way in ["ringdown", "resonance", "joint"] {
        for what in ["friction", "damping"] {
            let _ =
                write!(text, ",{what}_{way},{what}_{way}_std_error,{what}_{way}_low_95,{what}_{way}_high_95");
        }
    }
    text += ",friction_z,friction_p,damping_z,damping_p,p\n";
    let number = |v: f64| if v.is_finite() { v.to_string() } else { String::new() };
    for row in &analysed.answer.table {
        let mut cells = vec![quote(&row.condition)];
        let [value, error] = row.value.unwrap_or([f64::NAN, f64::NAN]);
        cells.extend([number(value), number(error)]);
        for cell in [&row.ring_down, &row.resonance, &row.joint] {
            let quantities = cell.as_ref().map(|c| [&c.friction, &c.damping]);
            match quantities {
                Some(both) => {
                    for q in both {
                        let [low, high] = q.interval_95;
                        cells.extend([q.value, q.std_error, low, high].map(number));
                    }
                }
                None => cells.extend((0..8).map(|_| String::new())),
            }
        }
        for pair in [&row.friction, &row.damping] {
            let [z, p] = pair.as_ref().map_or([f64::NAN, f64::NAN], |p| [p.z, p.p_value]);
            cells.extend([number(z), number(p)]);
        }
        cells.push(row.p_value.map_or_else(String::new, number));
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// What the table is built from and what follows from it.
pub(crate) fn account(analysed: &AnalysedSeries<'_>) -> Facts {
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
            "chi square {} for {} degrees of freedom, {}",
            plain(joint.chi_square, 3, ""),
            joint.degrees_of_freedom,
            p_value(joint.p_value)
        ));
        facts.add("joint", parts.join(", "));
    }
    let scales = Scales::of(analysed);
    let which = usize::from(scales.forces);
    let value = |row: &ConditionRow| {
        let joint = row.joint.as_ref()?;
        Some(format!(
            "{}: {} = {} {}, {} = {} {}",
            row.condition,
            Style::PLAIN.friction[which],
            shown(&joint.friction, &scales.friction, &Style::PLAIN),
            scales.friction.unit,
            Style::PLAIN.damping[which],
            shown(&joint.damping, &scales.damping, &Style::PLAIN),
            scales.damping.unit
        ))
    };
    for (i, line) in answer.table.iter().filter_map(value).enumerate() {
        facts.add(if i == 0 { "both" } else { "" }, line);
    }
}

fn laws(facts: &mut Facts, analysed: &AnalysedSeries<'_>) {
    for (i, law) in analysed.answer.laws.iter().enumerate() {
        let c = &law.coefficient;
        let [low, high] = c.interval_95;
        let offset = law.offset.as_ref().map_or_else(String::new, |q| {
            format!(", offset {}", Rounded::new(q.value, q.std_error, &q.unit))
        });
        let fit = law.p_value.map_or_else(String::new, |p| format!(", {}", p_value(p)));
        let tested = match law.degrees_of_freedom {
            0 => "as many parameters as loads".to_owned(),
            free => format!("chi square {} for {free}{fit}", plain(law.chi_square, 3, "")),
        };
        let shown = Rounded::new(c.value, c.std_error, &c.unit);
        let said = format!(
            "{}: {shown} (95 %: {} to {}){offset}; {tested}, ΔBIC {:.1}",
            law.law,
            shown.also(low),
            shown.also(high),
            law.delta_bic
        );
        facts.add(if i == 0 { "load" } else { "" }, said);
    }
}

/// Each measurement alone, in its own words.
fn alone(facts: &mut Facts, analysed: &AnalysedSeries<'_>) {
    for (((name, solo), input), m) in
        analysed.answer.solo.iter().zip(analysed.inputs).zip(analysed.measurements)
    {
        let said = match solo {
            Ok(SingleAnswer::RingDown(a)) => a.sentence(),
            Ok(SingleAnswer::Sweep(a)) => a.sentence(),
            Ok(SingleAnswer::Levels(a)) => a.sentence(),
            Ok(_) => "analysed".to_owned(),
            Err(error) => format!("could not be analysed: {error}"),
        };
        facts.add("alone", format!("{name} ({}, {}): {said}", input.kind, m.condition.label));
        let doubts: Vec<String> = match solo {
            Ok(SingleAnswer::RingDown(a)) => a.warnings.iter().map(|w| w.code().to_owned()).collect(),
            Ok(SingleAnswer::Sweep(a)) => a.warnings.iter().map(|w| w.code().to_owned()).collect(),
            Ok(SingleAnswer::Levels(a)) => a.warnings.iter().map(|w| w.code().to_owned()).collect(),
            _ => Vec::new(),
        };
        if !doubts.is_empty() {
            facts.add("", format!("doubts: {} (its own command says more)", doubts.join(", ")));
        }
    }
}
