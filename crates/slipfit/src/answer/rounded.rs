//! Numbers for display: rounded to their uncertainty, in a suitable unit.

use super::figures::figures;
use std::fmt;

/// Base units that take SI prefixes, and whether prefixes above one are in use.
const BASES: [(&str, bool); 12] = [
    ("m", true),
    ("g", true),
    ("s", false),
    ("rad", false),
    ("Hz", true),
    ("V", true),
    ("A", true),
    ("N", true),
    ("Pa", true),
    ("J", true),
    ("W", true),
    ("Ohm", true),
];

const PREFIXES: [(&str, i32); 12] = [
    ("T", 12),
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("", 0),
    ("m", -3),
    ("µ", -6),
    ("u", -6),
    ("n", -9),
    ("p", -12),
    ("f", -15),
    ("a", -18),
];

/// Numbers from this size …
const READS_FROM: f64 = 0.1;
/// … up to this size keep their own unit.
const READS_TO: f64 = 1e4;

/// A unit for display: displayed number = number × `factor`.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// Multiplies the number.
    pub factor: f64,
    /// The unit shown, with its SI prefix or power of ten.
    pub unit: String,
    /// Power of ten at the beginning of `unit`, if no prefix is available.
    pub power: Option<i32>,
}

impl Scale {
    /// The scale suited to numbers of this size.
    ///
    /// ```
    /// use slipfit::answer::rounded::Scale;
    /// assert_eq!(Scale::for_size(0.00227, "rad").unit, "mrad");
    /// assert_eq!(Scale::for_size(0.25, "rad").unit, "rad");
    /// assert_eq!(Scale::for_size(2e-5, "kg/s").unit, "mg/s");
    /// assert_eq!(Scale::for_size(3e-7, "1/s").unit, "×10⁻⁷ 1/s");
    /// ```
    pub fn for_size(size: f64, unit: &str) -> Self {
        let size = size.abs();
        let own = Self { factor: 1.0, unit: unit.to_owned(), power: None };
        if !size.is_finite() || size == 0.0 || (READS_FROM..READS_TO).contains(&size) {
            return own;
        }
        if let Some((exponent, base, above_one, rest)) = split_unit(unit) {
            let size = size * 10f64.powi(exponent);
            let highest = if above_one { 12 } else { 0 };
            let wanted = (((size.log10() + 1e-12) / 3.0).floor() as i32 * 3).clamp(-18, highest);
            if let Some((prefix, _)) = PREFIXES.iter().find(|p| p.1 == wanted)
                && (1e-3..1e6).contains(&(size / 10f64.powi(wanted)))
            {
                let factor = 10f64.powi(exponent - wanted);
                return Self { factor, unit: format!("{prefix}{base}{rest}"), power: None };
            }
        }
        if (1e-3..1e6).contains(&size) {
            return own;
        }
        let power = (size.log10() + 1e-12).floor() as i32;
        let unit = format!("×10{} {unit}", superscript(power)).trim_end().to_owned();
        // In two steps, because 10^±power alone may exceed the range of doubles.
        let half = power / 2;
        let factor = 10f64.powi(-half) * 10f64.powi(half - power);
        Self { factor, unit, power: Some(power) }
    }

    /// A name with its unit as in a heading or on an axis, `x_F [mrad]`; the name alone for pure numbers.
    ///
    /// ```
    /// use slipfit::answer::rounded::Scale;
    /// assert_eq!(Scale::for_size(0.002, "rad").titled("x_F"), "x_F [mrad]");
    /// assert_eq!(Scale::for_size(3e-7, "").titled("β"), "β [10⁻⁷]");
    /// ```
    pub fn titled(&self, name: &str) -> String {
        let unit = self.unit.trim_start_matches('×');
        if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
    }
}

/// Exponent of the prefix, base unit, whether the base takes prefixes above one, and the rest.
fn split_unit(unit: &str) -> Option<(i32, &'static str, bool, &str)> {
    let end = unit.find(|c: char| !c.is_alphabetic()).unwrap_or(unit.len());
    let (head, rest) = unit.split_at(end);
    if rest.starts_with(['²', '³', '^', '1', '2', '3', '_', '.']) {
        return None;
    }
    let prefixed = |exponent: i32, tail: &str| {
        BASES.iter().find(|b| b.0 == tail).map(|&(base, above)| (exponent, base, above, rest))
    };
    prefixed(0, head).or_else(|| {
        PREFIXES
            .iter()
            .filter(|p| !p.0.is_empty())
            .find_map(|(prefix, exponent)| prefixed(*exponent, head.strip_prefix(prefix)?))
    })
}

fn superscript(number: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
    };
    number.to_string().chars().map(digit).collect()
}

/// A value with its uncertainty, rounded by the rule of the Particle Data Group: the uncertainty keeps two digits if
/// its three leading digits are at most 354, one digit from 355 to 949, and is rounded to 1000 with two digits from 950
/// on.
///
/// ```
/// use slipfit::answer::rounded::Rounded;
/// assert_eq!(Rounded::new(0.0022713, 0.0000512, "rad").to_string(), "2.27 ± 0.05 mrad");
/// assert_eq!(Rounded::new(0.519164, 0.0000277, "Hz").to_string(), "0.519164 ± 0.000028 Hz");
/// assert_eq!(Rounded::new(3.21e-7, 4e-9, "1/s").to_string(), "(3.21 ± 0.04)×10⁻⁷ 1/s");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Rounded {
    value: f64,
    std_error: f64,
    decimals: i32,
    /// Unit and factor.
    pub scale: Scale,
}

