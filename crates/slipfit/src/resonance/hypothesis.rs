//! Hypotheses about a curve: the treatment of its phases, and the instrument terms from which a fit starts.

use super::Options;
use super::block::Block;
use super::criteria::Criteria;
use super::instrument_start::{self, InstrumentTerms};
use super::peak::{self, Peak};
use super::prepared::PreparedCurve;
use super::start::{self, Start};

/// Assumptions of a hypothesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The curve as measured; background and delay are added only if the data require them.
    Plain,
    /// A background, a delay or both from the start.
    Instrument,
    /// Amplitudes alone, because the phases are not those of the resonance.
    Amplitudes,
}

/// One hypothesis, with the start values that it implies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hypothesis {
    pub(super) kind: Kind,
    pub(super) peak: Peak,
    pub(super) instrument: InstrumentTerms,
    /// Start values from the phases, if there are any.
    pub(super) oscillator: Option<Start>,
    /// Whether the phases have the opposite sign (`e^(-i omega t)`) and are conjugated.
    pub(super) conjugated: bool,
}

impl Hypothesis {
    /// `seen` is the curve without the instrument terms; the sign of its loss determines the sign of the phases.
    fn new(kind: Kind, seen: &Block, peak: Peak, mut instrument: InstrumentTerms) -> Self {
        let (oscillator, conjugated) =
            start::linear(seen, &peak, true).map_or((None, false), |(start, c)| (Some(start), c));
        if conjugated {
            instrument.background = instrument.background.conj();
            instrument.delay = -instrument.delay;
        }
        Self { kind, peak, instrument, oscillator, conjugated }
    }

    /// The curve as measured.
    pub(super) fn plain(curve: &PreparedCurve) -> Self {
        let baseline = curve.baseline.as_ref();
        let seen = baseline.map_or(curve.every_point(), |b| &b.without);
        let instrument = baseline.map_or_else(InstrumentTerms::default, |b| b.terms);
        Self::new(Kind::Plain, seen, curve.peak, instrument)
    }

    /// Hypotheses with backgrounds and delays worth a fit, the most likely first.
    pub(super) fn with_instrument(
        curve: &PreparedCurve,
        options: &Options,
        criteria: &Criteria,
    ) -> Vec<Self> {
        let starts = instrument_start::find(&curve.main, options, &criteria.instrument);
        starts.into_iter().map(|s| Self::new(Kind::Instrument, &s.without, s.peak, s.terms)).collect()
    }

    /// Amplitudes alone.
    pub(super) fn amplitudes(curve: &PreparedCurve) -> Option<Self> {
        let seen = curve.main.without_phases();
        let peak = peak::find(&seen)?;
        Some(Self::new(Kind::Amplitudes, &seen, peak, InstrumentTerms::default()))
    }

    /// The points as treated by this hypothesis.
    pub(super) fn view(&self, points: &Block) -> Block {
        match self.kind {
            Kind::Amplitudes => points.without_phases(),
            _ if self.conjugated && points.complex => points.conjugated(),
            _ => points.clone(),
        }
    }
}
