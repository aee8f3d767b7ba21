//! The answers of all pixels, drawn and summarised.

use crate::args::{MapArgs, MapMethod};
use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use slipfit::InferenceCriteria;
use slipfit_report::escape;
use slipfit_report::format::{Scale, plain};
use slipfit_report::plot::{self, Image};
use std::collections::BTreeMap;

/// The answers of all blocks.
pub(super) struct Map {
    pub(super) parts: Vec<RecordBatch>,
    pub(super) pixels: [usize; 2],
}

impl Map {
    /// A column of numbers; `None` if a pixel has none.
    pub(super) fn numbers(&self, name: &str) -> Vec<Option<f64>> {
        let columns = self.parts.iter().filter_map(|part| part.column_by_name(name));
        columns.flat_map(|column| column.as_primitive::<Float64Type>().iter()).collect()
    }

    pub(super) fn texts<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a str> {
        let columns = self.parts.iter().filter_map(move |part| part.column_by_name(name));
        columns.flat_map(|column| column.as_string::<i32>().iter().map(Option::unwrap_or_default))
    }

    /// The unit of a column; empty if it has none.
    pub(super) fn unit_of(&self, column: &str) -> String {
        let field = self.parts.first().and_then(|part| part.schema_ref().field_with_name(column).ok());
        field.and_then(|field| field.metadata().get("unit").cloned()).unwrap_or_default()
    }

    /// The quantities that are drawn and summarised: name, words and unit.
    pub(super) fn shown(&self) -> Vec<(&'static str, &'static str, String)> {
        let all = [
            ("friction_displacement", "friction displacement"),
            ("sliding_rate", "sliding rate"),
            ("decay_rate_per_s", "decay rate"),
        ];
        let known = |name: &str| self.numbers(name).iter().any(Option::is_some);
        // The rate replaces the displacement if there is no frequency to convert it.
        let displacement = known("friction_displacement");
        let wanted = |name: &str| if name == "sliding_rate" { !displacement } else { known(name) };
        all.into_iter()
            .filter(|(name, _)| wanted(name))
            .map(|(name, words)| (name, words, self.unit_of(name)))
            .collect()
    }

    fn detected(&self) -> impl Iterator<Item = Option<bool>> {
        let columns = self.parts.iter().filter_map(|part| part.column_by_name("sliding_detected"));
        columns.flat_map(|column| column.as_boolean().iter())
    }

    /// Whether a pixel has a warning, or no answer.
    fn warned(&self) -> Vec<bool> {
        self.texts("status").map(|status| status != "done").collect()
    }

    /// Whether the trace of a pixel does not determine its numbers.
    fn undetermined(&self) -> Vec<bool> {
        let says = |reason: &str| reason.split(' ').any(|code| UNDETERMINED.contains(&code));
        self.texts("reason").map(says).collect()
    }

