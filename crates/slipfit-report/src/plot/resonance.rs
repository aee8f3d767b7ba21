//! The panels of a resonance curve.

use super::axis::Axis;
use super::figure::{Color, Figure, Point, Stroke};
use super::grid::{PANEL, headed};
use super::panel::{Mark, Panel};
use crate::AnalysedCurve;
use crate::Sentence;
use crate::format::{Rounded, Scale};
use slipfit::Parameter;
use slipfit::motion::steady::Phasor;
use slipfit::resonance::{Answer, CurvePoint};

/// Width over height of the axes of a panel, without labels.
const ASPECT: f64 = 442.0 / 252.0;

const FIT: Color = Color::new(0xd5, 0x5e, 0x00);
const POINTS: Color = Color::new(0x33, 0x66, 0x99);
const GHOST: Color = Color::new(0xa9, 0xb0, 0xb8);
const REFERENCE: Color = Color::new(0x00, 0x9e, 0x73);
const FIT_LINE: Stroke = Stroke::solid(FIT, 2.2);
const GHOST_LINE: Stroke = Stroke::solid(GHOST, 3.0);
/// A friction-free curve higher than this multiple of the data leaves the axes.
const GHOST_HEIGHT: f64 = 2.2;
/// Above this number of points, error bars are replaced by a band of dots.
const MOST_BARS: usize = 150;
/// Points at which curves are evaluated.
const STEPS: i32 = 800;

/// The individual panels.
pub(super) fn panels(analysed: &AnalysedCurve<'_>) -> Vec<Figure> {
    type Drawing = fn(&mut Figure, &View<'_>);
    let mut panels: Vec<Drawing> = vec![amplitude, residuals];
    if has_phases(analysed.answer) {
        panels = vec![amplitude, phase, residuals, circle];
        if !analysed.answer.force.is_empty() {
            panels.extend([dissipative as Drawing, elastic as Drawing]);
        }
    }
    let view = View::of(analysed);
    let draw = |panel: Drawing| {
        let mut figure = Figure::new(PANEL[0], PANEL[1]);
        panel(&mut figure, &view);
        figure
    };
    panels.into_iter().map(draw).collect()
}

pub(super) fn figure(analysed: &AnalysedCurve<'_>) -> Figure {
    headed(&analysed.answer.sentence(), &subtitle(analysed), panels(analysed))
}

fn subtitle(analysed: &AnalysedCurve<'_>) -> String {
    let path = std::path::Path::new(&analysed.reading.report.path);
    let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let mut parts = vec![file.into_owned(), analysed.answer.model.to_string()];
    for name in [
        Parameter::NaturalFrequency,
        Parameter::DECAY_RATE,
        Parameter::FRICTION_DISPLACEMENT,
        Parameter::DriveAmplitude,
        Parameter::CoulombForce,
    ] {
        if let Some(q) = analysed.answer.parameter(name).filter(|q| q.value != 0.0 && q.value.is_finite()) {
            parts.push(format!("{} = {}", name.symbol(), Rounded::of(q)));
        }
    }
    parts.join("  ·  ")
}

/// The units the axes are drawn in.
struct View<'a> {
    answer: &'a Answer,
    complex: bool,
    /// Frequency from which the axis counts, in units of `frequency`.
    base_hz: f64,
    frequency: Scale,
    frequency_label: String,
    /// Lowest and highest frequency measured, Hz.
    range_hz: [f64; 2],
    amplitude: Scale,
    /// Fitted background subtracted from the amplitudes because it would hide them.
    background: Phasor,
    /// Largest amplitude measured or fitted, response unit.
    largest: f64,
}

