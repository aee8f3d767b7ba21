//! Amplitude over the level of the drive.

use super::chart::{Chart, Scaled, Series, SeriesStyle};
use crate::AnalysedLevels;
use crate::format::Scale;
use slipfit::Parameter;

/// Number of straight segments in a drawn curve.
const CURVE_STEPS: u32 = 60;

pub(super) fn charts(analysed: &AnalysedLevels<'_>) -> Vec<Chart> {
    let answer = analysed.answer;
    let most = |of: fn(&slipfit::levels::LevelPoint) -> f64| {
        answer.points.iter().map(of).filter(|v| v.is_finite()).fold(0.0, f64::max)
    };
    let drive = Scale::for_size(most(|p| p.drive), &answer.drive_unit);
    let amplitude = Scale::for_size(most(|p| p.amplitude), &answer.unit);
    let (d, a) = (drive.factor, amplitude.factor);
    let top = most(|p| p.drive);
    let threshold = answer.parameter(Parameter::Threshold).map_or(0.0, |q| q.value).clamp(0.0, top);
    let dots = |moving: bool| {
        answer.points.iter().filter(|p| p.moving == moving).map(|p| [p.drive * d, p.amplitude * a]).collect()
    };
    // Curves, because drag bends the line.
    let drawn = |from: f64, of: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
        let steps = 0..=CURVE_STEPS;
        let drives = steps.map(|i| from + (top - from) * f64::from(i) / f64::from(CURVE_STEPS));
        drives.map(|x| [x * d, of(x) * a]).collect()
    };
    let free = drawn(0.0, &|x| answer.fit.friction_free(x));
    let moves = drawn(threshold, &|x| answer.fit.amplitude(x));
    let fit = [[0.0, answer.fit.amplitude(0.0) * a]].into_iter().chain(moves).collect();
    let axis = |name: &str, scale: &Scale| {
        let unit = scale.unit.trim_start_matches('×');
        if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
    };
    let series = |name: &str, points, style| Series::new(name, points, style);
    let curve = Chart {
        file: "levels",
        title: "amplitude at resonance".to_owned(),
        x: Scaled::linear(&axis("drive", &drive), [0.0, 1.03 * top * d]),
        y: Scaled::linear(&axis("amplitude", &amplitude), [0.0, 1.08 * most(|p| p.amplitude) * a]),
        series: vec![
            series("without friction", free, SeriesStyle::Dashed(5)),
            series("fit", fit, SeriesStyle::Line(1)),
            series("moving", dots(true), SeriesStyle::LargeDots(0)),
            series("stuck", dots(false), SeriesStyle::LargeDots(5)),
        ],
    };
    let left: Vec<[f64; 2]> =
        answer.points.iter().filter(|p| p.moving).map(|p| [p.drive * d, p.amplitude - p.fitted]).collect();
    let size = left.iter().map(|p| p[1].abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let residual = Scale::for_size(size, &answer.unit);
    let r = residual.factor;
    let residuals = Chart {
        file: "residuals",
        title: "residuals of the moving branch".to_owned(),
        x: Scaled::linear(&axis("drive", &drive), [0.0, 1.03 * top * d]),
        y: Scaled::linear(&axis("data − fit", &residual), [-1.3 * size * r, 1.3 * size * r]),
        series: vec![
            series("", vec![[0.0, 0.0], [top * d, 0.0]], SeriesStyle::Line(1)),
            series("", left.iter().map(|p| [p[0], p[1] * r]).collect(), SeriesStyle::LargeDots(0)),
        ],
    };
    vec![curve, residuals]
}