    pub(super) fn picture(&self, args: &MapArgs) -> plot::Picture {
        let shown = self.shown();
        let undetermined = self.undetermined();
        let doubtful = if matches!(args.method, MapMethod::Fit) { self.warned() } else { Vec::new() };
        let image = |(name, words, unit): &(&str, &str, String)| {
            let mut values = self.numbers(name);
            for (value, undetermined) in values.iter_mut().zip(&undetermined) {
                *value = value.filter(|_| !undetermined);
            }
            let mut sizes: Vec<f64> = values.iter().flatten().map(|v| v.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            // The scale of the median, so that a stray pixel has no influence.
            let scale = Scale::for_size(sizes.get(sizes.len() / 2).copied().unwrap_or(0.0), unit);
            values.iter_mut().flatten().for_each(|v| *v *= scale.factor);
            Image { title: scale.titled(words), values, doubtful: doubtful.clone() }
        };
        let images: Vec<Image> = shown.iter().map(image).collect();
        let file = args.file.display().to_string();
        let data = args.data.as_deref().map(|data| format!(":{data}")).unwrap_or_default();
        let axis = args.axis;
        let note = |y: usize, x: usize| {
            let index = match axis {
                0 => format!(":, {y}, {x}"),
                1 => format!("{y}, :, {x}"),
                _ => format!("{y}, {x}, :"),
            };
            format!("{file}{data}[{index}]")
        };
        let mut caption =
            "Viscous and sliding loss of each pixel. The colour scale leaves out one value in a hundred at \
             either end; grey: no answer, or a value that the trace does not determine."
                .to_owned();
        let drawn =
            self.warned().iter().zip(&undetermined).filter(|(warned, none)| **warned && !**none).count();
        let failed = self.texts("status").filter(|status| *status == "failed").count();
        if let Some(others) = drawn.checked_sub(failed).filter(|others| *others > 0) {
            let have = if others == 1 { "has" } else { "have" };
            let shown = if doubtful.is_empty() { "" } else { " (grey core, in no scale and no histogram)" };
            caption += &format!(" {others} of the coloured pixels {have} a warning{shown}.");
        }
        plot::images(&file, &caption, self.pixels, &images, &note)
    }

    pub(super) fn summary(&self, args: &MapArgs, samples: usize) -> String {
        let [rows, columns] = self.pixels;
        let name = escape::terminal(&args.file.display().to_string());
        let mut text = format!("{name}: {rows} × {columns} pixels of {samples} samples\n");
        let mut status: BTreeMap<&str, usize> = BTreeMap::new();
        self.texts("status").for_each(|word| *status.entry(word).or_default() += 1);
        let counts: Vec<String> = status.iter().map(|(word, count)| format!("{count} {word}")).collect();
        text += &format!("  {}\n", counts.join(", "));
        let detected = self.detected().filter(|flag| *flag == Some(true)).count();
        let warned = self.warned();
        let found = |(i, found): (usize, Option<bool>)| found == Some(true) && warned.get(i) == Some(&true);
        let warned_part = match self.detected().enumerate().filter(|at| found(*at)).count() {
            0 => String::new(),
            count => format!(", {count} of them with a warning"),
        };
        let chance = InferenceCriteria::default().detected;
        text += &format!(
            "  sliding friction detected in {}{warned_part} (expected by chance: 1 in {:.0})\n",
            pixels(detected),
            1.0 / chance
        );
        let sound = warned.iter().filter(|warned| !**warned).count();
        let apart = sound < warned.len() && sound > 0;
        if apart {
            text += &format!("  in the {} without a warning:\n", pixels(sound));
        }
        for (name, words, unit) in self.shown() {
            let counts = |i: usize| !apart || warned.get(i) == Some(&false);
            let mut values: Vec<f64> = self
                .numbers(name)
                .into_iter()
                .enumerate()
                .filter(|(i, _)| counts(*i))
                .filter_map(|(_, v)| v)
                .collect();
            values.sort_by(f64::total_cmp);
            let Some(last) = values.len().checked_sub(1) else { continue };
            let at = |part: f64| values[(part * last as f64).round() as usize];
            let [median, low, high] = [0.5, 0.25, 0.75].map(|part| plain(at(part), 4, &unit));
            text += &format!("  {words}: median {median}, half of the pixels from {low} to {high}\n");
        }
        let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
        self.texts("reason").filter(|r| !r.is_empty()).for_each(|r| *reasons.entry(r).or_default() += 1);
        let mut reasons: Vec<(&str, usize)> = reasons.into_iter().collect();
        reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        for (reason, count) in reasons.iter().take(MOST_REASONS) {
            text += &format!("  {}: {reason}\n", pixels(*count));
        }
        if let Some(others) = reasons.len().checked_sub(MOST_REASONS).filter(|others| *others > 0) {
            text += &format!("  and {others} more reasons: --table has all of them\n");
        }
        text
    }
}

/// Warnings that make the numbers of a pixel meaningless.
const UNDETERMINED: [&str; 2] = ["not_converged", "not_separable"];

/// `1 pixel`, `2 pixels`.
fn pixels(count: usize) -> String {
    if count == 1 { "1 pixel".to_owned() } else { format!("{count} pixels") }
}

/// Maximum number of reasons that are listed.
const MOST_REASONS: usize = 8;
