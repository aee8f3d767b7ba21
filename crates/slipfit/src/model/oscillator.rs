//! The oscillator and its friction: parameters, units, derived quantities.
//!
//! ```text
//! m x'' + gamma x' + k x + F sgn(x') = k u(t)
//! ```
//!
//! Motion depends on mass only through `omega_0`, `delta` and the friction displacement `x_F = F/k`; these are
//! stored. The mass is kept if it is known, so that forces and energies can be given in newtons and joules.

use crate::error::Error;
use crate::model::displacement::DisplacementUnit;
use std::f64::consts::PI;

/// A linear, underdamped oscillator with viscous and sliding friction.
///
/// It is built physically, from mass, stiffness and forces, or kinematically, from the quantities that a displacement
/// record alone can determine: see [`Oscillator::builder`].
///
/// All displacements have the same unit, m (or rad) unless
/// [`displacement_unit`](OscillatorBuilder::displacement_unit) names another. Forces are always in N, stiffnesses in
/// N/m (for an angle N m and N m/rad), and are available for lengths and angles only. Times are in seconds
/// throughout.
///
/// ```
/// # use slipfit::Oscillator;
/// let fork = Oscillator::builder()
///     .frequency_hz(32_700.0)
///     .stiffness(1e4)
///     .viscous_coefficient(20e-6)
///     .coulomb_force(15e-9)
///     .build()?;
/// assert!((fork.friction_displacement() - 1.5e-12).abs() < 1e-24);
/// assert!((fork.q_factor() - 2433.6).abs() < 0.1);
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    omega_0: f64,
    decay_rate: f64,
    omega_d: f64,
    friction: f64,
    static_friction: f64,
    mass: Option<f64>,
    /// Unit of the displacements; `None` if it is neither a length nor an angle.
    unit: Option<DisplacementUnit>,
}

impl Oscillator {
    /// An empty builder; set a frequency and the friction parameters.
    pub fn builder() -> OscillatorBuilder {
        OscillatorBuilder::default()
    }

    /// Oscillator from `m`, `gamma`, `k` and `F`, with static friction equal to kinetic friction.
    ///
    /// # Errors
    /// As [`OscillatorBuilder::build`].
    pub fn physical(
        mass: f64,
        viscous_coefficient: f64,
        stiffness: f64,
        coulomb_force: f64,
    ) -> Result<Self, Error> {
        Self::builder()
            .mass(mass)
            .viscous_coefficient(viscous_coefficient)
            .stiffness(stiffness)
            .coulomb_force(coulomb_force)
            .build()
    }

    /// Oscillator from `omega_0` (rad/s), `delta` (1/s) and `x_F`, with static friction equal to kinetic friction.
    ///
    /// # Errors
    /// As [`OscillatorBuilder::build`].
    pub fn kinematic(omega_0: f64, decay_rate_per_s: f64, friction_displacement: f64) -> Result<Self, Error> {
        Self::builder()
            .omega_0(omega_0)
            .decay_rate_per_s(decay_rate_per_s)
            .friction_displacement(friction_displacement)
            .build()
    }

    /// Undamped angular frequency `omega_0 = sqrt(k/m)`, rad/s.
    pub fn omega_0(&self) -> f64 {
        self.omega_0
    }