impl Rounded {
    /// A quantity for a line of text; if its interval is narrower than its standard error, a quarter of the interval
    /// sets the rounding.
    pub fn of(q: &crate::Quantity) -> Self {
        let [low, high] = q.interval_95;
        let error = if high - low < q.std_error { 0.25 * (high - low) } else { q.std_error };
        Self::new(q.value, error, &q.unit)
    }

    /// Rounds `value` by its standard error. If that is zero or not finite, four significant digits are kept and `±` is
    /// omitted.
    pub fn new(value: f64, std_error: f64, unit: &str) -> Self {
        let known = std_error.is_finite() && std_error > 0.0;
        let size = if known { value.abs().max(std_error) } else { value };
        let scale = Scale::for_size(size, unit);
        let (value, std_error) = (value * scale.factor, std_error * scale.factor);
        let decimals = if known {
            uncertainty_decimals(std_error)
        } else {
            // Without an uncertainty trailing zeros carry no meaning.
            let most = significant_decimals(value, 4).max(0);
            (0..most).find(|&d| (round_to(value, d) - round_to(value, most)).abs() < 1e-12).unwrap_or(most)
        };
        let std_error = if known { std_error } else { f64::NAN };
        Self { value, std_error, decimals: decimals.min(12), scale }
    }

    /// Digits of the value.
    pub fn value(&self) -> String {
        self.digits(self.value)
    }

    /// Digits of the uncertainty, if there is one.
    pub fn uncertainty(&self) -> Option<String> {
        self.std_error.is_finite().then(|| self.digits(self.std_error))
    }

    /// Another number in the same unit, at the same scale and with the same decimals.
    pub fn also(&self, other: f64) -> String {
        self.digits(other * self.scale.factor)
    }

    fn digits(&self, scaled: f64) -> String {
        digits(scaled, self.decimals)
    }
}

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.value();
        let number = match (self.uncertainty(), self.scale.power) {
            (Some(u), Some(_)) => format!("({value} ± {u})"),
            (Some(u), None) => format!("{value} ± {u}"),
            (None, _) => value,
        };
        let gap = if self.scale.unit.is_empty() || self.scale.power.is_some() { "" } else { " " };
        write!(f, "{number}{gap}{}", self.scale.unit)
    }
}

/// A relative difference in per cent with its sign, `+9 %`, `-3 %`; a difference that rounds to zero has no
/// sign, `0 %`.
///
/// ```
/// use slipfit::answer::rounded::signed_percent;
/// assert_eq!(signed_percent(0.094), "+9 %");
/// assert_eq!(signed_percent(-1e-3), "0 %");
/// ```
pub fn signed_percent(relative: f64) -> String {
    let per_cent = (100.0 * relative).round();
    if per_cent == 0.0 { "0 %".to_owned() } else { format!("{per_cent:+.0} %") }
}

/// A fraction as a percentage with two digits.
///
/// ```
/// use slipfit::answer::rounded::exact_percent;
/// assert_eq!(exact_percent(0.025), "2.5 %");
/// assert_eq!(exact_percent(0.4), "40 %");
/// ```
pub fn exact_percent(part: f64) -> String {
    let digits = (1.0 - (100.0 * part.abs().max(1e-9)).log10().floor()).clamp(0.0, 6.0);
    format!("{:.*} %", digits as usize, 100.0 * part)
}

/// Length of a record in decay times.
///
/// ```
/// use slipfit::answer::rounded::decay_times;
/// assert_eq!(decay_times(0.543), "0.54 of a decay time");
/// assert_eq!(decay_times(1.034), "1.03 decay times");
/// ```
pub fn decay_times(count: f64) -> String {
    let text = figures(count, if count < 1.0 { 2 } else { 3 });
    if count < 1.0 && text != "1" { format!("{text} of a decay time") } else { format!("{text} decay times") }
}

/// A number with the given count of significant digits, in a suitable unit.
///
/// ```
/// assert_eq!(slipfit::answer::rounded::plain(0.0002499, 2, "rad"), "250 µrad");
/// assert_eq!(slipfit::answer::rounded::plain(482.04, 4, "s"), "482 s");
/// ```
pub fn plain(value: f64, significant: i32, unit: &str) -> String {
    // Rounded first, because 999.96 µm to three digits is 1 mm.
    let rounded = round_to(value, significant_decimals(value, significant).min(300));
    let scale = Scale::for_size(if rounded.is_finite() { rounded } else { value }, unit);
    let shown = value * scale.factor;
    let most = significant_decimals(shown, significant).max(0);
    let fewest =
        (0..most).find(|&d| (round_to(shown, d) - round_to(shown, most)).abs() < 1e-12).unwrap_or(most);
    let gap = if scale.unit.is_empty() || scale.power.is_some() { "" } else { " " };
    format!("{}{gap}{}", digits(shown, fewest), scale.unit)
}