impl<'a> View<'a> {
    fn of(analysed: &AnalysedCurve<'a>) -> Self {
        let answer = analysed.answer;
        let f = |p: &CurvePoint| p.frequency_hz;
        let low = answer.points.iter().map(f).fold(f64::INFINITY, f64::min);
        let high = answer.points.iter().map(f).fold(f64::NEG_INFINITY, f64::max);
        let span = high - low;
        // The frequencies of a narrow line far from zero are shown relative to its centre.
        let natural = answer.parameter(Parameter::NaturalFrequency).map_or(0.5 * (low + high), |q| q.value);
        let decade = 10f64.powf((0.02 * span).log10().floor());
        let base = (natural / decade).round() * decade;
        let shifted = span < 0.03 * natural && base.is_finite();
        let base_hz = if shifted { base } else { 0.0 };
        let frequency = Scale::for_size(if shifted { span } else { high }, "Hz");
        let decimals = (-decade.log10()).max(0.0) as usize;
        let name =
            if shifted { format!("frequency − {base:.decimals$} Hz") } else { "frequency".to_owned() };
        let frequency_label = titled(&name, &frequency.unit);
        let background = dominant_background(answer);
        let largest = answer
            .points
            .iter()
            .flat_map(|p| [measured(p, background), fitted(p, background)])
            .filter(|v| v.is_finite())
            .fold(0.0, f64::max);
        Self {
            answer,
            complex: has_phases(answer),
            background,
            base_hz,
            frequency,
            frequency_label,
            range_hz: [low, high],
            amplitude: Scale::for_size(largest, &answer.unit),
            largest,
        }
    }

    fn x(&self, frequency_hz: f64) -> f64 {
        (frequency_hz - self.base_hz) * self.frequency.factor
    }

    fn x_axis(&self) -> Axis {
        let [low, high] = self.range_hz;
        let pad = 0.02 * (high - low);
        Axis::linear(self.x(low - pad), self.x(high + pad), self.frequency_label.clone())
    }

    /// Frequencies across the curve, denser where it is narrow.
    fn across(&self) -> Vec<f64> {
        let [low, high] = self.range_hz;
        let even = (0..=STEPS).map(|i| low + (high - low) * f64::from(i) / f64::from(STEPS));
        let natural = self.answer.parameter(Parameter::NaturalFrequency).map_or(f64::NAN, |q| q.value);
        let width =
            self.answer.parameter(Parameter::DECAY_RATE).map_or(0.0, |q| q.value) / std::f64::consts::PI;
        let near = (-200..=200).map(|i| natural + 4.0 * width * f64::from(i) / 200.0);
        let mut list: Vec<f64> = even.chain(near).filter(|f| (low..=high).contains(f)).collect();
        list.sort_by(f64::total_cmp);
        list
    }

    /// The title, with a remark on the subtracted background.
    fn title_with_background(&self, title: &str) -> String {
        let off = if self.background == Phasor::default() { "" } else { ", background subtracted" };
        format!("{title}{off}")
    }

    fn radius(&self) -> f32 {
        match self.answer.points.len() {
            n if n > 2000 => 1.1,
            n if n > 300 => 1.7,
            _ => 2.8,
        }
    }
}

/// Whether the fit used phases.
fn has_phases(answer: &Answer) -> bool {
    answer.points.iter().any(|p| p.phase_rad.is_some())
}

/// The fitted background, if it hides the line and phases distinguish the two; otherwise zero.
fn dominant_background(answer: &Answer) -> Phasor {
    let Some([re, im]) = answer.instrument.background.as_ref().filter(|_| has_phases(answer)) else {
        return Phasor::default();
    };
    let background = Phasor::new(re.value, im.value);
    let line =
        answer.points.iter().map(|p| fitted(p, background)).filter(|v| v.is_finite()).fold(0.0, f64::max);
    if background.norm() > 0.7 * line { background } else { Phasor::default() }
}

fn measured(p: &CurvePoint, background: Phasor) -> f64 {
    p.phase_rad.map_or(p.amplitude, |phase| (Phasor::from_polar(p.amplitude, phase) - background).norm())
}

fn fitted(p: &CurvePoint, background: Phasor) -> f64 {
    if background == Phasor::default() {
        return p.fitted_amplitude;
    }
    (Phasor::from_polar(p.fitted_amplitude, p.fitted_phase_rad) - background).norm()
}