    /// Undamped frequency `omega_0 / 2 pi`, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.omega_0 / (2.0 * PI)
    }

    /// Decay rate `delta = gamma / 2m`, 1/s.
    pub fn decay_rate_per_s(&self) -> f64 {
        self.decay_rate
    }

    /// Damped angular frequency `omega_d = sqrt(omega_0² - delta²)`, rad/s.
    pub fn omega_d(&self) -> f64 {
        self.omega_d
    }

    /// Damping ratio `zeta = delta / omega_0`.
    pub fn zeta(&self) -> f64 {
        self.decay_rate / self.omega_0
    }

    /// Quality factor of the viscous part alone, `Q = k / (gamma omega_0) = omega_0 / 2 delta`;
    /// infinite without viscous damping.
    pub fn q_factor(&self) -> f64 {
        self.omega_0 / (2.0 * self.decay_rate)
    }

    /// Half period of the free motion, `pi / omega_d`, s; friction does not change it.
    pub fn half_period_s(&self) -> f64 {
        PI / self.omega_d
    }

    /// Logarithmic decrement of the viscous part over a half period, `pi delta / omega_d`.
    pub fn half_cycle_decrement(&self) -> f64 {
        PI * self.decay_rate / self.omega_d
    }

    /// Friction displacement `x_F = F/k`: half width of the zone in which kinetic friction could balance the spring
    /// force.
    pub fn friction_displacement(&self) -> f64 {
        self.friction
    }

    /// `F_s/k`: half width of the zone in which a mass at rest stays at rest.
    pub fn static_displacement(&self) -> f64 {
        self.static_friction
    }

    /// Mass (or moment of inertia), if known.
    pub fn mass(&self) -> Option<f64> {
        self.mass
    }

    /// Stiffness `k = m omega_0²`, if the mass is known.
    pub fn stiffness(&self) -> Option<f64> {
        self.mass.map(|m| m * self.omega_0 * self.omega_0)
    }

    /// Viscous coefficient `gamma = 2 m delta`, if the mass is known.
    pub fn viscous_coefficient(&self) -> Option<f64> {
        self.mass.map(|m| 2.0 * m * self.decay_rate)
    }

    /// Unit of the displacements; `None` if it is neither a length nor an angle, so that forces cannot be given.
    pub fn displacement_unit(&self) -> Option<DisplacementUnit> {
        self.unit
    }

    /// Spring force `k x` at a displacement, N (for an angle N m), if the mass is known.
    pub fn force_at(&self, displacement: f64) -> Option<f64> {
        Some(self.unit?.force(displacement, self.stiffness()?))
    }

    /// Displacement `P/k` under a force in N (for an angle N m), if the mass is known: converts a force drive into
    /// the equivalent base drive.
    pub fn displacement_under(&self, force: f64) -> Option<f64> {
        Some(self.unit?.under_force(force, self.stiffness()?))
    }

    /// Kinetic friction force `F = k x_F`, if the mass is known.
    pub fn coulomb_force(&self) -> Option<f64> {
        self.force_at(self.friction)
    }

    /// Static friction force `F_s`, if the mass is known.
    pub fn static_force(&self) -> Option<f64> {
        self.force_at(self.static_friction)
    }

    /// Friction ratio for a base drive, `beta = 4 F / (pi k x_0)`.
    ///
    /// At resonance the steady amplitude is `Q x_0 (1 - beta)`, eq. (9) of Vitorino, Vieira and Rodrigues; for
    /// `beta >= 1` there is no steady motion in that approximation. A force drive of amplitude `P` corresponds to
    /// `x_0 = P/k` ([`Oscillator::displacement_under`]).
    pub fn friction_ratio(&self, drive_amplitude: f64) -> f64 {
        4.0 * self.friction / (PI * drive_amplitude)
    }

    /// The friction displacement for a friction ratio at a drive amplitude, `x_F = pi beta x_0/4`: the inverse of
    /// [`Oscillator::friction_ratio`].
    pub fn friction_displacement_for(friction_ratio: f64, drive_amplitude: f64) -> f64 {
        PI * friction_ratio * drive_amplitude / 4.0
    }

    /// Offset of the free decay, `C = x_F coth(pi delta / 2 omega_d)`: turning
    /// points fall exponentially towards `-C`. Infinite without viscous damping.
    pub fn decay_offset(&self) -> f64 {
        if self.friction == 0.0 { 0.0 } else { self.friction / (0.5 * self.half_cycle_decrement()).tanh() }
    }

    /// The same oscillator with other friction displacements.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `0 <= friction_displacement <= static_displacement`.
    pub fn with_friction(&self, friction_displacement: f64, static_displacement: f64) -> Result<Self, Error> {
        at_least_zero("friction_displacement", friction_displacement)?;
        if !(static_displacement >= friction_displacement && static_displacement.is_finite()) {
            return Err(Error::Parameter {
                name: "static_displacement",
                value: static_displacement,
                range: "friction_displacement <= static_displacement < infinity (F_s >= F)",
            });
        }
        Ok(Self { friction: friction_displacement, static_friction: static_displacement, ..*self })
    }
}

