//! Possible roles of a column, from its header and unit alone.

use slipfit::SignalKind::{self, Acceleration, Displacement, Envelope, Velocity};

use super::{
    name::{Name, words},
    units::{self, Measures, listed},
};

/// Role that a column may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Role {
    Time,
    /// The signal of a record; a higher rank is preferred.
    Signal {
        rank: u8,
        kind: SignalKind,
        like: &'static str,
    },
    Frequency,
    /// A frequency relative to a centre.
    Shift,
    Centre,
    Period,
    Amplitude,
    Phase,
    /// Real part, or in-phase output of a lock-in.
    Real,
    /// Imaginary part, or quadrature output of a lock-in.
    Imaginary,
    /// Quartz: real and imaginary part of the admittance.
    Conductance,
    Susceptance,
    /// Quartz: real and imaginary part of the impedance in series.
    Resistance,
    Reactance,
    /// The modulus of an admittance, electrical as of a quartz.
    Admittance,
    /// The modulus of an impedance.
    Impedance,
    Drive,
    /// The motion of the base that carries the oscillator.
    Base,
    StdError,
    /// Not part of the motion: a counter, a file name, a temperature, a spectrum.
    Never,
    Unknown,
}

/// A header in the form used by the rules. Words in lists are separated by blanks.
struct Header<'a> {
    name: &'a Name,
    bare: &'a str,
    words: Vec<String>,
    measures: Option<Measures>,
}

impl<'a> Header<'a> {
    fn new(name: &'a Name) -> Self {
        Self { name, bare: name.bare.trim(), words: words(&name.bare), measures: name.measures() }
    }

    /// Whether one of its words is listed.
    fn has(&self, list: &str) -> bool {
        self.words.iter().any(|word| listed(list, word))
    }

    /// Whether the first word is listed: short words are significant only in front, the A of `Weg b_A` is an index.
    fn begins(&self, list: &str) -> bool {
        self.words.first().is_some_and(|word| listed(list, word))
    }

    /// Whether one of its words contains one listed.
    fn within(&self, list: &str) -> bool {
        self.words.iter().any(|word| list.split_ascii_whitespace().any(|part| word.contains(part)))
    }

    fn is_time(&self) -> bool {
        matches!(self.measures, Some(Measures::Time(_)))
    }

    fn is_signal(&self, kind: SignalKind) -> bool {
        self.measures == Some(Measures::Signal(kind))
    }

    /// Whether the unit allows a letter to denote a kind: `V (V)` is no velocity, `gz (deg/s)` no acceleration.
    fn leaves_open(&self, kind: SignalKind) -> bool {
        match self.measures {
            None => true,
            Some(Measures::Signal(measured)) => measured == kind,
            Some(_) => false,
        }
    }

    /// Whether one of its words is the name of a sensor with or without an axis: `AccX`, `gFz`, `GyrY`.
    fn of_axis(&self, sensors: &str) -> bool {
        self.words.iter().any(|word| listed(sensors, word.strip_suffix(['x', 'y', 'z']).unwrap_or(word)))
    }

    /// Whether the header is an analogue input of a microcontroller: `A0`, `a0`.
    fn is_analogue_pin(&self) -> bool {
        let number = self.bare.strip_prefix('A').or(Some("0").filter(|_| self.bare == "a0"));
        number.is_some_and(|n| !n.is_empty() && n.len() < 3 && n.bytes().all(|b| b.is_ascii_digit()))
    }

    /// Whether the header is the letter of a channel, as used by PicoScope: an acceleration is a lower-case `a`.
    fn is_channel(&self) -> bool {
        self.bare == "A" && !self.is_signal(Acceleration)
    }

    fn is_level(&self) -> bool {
        matches!(self.measures, Some(Measures::Level(_)))
    }

    /// Whether the unit is one of frequency only.
    fn in_hertz(&self) -> bool {
        let unit = self.name.unit.as_str();
        let of_other = listed("deg/s \u{b0}/s mrad/s", &unit.trim().to_lowercase());
        units::hertz(unit).is_some() && !of_other && !units::is_per_second(unit)
    }

