//! The response of the oscillator with its instrument terms, and the slots of its parameters.

use super::Method;
use crate::model::loss::{FURTHER, LossTerm};
use crate::motion::steady::Phasor;
use crate::motion::steady::fundamental::{Follower, Fundamental, Point, Regime, leading};

/// `omega_0` minus the centre, rad/s.
pub(crate) const OMEGA: usize = 0;
pub(crate) const DELTA: usize = 1;
pub(crate) const X_0: usize = 2;
/// Friction displacement, or the friction ratio if [`Problem::ratio`](super::problem::Problem) is set.
pub(crate) const X_F: usize = 3;
/// Drag rate a2 at the centre frequency, per s and unit.
pub(crate) const DRAG: usize = 4;
/// Shift of `omega_0` per squared amplitude (Duffing), rad/s per unit²; its slot follows those of the further loss
/// terms.
pub(crate) const DUFFING: usize = DRAG + 1 + FURTHER;
pub(crate) const PHASE: usize = DUFFING + 1;
pub(crate) const DELAY: usize = DUFFING + 2;
pub(crate) const BG_RE: usize = DUFFING + 3;
pub(crate) const BG_IM: usize = DUFFING + 4;
/// A constant in every amplitude read, unit of the response; for curves without phases.
pub(crate) const OFFSET: usize = DUFFING + 5;
/// Square of a noise floor that adds to every amplitude in quadrature; for curves without phases.
pub(crate) const FLOOR: usize = DUFFING + 6;
/// Number of parameters of the main block.
pub(super) const MAIN: usize = DUFFING + 7;
/// Slots of the reference; drive, delay, offset, noise floor, drag and Duffing term are shared.
pub(crate) const R_OMEGA: usize = MAIN;
pub(crate) const R_DELTA: usize = MAIN + 1;
pub(crate) const R_PHASE: usize = MAIN + 2;
pub(crate) const R_BG_RE: usize = MAIN + 3;
pub(crate) const R_BG_IM: usize = MAIN + 4;
pub(crate) const COUNT: usize = MAIN + 5;
/// Number of parameters of the oscillator, which come first.
pub(super) const OWN: usize = PHASE;

/// Slot of the coefficient of a loss term in a fit.
pub(crate) fn slot(term: LossTerm) -> usize {
    match term {
        LossTerm::Viscous => DELTA,
        LossTerm::Sliding => X_F,
        LossTerm::Drag => DRAG,
        // Further terms follow in the order of their list.
        #[allow(unreachable_patterns, reason = "there may be none")]
        further => DRAG + further as usize - LossTerm::Drag as usize,
    }
}

/// Model at one point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Modelled {
    /// Value including instrument terms.
    pub(crate) value: Phasor,
    /// The oscillator alone.
    pub(crate) oscillator: Phasor,
    /// Constant in the amplitude read.
    pub(crate) offset: f64,
    /// Addition to the square of the amplitude read.
    pub(crate) floor: f64,
    pub(crate) regime: Regime,
}

impl Modelled {
    /// Amplitude including the noise floor.
    pub(crate) fn size(&self) -> f64 {
        let size = self.value.norm();
        if self.floor == 0.0 { size } else { (size * size + self.floor).max(0.0).sqrt() }
    }
}

/// The response of one block: oscillator and instrument with their parameters.
///
/// The measured response is `Z e^(i (phase - (omega - centre) delay)) + background`; for curves without phases its
/// modulus, with a noise floor added in quadrature, and an offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelResponse {
    pub(super) method: Method,
    pub(super) centre: f64,
    pub(super) shift: f64,
    pub(super) delta: f64,
    pub(super) x_0: f64,
    pub(super) x_f: f64,
    /// If the friction ratio is a parameter: derivatives of `x_F` with respect to the drive and to the ratio.
    pub(super) ratio: Option<[f64; 2]>,
    /// Whether drag, a further loss or a Duffing term is included.
    pub(super) amplitude_dependent: bool,
    pub(super) drag: f64,
    /// Whether further losses are included, and their coefficients.
    pub(super) with_further: bool,
    pub(super) further: [f64; FURTHER],
    pub(super) duffing: f64,
    pub(super) phase: f64,
    pub(super) delay: f64,
    pub(super) background: Phasor,
    /// Whether the delay also applies to the background.
    pub(super) background_delayed: bool,
    pub(super) offset: f64,
    pub(super) floor: f64,
}

impl ModelResponse {
    /// The amplitude that corresponds to this reading, for curves without phases.
    #[inline(always)]
    pub(super) fn amplitude_from_reading(&self, read: f64) -> f64 {
        let above = read - self.offset;
        if self.floor == 0.0 { above } else { (above * above - self.floor).max(0.0).sqrt() }
    }

