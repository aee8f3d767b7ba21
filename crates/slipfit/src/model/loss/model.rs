//! Loss models: sets of loss terms.

use super::LossTerm;
use std::fmt;
use std::sync::LazyLock;

/// The set of loss terms that act on the oscillator.
///
/// The amplitude obeys `dA/dt = -(a0 + a1 A + a2 A² + ...)`: sliding friction gives the constant term (eqs. (15)-(18)
/// of Vitorino, Vieira and Rodrigues), viscous damping the linear term, quadratic drag the quadratic term; further
/// [terms](LossTerm) add their own.
///
/// ```
/// use slipfit::{LossModel, LossTerm};
/// let model: LossModel = "viscous+sliding".parse()?;
/// assert_eq!(model, LossModel::VISCOUS_SLIDING);
/// assert!(model.has(LossTerm::Sliding));
/// assert!(!model.has(LossTerm::Drag));
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LossModel {
    /// One bit for each term of [`LossTerm::ALL`].
    terms: u16,
}

/// The names of all sets of terms.
static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let name = |terms| LossModel { terms }.terms().map(LossTerm::name).collect::<Vec<_>>().join("+");
    (0..1 << LossTerm::ALL.len()).map(name).collect()
});

const fn set(terms: &[LossTerm]) -> LossModel {
    let (mut bits, mut i) = (0, 0);
    while i < terms.len() {
        bits |= 1 << terms[i] as u8;
        i += 1;
    }
    LossModel { terms: bits }
}

impl LossModel {
    /// Viscous damping only: the exponential decay.
    pub const VISCOUS: LossModel = set(&[LossTerm::Viscous]);
    /// Sliding friction only: the amplitude falls along a straight line.
    pub const SLIDING: LossModel = set(&[LossTerm::Sliding]);
    /// Quadratic drag only.
    pub const DRAG: LossModel = set(&[LossTerm::Drag]);
    /// Viscous damping and sliding friction: the paper's model.
    pub const VISCOUS_SLIDING: LossModel = set(&[LossTerm::Viscous, LossTerm::Sliding]);
    /// Viscous damping and quadratic drag (air, water).
    pub const VISCOUS_DRAG: LossModel = set(&[LossTerm::Viscous, LossTerm::Drag]);
    /// Sliding friction and quadratic drag.
    pub const SLIDING_DRAG: LossModel = set(&[LossTerm::Sliding, LossTerm::Drag]);
    /// All three.
    pub const VISCOUS_SLIDING_DRAG: LossModel = set(&[LossTerm::Viscous, LossTerm::Sliding, LossTerm::Drag]);

    /// Every model, simpler ones first.
    pub fn all() -> impl Iterator<Item = LossModel> {
        let most = LossTerm::ALL.len() as u32;
        let sets = |count: u32| (0..1u16 << LossTerm::ALL.len()).filter(move |t| t.count_ones() == count);
        (1..=most).flat_map(sets).map(|terms| LossModel { terms })
    }

    /// Sort key for the order of [`Self::all`].
    pub(crate) fn place(self) -> (u32, u16) {
        (self.terms.count_ones(), self.terms)
    }

    /// The models that an analysis compares, simpler ones first: all combinations of the terms that are always
    /// compared and those of the requested model. Drag together with a term whose shape is fitted is compared only if
    /// both were requested, because such a term may take its place. With two or more further terms there are so many
    /// models that their fits would take minutes; then only these are compared: the requested model, the models with
    /// one of its terms removed, and those that lead up to it by adding one term at a time, whose fits provide its
    /// start values.
    pub fn compared(asked: Option<LossModel>) -> impl Iterator<Item = LossModel> {
        let terms = LossTerm::compared(asked).fold(0, |bits, term| bits | 1 << term as u8);
        let few = Self::further_named(asked) < 2;
        let is_near = move |m: &LossModel, asked: LossModel| {
            let lacks_one = m.is_within(asked) && asked.terms.count_ones() <= m.terms.count_ones() + 1;
            let up_to_last = u16::MAX >> m.terms.leading_zeros();
            lacks_one || m.terms == asked.terms & up_to_last
        };
        let near = move |m: &LossModel| {
            few || m.terms().all(LossTerm::is_compared) || asked.is_some_and(|asked| is_near(m, asked))
        };
        let both = asked.is_none_or(|m| m.has(LossTerm::Drag));
        let shaped = |m: &LossModel| LossTerm::shaped().iter().any(|t| m.has(*t));
        let meant = move |m: &LossModel| both || !m.has(LossTerm::Drag) || !shaped(m);
        Self::all().filter(move |m| m.is_within(LossModel { terms })).filter(meant).filter(near)
    }

    /// Number of terms in the requested model that are compared only on request.
    pub(crate) fn further_named(asked: Option<LossModel>) -> usize {
        LossTerm::further_of(asked).filter(|t| !t.is_compared()).count()
    }

    /// The model with these terms; `None` if there are none.
    pub fn from_terms(terms: &[LossTerm]) -> Option<Self> {
        (!terms.is_empty()).then(|| set(terms))
    }

    /// Its terms, in the order of [`LossTerm::ALL`].
    pub fn terms(self) -> impl Iterator<Item = LossTerm> {
        LossTerm::ALL.iter().copied().filter(move |t| self.has(*t))
    }

    /// Whether a term is part of the model.
    pub const fn has(self, term: LossTerm) -> bool {
        self.terms & (1 << term as u8) != 0
    }

