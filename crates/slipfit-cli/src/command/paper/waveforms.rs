//! Fig. 1: displacement and velocity when friction leaves a gain of 5, and of 1.

use slipfit::motion::steady::{HarmonicDrive, Method, SteadyState, solve};
use slipfit::{Error, Oscillator};
use slipfit_report::plot::{Chart, Scaled, Series, SeriesStyle};

const Q: f64 = 1e4;
/// Number of cycles shown.
const CYCLES: f64 = 2.0;
const STEPS: u32 = 800;
const DOTS: u32 = 64;

pub(super) struct Waveforms {
    pub(super) charts: Vec<Chart>,
    pub(super) caption: String,
    /// Results of the exact motion for each case.
    pub(super) notes: Vec<String>,
}

pub(super) fn charts() -> Result<Waveforms, Error> {
    let mut all = Waveforms { charts: Vec::new(), caption: String::new(), notes: Vec::new() };
    let names: [(f64, [&'static str; 2], [&str; 2]); 2] =
        [(5.0, ["fig1_a", "fig1_b"], ["(a)", "(b)"]), (1.0, ["fig1_c", "fig1_d"], ["(c)", "(d)"])];
    for (gain, files, letters) in names {
        let x_f = Oscillator::friction_displacement_for(1.0 - gain / Q, 1.0);
        let o = Oscillator::builder().omega_0(1.0).q_factor(Q).friction_displacement(x_f).build()?;
        let drive = HarmonicDrive::new(1.0, 1.0)?;
        let leading = SteadyState::new(&o, &drive, Method::Leading)?;
        let series = SteadyState::new(&o, &drive, Method::Series { terms: 30 })?;
        let exact = solve(&o, &drive)?.state;
        let stops = exact.stops();
        all.notes.push(format!(
            "G = {gain}: exact amplitude {:.6} x_0 at the turns, fundamental {:.6} x_0, lag behind the drive \
             {:.4} rad, φ_1 = {:.4} rad, stops per cycle: {stops}; eq. (8) {:.6} x_0, lag {:.4} rad; 30 terms \
             {:.6} x_0.",
            exact.amplitude(),
            exact.gain(),
            exact.phase_lag(),
            exact.phase_lag() - drive.omega() * top(&exact),
            leading.amplitude(),
            leading.phase_lag(),
            series.amplitude(),
        ));
        for (column, (file, letter)) in files.into_iter().zip(letters).enumerate() {
            let velocity = column == 1;
            let curve = |state: &SteadyState, steps: u32| trace(state, steps, velocity);
            let mut curves = vec![
                Series::new("exact", curve(&exact, STEPS), SeriesStyle::Wide(5)),
                Series::new("30 terms", curve(&series, STEPS), SeriesStyle::Line(1)),
                Series::new("leading term, eq. (8)", curve(&leading, DOTS), SeriesStyle::Dots(0)),
            ];
            if velocity {
                let points = curve(&exact, STEPS)
                    .into_iter()
                    .map(|[t, v]| [t, if v.abs() < 1e-9 * gain { 0.0 } else { -0.5 * gain * v.signum() }])
                    .collect();
                curves.push(Series::new("friction force, rescaled", points, SeriesStyle::Dashed(2)));
            }
            if stops > 0 {
                let points = exact
                    .turning_points()
                    .into_iter()
                    .map(|(t, x)| {
                        let t = ((t - top(&exact)) / drive.period_s()).rem_euclid(1.0);
                        [t, if velocity { 0.0 } else { x }]
                    })
                    .collect();
                curves.push(Series::new("stops", points, SeriesStyle::LargeDots(3)));
            }
            // Leaves room for the legend above the curves.
            let reach = if velocity { 2.4 } else { 1.9 } * gain;
            let (title, label) = if velocity {
                (format!("{letter} velocity, G = {gain}"), "dx/dt / (ω₀ x₀)")
            } else {
                (format!("{letter} displacement, G = {gain}"), "x / x₀")
            };
            all.charts.push(Chart {
                file,
                title,
                x: Scaled::linear("t / T", [0.0, CYCLES]),
                y: Scaled::linear(label, [-1.15 * gain, reach]),
                series: curves,
            });
        }
    }
    all.caption = "Time counts from the positive turning point of each motion, as in the paper, where friction \
                   has its phase zero. Friction such that 4F ≈ πk x₀: G is the gain it leaves of 10⁴. Grey: the \
                   exact motion, which the paper does not have."
        .to_owned();
    Ok(all)
}

/// Time of the positive turning point.
fn top(state: &SteadyState) -> f64 {
    let highest = state.turning_points().into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    highest.map_or(0.0, |p| p.0)
}

fn trace(state: &SteadyState, steps: u32, velocity: bool) -> Vec<[f64; 2]> {
    let (from, period) = (top(state), state.drive().period_s());
    (0..=steps)
        .map(|i| {
            let t = CYCLES * f64::from(i) / f64::from(steps);
            let (x, v) = state.state(from + t * period);
            [t, if velocity { v } else { x }]
        })
        .collect()
}
