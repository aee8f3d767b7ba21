//! A curve made ready for its fits: what is seen of the line, phases the right way round, dense
//! points put together.

use super::Options;
use super::block::Block;
use super::fits::Way;
use super::instrument_start::{self, Allowed, InstrumentStart};
use super::peak::{self, Peak};
use super::start::{self, Start};
use crate::Error;
use crate::motion::steady::Phasor;

/// So many points tell a line as well as more do.
const ENOUGH: usize = 1000;

pub(super) struct PreparedCurve {
    pub(super) main: Block,
    pub(super) reference: Option<Block>,
    /// Every point, where the fit uses means of neighbours.
    pub(super) all: Option<Block>,
    pub(super) line: Peak,
    pub(super) pedestal: Option<InstrumentStart>,
    pub(super) background: bool,
    pub(super) from_phases: Option<Start>,
    /// Phases ran the other way, and are turned.
    pub(super) conjugated: bool,
    /// Of one amplitude.
    pub(super) noise: f64,
}

impl PreparedCurve {
    pub(super) fn new(
        mut main: Block,
        mut reference: Option<Block>,
        options: &Options,
        way: Way,
    ) -> Result<Self, Error> {
        let no = |reason| Error::NoResonance { reason };
        let mut line = peak::find(&main).ok_or(no("every amplitude is zero"))?;
        if main.len() < 4 {
            return Err(Error::TooFewPoints { points: main.len(), parameters: 3 });
        }
        let noise = peak::noise(&main);
        if let Some(reason) = peak::absence(&main, 0.0) {
            return Err(no(reason));
        }
        let mut pedestal = match way {
            Way::Behind(pedestal) => Some(*pedestal),
            _ => instrument_start::baseline(&main, &line).filter(|_| Allowed::by(options).background),
        };
        if let Some(p) = &pedestal {
            line = p.line;
        }
        let raised = |p: &InstrumentStart| p.height != Phasor::default();
        let background = options.terms.background == Some(true) || pedestal.as_ref().is_some_and(raised);
        let seen = pedestal.as_ref().map_or(&main, |p| &p.without);
        let (from_phases, conjugated) = start::linear(seen, &line, true)
            .map_or((None, false), |(start, conjugated)| (Some(start), conjugated));
        if conjugated {
            main.conjugate();
            if let Some(r) = reference.as_mut().filter(|r| r.complex) {
                r.conjugate();
            }
            if let Some(p) = &mut pedestal {
                p.height = p.height.conj();
                p.delay = -p.delay;
            }
        }
        // A dense curve is fitted by the means of neighbours much closer than the line is wide.
        let spacing = (main.omega[main.len() - 1] - main.omega[0]) / main.len() as f64;
        let fine = (0.03 * line.half_width / spacing.max(f64::MIN_POSITIVE)) as usize;
        let group = (main.len() / ENOUGH).min(fine).max(1);
        let all = (group > 1).then(|| {
            let few = main.grouped(group);
            line.index /= group;
            std::mem::replace(&mut main, few)
        });
        Ok(Self { main, reference, all, line, pedestal, background, from_phases, conjugated, noise })
    }
}
