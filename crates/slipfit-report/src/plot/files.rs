//! Answers of many files side by side.

use super::axis::Axis;
use super::figure::{Color, Figure, Stroke};
use super::grid::{PANEL, headed};
use super::panel::{Mark, Panel};
use crate::format::Scale;
use crate::row::{Row, Status};

const CLEAN: Color = Color::new(0x00, 0x72, 0xb2);
const WARNED: Color = Color::new(0xd5, 0x5e, 0x00);
/// With more files than this, bars are thin and dots small.
const MANY: usize = 60;

/// A value of one file, with its interval if there is one.
struct Entry {
    place: f64,
    warned: bool,
    value: f64,
    low: f64,
    high: f64,
}

pub(super) fn figure(rows: &[Row]) -> Figure {
    let count = |status| rows.iter().filter(|r| r.status == status).count();
    let title = format!(
        "{} files: {} without warnings, {} with warnings, {} failed",
        rows.len(),
        count(Status::Done),
        count(Status::Warned),
        count(Status::Failed)
    );
    let unit = usual_unit(rows);
    let other = rows.iter().filter(|r| r.status != Status::Failed && r.friction_unit() != unit).count();
    let mut below = "Bars: 95 % intervals.".to_owned();
    if other > 0 {
        below += &format!(" {other} files in other units than {unit} are left out of the friction.");
    }
    let same_unit = |r: &Row| r.friction_unit() == unit;
    let x_f = entries(rows, "friction_displacement", "friction_displacement", "", same_unit);
    let delta = entries(rows, "decay_rate", "decay_rate", "_per_s", |_| true);
    let share = plain(rows, &["sliding_share_at_start", "sliding_share_at_peak"], 100.0);
    let frequency = plain(rows, &["frequency_hz", "natural_frequency_hz"], 1.0);
    let share_title = match rows.first().and_then(|r| r.columns.iter().find(|c| c.name.contains("share"))) {
        Some(column) if column.name.ends_with("peak") => "sliding share of the loss at the peak",
        _ => "sliding share of the loss at the start",
    };
    let panels = vec![
        panel(rows, "friction displacement", "x_F", unit, &x_f),
        panel(rows, "decay rate", "δ", "1/s", &delta),
        panel(rows, share_title, "share", "%", &share),
        panel(rows, "frequency", "f", "Hz", &frequency),
    ];
    headed(&title, &below, panels)
}

/// The most frequent unit of the files.
fn usual_unit(rows: &[Row]) -> &str {
    let answered = || rows.iter().filter(|r| r.status != Status::Failed).map(Row::friction_unit);
    answered().max_by_key(|unit| answered().filter(|u| u == unit).count()).unwrap_or("")
}

fn entries(rows: &[Row], name: &str, ends: &str, behind: &str, kept: impl Fn(&Row) -> bool) -> Vec<Entry> {
    let names = [format!("{name}{behind}"), format!("{ends}_low{behind}"), format!("{ends}_high{behind}")];
    let one = |(i, row): (usize, &Row)| {
        let [value, low, high] = names.each_ref().map(|name| row.number(&[name]));
        let value = value.filter(|_| kept(row))?;
        Some(Entry {
            place: i as f64 + 1.0,
            warned: row.status == Status::Warned,
            value,
            low: low.unwrap_or(value),
            // An interval without an upper end extends beyond the axis.
            high: high.unwrap_or(f64::MAX),
        })
    };
    rows.iter().enumerate().filter_map(one).collect()
}

fn plain(rows: &[Row], names: &[&str], factor: f64) -> Vec<Entry> {
    let one = |(i, row): (usize, &Row)| {
        let value = row.number(names)? * factor;
        let warned = row.status == Status::Warned;
        Some(Entry { place: i as f64 + 1.0, warned, value, low: value, high: value })
    };
    rows.iter().enumerate().filter_map(one).collect()
}

fn panel(rows: &[Row], title: &str, name: &str, unit: &str, entries: &[Entry]) -> Figure {
    let largest = entries.iter().map(|e| e.value.abs()).fold(0.0, f64::max);
    // A wide interval must not flatten all values.
    let reach = |v: f64| v.min(2.5 * largest);
    let high = entries.iter().map(|e| reach(e.high)).fold(0.0, f64::max);
    let least = entries.iter().map(|e| e.low).fold(f64::INFINITY, f64::min);
    let span = high - least;
    // Far from zero the axis resolves the differences; near zero it includes zero.
    let (low, top) = if least > 0.0 && span < 0.5 * high {
        (least - 0.2 * span, high + 0.5 * span)
    } else {
        (0.0, 1.3 * high)
    };
    let scale = if unit == "%" {
        Scale { factor: 1.0, unit: unit.to_owned(), power: None }
    } else {
        Scale::for_size(largest, unit)
    };
    let s = scale.factor;
    let label = match scale.unit.trim_start_matches('×') {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    };
    let names = rows.iter().map(|r| r.file.clone()).collect();
    let mut figure = Figure::new(PANEL[0], PANEL[1]);
    let (x, y) = (Axis::numbered(names, "file"), Axis::linear(low * s, top * s, label));
    let mut panel = Panel::new(&mut figure, title, x, y);
    if entries.is_empty() {
        panel.note("no file gives it");
        return figure;
    }
    let (width, radius) = if rows.len() > MANY { (0.8, 1.8) } else { (1.6, 3.2) };
    for (warned, color) in [(false, CLEAN), (true, WARNED)] {
        let of = || entries.iter().filter(move |e| e.warned == warned);
        let bars = of().filter(|e| e.high > e.low).map(|e| [e.place, e.low * s, e.high.min(1e3 * top) * s]);
        panel.bars(bars, Stroke::solid(color.faded(0.6), width));
        panel.dots(of().map(|e| [e.place, e.value * s]), radius, color);
    }
    let mut legend = vec![(Mark::Dot(CLEAN), "without warnings")];
    if entries.iter().any(|e| e.warned) {
        legend.push((Mark::Dot(WARNED), "with warnings"));
    }
    panel.legend(&legend);
    figure
}