/// Parameters of an [`Oscillator`], in several equivalent forms.
///
/// One frequency is required: `omega_0`, `frequency_hz`, or two of mass, stiffness and frequency. At most one viscous
/// loss may be given: `q_factor`, `decay_rate_per_s`, `zeta` or `viscous_coefficient` (needs mass or stiffness). At
/// most one kinetic friction may be given: `friction_displacement` or `coulomb_force` (needs mass or stiffness).
/// Static friction equals kinetic friction unless given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OscillatorBuilder {
    mass: Option<f64>,
    stiffness: Option<f64>,
    omega_0: Option<f64>,
    frequency_hz: Option<f64>,
    viscous_coefficient: Option<f64>,
    q_factor: Option<f64>,
    decay_rate_per_s: Option<f64>,
    zeta: Option<f64>,
    coulomb_force: Option<f64>,
    friction_displacement: Option<f64>,
    static_force: Option<f64>,
    static_displacement: Option<f64>,
    displacement_unit: Option<String>,
}

macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        $($(#[$doc])* #[must_use] pub fn $name(mut self, $name: f64) -> Self {
            self.$name = Some($name);
            self
        })*
    };
}

impl OscillatorBuilder {
    setters! {
        /// Mass in kg (or moment of inertia), above zero.
        mass,
        /// Stiffness `k` in N/m (or N m/rad), above zero.
        stiffness,
        /// Undamped angular frequency in rad/s, above zero.
        omega_0,
        /// Undamped frequency in Hz, above zero.
        frequency_hz,
        /// Viscous coefficient `gamma` in N s/m, at least zero.
        viscous_coefficient,
        /// Quality factor of the viscous part, above 1/2; infinity for none.
        q_factor,
        /// Decay rate `delta = gamma/2m` in 1/s, at least zero.
        decay_rate_per_s,
        /// Damping ratio `delta/omega_0`, at least zero and below one.
        zeta,
        /// Kinetic friction force `F` in N, at least zero.
        coulomb_force,
        /// Friction displacement `x_F = F/k`, at least zero.
        friction_displacement,
        /// Static friction force `F_s` in N, at least `F`.
        static_force,
        /// Static friction as a displacement `F_s/k`, at least `x_F`.
        static_displacement,
    }

    /// Unit of all displacements, a length or an angle; forces are converted into it. With any other unit, such as V,
    /// only displacements can be given. The default is m (or rad).
    ///
    /// ```
    /// # use slipfit::Oscillator;
    /// let fork = Oscillator::builder()
    ///     .frequency_hz(32_700.0)
    ///     .stiffness(1e4)
    ///     .coulomb_force(15e-9)
    ///     .displacement_unit("nm")
    ///     .build()?;
    /// assert!((fork.friction_displacement() - 1.5e-3).abs() < 1e-15);
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    #[must_use]
    pub fn displacement_unit(mut self, unit: impl Into<String>) -> Self {
        self.displacement_unit = Some(unit.into());
        self
    }

