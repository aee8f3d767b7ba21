//! The equations an answer is based on, with their sources.
//!
//! "The paper" is Vitorino, Vieira and Rodrigues, Effect of sliding friction in harmonic oscillators; where its
//! printed version does not hold, this is stated next to the equation.

use slipfit::LossTerm;
use slipfit::resonance::Method;
use slipfit::{levels, resonance, ringdown, series};

/// One step: what it does, its formula if it has one, and the source.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Step {
    pub(crate) what: &'static str,
    pub(crate) formula: &'static str,
    pub(crate) source: &'static str,
}

const fn step(what: &'static str, formula: &'static str, source: &'static str) -> Step {
    Step { what, formula, source }
}

/// Reference to the paper, for the foot of a page.
pub(crate) const PAPER: &str = "Vitorino, Vieira and Rodrigues, “Effect of sliding friction in harmonic oscillators”; \
     its numbered equations run from (1) to (18).";

const MOTION: Step = step(
    "Motion",
    "m x″ + γ x′ + k x + F sgn(x′) = k x_0 cos(ωt),   δ = γ/2m,   x_F = F/k,   ω_0² = k/m",
    "Eq. (2) of the paper, without a series. The paper prints the square wave with a minus sign; with x = \
     R cos(ωt) friction opposes −sin(ωt), so the sign is plus, as in (8) and (15).",
);
const HALF_CYCLE: Step = step(
    "Free decay, from one turning point to the next",
    "|X_{n+1}| = e^{−δT} |X_n| − (1 + e^{−δT}) x_F,   T = π/ω_d,   ω_d² = ω_0² − δ²",
    "Exact; friction is constant between turning points. Eqs. (15) and (16) of the paper approximate it.",
);
const OFFSET: Step = step(
    "The same as an envelope",
    "|X_n| + C = e^{−nδT} (|X_0| + C),   C = x_F coth(πδ/2ω_d)",
    "Eq. (16) of the paper prints the leading order of C, 4F/(πγω_0), which is low by (π²/48 − 1/8)/Q²: 2 % at Q = 2.",
);
const RICE: Step = step(
    "Amplitudes without a phase",
    "E[R²] = A² + 2σ²",
    "Rice (1944): the noise of both quadratures lifts small amplitudes, so it is part of the fit.",
);
const COMPARED: Step = step(
    "Models compared",
    "ΔBIC = n ln(RSS/RSS_{best}) + (p − p_{best}) ln n",
    "Schwarz (1978); n counts independent observations, so autocorrelated residuals weigh less. Loss terms \
     are not allowed below zero; sliding is tested one-sided against the best model without it (Chernoff 1954).",
);
const INTERVALS: Step = step(
    "Intervals",
    "",
    "95 % from the profile of the sum of squares, wider for autocorrelated residuals; near a limit such as \
     zero friction, the intervals are those of Feldman and Cousins (1998), which cover 95 % there as well.",
);
const STEADY: Step = step(
    "Driven steady state",
    "X = √((k x_0/|D|)² − (H x_F)²) − G x_F,   X_1 = X + (G − iH) x_F − i(4F/π)/D,   D = k − mω² + iγω",
    "Den Hartog (1931), exact for two turning points per cycle; with y = πδ/ω, θ = πω_d/ω, N = cosh y + \
     cos θ: G = (sinh y − (δ/ω_d) sin θ)/N, H = (ω_0²/ωω_{d}) sin θ/N. Where the mass stops within the \
     cycle, the periodic motion itself is found. Eq. (3) of the paper sums to it. The phase φ_1 that (7) \
     prints is of order F/kRQ; near resonance it is F/πkR.",
);
const LEADING: Step = step(
    "Driven steady state, leading term",
    "R = [−4Fγω + √(π²k²x_0²Z² − 16F²(k − mω²)²)]/(πZ²),   Z² = (k − mω²)² + γ²ω²",
    "Eq. (8) of the paper. At resonance accurate to 1e-3 at a gain of 5; on the flanks in error by up to \
     20 % at Q = 50, β = 0.9.",
);
const LORENTZIAN: Step = step(
    "Effective Lorentzian",
    "R = x_f ω_0²/√((ω_0² − ω²)² + (ωω_0/Q_f)²),   Q_f = Q(1 − β/a),   x_f = x_0(1 − β)/(1 − β/a),   β = 4F/πkx_0",
    "Eqs. (12) to (14) of the paper, with a = 4/3. In fact a varies from 1.24 to 1.62 with β and the \
     window fitted, so that inverting with 4/3 is biased; the bias on this curve is given above. The \
     paper's x_f is an effective drive, not the friction displacement.",
);
const FORCE: Step = step(
    "Force balance, without a model of the curve",
    "x_0 sin(lag) = 4x_F/π + (2δ/ω_0)(ω/ω_0)|Z|",
    "Eq. (9) of the paper, off resonance as well: the value at zero amplitude is sliding friction.",
);
const LEVELS: Step = step(
    "Amplitude at resonance",
    "R_0 = Q(x_0 − 4F/πk)   above the threshold x_0 = 4x_F/π",
    "Eq. (9) of the paper; the exact motion agrees with it within 2(x_F/R_0)².",
);
const LINE: Step = step(
    "Line and threshold",
    "",
    "Levels are split into stuck and moving where that describes them best; a weighted line goes through \
     the moving ones. A threshold above zero is tested one-sided; its interval is that of Feldman and \
     Cousins (1998). A loss proportional to the square of the amplitude bends the line: it is fitted where \
     the levels show it, and included in the intervals where they do not exclude it.",
);
const AGREE: Step = step(
    "Do ring-down and resonance agree?",
    "z = (a − b)/√(s_a² + s_b²)",
    "Both differences are tested together by chi square, with the correlations of friction and damping: \
     Table 1 of the paper, with uncertainties.",
);
const JOINT: Step = step(
    "Joint fit",
    "",
    "Least squares of all single answers with their covariances; the parameters named as shared have one \
     common value.",
);
const REPEATS: Step = step(
    "Scatter of repeats",
    "C = C_i + diag(τ_δ², τ_F²)",
    "Random effects by restricted maximum likelihood from all conditions; intervals of Knapp and Hartung (2003).",
);
const LOAD: Step = step(
    "Friction against load",
    "F = μN,   F = μN + F_0,   F = μ(N + N_0),   F = cN^{2/3}",
    "Amontons without and with offset, with adhesion, Hertz; errors of both variables and a scatter about \
     the law are included; the laws are compared by BIC.",
);