    /// The background as read at one frequency.
    pub(super) fn background_at(&self, omega: f64) -> Phasor {
        let delayed = self.background_delayed && self.delay != 0.0;
        let rotation = || Phasor::from_polar(1.0, (self.centre - omega) * self.delay);
        if delayed { self.background * rotation() } else { self.background }
    }

    #[inline(always)]
    pub(super) fn point(&self, omega: f64, level: f64) -> Point {
        Point {
            omega,
            omega_0: self.centre + self.shift,
            detuning: (omega - self.centre) - self.shift,
            delta: self.delta,
            x_0: self.x_0 * level,
            x_f: self.x_f,
        }
    }

    /// The model at one frequency; `level` is the relative drive, `guess` an amplitude that selects the branch if there
    /// are several.
    pub(crate) fn at(&self, omega: f64, level: f64, guess: f64, follower: &mut Follower) -> Option<Modelled> {
        let mut by = [Phasor::default(); OWN];
        let f = self.oscillator(&self.point(omega, level), guess, follower, &mut by)?;
        let rotation = Phasor::from_polar(1.0, self.phase - (omega - self.centre) * self.delay);
        let value = f.value * rotation + self.background_at(omega);
        Some(Modelled {
            value,
            oscillator: f.value,
            offset: self.offset,
            floor: self.floor,
            regime: f.regime,
        })
    }

    /// The oscillator alone, and its derivatives.
    pub(super) fn oscillator(
        &self,
        point: &Point,
        guess: f64,
        follower: &mut Follower,
        by: &mut [Phasor; OWN],
    ) -> Option<Fundamental> {
        if self.amplitude_dependent {
            return self.at_own_amplitude(point, guess, follower, by);
        }
        let f = self.kernel(point, follower)?;
        (by[OMEGA], by[DELTA], by[X_0], by[X_F]) = (f.by_omega_0, f.by_delta, f.by_x_0, f.by_x_f);
        Some(f)
    }

    fn kernel(&self, point: &Point, follower: &mut Follower) -> Option<Fundamental> {
        match self.method {
            Method::Exact | Method::Paper => follower.fundamental(point),
            Method::Leading => {
                let damped = point.delta.abs() < point.omega_0 && point.x_0 > 0.0 && point.omega_0 > 0.0;
                if damped { leading(point) } else { None }
            }
        }
    }

    /// Factor by which the coefficient of each further loss is multiplied to give the equivalent rate of viscous
    /// damping at amplitude `r`, `g(r)/r (omega/omega_c)^n`; and its derivative with respect to `r`.
    ///
    /// `rate`: the ratio of the frequency to the centre, where the coefficients are those of a free decay.
    #[inline(always)]
    pub(super) fn further_damping(r: f64, rate: f64) -> [[f64; 2]; FURTHER] {
        let over_r = if r > 0.0 { 1.0 / r } else { 0.0 };
        std::array::from_fn(|k| {
            let term = LossTerm::further()[k];
            let factor = rate.powi(term.frequency_power()) * over_r;
            let damping = term.shape(r) * factor;
            [damping, term.shape_derivative(r) * factor - damping * over_r]
        })
    }

    /// The rate of viscous damping equivalent to all further losses, and its derivative.
    #[inline(always)]
    pub(super) fn further_rate(&self, damping: &[[f64; 2]; FURTHER]) -> [f64; 2] {
        let coefficients = self.further.iter().zip(damping);
        coefficients.fold([0.0; 2], |[sum, slope], (c, [d, by_r])| [sum + c * d, slope + c * by_r])
    }