    /// Checks every parameter and derives the rest.
    ///
    /// # Errors
    /// [`Error::NeitherLengthNorAngle`] for a force if the unit of the displacements is neither a length nor an
    /// angle; [`Error::Parameter`] for a value out of range or not finite (named, with the allowed range);
    /// [`Error::MissingParameter`] if a required value was not given; [`Error::ConflictingParameters`] if the same
    /// quantity was given twice.
    pub fn build(self) -> Result<Oscillator, Error> {
        one_of(&[("omega_0", self.omega_0), ("frequency_hz", self.frequency_hz)])?;
        one_of(&[
            ("q_factor", self.q_factor),
            ("decay_rate_per_s", self.decay_rate_per_s),
            ("zeta", self.zeta),
            ("viscous_coefficient", self.viscous_coefficient),
        ])?;
        one_of(&[
            ("friction_displacement", self.friction_displacement),
            ("coulomb_force", self.coulomb_force),
        ])?;
        one_of(&[("static_displacement", self.static_displacement), ("static_force", self.static_force)])?;

        for (name, value) in [
            ("mass", self.mass),
            ("stiffness", self.stiffness),
            ("omega_0", self.omega_0),
            ("frequency_hz", self.frequency_hz),
        ] {
            if let Some(v) = value {
                above_zero(name, v)?;
            }
        }
        let (omega_0, mass) = self.frequency_and_mass()?;
        let decay_rate = self.decay_rate(omega_0, mass)?;
        let stiffness = mass.map(|m| self.stiffness.unwrap_or(m * omega_0 * omega_0));
        let unit = self.displacement_unit.as_deref().unwrap_or("m");
        let friction = displacement(
            ("friction_displacement", self.friction_displacement),
            ("coulomb_force", self.coulomb_force),
            stiffness,
            unit,
        )?
        .unwrap_or(0.0);
        let given_static = displacement(
            ("static_displacement", self.static_displacement),
            ("static_force", self.static_force),
            stiffness,
            unit,
        )?;
        let static_friction = given_static.unwrap_or(friction);
        if static_friction < friction {
            return Err(match self.static_force {
                Some(value) => Error::Parameter {
                    name: "static_force",
                    value,
                    range: "coulomb_force <= static_force < infinity (F_s >= F)",
                },
                None => Error::Parameter {
                    name: "static_displacement",
                    value: static_friction,
                    range: "friction_displacement <= static_displacement < infinity (F_s >= F)",
                },
            });
        }
        let omega_d = ((omega_0 - decay_rate) * (omega_0 + decay_rate)).sqrt();
        let unit = DisplacementUnit::named(unit);
        Ok(Oscillator { omega_0, decay_rate, omega_d, friction, static_friction, mass, unit })
    }

    fn frequency_and_mass(&self) -> Result<(f64, Option<f64>), Error> {
        let given = self.omega_0.or(self.frequency_hz.map(|f| 2.0 * PI * f));
        let (omega_0, mass) = match (given, self.mass, self.stiffness) {
            (Some(_), Some(_), Some(_)) => {
                let first = if self.omega_0.is_some() { "omega_0" } else { "frequency_hz" };
                return Err(Error::ConflictingParameters { first, second: "mass and stiffness" });
            }
            (Some(w), Some(m), None) => (w, Some(m)),
            (Some(w), None, Some(k)) => (w, Some(k / (w * w))),
            (Some(w), None, None) => (w, None),
            (None, Some(m), Some(k)) => ((k / m).sqrt(), Some(m)),
            (None, _, _) => {
                return Err(Error::MissingParameter {
                    name: "frequency_hz",
                    hint: "give frequency_hz or omega_0, or both mass and stiffness",
                });
            }
        };
        // Fourth powers and reciprocals of omega_0 are needed.
        if !(1e-30..=1e30).contains(&omega_0) {
            return Err(Error::Parameter { name: "omega_0", value: omega_0, range: "1e-30 to 1e30 rad/s" });
        }
        if let Some(m) = mass {
            above_zero("mass", m)?;
            above_zero("stiffness", m * omega_0 * omega_0)?;
        }
        Ok((omega_0, mass))
    }

