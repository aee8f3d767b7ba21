//! Friction and damping against the condition.

use super::axis::Axis;
use super::figure::{Color, Figure, Stroke};
use super::grid::{PANEL, headed};
use super::panel::{Mark, Panel};
use crate::AnalysedSeries;
use crate::Sentence;
use crate::format::Scale;
use slipfit::Quantity;
use slipfit::series::{ConditionRow, Estimate, LawFit, LoadLaw};

/// Higher than other panels, because there is only one row.
const HEIGHT: f64 = 360.0;

const RING_DOWN: Color = Color::new(0x00, 0x72, 0xb2);
const RESONANCE: Color = Color::new(0xd5, 0x5e, 0x00);
const JOINT: Color = Color::new(0x22, 0x22, 0x22);
const LAW: Stroke = Stroke::dashed(Color::new(0x8a, 0x92, 0x9c), 2.0);

type Part = fn(&Estimate) -> &Quantity;

/// The individual panels.
pub(super) fn panels(analysed: &AnalysedSeries<'_>) -> Vec<Figure> {
    let forces = analysed.options.calibration.is_some();
    let (friction, damping) = if forces {
        ("sliding friction F", "viscous coefficient γ")
    } else {
        ("friction displacement x_F", "decay rate δ")
    };
    vec![
        panel(analysed, friction, |c| &c.friction, &analysed.answer.laws),
        panel(analysed, damping, |c| &c.damping, &[]),
    ]
}

pub(super) fn figure(analysed: &AnalysedSeries<'_>) -> Figure {
    let sentence = analysed.answer.sentence();
    let bars = "Bars: one standard error.";
    let panels = panels(analysed);
    match analysed.heading.title.as_str() {
        "" => headed(&sentence, bars, panels),
        title => headed(title, &format!("{sentence} {bars}"), panels),
    }
}

fn panel(analysed: &AnalysedSeries<'_>, name: &str, part: Part, laws: &[LawFit]) -> Figure {
    let mut figure = Figure::new(PANEL[0], HEIGHT);
    let rows = &analysed.answer.table;
    let cells = || rows.iter().flat_map(|r| [&r.ring_down, &r.resonance, &r.joint]).flatten().map(part);
    let ends =
        |q: &Quantity, sign: f64| q.value + sign * if q.std_error.is_finite() { q.std_error } else { 0.0 };
    let high = cells().map(|q| ends(q, 1.0)).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let least = cells().map(|q| ends(q, -1.0)).filter(|v| v.is_finite()).fold(f64::INFINITY, f64::min);
    // Far from zero the axis resolves the differences; near zero it includes zero.
    let span = high - least;
    let (low, top) = if least > 0.0 && span < 0.5 * high {
        (least - 0.35 * span, high + 0.6 * span)
    } else {
        (1.1 * least.min(0.0), 1.3 * high)
    };
    let unit = cells().next().map_or("", |q| q.unit.as_str());
    let scale = Scale::for_size(high, unit);
    let s = scale.factor;
    let places = Places::of(rows);
    let x = places.axis(analysed, rows);
    let label = match scale.unit.trim_start_matches('×') {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    };
    let y = Axis::linear(low * s, top * s, label);
    let mut panel = Panel::new(&mut figure, name, x, y);
    let mut legend: Vec<(Mark, &str)> = Vec::new();
    let law = laws.first().filter(|_| analysed.answer.has_friction());
    let law_name = law.map(|l| l.law.to_string()).unwrap_or_default();
    if let (Places::Values { range, .. }, Some(law)) = (&places, law) {
        let along = (0..=100).map(|i| range[0] + (range[1] - range[0]) * f64::from(i) / 100.0);
        panel.line(along.map(|n| [n, at_load(law, n) * s]), LAW);
        legend.push((Mark::Line(LAW), &law_name));
    }
    type Way = fn(&ConditionRow) -> &Option<Estimate>;
    let ways: [(Way, Color, &str, f64); 3] = [
        (|r| &r.joint, JOINT, "both together", 0.0),
        (|r| &r.ring_down, RING_DOWN, "ring-down", -1.0),
        (|r| &r.resonance, RESONANCE, "resonance", 1.0),
    ];
    // With a single method there is no joint value to draw.
    let alone = analysed.answer.methods() != [true; 2];
    for (way, color, name, side) in ways.into_iter().skip(usize::from(alone)) {
        let side = if alone { 0.0 } else { side };
        let points: Vec<[f64; 3]> = rows
            .iter()
            .enumerate()
            .filter_map(|(i, r)| way(r).as_ref().map(|c| (i, part(c))))
            .map(|(i, q)| {
                [places.at(i) + side * places.half_separation(), ends(q, -1.0) * s, ends(q, 1.0) * s]
            })
            .collect();
        if points.is_empty() {
            continue;
        }
        panel.bars(points.iter().copied(), Stroke::solid(color, 2.0));
        let dots = points.iter().map(|p| ([p[0], 0.5 * (p[1] + p[2])], 0.5 * (p[2] - p[1])));
        panel.sized_dots(dots, 3.6, color);
        legend.push((Mark::Dot(color), name));
    }
    panel.legend(&legend);
    figure
}

/// Positions of the conditions.
enum Places {
    Values { values: Vec<f64>, range: [f64; 2] },
    Named,
}

impl Places {
    fn of(rows: &[ConditionRow]) -> Self {
        let values: Option<Vec<f64>> = rows.iter().map(|r| r.value.map(|v| v[0])).collect();
        match values {
            Some(values) => {
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                if values.len() < 2 || !(high > low) {
                    return Self::Named;
                }
                let pad = 0.1 * (high - low);
                let from = if low >= 0.0 && low - pad < 0.0 { -pad } else { low - pad };
                Self::Values { values, range: [from, high + pad] }
            }
            None => Self::Named,
        }
    }

    fn at(&self, index: usize) -> f64 {
        match self {
            Self::Values { values, .. } => values[index],
            Self::Named => index as f64 + 1.0,
        }
    }

    /// Half the distance between the two methods of one condition.
    fn half_separation(&self) -> f64 {
        match self {
            Self::Values { range, .. } => 0.016 * (range[1] - range[0]),
            Self::Named => 0.12,
        }
    }

    fn axis(&self, analysed: &AnalysedSeries<'_>, rows: &[ConditionRow]) -> Axis {
        let (name, unit) = (&analysed.heading.condition, &analysed.heading.condition_unit);
        match self {
            Self::Values { range, .. } => {
                let label = if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") };
                Axis::linear(range[0], range[1], label)
            }
            Self::Named => Axis::named(rows.iter().map(|r| r.condition.clone()).collect(), name.clone()),
        }
    }
}

/// A law of friction at a load, in the unit of the table.
fn at_load(law: &LawFit, load: f64) -> f64 {
    let (c, offset) = (law.coefficient.value, law.offset.as_ref().map_or(0.0, |q| q.value));
    match law.law {
        LoadLaw::Proportional => c * load,
        LoadLaw::Amontons => c * load + offset,
        LoadLaw::Adhesive => c * (load + offset),
        LoadLaw::Hertz => c * load.max(0.0).powf(2.0 / 3.0),
        _ => f64::NAN,
    }
}