    /// Whether sliding friction is part of the model.
    pub const fn has_sliding(self) -> bool {
        self.has(LossTerm::Sliding)
    }

    /// The model with one more term.
    #[must_use]
    pub const fn with(self, term: LossTerm) -> Self {
        LossModel { terms: self.terms | 1 << term as u8 }
    }

    /// The model without some of its terms; `None` if none remain.
    pub(crate) fn without(self, terms: &[LossTerm]) -> Option<Self> {
        let left: Vec<LossTerm> = self.terms().filter(|t| !terms.contains(t)).collect();
        Self::from_terms(&left)
    }

    /// Whether every term of this model is also in the other.
    pub const fn is_within(self, other: LossModel) -> bool {
        self.terms & !other.terms == 0
    }

    /// Name, as in the JSON answer: the terms joined by `+`.
    pub fn name(self) -> &'static str {
        &NAMES[usize::from(self.terms)]
    }
}

impl fmt::Display for LossModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for LossModel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = |name: &str| LossTerm::ALL.iter().copied().find(|term| term.name() == name);
        let terms: Option<Vec<LossTerm>> = text.split('+').map(named).collect();
        let model = terms.as_deref().and_then(Self::from_terms);
        // No term may appear twice.
        model.filter(|m| m.terms().count() == text.split('+').count()).ok_or_else(|| {
            let terms: Vec<_> = LossTerm::ALL.iter().map(|term| term.name()).collect();
            let known_as = text.split('+').find_map(|part| {
                let known = SYNONYMS.iter().find(|(synonym, _)| part.trim().eq_ignore_ascii_case(synonym));
                known.map(|(synonym, term)| format!("; {synonym} is `{}` here", term.name()))
            });
            format!(
                "no loss model is called `{text}`; its terms may be {}, joined by + as in viscous+sliding{}",
                terms.join(", "),
                known_as.unwrap_or_default()
            )
        })
    }
}

/// Synonyms for the names of the losses.
const SYNONYMS: [(&str, LossTerm); 10] = [
    ("coulomb", LossTerm::Sliding),
    ("dry", LossTerm::Sliding),
    ("friction", LossTerm::Sliding),
    ("solid", LossTerm::Sliding),
    ("linear", LossTerm::Viscous),
    ("exponential", LossTerm::Viscous),
    ("quadratic", LossTerm::Drag),
    ("air", LossTerm::Drag),
    ("aerodynamic", LossTerm::Drag),
    ("turbulent", LossTerm::Drag),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        for model in LossModel::all() {
            assert_eq!(model.name().parse(), Ok(model));
            let terms: Vec<_> = model.terms().collect();
            assert_eq!(LossModel::from_terms(&terms), Some(model));
        }
        assert_eq!(LossModel::VISCOUS_SLIDING_DRAG.name(), "viscous+sliding+drag");
        assert_eq!(LossModel::from_terms(&[]), None);
        assert_eq!("sliding+viscous".parse(), Ok(LossModel::VISCOUS_SLIDING));
        for (text, meant) in
            [("Coulomb", "coulomb is `sliding`"), ("viscous+quadratic", "quadratic is `drag`")]
        {
            let refusal = text.parse::<LossModel>().unwrap_err();
            assert!(refusal.ends_with(&format!("; {meant} here")), "{refusal}");
        }
        for none in ["elastic", "viscous+", "viscous+viscous", ""] {
            assert!(none.parse::<LossModel>().is_err(), "{none}");
        }
    }

    #[test]
    fn terms_are_compared_by_default_or_when_asked_for() {
        use LossModel as M;
        let default = [
            M::VISCOUS,
            M::SLIDING,
            M::DRAG,
            M::VISCOUS_SLIDING,
            M::VISCOUS_DRAG,
            M::SLIDING_DRAG,
            M::VISCOUS_SLIDING_DRAG,
        ];
        assert_eq!(M::compared(None).collect::<Vec<_>>(), default);
        assert_eq!(M::compared(Some(M::VISCOUS_DRAG)).collect::<Vec<_>>(), default);
        // With one further term every set is compared; with more, only those near the requested model.
        let one = M::VISCOUS_SLIDING_DRAG.with(LossTerm::Cubic);
        assert!(M::compared(Some(one)).eq(M::all().filter(|m| m.is_within(one))));
        let every = LossTerm::ALL.iter().fold(M::VISCOUS, |m, t| m.with(*t));
        let near: Vec<_> = M::compared(Some(every)).collect();
        assert!(default.iter().all(|m| near.contains(m)));
        assert!(LossTerm::ALL.iter().all(|t| every.without(&[*t]).is_some_and(|m| near.contains(&m))));
        assert_eq!(near.last(), Some(&every));
        assert!(near.windows(2).all(|pair| pair[0] != pair[1]) && near.len() < 25, "{near:?}");
        // A smaller model comes before those that contain it, because its fit gives their start values.
        let all: Vec<_> = M::all().collect();
        assert!((0..all.len()).all(|i| (0..i).all(|k| !all[i].is_within(all[k]))));
    }

    #[test]
    fn a_model_lies_within_those_with_more_terms() {
        assert!(LossModel::VISCOUS.is_within(LossModel::VISCOUS_DRAG));
        assert!(!LossModel::VISCOUS_DRAG.is_within(LossModel::VISCOUS_SLIDING));
        assert_eq!(LossModel::VISCOUS.with(LossTerm::Sliding), LossModel::VISCOUS_SLIDING);
    }
}
