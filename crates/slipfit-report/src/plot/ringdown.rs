//! The four panels of a ring-down.

use super::axis::Axis;
use super::decimate::decimate;
use super::figure::{Color, Figure, Point, Stroke};
use super::grid::{PANEL, headed};
use super::panel::{Mark, Panel};
use crate::AnalysedRingdown;
use crate::Sentence;
use crate::format::{Rounded, Scale};
use slipfit::answer::Candidate;
use slipfit::ringdown::{Answer, EnvelopePoint, LossPoint};
use slipfit::{LossModel, LossTerm, Parameter, SignalKind};

/// Okabe and Ito's colour-blind-safe palette.
const DATA: Color = Color::new(0x8f, 0xb4, 0xd0);
const LEFT_OUT: Color = Color::new(0xcf, 0xd3, 0xd8);
const FIT: Color = Color::new(0xd5, 0x5e, 0x00);
const VISCOUS: Color = Color::new(0x00, 0x72, 0xb2);
const SLIDING: Color = Color::new(0x00, 0x9e, 0x73);
const FREE: Color = Color::new(0xcc, 0x79, 0xa7);
const POINTS: Color = Color::new(0x55, 0x5b, 0x63);

const FIT_LINE: Stroke = Stroke::solid(FIT, 2.2);
const FREE_LINE: Stroke = Stroke::dashed(FREE, 1.6);
const VISCOUS_LINE: Stroke = Stroke::dashed(VISCOUS, 2.0);

/// A cycle narrower than this many units is drawn by its extremes only.
const NARROW_CYCLE: f64 = 7.0;
/// Above this number of points, error bars are replaced by a band.
const MOST_BARS: usize = 120;
/// Amplitudes below this fraction of the largest are off the logarithmic axis.
const LOG_FLOOR: f64 = 1e-4;

/// The individual panels.
pub(super) fn panels(analysed: &AnalysedRingdown<'_>) -> Vec<Figure> {
    let answer = analysed.answer;
    let scales = Scales::of(analysed);
    let mut panels: [Figure; 4] = std::array::from_fn(|_| Figure::new(PANEL[0], PANEL[1]));
    let [first, second, third, fourth] = &mut panels;
    signal(first, analysed, &scales);
    envelope(second, analysed, &scales);
    residuals(third, answer, &scales);
    loss(fourth, answer);
    panels.into()
}

pub(super) fn figure(analysed: &AnalysedRingdown<'_>) -> Figure {
    headed(&analysed.answer.sentence(), &subtitle(analysed), panels(analysed))
}

fn subtitle(analysed: &AnalysedRingdown<'_>) -> String {
    let file = analysed.file.file_name().unwrap_or(analysed.file.as_os_str()).to_string_lossy();
    let mut parts = vec![file.into_owned(), analysed.answer.model.to_string()];
    let linear = [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT, Parameter::SlidingRate];
    let others = LossTerm::ALL.iter().map(|term| Parameter::Loss(*term)).filter(|p| !linear.contains(p));
    let first = std::iter::once(Parameter::Frequency).chain(linear);
    for name in first.chain(others).chain([Parameter::CoulombForce]) {
        let twice = name == Parameter::SlidingRate
            && analysed.answer.parameter(Parameter::FRICTION_DISPLACEMENT).is_some();
        if let Some(q) = analysed.answer.parameter(name).filter(|q| q.value != 0.0 && !twice) {
            parts.push(format!("{} = {}", name.symbol(), Rounded::of(q)));
        }
    }
    parts.join("  ·  ")
}

/// The units the axes are drawn in.
struct Scales {
    time: Scale,
    amplitude: Scale,
    /// First and last instant of the record, s.
    range_s: [f64; 2],
}

impl Scales {
    fn of(analysed: &AnalysedRingdown<'_>) -> Self {
        let record = &analysed.reading.record;
        let range_s = [record.time_s(0), record.time_s(record.len() - 1)];
        let largest = analysed.answer.envelope.iter().map(|p| p.amplitude).fold(0.0, f64::max);
        Self {
            time: Scale::for_size(range_s[0].abs().max(range_s[1].abs()), "s"),
            amplitude: Scale::for_size(largest, &analysed.answer.signal_unit),
            range_s,
        }
    }

    fn time_axis(&self) -> Axis {
        let [low, high] = self.range_s.map(|t| t * self.time.factor);
        Axis::linear(low, high, titled("time", &self.time.unit))
    }
}