    /// With drag, further losses and a Duffing term, which depend on the amplitude itself:
    /// `R = |Z(delta + a2 R omega/omega_c + ..., omega_0 + c R²)|`, solved by Newton's method from the measured
    /// amplitude.
    fn at_own_amplitude(
        &self,
        point: &Point,
        guess: f64,
        follower: &mut Follower,
        by: &mut [Phasor; OWN],
    ) -> Option<Fundamental> {
        const MOST_STEPS: usize = 60;
        let (drag, duffing) = (self.drag, self.duffing);
        let rate = point.omega / self.centre;
        let mut r = guess.max(0.0);
        let mut found = None;
        let none = [[0.0; 2]; FURTHER];
        for _ in 0..MOST_STEPS {
            let shift = duffing * r * r;
            if shift.abs() > 0.5 * point.omega_0 {
                return None;
            }
            let damping = if self.with_further { Self::further_damping(r, rate) } else { none };
            let [further, by_r] = self.further_rate(&damping);
            let there = Point {
                delta: point.delta + drag * rate * r + further,
                omega_0: point.omega_0 + shift,
                detuning: point.detuning - shift,
                ..*point
            };
            let f = self.kernel(&there, follower)?;
            let m = f.value.norm();
            let z_r = f.by_delta * (drag * rate + by_r) + f.by_omega_0 * (2.0 * duffing * r);
            let along = |d: Phasor| if m > 0.0 { (f.value.re * d.re + f.value.im * d.im) / m } else { 0.0 };
            let slope = along(z_r);
            let gain = bounded(1.0 - slope);
            let step = (m - r) / gain;
            found = Some((f, m, r, z_r, gain, damping));
            if (m - r).abs() <= 1e-12 * m.max(r) {
                break;
            }
            let reach = 0.5 * (r + m);
            // If the mass is at rest at this amplitude, it may be at rest at zero amplitude.
            r = if m > 0.0 { (r + step.max(-reach).min(reach)).max(0.0) } else { 0.0 };
        }
        let (f, m, r, z_r, gain, damping) = found?;
        if (m - r).abs() > 1e-6 * m.max(r) {
            return None;
        }
        let through = |d: Phasor| {
            if m > 0.0 { d + z_r * ((f.value.re * d.re + f.value.im * d.im) / m / gain) } else { d }
        };
        by[OMEGA] = through(f.by_omega_0);
        by[DELTA] = through(f.by_delta);
        by[X_0] = through(f.by_x_0);
        by[X_F] = through(f.by_x_f);
        by[DRAG] = through(f.by_delta * (rate * r));
        for (k, [damping, _]) in damping.iter().enumerate() {
            by[DRAG + 1 + k] = through(f.by_delta * *damping);
        }
        by[DUFFING] = through(f.by_omega_0 * (r * r));
        Some(f)
    }
}

/// One step of Newton's method for the amplitude on which the response depends.
#[derive(Clone, Copy)]
pub(super) struct AmplitudeStep {
    pub(super) next: f64,
    /// Remaining difference over the amplitude.
    pub(super) gap: f64,
    /// Change of the response with the amplitude, divided by modulus and gain: its product with the scalar product of
    /// the response and a derivative at fixed amplitude is added to that derivative.
    pub(super) turn: Phasor,
}

impl ModelResponse {
    /// The oscillator at amplitude `r` without further losses, and the derivative of its damping with respect to the
    /// amplitude.
    #[inline(always)]
    pub(super) fn at_amplitude(&self, plain: &Point, r: f64, over_centre: f64) -> (Point, f64) {
        let shift = self.duffing * r * r;
        let drag = self.drag * (plain.omega * over_centre);
        let point = Point {
            delta: plain.delta + drag * r,
            omega_0: plain.omega_0 + shift,
            detuning: plain.detuning - shift,
            ..*plain
        };
        (point, drag)
    }

    /// Whether an oscillator with amplitude-dependent parameters is still underdamped and close to its natural
    /// frequency.
    #[inline(always)]
    pub(super) fn is_damped(plain: f64, omega_0: f64, delta: f64) -> bool {
        ((omega_0 - plain).abs() <= 0.5 * plain) & (delta.abs() < omega_0)
    }

    /// From amplitude `r` and the response there, with its derivatives with respect to decay rate and frequency.
    #[inline(always)]
    pub(super) fn amplitude_step(
        &self,
        r: f64,
        slope: f64,
        value: Phasor,
        [by_delta, by_omega_0]: [Phasor; 2],
    ) -> AmplitudeStep {
        let m = (value.re * value.re + value.im * value.im).sqrt();
        let over_m = if m > 0.0 { 1.0 / m } else { 0.0 };
        let z_r = by_delta * slope + by_omega_0 * (2.0 * self.duffing * r);
        let gain = bounded(1.0 - (value.re * z_r.re + value.im * z_r.im) * over_m);
        let step = (m - r) / gain;
        let reach = 0.5 * (r + m);
        let step = if step > reach { reach } else { step };
        let step = if step < -reach { -reach } else { step };
        AmplitudeStep {
            next: if r + step > 0.0 { r + step } else { 0.0 },
            gap: (m - r).abs() / r.max(m),
            turn: z_r * (over_m / gain),
        }
    }
}

/// At a fold the root is double; a bounded derivative keeps the step finite.
#[inline(always)]
pub(super) fn bounded(gain: f64) -> f64 {
    let least = if gain < 0.0 { -0.02 } else { 0.02 };
    if gain.abs() < 0.02 { least } else { gain }
}