fn titled(name: &str, unit: &str) -> String {
    let unit = unit.trim_start_matches('×');
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// (a) Amplitude, with the friction-free curve behind it.
fn amplitude(figure: &mut Figure, view: &View<'_>) {
    let answer = view.answer;
    let a = view.amplitude.factor;
    let across = view.across();
    let ghost: Vec<Point> = if answer.model.has_sliding() {
        across
            .iter()
            .map(|&f| [view.x(f), (answer.fit.friction_free(f) - view.background).norm() * a])
            .collect()
    } else {
        Vec::new()
    };
    let peak = ghost.iter().map(|p| p[1]).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let top = view.largest * a;
    let reference_peak =
        answer.reference.iter().flat_map(|r| &r.points).map(|p| p.amplitude * a).fold(0.0, f64::max);
    // A curve behind the data may be higher, but must not flatten them.
    let highest = [peak, reference_peak].into_iter().filter(|v| *v <= GHOST_HEIGHT * top).fold(top, f64::max);
    let high = if peak > GHOST_HEIGHT * top { 1.25 * highest } else { 1.06 * highest };
    let y = Axis::linear(0.0, high, titled("amplitude", &view.amplitude.unit));
    let mut panel = Panel::new(figure, &view.title_with_background("amplitude and fit"), view.x_axis(), y);
    let mut legend = vec![(Mark::Dot(POINTS), "measured")];
    if !ghost.is_empty() {
        panel.line(ghost, GHOST_LINE);
        if peak > high {
            panel.remark(&format!("friction-free peak {:.1} times as high as the data", peak / top));
        }
    }
    let reference = answer.reference.as_ref();
    if let Some(reference) = reference {
        let dots = reference.points.iter().map(|p| [view.x(p.frequency_hz), p.amplitude * a]);
        panel.dots(dots, view.radius() * 0.8, REFERENCE.faded(0.55));
        legend.push((Mark::Dot(REFERENCE), "reference"));
    }
    let dots = answer
        .points
        .iter()
        .map(|p| ([view.x(p.frequency_hz), measured(p, view.background) * a], p.std_error * a));
    panel.sized_dots(dots, view.radius(), POINTS);
    panel.line(
        across.iter().map(|&f| [view.x(f), (answer.fit.response(f) - view.background).norm() * a]),
        FIT_LINE,
    );
    legend.push((Mark::Line(FIT_LINE), answer.model.name()));
    if answer.model.has_sliding() {
        legend.push((Mark::Line(GHOST_LINE), "without friction"));
    }
    panel.legend(&legend);
}

/// (b) Phase relative to the drive.
fn phase(figure: &mut Figure, view: &View<'_>) {
    let answer = view.answer;
    // Both are unwrapped along the frequency, starting in the same turn.
    let fitted = unwrapped(view.across().iter().map(|&f| (f, answer.fit.response(f))));
    let ghost = unwrapped(view.across().iter().map(|&f| (f, answer.fit.friction_free(f))));
    let near = |f: f64| {
        let at = fitted.partition_point(|p| p[0] < f).min(fitted.len().saturating_sub(1));
        fitted.get(at).map_or(0.0, |p| p[1])
    };
    let measured: Vec<Point> = answer
        .points
        .iter()
        .filter_map(|p| p.phase_rad.map(|phase| (p.frequency_hz, phase.to_degrees())))
        .map(|(f, deg)| [f, deg - 360.0 * ((deg - near(f)) / 360.0).round()])
        .collect();
    let all = || measured.iter().chain(&fitted).map(|p| p[1]).filter(|v| v.is_finite());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let pad = 0.06 * (high - low).max(1.0);
    let y = Axis::linear(low - pad, high + pad, "phase against the drive [°]");
    let mut panel = Panel::new(figure, "phase and fit", view.x_axis(), y);
    let shown = |points: &[Point]| points.iter().map(|p| [view.x(p[0]), p[1]]).collect::<Vec<_>>();
    let mut legend = vec![(Mark::Dot(POINTS), "measured"), (Mark::Line(FIT_LINE), answer.model.name())];
    if answer.model.has_sliding() {
        panel.line(shown(&ghost), GHOST_LINE);
        legend.push((Mark::Line(GHOST_LINE), "without friction"));
    }
    panel.dots(shown(&measured), view.radius(), POINTS);
    panel.line(shown(&fitted), FIT_LINE);
    panel.legend(&legend);
}

/// Phases in degrees, unwrapped.
fn unwrapped(points: impl Iterator<Item = (f64, Phasor)>) -> Vec<Point> {
    let mut list: Vec<Point> = Vec::new();
    for (f, z) in points {
        let deg = z.arg().to_degrees();
        if !deg.is_finite() || z.norm() == 0.0 {
            continue;
        }
        let before = list.last().map_or(deg, |p| p[1]);
        list.push([f, deg - 360.0 * ((deg - before) / 360.0).round()]);
    }
    list
}

/// (c) Residuals of the fit.
fn residuals(figure: &mut Figure, view: &View<'_>) {
    let points = &view.answer.points;
    let all = || points.iter().flat_map(|p| [p.residual, p.residual_across]).filter(|v| v.is_finite());
    let mut sizes: Vec<f64> = all().map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    let most = sizes.last().copied().unwrap_or(0.0);
    let usual = sizes.get(sizes.len() * 98 / 100).copied().unwrap_or(most);
    // A few outliers must not flatten the rest.
    let size = if most > 3.0 * usual && usual > 0.0 { 1.6 * usual } else { most };
    let sigma = points.iter().map(|p| p.std_error).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let size = size.max(if sigma < 3.0 * size { sigma } else { 0.0 });
    let scale = Scale::for_size(size, &view.answer.unit);
    let s = scale.factor;
    let y = Axis::linear(-1.25 * size * s, 1.75 * size * s, titled("data − fit", &scale.unit));
    let mut panel = Panel::new(figure, "residuals", view.x_axis(), y);
    panel.line(view.range_hz.map(|f| [view.x(f), 0.0]), FIT_LINE);
    if points.len() <= MOST_BARS {
        let bar = |p: &CurvePoint| {
            let e = if p.std_error.is_finite() { p.std_error } else { 0.0 };
            [view.x(p.frequency_hz), (p.residual - e) * s, (p.residual + e) * s]
        };
        panel.bars(points.iter().map(bar), Stroke::solid(POINTS.faded(0.5), 1.0));
    }
    let mut legend =
        vec![(Mark::Dot(POINTS), if view.complex { "along the fitted phase" } else { "amplitude" })];
    if view.complex {
        let dots = points.iter().map(|p| [view.x(p.frequency_hz), p.residual_across * s]);
        panel.dots(dots, view.radius(), REFERENCE);
        legend.push((Mark::Dot(REFERENCE), "across it"));
    }
    let dots = points.iter().map(|p| ([view.x(p.frequency_hz), p.residual * s], p.std_error * s));
    panel.sized_dots(dots, view.radius(), POINTS);
    let beyond = all().filter(|v| !(-1.25 * size..=1.75 * size).contains(v)).count();
    if beyond > 0 {
        panel.remark(&format!("{beyond} of {} beyond the axis", all().count()));
    }
    panel.legend(&legend);
}

/// (d) The response in the complex plane: a circle for viscous loss alone.
fn circle(figure: &mut Figure, view: &View<'_>) {
    let answer = view.answer;
    let a = view.amplitude.factor;
    let place = |z: Phasor| [z.re * a, z.im * a];
    let measured: Vec<Point> = answer
        .points
        .iter()
        .filter_map(|p| {
            p.phase_rad.map(|phase| place(Phasor::from_polar(p.amplitude, phase) - view.background))
        })
        .collect();
    let across = view.across();
    let fitted: Vec<Point> =
        across.iter().map(|&f| place(answer.fit.response(f) - view.background)).collect();
    let ghost: Vec<Point> =
        across.iter().map(|&f| place(answer.fit.friction_free(f) - view.background)).collect();
    let extent = |points: &[Point]| {
        points.iter().flatten().map(|v| v.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max)
    };
    let most = GHOST_HEIGHT * extent(&measured).max(extent(&fitted));
    let with_ghost = answer.model.has_sliding() && extent(&ghost) <= most;
    let shown = || {
        let ghost = if with_ghost { &ghost[..] } else { &[] };
        measured.iter().chain(&fitted).chain(ghost).chain([&[0.0, 0.0]]).copied()
    };
    let range = |axis: usize| {
        let values = || shown().map(move |p| p[axis]).filter(|v| v.is_finite());
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let ((x_low, x_high), (y_low, y_high)) = (range(0), range(1));
    // Equal scales in both directions.
    let height = 1.12 * (y_high - y_low).max((x_high - x_low) / ASPECT).max(f64::MIN_POSITIVE);
    let width = height * ASPECT;
    let (x_mid, y_mid) = (0.5 * (x_low + x_high), 0.5 * (y_low + y_high));
    let unit = &view.amplitude.unit;
    // The circle lies left of the middle; the legend is on the right.
    let x = Axis::linear(x_mid - 0.4 * width, x_mid + 0.6 * width, titled("in phase with the drive", unit));
    let y = Axis::linear(y_mid - 0.5 * height, y_mid + 0.5 * height, titled("in quadrature", unit));
    let title = "complex plane: a circle without friction";
    let mut panel = Panel::new(figure, &view.title_with_background(title), x, y);
    let mut legend = vec![(Mark::Dot(POINTS), "measured"), (Mark::Line(FIT_LINE), answer.model.name())];
    if answer.model.has_sliding() {
        panel.line(ghost, GHOST_LINE);
        legend.push((Mark::Line(GHOST_LINE), "without friction"));
    }
    panel.dots(measured, view.radius(), POINTS);
    panel.line(fitted, FIT_LINE);
    panel.legend(&legend);
}

/// (e) Dissipative force over the stiffness, against amplitude.
fn dissipative(figure: &mut Figure, view: &View<'_>) {
    let answer = view.answer;
    let rows: Vec<[f64; 3]> =
        answer.force.iter().map(|p| [p.amplitude, p.dissipative, p.dissipative_std_error]).collect();
    let mut line = Vec::new();
    if let Some(fit) = &answer.force_line {
        let natural = answer.parameter(Parameter::NaturalFrequency).map_or(f64::NAN, |q| q.value);
        let slope = fit.decay_rate_per_s.value / (std::f64::consts::PI * natural);
        let intercept = 4.0 / std::f64::consts::PI * fit.friction_displacement.value;
        line = vec![[0.0, intercept], [view.largest, intercept + slope * view.largest]];
    }
    let title = "dissipative force: its value at zero is sliding";
    force(figure, view, title, "dissipative force / k", &rows, &line);
}

/// (f) Spring force over the stiffness, against amplitude.
fn elastic(figure: &mut Figure, view: &View<'_>) {
    let rows: Vec<[f64; 3]> =
        view.answer.force.iter().map(|p| [p.amplitude, p.elastic, p.elastic_std_error]).collect();
    let line = [[0.0, 0.0], [view.largest, view.largest]];
    force(figure, view, "elastic force: straight for a linear spring", "elastic force / k", &rows, &line);
}

fn force(figure: &mut Figure, view: &View<'_>, title: &str, name: &str, rows: &[[f64; 3]], line: &[Point]) {
    let mut sizes: Vec<f64> = rows.iter().map(|r| r[1]).filter(|v| v.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let quantile = |q: f64| sizes.get(((sizes.len().max(1) - 1) as f64 * q) as usize).copied().unwrap_or(0.0);
    let (least, most) = (quantile(0.02), quantile(0.98));
    let top = line.iter().map(|p| p[1]).fold(most, f64::max);
    let low = least.min(0.0);
    let scale = Scale::for_size(top.max(-low), &view.answer.unit);
    let (a, s) = (view.amplitude.factor, scale.factor);
    let x = Axis::linear(0.0, 1.05 * view.largest * a, titled("amplitude", &view.amplitude.unit));
    let pad = 0.08 * (top - low);
    let y = Axis::linear(
        (low - if low < 0.0 { pad } else { 0.0 }) * s,
        (top + pad) * s,
        titled(name, &scale.unit),
    );
    let mut panel = Panel::new(figure, title, x, y);
    let sigma = |r: &[f64; 3]| if r[2].is_finite() { r[2] } else { 0.0 };
    if rows.len() <= MOST_BARS {
        let bar = |r: &[f64; 3]| [r[0] * a, (r[1] - sigma(r)) * s, (r[1] + sigma(r)) * s];
        panel.bars(rows.iter().map(bar), Stroke::solid(POINTS.faded(0.5), 1.0));
    }
    panel.sized_dots(rows.iter().map(|r| ([r[0] * a, r[1] * s], r[2] * s)), view.radius(), POINTS);
    let mut legend = vec![(Mark::Dot(POINTS), "from each point, no model")];
    if !line.is_empty() {
        panel.line(line.iter().map(|p| [p[0] * a, p[1] * s]), FIT_LINE);
        legend.push((Mark::Line(FIT_LINE), if name.starts_with('e') { "k x" } else { "4 x_F/π + slope" }));
    }
    panel.legend(&legend);
}