fn titled(name: &str, unit: &str) -> String {
    let unit = unit.trim_start_matches('×');
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// (a) The record and the fit.
fn signal(figure: &mut Figure, analysed: &AnalysedRingdown<'_>, scales: &Scales) {
    let record = &analysed.reading.record;
    let answer = analysed.answer;
    let (t, a) = (scales.time.factor, scales.amplitude.factor);
    let of_amplitudes = holds_amplitudes(record.kind());
    let value = |i: usize| match record.quadrature() {
        Some(quadrature) => record.signal()[i].hypot(quadrature[i]),
        None => record.signal()[i],
    };
    let points = decimate(
        (0..record.len()).map(|i| [record.time_s(i) * t, value(i) * a]),
        scales.range_s.map(|s| s * t),
        (PANEL[0] - 88.0) as usize,
    );
    let (low, high) =
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[1]), h.max(p[1])));
    let pad = 0.05 * (high - low);
    let name = if of_amplitudes { "amplitude" } else { "signal" };
    let y = Axis::linear(
        if of_amplitudes { low.min(0.0) } else { low - pad },
        high + pad,
        titled(name, &scales.amplitude.unit),
    );
    let mut panel = Panel::new(figure, "record and fit", scales.time_axis(), y);

    let used = [answer.segment.start_s * t, answer.segment.end_s * t];
    let inside = |p: &Point| (used[0]..=used[1]).contains(&p[0]);
    let sparse = points.len() <= 300;
    // Wider than the fit, so that the data remain visible around it where both agree.
    let wide = |color| Stroke::solid(color, 3.2);
    // Left-out data are drawn throughout and used data on top of them, so that there is no gap between them.
    panel.line(points.iter().copied(), wide(LEFT_OUT));
    panel.line(points.iter().copied().filter(inside), wide(DATA));
    if sparse {
        panel.dots(points.iter().copied(), 2.0, DATA);
    }
    for line in fit_lines(answer, scales, panel.columns()) {
        panel.line(line, Stroke::solid(FIT, 1.2));
    }
    let mut legend = vec![(Mark::Line(Stroke::solid(DATA, 4.0)), "data used")];
    if points.iter().any(|p| !inside(p)) {
        legend.push((Mark::Line(Stroke::solid(LEFT_OUT, 4.0)), "left out"));
    }
    legend.push((Mark::Line(Stroke::solid(FIT, 1.2)), "fit"));
    panel.legend(&legend);
}

/// Whether the record holds amplitudes instead of the motion itself.
fn holds_amplitudes(kind: SignalKind) -> bool {
    matches!(kind, SignalKind::Envelope | SignalKind::LockIn)
}

/// The fitted motion, or its upper and lower edge if its cycles are too narrow to be seen.
fn fit_lines(answer: &Answer, scales: &Scales, columns: usize) -> Vec<Vec<Point>> {
    let (t, a) = (scales.time.factor, scales.amplitude.factor);
    let [start, end] = answer.fit.range_s();
    let per_column_s = (scales.range_s[1] - scales.range_s[0]) / columns as f64;
    if !(end > start && per_column_s > 0.0) {
        return Vec::new();
    }
    let frequency_hz = answer.parameter(Parameter::Frequency).map_or(0.0, |q| q.value);
    let cycle_s =
        if answer.segment.cycles > 0.0 && frequency_hz > 0.0 { 1.0 / frequency_hz } else { f64::INFINITY };
    let sample = |steps: usize| (0..=steps).map(move |i| start + (end - start) * i as f64 / steps as f64);
    if cycle_s >= NARROW_CYCLE * per_column_s {
        let steps = (2.0 * (end - start) / per_column_s).ceil() as usize;
        return vec![sample(steps.max(2)).map(|s| [s * t, answer.fit.signal_at(s) * a]).collect()];
    }
    let steps = ((end - start) / per_column_s).ceil() as usize;
    let edge = |pick: fn(f64, f64) -> f64| {
        let extreme = |s: f64| {
            // A whole cycle, kept within the fitted segment.
            let first = s.min(end - cycle_s).max(start);
            let at = |k: i32| answer.fit.signal_at((first + cycle_s * f64::from(k) / 24.0).min(end));
            (0..24).map(at).fold(f64::NAN, pick)
        };
        sample(steps.max(2)).map(|s| [s * t, extreme(s) * a]).collect()
    };
    vec![edge(f64::min), edge(f64::max)]
}

fn viscous(answer: &Answer) -> Option<&Candidate> {
    let alternative = |c: &&Candidate| c.model == LossModel::VISCOUS && c.converged;
    (answer.model != LossModel::VISCOUS).then(|| answer.comparison.iter().find(alternative)).flatten()
}

/// Amplitude of the viscous alternative.
fn viscous_amplitude(answer: &Answer, candidate: &Candidate, time_s: f64) -> f64 {
    candidate.value(Parameter::InitialAmplitude)
        * (-candidate.value(Parameter::DECAY_RATE) * (time_s - answer.segment.start_s)).exp()
}

/// Times along the fitted segment.
fn along(answer: &Answer, steps: i32) -> impl Iterator<Item = f64> + use<> {
    let [start, end] = answer.fit.range_s();
    (0..=steps).map(move |i| start + (end - start) * f64::from(i) / f64::from(steps))
}