fn round_to(value: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(decimals);
    (value * unit).round() / unit
}

fn digits(value: f64, decimals: i32) -> String {
    if !value.is_finite() {
        return if value.is_nan() {
            "?".to_owned()
        } else if value > 0.0 {
            "∞".to_owned()
        } else {
            "-∞".to_owned()
        };
    }
    let text = if decimals < 0 {
        format!("{:.0}", round_to(value, decimals))
    } else {
        format!("{value:.*}", decimals as usize)
    };
    // "-0.00" is a rounded zero, not a negative number.
    if text.starts_with('-') && !text.contains(|c: char| ('1'..='9').contains(&c)) {
        text[1..].to_owned()
    } else {
        text
    }
}

fn significant_decimals(value: f64, significant: i32) -> i32 {
    if value == 0.0 || !value.is_finite() {
        return 0;
    }
    // Rounding may carry into the next decade: 9.96 to two digits is 10.
    let decade = |v: f64| (v.abs().log10() + 1e-12).floor() as i32;
    let decimals = significant - 1 - decade(value);
    let rounded = round_to(value, decimals);
    if rounded == 0.0 { decimals } else { significant - 1 - decade(rounded) }
}

/// Decimals according to the rule of the Particle Data Group.
fn uncertainty_decimals(std_error: f64) -> i32 {
    let decade = std_error.log10().floor() as i32;
    let leading = (std_error / 10f64.powi(decade - 2)).round() as i32;
    // From 950 on the uncertainty is rounded to 1000, of which two digits are kept.
    if leading <= 354 { 1 - decade } else { -decade }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncertainties_keep_one_or_two_digits() {
        let text = |v, s| Rounded::new(v, s, "").to_string();
        assert_eq!(text(1.2345, 0.0354), "1.234 ± 0.035");
        assert_eq!(text(1.2345, 0.0355), "1.23 ± 0.04");
        assert_eq!(text(1.2345, 0.0949), "1.23 ± 0.09");
        assert_eq!(text(1.2345, 0.0951), "1.23 ± 0.10");
        assert_eq!(text(1.2345, 0.09996), "1.23 ± 0.10");
        assert_eq!(text(1234.0, 57.0), "1230 ± 60");
        assert_eq!(text(1234.0, 12.3), "1234 ± 12");
        assert_eq!(text(0.0, 0.2), "0.00 ± 0.20");
        assert_eq!(text(-0.001, 0.2), "0.00 ± 0.20");
    }

    #[test]
    fn a_value_without_uncertainty_shows_no_sign_of_one() {
        assert_eq!(Rounded::new(2.5, f64::NAN, "rad").to_string(), "2.5 rad");
        assert_eq!(Rounded::new(f64::INFINITY, 0.0, "").to_string(), "∞");
        assert_eq!(Rounded::new(f64::NAN, f64::NAN, "m").to_string(), "? m");
    }

    #[test]
    fn prefixes_follow_the_size_of_number_or_doubt() {
        let text = |v, s, u| Rounded::new(v, s, u).to_string();
        assert_eq!(text(25e-9, 1e-10, "m"), "25.00 ± 0.10 nm");
        assert_eq!(text(0.0, 2e-10, "m"), "0 ± 200 pm");
        assert_eq!(text(32_700.0, 0.02, "Hz"), "32.700000 ± 0.000020 kHz");
        assert_eq!(text(1.5e-8, 1e-9, "N"), "15.0 ± 1.0 nN");
        assert_eq!(text(0.003, 0.0002, "mm"), "3.00 ± 0.20 µm");
        assert_eq!(text(12.0, 0.5, "deg"), "12.0 ± 0.5 deg");
        assert_eq!(text(5e5, 1e3, "s"), "500000 ± 1000 s");
        assert_eq!(text(2e-5, 1e-6, "m²"), "(2.00 ± 0.10)×10⁻⁵ m²");
        assert_eq!(text(4e-3, 1e-4, "m/s"), "4.00 ± 0.10 mm/s");
        assert_eq!(text(1e-300, 1e-301, "N"), "(1.00 ± 0.10)×10⁻³⁰⁰ N");
        assert_eq!(text(1e300, 1e299, "1/s"), "(1.00 ± 0.10)×10³⁰⁰ 1/s");
    }

    #[test]
    fn intervals_share_the_scale_of_their_value() {
        let r = Rounded::new(0.00012, 0.00005, "rad");
        assert_eq!((r.also(0.0), r.also(0.00031)), ("0".to_owned(), "310".to_owned()));
    }

    #[test]
    fn plain_numbers_carry_into_the_next_decade() {
        assert_eq!(plain(9.996, 3, "s"), "10 s");
        assert_eq!(plain(0.000_999_96, 3, "m"), "1 mm");
        assert_eq!(plain(1234.6, 3, "s"), "1235 s");
        assert_eq!(plain(0.0, 3, "s"), "0 s");
        assert_eq!(plain(f64::NAN, 3, ""), "?");
    }
}