    /// Whether the header is the logarithm of a frequency: `log10(f/Hz)`.
    fn is_logarithm(&self) -> bool {
        let words = words(&self.name.header);
        let of = |word: &String| listed("f freq frequency frequenz omega ω nu ν", word);
        let one = |word: &String| listed("logf lgf", word);
        words.first().is_some_and(|first| one(first) || listed("log lg ln", first) && words.iter().any(of))
    }

    fn names_frequency(&self) -> bool {
        self.within("freq frequen fréquen frecuen kreisfrequ puls част 频率 頻率 周波数")
    }

    /// Whether the header is the frequency of a drive, not the drive itself: `Erregerfrequenz`, `f_drive`; a capital F
    /// is a force.
    fn is_drive_frequency(&self) -> bool {
        let unit = self.name.unit.trim();
        let letter = self.begins("f \u{3bd} nu \u{3c9} omega") && !self.bare.starts_with('F');
        let of_drive = || self.within(DRIVES) || self.has("exc d");
        (self.names_frequency() || letter && of_drive()) && (unit.is_empty() || units::hertz(unit).is_some())
    }

    /// Whether the header is one of the two outputs of a lock-in and not a phase: `in-phase`, `Out of phase (V)`.
    fn is_quadrature_of_phase(&self) -> bool {
        is_in_phase(&self.words) || is_out_of_phase(&self.words)
    }

    fn unit_in(&self, list: &str) -> bool {
        listed(list, &self.name.unit.trim().to_lowercase())
    }

    /// Whether the header is a letter for a quantity of a quartz, in its unit or without one.
    fn letter(&self, letter: &str, units: &str) -> bool {
        self.bare.eq_ignore_ascii_case(letter) && (self.name.unit.trim().is_empty() || self.unit_in(units))
    }

    /// Whether the header is the modulus of an admittance or an impedance, in its unit or without one: by a part of a
    /// word, by its spelling, or by a letter in that unit.
    fn electrical(&self, part: &str, written: &str, letter: &str, units: &str) -> bool {
        let in_unit = self.unit_in(units);
        // A unit of several words remains in the name: `Impedance (N s/m)` is mechanical.
        let named = self.within(part) && !self.bare.contains(['(', '[']) || self.is_any(written);
        named && (in_unit || self.name.unit.trim().is_empty()) || in_unit && self.is_any(letter)
    }

    fn is_any(&self, list: &str) -> bool {
        listed(list, &self.bare.to_lowercase())
    }
}

const DRIVES: &str = "drive driving antrieb excit anreg erreg force kraft forza stimul";
const FORCES: &str = "n kn mn un \u{b5}n \u{3bc}n nn pn";

/// Whether one of the words, or two in a row, says `in phase`; the end of `gain phase` does not.
pub(super) fn is_in_phase(words: &[String]) -> bool {
    words.iter().any(|word| word == "inphase") || words.windows(2).any(|pair| pair == ["in", "phase"])
}

/// Whether the words say `out of phase`.
pub(super) fn is_out_of_phase(words: &[String]) -> bool {
    words.iter().any(|word| word == "outofphase")
        || words.windows(3).any(|triple| triple == ["out", "of", "phase"])
}

