//! Fig. 2 (c) and (d): resonance curves, and the response at omega_0 to a drive near omega_0/3.

use super::ringdowns::{FREQUENCY_HZ, fork};
use slipfit::Error;
use slipfit::motion::steady::lorentzian::{self, Inversion, LorentzianFit};
use slipfit::motion::steady::{HarmonicDrive, scan, solve};
use slipfit_report::plot::{Chart, Scaled, Series, SeriesStyle};
use std::f64::consts::TAU;

const VISCOUS: f64 = 20e-6;
/// Base amplitude: 25 nm at resonance without load.
const DRIVE_M: f64 = 25e-9 / 2433.6;
const FORCES: [f64; 4] = [0.0, 16e-9, 32e-9, 48e-9];
const HALF_SPAN_HZ: f64 = 30.0;
const POINTS: i32 = 60;

/// Base amplitude at a third of the frequency, and the forces there. A weak drive shows no resonance: the third
/// harmonic of the velocity cannot become larger than its fundamental, or friction would no longer follow the
/// drive.
const DRIVE_AT_A_THIRD_M: f64 = 20e-9;
const FORCES_AT_A_THIRD: [f64; 3] = [0.0, 16e-9, 32e-9];

pub(super) struct Curves {
    pub(super) chart: Chart,
    pub(super) fits: Vec<Fitted>,
}

/// The Lorentzian of a resonance curve, and its inversion after the paper.
pub(super) struct Fitted {
    pub(super) coulomb_force: f64,
    pub(super) line: LorentzianFit,
    pub(super) inversion: Inversion,
    pub(super) true_q: f64,
}

pub(super) fn caption(left_out: usize) -> String {
    let mut text =
        "(c): exact fundamentals, base driven by 10.3 pm, γ = 20 µN s/m (lines); Lorentzians fitted, \
                    eq. (14) (dots). (d): third harmonic of the exact motion, base driven by 20 nm."
            .to_owned();
    if left_out > 0 {
        text += &format!(" {left_out} points without a motion that repeats with the drive are left out.");
    }
    text
}

fn named(force: f64) -> String {
    if force > 0.0 { format!("F = {:.0} nN", force * 1e9) } else { "free".to_owned() }
}

pub(super) fn curves() -> Result<Curves, Error> {
    const COLORS: [usize; 4] = [1, 3, 0, 2];
    let mut series = Vec::new();
    let mut dots = Vec::new();
    let mut fits = Vec::new();
    for (coulomb_force, color) in FORCES.into_iter().zip(COLORS) {
        let o = fork(coulomb_force, VISCOUS)?;
        let frequency = |i: i32| FREQUENCY_HZ + HALF_SPAN_HZ * f64::from(i) / f64::from(POINTS);
        let readings: Vec<scan::Reading> =
            (-POINTS..=POINTS).map(|i| scan::reading(&o, DRIVE_M, frequency(i))).collect::<Result<_, _>>()?;
        let omega: Vec<f64> = readings.iter().map(|r| TAU * r.frequency_hz).collect();
        let amplitude: Vec<f64> = readings.iter().map(scan::Reading::amplitude).collect();
        let line = lorentzian::fit(&omega, &amplitude)?;
        // Without friction, rounding may put the fitted drive slightly above x_0.
        let x_f = line.effective_drive.min(DRIVE_M);
        let inversion = lorentzian::invert(x_f, line.effective_q_factor, DRIVE_M, lorentzian::PAPER_A)?;
        fits.push(Fitted { coulomb_force, line, inversion, true_q: o.q_factor() });
        let point = |f: f64, a: f64| [f - FREQUENCY_HZ, a * 1e9];
        let points = readings.iter().map(|r| point(r.frequency_hz, r.amplitude())).collect();
        series.push(Series::new(named(coulomb_force), points, SeriesStyle::Line(color)));
        let fitted = (-POINTS..=POINTS).step_by(3).map(frequency);
        let points = fitted.map(|f| point(f, line.amplitude(TAU * f))).collect();
        let name = format!("Lorentzian fit, {}", named(coulomb_force));
        // One legend entry for all of them.
        let legend = if color == COLORS[3] { "Lorentzian fits" } else { "" };
        dots.push(Series::new(name, points, SeriesStyle::Dots(color)).in_legend(legend));
    }
    series.append(&mut dots);
    let chart = Chart {
        file: "fig2_c",
        title: "(c) resonance under increasing load".to_owned(),
        x: Scaled::linear("f − f₀ [Hz]", [-HALF_SPAN_HZ, HALF_SPAN_HZ]),
        y: Scaled::linear("amplitude R [nm]", [0.0, 27.0]),
        series,
    };
    Ok(Curves { chart, fits })
}

pub(super) struct AtAThird {
    pub(super) chart: Chart,
    /// Points at which no motion that repeats with the drive was found.
    pub(super) left_out: usize,
}

pub(super) fn at_a_third() -> Result<AtAThird, Error> {
    const COLORS: [usize; 3] = [1, 3, 0];
    let mut left_out = 0;
    let mut series = Vec::new();
    let mut highest = 0.0f64;
    let mut others = Vec::new();
    for (coulomb_force, color) in FORCES_AT_A_THIRD.into_iter().zip(COLORS) {
        let o = fork(coulomb_force, VISCOUS)?;
        let (mut points, mut irregular) = (Vec::new(), Vec::new());
        for i in -POINTS..=POINTS {
            let off = HALF_SPAN_HZ * f64::from(i) / f64::from(POINTS);
            let drive = HarmonicDrive::new(DRIVE_AT_A_THIRD_M, TAU * (FREQUENCY_HZ + off) / 3.0)?;
            match solve(&o, &drive) {
                Ok(found) => {
                    let point = [off, found.state.harmonic(3).norm() * 1e9];
                    points.push(point);
                    if found.state.stops() > 0 || found.state.turning_points().len() > 2 {
                        irregular.push(point);
                    }
                }
                Err(Error::DoesNotHold { .. }) => left_out += 1,
                Err(e) => return Err(e),
            }
        }
        others.extend(irregular);
        highest = points.iter().fold(highest, |m, p| m.max(p[1]));
        series.push(Series::new(named(coulomb_force), points, SeriesStyle::Line(color)));
    }
    if !others.is_empty() {
        series.push(Series::new("the mass stops or turns on the way", others, SeriesStyle::Dots(4)));
    }
    let chart = Chart {
        file: "fig2_d",
        title: "(d) response at 3f, driven at f near f₀/3".to_owned(),
        x: Scaled::linear("3f − f₀ [Hz]", [-HALF_SPAN_HZ, HALF_SPAN_HZ]),
        y: Scaled::linear("amplitude at 3f [nm]", [-0.03 * highest, 1.9 * highest]),
        series,
    };
    Ok(AtAThird { chart, left_out })
}