pub(super) fn of_ringdown(answer: &ringdown::Answer, amplitudes: bool) -> Vec<Step> {
    let mut steps = vec![MOTION, HALF_CYCLE, OFFSET];
    steps.extend(laws(|term| answer.comparison.iter().any(|c| c.model.has(term))));
    if amplitudes {
        steps.push(RICE);
    }
    steps.extend([COMPARED, INTERVALS]);
    steps
}

/// The laws of those loss terms that have a law of their own.
fn laws(wanted: impl Fn(LossTerm) -> bool) -> impl Iterator<Item = Step> {
    let terms = LossTerm::ALL.iter().filter(move |term| wanted(**term));
    terms.filter_map(|term| term.method()).map(|[what, formula, source]| step(what, formula, source))
}

pub(super) fn of_resonance(answer: &resonance::Answer) -> Vec<Step> {
    let response = match answer.method {
        Method::Leading => LEADING,
        Method::Paper => LORENTZIAN,
        _ => STEADY,
    };
    let mut steps = vec![MOTION, response];
    steps.extend(laws(|term| answer.model.has(term) && !term.is_compared()));
    if answer.paper.is_some() && answer.method != Method::Paper {
        steps.push(LORENTZIAN);
    }
    if answer.force_line.is_some() {
        steps.push(FORCE);
    }
    steps.extend([COMPARED, INTERVALS]);
    steps
}

pub(super) fn of_levels(_: &levels::Answer) -> Vec<Step> {
    vec![MOTION, LEVELS, LINE]
}

pub(super) fn of_series(answer: &series::Answer) -> Vec<Step> {
    let singles = || answer.singles.iter().filter_map(|(_, single)| single.as_ref().ok());
    let mut steps = vec![MOTION];
    if singles().any(|s| matches!(s, series::SingleAnswer::RingDown(_))) {
        steps.extend([HALF_CYCLE, OFFSET]);
    }
    if singles().any(|s| matches!(s, series::SingleAnswer::Sweep(_))) {
        steps.push(STEADY);
    }
    if singles().any(|s| matches!(s, series::SingleAnswer::Levels(_))) {
        steps.push(LEVELS);
    }
    if answer.scatter.is_some() {
        steps.push(REPEATS);
    }
    if answer.methods() == [true; 2] {
        steps.push(AGREE);
    }
    if answer.joint.is_some() {
        steps.push(JOINT);
    }
    if !answer.laws.is_empty() {
        steps.push(LOAD);
    }
    steps.push(INTERVALS);
    steps
}