type Rule = (Role, fn(&Header<'_>) -> bool);

const fn signal(rank: u8, kind: SignalKind, like: &'static str) -> Role {
    Role::Signal { rank, kind, like }
}

const MEASURED: Role = signal(70, Displacement, "named like a measured signal");
const VELOCITY: Role = signal(60, Velocity, "named like a velocity");

/// Roles in a record over time; the first rule that fits decides.
const RECORD: &[Rule] = &[
    (Role::Never, |h| {
        h.has("sigma err error errors unc uncert uncertainty std stdev fehler unsicherheit incertezza errore \
               erreur incertidumbre freq frequency frequenz frequenza fréquence frecuencia f index idx nr sample \
               samples no drive antrieb excitation temperature temperatur temp pressure druck force kraft forza \
               fit model residual residuals mass masse massa energy energie row frame fps n period periode date \
               datum fecha")
            || h.within("fft uncert residu frequen fréquen frecuen 频率 頻率 周波数")
            || h.measures == Some(Measures::Other)
    }),
    (Role::Time, |h| {
        let named = h.has(
            "time timed times timestamp zeit laufzeit tempo temps tiempo tid tijd czas aika zaman čas idő время час \
             时间 時間 时刻 時刻 시간 elapsed seconds millis clock sekunden secondi segundos hora",
        );
        (h.is_time() || named || h.begins("t dt δt sec secs ms") || h.within("time zeit tiempo timestamp"))
            && !matches!(h.measures, Some(Measures::Signal(_) | Measures::Level(_)))
    }),
    (Role::Real, |h| is_in_phase(&h.words)),
    (Role::Imaginary, |h| h.has("quadrature quad") || is_out_of_phase(&h.words)),
    (signal(90, Envelope, "named like a level in dB"), |h| h.is_level()),
    (signal(30, Acceleration, "named like an acceleration"), |h| {
        is_acceleration(h) && (h.within("absolut betrag norm abs total magnitude") || h.begins("tgf"))
    }),
    (signal(50, Acceleration, "named like an acceleration"), is_acceleration),
    (VELOCITY, |h| {
        h.is_signal(Velocity)
            || h.within("ableitung derivative derivata dérivée derivada")
            || h.within(
                "veloc speed geschwindig vitesse omega angvel gyro drehrate rotationrate rotrate скорость 速度",
            )
            || h.is_any("dx/dt dy/dt dz/dt dθ/dt dϑ/dt dφ/dt dtheta/dt dphi/dt")
            || h.of_axis("gyr")
            || h.begins("v vx vy vz w wx wy wz ω ωx ωy ωz vel") && h.leaves_open(Velocity)
            || h.has("rotation") && h.has("rate")
    }),
    (signal(80, Envelope, "named like an amplitude"), |h| {
        h.within("magnitude envelope enveloppe envolvente einhüllende hüllkurve inviluppo amplitud ampiezza 振幅 power") || h.begins("r mag amp")
    }),
    (signal(100, Displacement, "named like an angle"), |h| {
        h.within("angle angol ángul ângul angul winkel theta угол 角度 twist rotation")
            || h.begins("θ ϑ phi φ ϕ alpha α ang")
    }),
    (signal(100, Displacement, "named like a position"), |h| {
        h.within(
            "position posizion posici posiç displace auslenk weg elongat elongac élong desloc 位置 変位 spostament déplacem deplacem desplaz \
             ausschlag deflection distanc distanz abstand waveform переме 位移",
        ) || h.begins("x y z pos disp s height höhe altezza length dist")
    }),
    (MEASURED, |h| {
        h.is_signal(Displacement)
            || h.is_analogue_pin()
            || h.within("voltag spannung tension voltaj signal detector photodiode")
            || h.begins("u volt volts ch cha chb kanal canal adc value wert")
    }),
];

fn is_acceleration(h: &Header<'_>) -> bool {
    h.is_signal(Acceleration)
        || h.within("accel beschleunig acelera accélér ускорен 加速度")
        || h.of_axis("acc ac linacc gf")
        || h.is_any("d2x/dt2 d²x/dt² d^2x/dt^2")
        || h.begins("tgf")
        || h.begins("a ax ay az gx gy gz")
            && h.leaves_open(Acceleration)
            && !h.is_analogue_pin()
            && !h.is_channel()
}

/// Roles in a curve over frequency or over drive levels; the first rule that fits decides.
const CURVE: &[Rule] = &[
    (Role::StdError, |h| {
        h.has("sigma err error unc std stdev fehler errore erreur se σ")
            || h.within("uncert unsicher incert stderr")
    }),
    (Role::Never, |h| h.within("resid fft outlier temperat pressure bandwidth coheren kohären")),
    // `Oscillation Control>Center Frequency (Hz)` and `Frequency Shift (Hz)` are matched before `Frequency`.
    (Role::Centre, |h| {
        h.within("center centre mitten carrier central") && (h.in_hertz() || h.names_frequency())
    }),
    (Role::Shift, |h| {
        h.within("shift detun verstimm offset delta") && (h.in_hertz() || h.names_frequency())
            || h.begins("df δf dω δω dw ∆f")
    }),
    (Role::Phase, |h| {
        h.within("phase fase phas phasenv фаз 相位 位相") && !h.is_quadrature_of_phase()
            // `S21 (deg)` is the phase of a scattering parameter.
            || h.begins("s") && h.bare.contains(|c: char| c.is_ascii_digit()) && units::radians(&h.name.unit).is_some()
    }),
    (Role::Real, |h| h.begins("re real realteil inphase reale réel") || is_in_phase(&h.words)),
    (Role::Imaginary, |h| {
        h.begins("im imag imaginary imaginärteil quadrature quad immaginaria") || is_out_of_phase(&h.words)
    }),
    (Role::Frequency, |h| h.is_drive_frequency()),
    (Role::Drive, |h| {
        h.within(DRIVES)
            || h.bare.starts_with('F') && h.begins("f") && h.unit_in(FORCES)
            || h.has("input exc force")
            || listed("uin vin uein chin", &h.words.concat())
    }),
    (Role::Base, |h| {
        h.has("base basis sockel socle shaker foundation fundament")
            && (h.name.unit.is_empty() || matches!(h.measures, Some(Measures::Signal(_))))
    }),
    (Role::Period, |h| h.within("period schwingungsdauer umlauf") || h.is_time() && h.bare == "T"),
    (Role::Time, |h| {
        h.within("time zeit tempo temps tiempo timestamp elapsed время 时间 時間")
            || h.is_time() && ["t", "T"].contains(&h.bare)
    }),
    (Role::Frequency, |h| h.names_frequency() || h.in_hertz() || h.is_logarithm()),
    (Role::Conductance, |h| h.is_any("gp conductance leitwert") || h.letter("g", SIEMENS)),
    (Role::Susceptance, |h| h.is_any("bp susceptance") || h.letter("b", SIEMENS)),
    (Role::Resistance, |h| h.is_any("rs resistance") || h.bare.eq_ignore_ascii_case("r") && h.unit_in(OHM)),
    (Role::Reactance, |h| {
        h.is_any("xs reactance reaktanz") || h.bare.eq_ignore_ascii_case("x") && h.unit_in(OHM)
    }),
    (Role::Admittance, |h| h.electrical("admittan", "|y| ymag y_mag mag(y) abs(y)", "y", SIEMENS)),
    (Role::Impedance, |h| h.electrical("impedan", "|z| zmag z_mag mag(z) abs(z)", "z", OHM)),
    // An angle of an oscillator is a response; a phase is named so or has a unit of angle.
    (Role::Unknown, |h| {
        h.begins("theta θ ϑ angle ang")
            && !listed("deg \u{b0} rad degree degrees grad", &h.name.unit.to_lowercase())
    }),
    (Role::Phase, |h| {
        h.begins("phi φ ϕ theta θ ϑ arg ph angle ang lag") || h.bare.starts_with(['<', '\u{2220}'])
    }),
    (Role::Amplitude, |h| {
        h.within(
            "amplitud ampiezza magnitud betrag response respons transmiss ausschlag амплит 振幅 幅值 幅度 level pegel power gain \
             deflection elongat mobilit movilidad inertanc accelerance receptanc rezeptanz frf psd asd",
        ) || h.bare.starts_with('|')
            || h.is_level()
    }),
    (Role::Frequency, |h| h.begins("f ν nu hz khz mhz ghz omega ω w rpm drehzahl")),
    (Role::Period, |h| h.bare == "T"),
    (Role::Time, |h| h.bare == "t"),
    (Role::Amplitude, |h| {
        h.begins("a amp ampl mag r max peak pk pp vpp rms abs s db dbm y z")
            || h.begins("x") && h.words.len() == 1
    }),
    (Role::Never, |h| {
        h.has("index idx nr no n row source file temp temperature temperatur outliers samples points q vswr fwhm date \
               datum run id label comment")
    }),
];

const SIEMENS: &str = "s ms us \u{b5}s \u{3bc}s ns siemens mho mmho umho \u{b5}mho \u{3bc}mho";
const OHM: &str = "ohm ohms \u{3c9} kohm k\u{3c9} mohm m\u{3c9} \u{2126}";

impl Role {
    /// Role in a record over time.
    pub(crate) fn in_record(name: &Name) -> Self {
        Self::by(RECORD, name)
    }

    /// Role in a curve over frequency or over drive levels.
    pub(crate) fn in_curve(name: &Name) -> Self {
        Self::by(CURVE, name)
    }

    fn is_of(self, wanted: SignalKind) -> bool {
        matches!(self, Self::Signal { kind, .. } if kind == wanted)
    }

    fn by(rules: &[Rule], name: &Name) -> Self {
        if name.header.is_empty() {
            return Self::Unknown;
        }
        let header = Header::new(name);
        rules.iter().find(|(_, fits)| fits(&header)).map_or(Self::Unknown, |(role, _)| *role)
    }
}

/// Roles of the columns of a record, which depend on each other: `gx` is an angular velocity if there is an `ax`.
pub(super) fn in_records(names: &[Name]) -> Vec<Role> {
    let first = |name: &Name| words(&name.bare).into_iter().next().unwrap_or_default();
    let accelerometer = names.iter().any(|name| {
        listed("ax ay az accx accy accz acx acy acz", &first(name))
            && Role::in_record(name).is_of(Acceleration)
    });
    let pins = names.iter().any(|name| name.bare.trim() == "a0");
    let is_pin = |name: &Name| {
        let number = name.bare.trim().strip_prefix('a');
        pins && name.unit.is_empty() && number.is_some_and(|n| n.parse::<u8>().is_ok())
    };
    let of = |name: &Name| {
        if is_pin(name) {
            return MEASURED;
        }
        let is_gyroscope = accelerometer && name.unit.is_empty() && listed("gx gy gz", &first(name));
        if is_gyroscope { VELOCITY } else { Role::in_record(name) }
    };
    names.iter().map(of).collect()
}

/// Kind measured by the sensor after which a sheet or a file is named: `Linear Acceleration`, `Gyroscope.csv`.
pub(super) fn kind_of_place(place: &str) -> Option<SignalKind> {
    // `TotalAcceleration` is one word; `acc` in `account` does not count.
    let words = words(place);
    let within =
        |parts: &str| words.iter().any(|word| parts.split_ascii_whitespace().any(|part| word.contains(part)));
    let has = |list: &str| words.iter().any(|word| listed(list, word));
    if within("acceler beschleunig acelera accélér accelero ускорен 加速度") || has("acc accel") {
        Some(Acceleration)
    } else if within("gyro rotationrate angularvel drehrate") || has("gyr") {
        Some(Velocity)
    } else {
        None
    }
}

/// Whether a header names a date.
pub(super) fn names_date(name: &Name) -> bool {
    words(&name.header).iter().any(|word| listed("date datetime datum fecha data", word))
}

/// Whether a header names a force or a pressure, or has a unit of one.
pub(super) fn names_force(name: &Name) -> bool {
    let unit = name.unit.trim().to_lowercase();
    let named =
        || words(&name.bare).iter().any(|word| listed("force kraft forza fuerza pressure druck sound", word));
    listed(FORCES, &unit) || listed("pa kpa hpa mpa bar mbar", &unit) || unit.is_empty() && named()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_in_a_record_follow_the_words() {
        for header in [
            "Time (s)",
            "t",
            "timestamp",
            "Zeit t / s",
            "Tempo",
            "Δt (ms)",
            "Timed",
            "t1",
            "Temps (s)",
            "us",
            "TimeUS",
        ] {
            assert_eq!(Role::in_record(&Name::parse(header)), Role::Time, "{header}");
        }
        for (header, wanted) in [
            ("Weg &b_A1 / rad", Displacement),
            ("zeiliche Ableitung w_1 / rad/s", Velocity),
            ("AngVel/rad/s", Velocity),
            ("With TMD (m/s^2)", Acceleration),
            ("power [dBm]", Envelope),
            ("omega1", Velocity),
            ("Voltage ( V )", Displacement),
            ("V (V)", Displacement),
            ("v [V]", Displacement),
            ("V1 (V)", Displacement),
            ("V(out)", Displacement),
            ("A (V)", Displacement),
            ("ax (V)", Displacement),
            ("A0", Displacement),
            ("v (m)", Displacement),
            ("v", Velocity),
            ("V", Velocity),
            ("gz (deg/s)", Velocity),
            ("gz", Acceleration),
            ("a1", Acceleration),
            ("Acceleration (V)", Acceleration),
            ("gFx", Acceleration),
            ("TgF", Acceleration),
            ("AccX", Acceleration),
            ("AcZ", Acceleration),
            ("LinAccY", Acceleration),
            ("LSM6DS_AccZ", Acceleration),
            ("Vertical acc", Acceleration),
            ("a / ms⁻²", Acceleration),
            ("GyrX", Velocity),
            ("wz", Velocity),
            ("rotationRate.x", Velocity),
            ("Rotation rate z", Velocity),
            ("Drehrate", Velocity),
            ("dx/dt", Velocity),
            ("rotation", Displacement),
        ] {
            let role = Role::in_record(&Name::parse(header));
            assert!(matches!(role, Role::Signal { kind, .. } if kind == wanted), "{header}: {role:?}");
        }
        for header in ["FFT f_3 / rad", "Frequenz f / Hz", "sigma", "Neue Größe f_2 / V"] {
            assert_eq!(Role::in_record(&Name::parse(header)), Role::Never, "{header}");
        }
    }

    #[test]
    fn places_are_named_after_their_sensor() {
        for (place, kind) in [
            ("Accelerometer.csv", Some(Acceleration)),
            ("TotalAcceleration", Some(Acceleration)),
            ("run 3 acc.csv", Some(Acceleration)),
            ("Gyroscope.csv", Some(Velocity)),
            ("account.csv", None),
            ("swing.csv", None),
            ("Orientation.csv", None),
        ] {
            assert_eq!(kind_of_place(place), kind, "{place}");
        }
    }

    #[test]
    fn roles_in_a_curve_follow_the_words() {
        for (headers, wanted) in [
            ("f_Hz|freq|Frequenz f / Hz|Omega|ω (rad/s)|MHz", Role::Frequency),
            ("Frequency Shift (Hz)", Role::Shift),
            ("Center Frequency (Hz)", Role::Centre),
            ("T_s|Period (ms)", Role::Period),
            ("amp_rad|A_Skt|Amplitude (m)|S21 (dB)|X[%]", Role::Amplitude),
            ("phase_deg|phi[deg]|Phase (rad)|<Zs|S21(DEG)|S21_deg|Ang (deg)", Role::Phase),
            ("Re(X)", Role::Real),
            ("Im (V)", Role::Imaginary),
            ("drive_V|drive_amp|Excitation (V)|U_in [V]|Vin (V)|U_in|Ch in", Role::Drive),
            ("base (g)|Base acceleration (g)|Shaker displacement (mm)", Role::Base),
            (
                "Drive frequency (Hz)|driving frequency|Excitation frequency|drive freq|f_drive|f_exc (Hz)|\
                 Erregerfrequenz|Erregerkreisfrequenz \u{3c9}/(1/s)|\u{3c9}_d (rad/s)",
                Role::Frequency,
            ),
            ("F (N)|F0 (mN)|F_drive|Drive frequency amplitude (V)|Excitation (Hz/V)", Role::Drive),
            ("S11 in-phase|In phase (V)", Role::Real),
            ("Out-of-phase (V)|out of phase", Role::Imaginary),
            ("gain phase", Role::Phase),
            ("log10 f|log10(f/Hz)|lg f|log frequency (kHz)", Role::Frequency),
            ("baseline|log10 A", Role::Unknown),
            ("sigma_A|amp err", Role::StdError),
            ("Gp", Role::Conductance),
            ("Bp", Role::Susceptance),
            ("Rs", Role::Resistance),
            ("Xs (Ω)", Role::Reactance),
            ("Impedance|Z (kOhm)|Impedanz [Ω]|Zmag", Role::Impedance),
            ("Admittance (mS)|Y [µS]", Role::Admittance),
            ("impedance phase (deg)", Role::Phase),
            ("Y (V)|Y", Role::Amplitude),
            ("mobility (m/s/N)|FRF magnitude ((m/s²)/N)|receptance (m/N)|PSD (nm^2/Hz)", Role::Amplitude),
            ("resid_rms_rad|FFT fft / rad|n_outliers|source", Role::Never),
            ("Zeit t / s", Role::Time),
            ("Weg|", Role::Unknown),
        ] {
            for header in headers.split('|') {
                assert_eq!(Role::in_curve(&Name::parse(header)), wanted, "{header}");
            }
        }
        assert_eq!(Role::in_curve(&Name::parse("|Zs|")), Role::Amplitude);
        assert_eq!(Role::in_curve(&Name::parse("|Z| (Ohm)")), Role::Impedance);
        assert_eq!(Role::in_curve(&Name::parse("|Y| (S)")), Role::Admittance);
    }
}