/// (b) The envelope on an axis on which a viscous decay is straight.
fn envelope(figure: &mut Figure, analysed: &AnalysedRingdown<'_>, scales: &Scales) {
    let answer = analysed.answer;
    let (t, a) = (scales.time.factor, scales.amplitude.factor);
    let amplitudes = |used: bool| {
        answer.envelope.iter().filter(move |p| p.used == used).map(|p| p.amplitude).filter(|v| *v > 0.0)
    };
    let high = amplitudes(true).chain(amplitudes(false)).fold(0.0, f64::max);
    let used_low = amplitudes(true).fold(high, f64::min);
    // Some of the left-out amplitudes below are shown, but not their whole noise.
    let low = amplitudes(false).fold(used_low, f64::min).max(used_low / 20.0).max(LOG_FLOOR * high);
    let y = Axis::log(0.6 * low * a, 1.4 * high * a, titled("amplitude", &scales.amplitude.unit));
    let title = "envelope: a viscous decay would be straight";
    let mut panel = Panel::new(figure, title, scales.time_axis(), y);
    let dots = |used: bool| {
        let kept = answer.envelope.iter().filter(move |p| p.used == used);
        kept.map(move |p| ([p.time_s * t, p.amplitude * a], p.std_error * a))
    };
    let radius = if answer.envelope.len() > 300 { 1.8 } else { 2.6 };
    panel.sized_dots(dots(false), radius, LEFT_OUT);
    panel.sized_dots(dots(true), radius, POINTS);
    let mut legend = vec![(Mark::Dot(POINTS), "measured")];
    if let Some(candidate) = viscous(answer) {
        panel.line(
            along(answer, 200).map(|s| [s * t, viscous_amplitude(answer, candidate, s) * a]),
            VISCOUS_LINE,
        );
        legend.push((Mark::Line(VISCOUS_LINE), "purely viscous"));
    }
    // A measured amplitude includes its noise floor, so the fit is drawn with it.
    let of_amplitudes = holds_amplitudes(analysed.reading.record.kind());
    let fitted = |s: f64| if of_amplitudes { answer.fit.signal_at(s) } else { answer.fit.amplitude_at(s) };
    panel.line(along(answer, 400).map(|s| [s * t, fitted(s) * a]), FIT_LINE);
    legend.insert(1, (Mark::Line(FIT_LINE), answer.model.name()));
    panel.legend(&legend);
}

/// (c) Residuals of the fit.
fn residuals(figure: &mut Figure, answer: &Answer, scales: &Scales) {
    let used: Vec<&EnvelopePoint> =
        answer.envelope.iter().filter(|p| p.used && (p.amplitude - p.fitted).is_finite()).collect();
    let extents = || used.iter().map(|p| (p.amplitude - p.fitted).abs() + finite_or_zero(p.std_error));
    let largest = extents().fold(0.0, f64::max);
    // A few outliers must not flatten the rest.
    let size =
        if largest > 3.0 * quantile(extents(), 0.95) { 1.5 * quantile(extents(), 0.95) } else { largest };
    let scale = Scale::for_size(size, &answer.signal_unit);
    let (t, a) = (scales.time.factor, scale.factor);
    let y = Axis::linear(-1.15 * size * a, 1.9 * size * a, titled("data − fit", &scale.unit));
    let mut panel = Panel::new(figure, "residuals of the envelope", scales.time_axis(), y);
    if used.is_empty() {
        panel.note("no amplitudes inside the fitted part");
        return;
    }
    let sigma = |p: &EnvelopePoint| finite_or_zero(p.std_error) * a;
    if used.len() > MOST_BARS {
        let band: Vec<[f64; 3]> = used.iter().map(|p| [p.time_s * t, -sigma(p), sigma(p)]).collect();
        panel.band(&band, POINTS.faded(0.16));
    } else {
        let bar = |p: &&EnvelopePoint| {
            let r = (p.amplitude - p.fitted) * a;
            [p.time_s * t, r - sigma(p), r + sigma(p)]
        };
        panel.bars(used.iter().map(bar), Stroke::solid(POINTS.faded(0.6), 1.0));
    }
    let mut legend = vec![(Mark::Dot(POINTS), answer.model.name())];
    if used.len() > MOST_BARS {
        legend.push((Mark::Patch(POINTS.faded(0.16)), "±σ of the data"));
    }
    if let Some(candidate) = viscous(answer) {
        let difference = |s: f64| (answer.fit.amplitude_at(s) - viscous_amplitude(answer, candidate, s)) * a;
        panel.line(along(answer, 400).map(|s| [s * t, difference(s)]), VISCOUS_LINE);
        legend.push((Mark::Line(VISCOUS_LINE), "residuals if purely viscous"));
    }
    panel.line(scales.range_s.map(|s| [s * t, 0.0]), FIT_LINE);
    let outside =
        used.iter().filter(|p| !(-1.15 * size..=1.9 * size).contains(&(p.amplitude - p.fitted))).count();
    if outside > 0 {
        panel.remark(&format!("{outside} of {} beyond the axis", used.len()));
    }
    let radius = if used.len() > 300 { 1.8 } else { 2.6 };
    let dots = used.iter().map(|p| ([p.time_s * t, (p.amplitude - p.fitted) * a], sigma(p)));
    panel.sized_dots(dots, radius, POINTS);
    panel.legend(&legend);
}