    fn decay_rate(&self, omega_0: f64, mass: Option<f64>) -> Result<f64, Error> {
        if let Some(q) = self.q_factor {
            return if q > 0.5 {
                Ok(omega_0 / (2.0 * q))
            } else {
                Err(Error::Parameter { name: "q_factor", value: q, range: "q_factor > 0.5 (underdamped)" })
            };
        }
        let (name, value, range, delta) = if let Some(z) = self.zeta {
            ("zeta", z, "0 <= zeta < 1 (underdamped)", z * omega_0)
        } else if let Some(d) = self.decay_rate_per_s {
            ("decay_rate_per_s", d, "0 <= decay_rate_per_s < omega_0 (underdamped)", d)
        } else if let Some(g) = self.viscous_coefficient {
            let m = mass.ok_or(Error::MissingParameter {
                name: "stiffness",
                hint: "viscous_coefficient needs mass or stiffness; q_factor needs neither",
            })?;
            ("viscous_coefficient", g, "0 <= viscous_coefficient < 2 sqrt(k m) (underdamped)", g / (2.0 * m))
        } else {
            return Ok(0.0);
        };
        if delta >= 0.0 && delta < omega_0 && value.is_finite() {
            Ok(delta)
        } else {
            Err(Error::Parameter { name, value, range })
        }
    }
}

