//! Detection of a step of the phase, as after a knock.

use super::blocks::Block;
use super::criteria::PhaseCriteria;
use super::phase::phase_weight;
use crate::numeric::robust::deviation;

/// A step of the phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PhaseStep {
    pub(crate) time_s: f64,
    pub(crate) radians: f64,
}

/// The largest step of the phase across two blocks: a knock within a block shows on both sides of it.
///
/// It must exceed its own error (or the scatter of all such changes, if that is larger) by the factor
/// [`PhaseCriteria::step_errors`], and the changes next to it by the factor [`PhaseCriteria::step_isolated`], because
/// a phase that walks, drifts or beats changes everywhere.
pub(crate) fn phase_step(blocks: &[Block], noise_rms: f64, criteria: &PhaseCriteria) -> Option<PhaseStep> {
    let weight: Vec<f64> = blocks.iter().map(|b| phase_weight(b, noise_rms)).collect();
    let sure = weight.iter().position(|w| *w < criteria.sure_weight).unwrap_or(weight.len());
    let beside = criteria.step_beside;
    let (blocks, weight) = (&blocks[..sure], &weight[..sure]);
    if sure < criteria.step_blocks {
        return None;
    }
    let rates: Vec<f64> =
        blocks.windows(2).map(|w| (w[1].phase - w[0].phase) / (w[1].time_s - w[0].time_s)).collect();
    // Changes across the blocks `i + 1`, each made of two rates.
    let across = |i: usize| blocks[i + 2].time_s - blocks[i].time_s;
    let change = |i: usize| {
        let before = i.saturating_sub(beside)..i;
        let after = i + 2..(i + 2 + beside).min(rates.len());
        let mut around = [&rates[before], &rates[after]].concat();
        around.sort_unstable_by(f64::total_cmp);
        // If the rate drifts, the two middle values lie on either side.
        let rate = 0.5 * (around[(around.len() - 1) / 2] + around[around.len() / 2]);
        blocks[i + 2].phase - blocks[i].phase - rate * across(i)
    };
    let changes: Vec<f64> = (0..sure - 2).map(change).collect();
    let own = |i: usize| changes[i].abs() / (1.0 / weight[i] + 1.0 / weight[i + 2]).sqrt();
    let scatter = deviation((0..changes.len()).map(own))?.max(1.0);
    let errors = |i: usize| own(i) / scatter;
    // At the ends there are neighbours on one side only, and a curved law looks like a step.
    let inside = beside..changes.len().saturating_sub(beside);
    let largest = inside.max_by(|a, b| errors(*a).total_cmp(&errors(*b)))?;
    let around = (largest.saturating_sub(beside)..=largest + beside).filter(|i| i.abs_diff(largest) > 1);
    let next = around.map(|i| changes[i].abs()).fold(0.0, f64::max);
    let found = PhaseStep { time_s: blocks[largest + 1].time_s, radians: changes[largest] };
    (errors(largest) > criteria.step_errors && found.radians.abs() > criteria.step_isolated * next)
        .then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    const NOISE: f64 = 0.01;

    /// Sixty blocks of 0.5 s whose phases depend on the amplitude, with independent errors and the addition `extra`.
    fn step(repeat: usize, extra: impl Fn(f64) -> f64) -> Option<PhaseStep> {
        let block = |i: usize| {
            let time_s = 0.5 * i as f64;
            let amplitude = (-0.05 * time_s).exp();
            let phase = 12.0 * time_s - 3.0 * amplitude * amplitude + extra(time_s);
            let error = NOISE * 0.2 / amplitude;
            Block {
                amplitude,
                phase: phase + error * jitter(i + 60 * repeat, 3),
                unit_variance: 0.04,
                span_s: 0.5,
                omega: 12.0,
                ..Block::of(10 * i, 10 * i + 10, time_s)
            }
        };
        let blocks: Vec<Block> = (0..60).map(block).collect();
        phase_step(&blocks, NOISE, &PhaseCriteria::default())
    }

    #[test]
    fn a_step_is_found_on_an_edge_and_within_a_block() {
        for repeat in 0..20 {
            let on_edge = step(repeat, |t| if t > 10.2 { 0.15 } else { 0.0 }).expect("a step");
            assert!(
                (on_edge.time_s - 10.25).abs() < 0.6 && (on_edge.radians - 0.15).abs() < 0.02,
                "{on_edge:?}"
            );
            let within = step(repeat, |t| 0.15 * (2.0 * (t - 9.75)).clamp(0.0, 1.0)).expect("a step");
            assert!((within.time_s - 10.0).abs() < 0.6 && (within.radians - 0.15).abs() < 0.02, "{within:?}");
        }
    }

    #[test]
    fn a_phase_that_walks_beats_or_drifts_has_no_step() {
        for repeat in 0..20 {
            let walk =
                |t: f64| (0..(2.0 * t) as usize).map(|i| 0.03 * jitter(i + 60 * repeat, 4)).sum::<f64>();
            assert_eq!(step(repeat, |_| 0.0), None, "{repeat}");
            assert_eq!(step(repeat, walk), None, "{repeat}");
            assert_eq!(step(repeat, |t| 0.1 * (1.3 * t).sin()), None, "{repeat}");
            assert_eq!(step(repeat, |t| 0.01 * t * t), None, "{repeat}");
        }
    }
}
