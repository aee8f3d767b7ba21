//! What a person can do about a warning or an error, independent of the program that shows it.

use std::{borrow::Cow, fmt};

/// Advice that usually names an option and, if known, a value for it.
///
/// Libraries name options by the field of the options structure that holds them (`band_hz`); a
/// program spells them its own way with [`Hint::spelled`]: `--band 79 82` on a command line,
/// `band_hz=(79, 82)` in Python.
///
/// ```
/// use slipfit::answer::hint::Hint;
/// let hint = Hint::new("band_hz", "isolates one mode").with([79.0, 82.0]);
/// assert_eq!(hint.to_string(), "band_hz = (79, 82) isolates one mode");
/// let flag = |name: &str, _: Option<&_>| format!("--{}", name.replace('_', "-"));
/// assert_eq!(hint.spelled(&flag), "--band-hz isolates one mode");
/// assert_eq!(Hint::advice("a longer record helps").to_string(), "a longer record helps");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Hint {
    /// Field of an options structure, such as `rate_hz`, or `analysis`; `None` if no option helps.
    pub option: Option<&'static str>,
    /// The value to give it, if known.
    pub value: Option<HintValue>,
    /// What the option does, as a predicate (`isolates one mode`), or a whole sentence if no
    /// option helps.
    pub advice: Cow<'static, str>,
}

/// A value for an option.
#[derive(Debug, Clone, PartialEq)]
pub enum HintValue {
    /// A number in the unit of the option.
    Number(f64),
    /// Lower and upper limit in the unit of the option.
    Range([f64; 2]),
    /// A word, such as the name of a model or a unit.
    Text(String),
}

/// An analysis, for hints that depend on it or lead to another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Analysis {
    /// A free decay.
    Ringdown,
    /// A resonance curve.
    Resonance,
    /// Amplitudes over drive levels.
    Levels,
}

impl Analysis {
    /// Name of its module.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ringdown => "ringdown",
            Self::Resonance => "resonance",
            Self::Levels => "levels",
        }
    }
}

impl From<Analysis> for HintValue {
    fn from(analysis: Analysis) -> Self {
        analysis.name().into()
    }
}

impl From<f64> for HintValue {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<[f64; 2]> for HintValue {
    fn from(limits: [f64; 2]) -> Self {
        Self::Range(limits)
    }
}

impl From<&str> for HintValue {
    fn from(word: &str) -> Self {
        Self::Text(word.to_owned())
    }
}

/// How a program writes an option and its value, if any.
pub type Spelling<'a> = &'a dyn Fn(&'static str, Option<&HintValue>) -> String;

impl Hint {
    /// Advice about an option, named by its field.
    pub fn new(option: &'static str, advice: impl Into<Cow<'static, str>>) -> Self {
        Self { option: Some(option), value: None, advice: advice.into() }
    }

    /// Advice to use another analysis: the option `analysis` with its name.
    pub fn analysis(analysis: Analysis, advice: impl Into<Cow<'static, str>>) -> Self {
        Self::new("analysis", advice).with(analysis)
    }

    /// Advice that is not about an option.
    pub fn advice(advice: impl Into<Cow<'static, str>>) -> Self {
        Self { option: None, value: None, advice: advice.into() }
    }

    /// The same hint with a value for the option.
    #[must_use]
    pub fn with(self, value: impl Into<HintValue>) -> Self {
        Self { value: Some(value.into()), ..self }
    }

    /// As a sentence in which `spell` writes the option with its value.
    pub fn spelled(&self, spell: Spelling<'_>) -> String {
        spelled(std::slice::from_ref(self), spell)
    }
}

/// Several hints as one sentence: hints with the same advice are alternatives (`a, b or c narrows it`), the others
/// follow one another, separated by semicolons.
///
/// ```
/// use slipfit::answer::hint::{Hint, spelled};
/// let hints = [Hint::new("start_s", "chooses by hand"), Hint::new("end_s", "chooses by hand")];
/// let text = spelled(&hints, &|name, _| name.to_owned());
/// assert_eq!(text, "start_s or end_s chooses by hand");
/// ```
pub fn spelled(hints: &[Hint], spell: Spelling<'_>) -> String {
    let sentence = |alternatives: &[Hint]| {
        let options: Vec<String> =
            alternatives.iter().filter_map(|h| Some(spell(h.option?, h.value.as_ref()))).collect();
        let subject = match options.split_last() {
            None => String::new(),
            Some((last, [])) => format!("{last} "),
            Some((last, others)) => format!("{} or {last} ", others.join(", ")),
        };
        format!("{subject}{}", alternatives[0].advice)
    };
    hints.chunk_by(|a, b| a.advice == b.advice).map(sentence).collect::<Vec<_>>().join("; ")
}

impl fmt::Display for HintValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value}"),
            Self::Range([low, high]) => write!(f, "({low}, {high})"),
            Self::Text(word) => f.write_str(word),
        }
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.spelled(&|name, value| match value {
            Some(value) => format!("{name} = {value}"),
            None => name.to_owned(),
        }))
    }
}