/// (d) Loss against amplitude: sliding friction is the part that does not vanish with amplitude.
fn loss(figure: &mut Figure, answer: &Answer) {
    let mut points: Vec<&LossPoint> = answer.loss.iter().filter(|p| p.amplitude.is_finite()).collect();
    points.sort_by(|p, q| p.amplitude.total_cmp(&q.amplitude));
    let largest = points.iter().map(|p| p.amplitude).fold(0.0, f64::max);
    let x_scale = Scale::for_size(largest, &answer.signal_unit);
    let fitted = points.iter().map(|p| p.fitted).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let measured = quantile(points.iter().map(|p| p.loss_per_cycle), 0.98);
    let high =
        if fitted > 0.0 { (1.25 * fitted).max(1.1 * measured.min(2.0 * fitted)) } else { 1.1 * measured };
    let y_scale = Scale::for_size(high, &answer.signal_unit);
    let (x, y) = (x_scale.factor, y_scale.factor);
    // Without a frequency the core gives losses per second.
    let per = if answer.parameter(Parameter::Frequency).is_some() { "per cycle" } else { "per second" };
    let lowest = points.iter().map(|p| p.loss_per_cycle).filter(|v| v.is_finite()).fold(0.0, f64::min);
    let x_axis = Axis::linear(0.0, 1.04 * largest * x, titled("amplitude", &x_scale.unit));
    let y_axis =
        Axis::linear(lowest.max(-0.3 * high) * y, high * y, titled(&format!("loss {per}"), &y_scale.unit));
    let mut panel = Panel::new(figure, &format!("amplitude lost {per}"), x_axis, y_axis);
    if points.is_empty() {
        panel.note("the record gives no loss point by point");
        return;
    }
    let mut legend = vec![(Mark::Dot(POINTS), "measured"), (Mark::Line(FIT_LINE), answer.model.name())];
    if answer.model.has_sliding() {
        // Sliding friction takes the same amplitude from every cycle, down to rest.
        let mut band: Vec<[f64; 3]> =
            points.iter().map(|p| [p.amplitude * x, 0.0, p.fitted_sliding * y]).collect();
        if let Some(&[_, _, first]) = band.first() {
            band.insert(0, [0.0, 0.0, first]);
        }
        panel.band(&band, SLIDING.faded(0.22));
        panel.line(band.iter().map(|b| [b[0], b[2]]), Stroke::solid(SLIDING, 2.0));
        legend.push((Mark::Patch(SLIDING.faded(0.45)), "sliding part"));
    }
    if let Some(law) = &answer.free_law {
        let band: Vec<[f64; 3]> =
            law.curve.iter().map(|p| [p.amplitude * x, p.low_95 * y, p.high_95.min(high) * y]).collect();
        panel.band(&band, FREE.faded(0.22));
        panel.line(law.curve.iter().map(|p| [p.amplitude * x, p.loss_per_cycle * y]), FREE_LINE);
        legend.push((Mark::Patch(FREE.faded(0.45)), "without a model, 95 %"));
    }
    if points.len() <= MOST_BARS {
        let bar = |p: &&LossPoint| {
            let sigma = finite_or_zero(p.std_error);
            [p.amplitude * x, (p.loss_per_cycle - sigma) * y, (p.loss_per_cycle + sigma) * y]
        };
        panel.bars(points.iter().map(bar), Stroke::solid(POINTS.faded(0.6), 1.0));
    }
    let dots = points.iter().map(|p| ([p.amplitude * x, p.loss_per_cycle * y], p.std_error * y));
    panel.sized_dots(dots, 2.6, POINTS);
    panel.line(points.iter().map(|p| [p.amplitude * x, p.fitted * y]), FIT_LINE);
    panel.legend(&legend);
}

fn finite_or_zero(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

/// Quantile `share` of the finite values; zero if there are none.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let index = (share * sorted.len() as f64) as usize;
    sorted.get(index.min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_ignore_what_is_no_number() {
        assert_eq!(quantile([3.0, f64::NAN, 1.0, 2.0].into_iter(), 0.99), 3.0);
        assert_eq!(quantile(std::iter::empty(), 0.5), 0.0);
    }
}