fn displacement(
    direct: (&'static str, Option<f64>),
    force: (&'static str, Option<f64>),
    stiffness: Option<f64>,
    unit: &str,
) -> Result<Option<f64>, Error> {
    if let (name, Some(x)) = direct {
        at_least_zero(name, x)?;
        return Ok(Some(x));
    }
    let (name, Some(f)) = force else { return Ok(None) };
    at_least_zero(name, f)?;
    let k = stiffness.ok_or(Error::MissingParameter {
        name: "stiffness",
        hint: "a friction force needs mass or stiffness; friction_displacement needs neither",
    })?;
    let x = DisplacementUnit::of_forces(unit)?.under_force(f, k);
    at_least_zero(name, x)?;
    Ok(Some(x))
}

fn one_of(given: &[(&'static str, Option<f64>)]) -> Result<(), Error> {
    let mut present = given.iter().filter(|(_, v)| v.is_some()).map(|(name, _)| *name);
    match (present.next(), present.next()) {
        (Some(first), Some(second)) => Err(Error::ConflictingParameters { first, second }),
        _ => Ok(()),
    }
}

pub(crate) fn above_zero(name: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::Parameter { name, value, range: "0 < value < infinity" })
    }
}

pub(crate) fn at_least_zero(name: &'static str, value: f64) -> Result<(), Error> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::Parameter { name, value, range: "0 <= value < infinity" })
    }
}

pub(crate) fn moderate(name: &'static str, value: f64) -> Result<(), Error> {
    // Squares and products with frequencies must not overflow.
    if value.abs() <= 1e100 {
        Ok(())
    } else {
        Err(Error::Parameter { name, value, range: "finite, magnitude at most 1e100" })
    }
}

pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::Parameter { name, value, range: "finite numbers" }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn physical_and_kinematic_descriptions_agree() {
        let a = Oscillator::physical(2.0, 0.4, 50.0, 1.5).unwrap();
        let b = Oscillator::kinematic(5.0, 0.1, 0.03).unwrap();
        assert_eq!(a.omega_0(), b.omega_0());
        assert_eq!(a.decay_rate_per_s(), b.decay_rate_per_s());
        assert_eq!(a.friction_displacement(), b.friction_displacement());
        assert_eq!(a.static_displacement(), a.friction_displacement());
        assert!((a.q_factor() - 25.0).abs() < 1e-14);
        assert!((a.coulomb_force().unwrap() - 1.5).abs() < 1e-15);
        assert_eq!(b.coulomb_force(), None);
    }

    #[test]
    fn every_bad_parameter_is_named_with_its_range() {
        let named = |b: OscillatorBuilder| match b.build() {
            Err(Error::Parameter { name, value, range }) => (name, value, range),
            other => panic!("{other:?}"),
        };
        let b = Oscillator::builder;
        assert_eq!(named(b().mass(-1.0).stiffness(1.0)).0, "mass");
        assert_eq!(named(b().mass(1.0).stiffness(0.0)).0, "stiffness");
        assert!(named(b().frequency_hz(f64::NAN)).1.is_nan());
        assert_eq!(named(b().frequency_hz(1.0).q_factor(0.5)).2, "q_factor > 0.5 (underdamped)");
        assert_eq!(named(b().omega_0(1.0).decay_rate_per_s(1.0)).0, "decay_rate_per_s");
        assert_eq!(named(b().omega_0(1.0).zeta(-0.1)).0, "zeta");
        assert_eq!(named(b().omega_0(1.0).mass(1.0).viscous_coefficient(2.0)).0, "viscous_coefficient");
        assert_eq!(named(b().omega_0(1.0).friction_displacement(-1e-9)).0, "friction_displacement");
        let (name, value, range) = named(b().mass(1.0).stiffness(1.0).coulomb_force(2.0).static_force(1.0));
        assert_eq!((name, value), ("static_force", 1.0));
        assert!(range.contains("F_s >= F"));
    }

    #[test]
    fn missing_and_doubled_parameters_are_said() {
        assert!(matches!(
            Oscillator::builder().q_factor(10.0).build(),
            Err(Error::MissingParameter { name: "frequency_hz", .. })
        ));
        assert!(matches!(
            Oscillator::builder().omega_0(1.0).coulomb_force(1.0).build(),
            Err(Error::MissingParameter { name: "stiffness", .. })
        ));
        assert!(matches!(
            Oscillator::builder().omega_0(1.0).q_factor(10.0).zeta(0.1).build(),
            Err(Error::ConflictingParameters { first: "q_factor", second: "zeta" })
        ));
        assert!(matches!(
            Oscillator::builder().omega_0(1.0).mass(1.0).stiffness(1.0).build(),
            Err(Error::ConflictingParameters { first: "omega_0", .. })
        ));
    }

    /// 15 nN over 10 kN/m are 1.5e-12 m; earlier versions also gave 1.5e-12 for nm.
    #[test]
    fn forces_are_turned_into_the_unit_of_the_displacement() {
        let of = |unit: &str| {
            let b = Oscillator::builder().frequency_hz(32_700.0).stiffness(1e4).coulomb_force(15e-9);
            b.static_force(20e-9).displacement_unit(unit).build()
        };
        for (unit, x_f) in [
            ("m", 1.5e-12),
            ("nm", 1.5e-3),
            ("pm", 1.5),
            ("Inches", 1.5e-12 / 0.0254),
            ("rad", 1.5e-12),
            ("mrad", 1.5e-9),
            ("deg", 1.5e-12 * 180.0 / PI),
        ] {
            let o = of(unit).unwrap();
            assert!((o.friction_displacement() / x_f - 1.0).abs() < 1e-14, "{unit}: {o:?}");
            assert!((o.static_displacement() / x_f - 4.0 / 3.0).abs() < 1e-14, "{unit}: {o:?}");
            // Converting back gives the force that was put in, as headers and answers print it.
            assert!((o.coulomb_force().unwrap() / 15e-9 - 1.0).abs() < 1e-14, "{unit}");
            assert!((o.static_force().unwrap() / 20e-9 - 1.0).abs() < 1e-14, "{unit}");
            assert!((o.displacement_under(15e-9).unwrap() / x_f - 1.0).abs() < 1e-14, "{unit}");
        }
        for unit in ["dB", "furlong", "V", "", "m/s"] {
            assert_eq!(of(unit), Err(Error::NeitherLengthNorAngle { unit: unit.to_owned() }));
            let bare = Oscillator::builder().frequency_hz(1.0).stiffness(1e4).friction_displacement(0.1);
            let o = bare.displacement_unit(unit).build().unwrap();
            assert_eq!((o.friction_displacement(), o.coulomb_force()), (0.1, None), "{unit}");
            assert_eq!(o.displacement_under(1.0), None, "{unit}");
        }
    }

    #[test]
    fn an_infinite_quality_factor_is_no_viscous_damping() {
        let o = Oscillator::builder().omega_0(3.0).q_factor(f64::INFINITY).build().unwrap();
        assert_eq!(o.decay_rate_per_s(), 0.0);
        assert_eq!(o.q_factor(), f64::INFINITY);
    }
}
