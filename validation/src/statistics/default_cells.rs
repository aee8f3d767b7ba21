//! Cells (simulated cases) of the statistics of ring-downs analysed by default.

use super::nuisances::{COARSE_DECAY_TIMES, DISTURBANCES, Nuisance};

pub(super) const Q: [f64; 4] = [5.0, 30.0, 300.0, 5_000.0];
pub(super) const SHARE: [f64; 4] = [0.0, 0.03, 0.2, 0.7];
pub(super) const SNR_DB: [f64; 3] = [20.0, 40.0, 60.0];
pub(super) const DECAY_TIMES: [f64; 4] = [0.5, 1.0, 3.0, 8.0];
pub(super) const SAMPLES_PER_CYCLE: [f64; 3] = [6.0, 30.0, 200.0];
pub(super) const ENVELOPE_DECAY_TIMES: [f64; 3] = [1.0, 3.0, 6.0];
pub(super) const ENVELOPE_SAMPLES_PER_CYCLE: [f64; 2] = [0.5, 4.0];
pub(super) const NUISANCE_Q: [f64; 2] = [30.0, 300.0];
pub(super) const NUISANCE_SHARE: [f64; 3] = [0.0, 0.2, 0.5];
/// Motions that stop after about ten swings, with the record continuing: the level at rest shows which swing was the
/// last.
pub(super) const REST_Q: [f64; 3] = [50.0, 100.0, 200.0];
pub(super) const REST_SHARE: [f64; 3] = [0.3, 0.5, 0.7];
pub(super) const REST_SNR_DB: [f64; 4] = [30.0, 40.0, 50.0, 60.0];
/// Motions of few cycles, recorded as by a gyroscope or an accelerometer.
pub(super) const DERIVATIVE_Q: [f64; 3] = [5.0, 8.0, 15.0];
pub(super) const DERIVATIVE_SHARE: [f64; 2] = [0.2, 0.5];
pub(super) const DERIVATIVE_SNR_DB: [f64; 2] = [40.0, 60.0];
/// Drag as a part of the non-sliding loss at the start.
pub(super) const DRAG: [f64; 3] = [0.03, 0.3, 1.0];
pub(super) const FREQUENCY_HZ: f64 = 1.7;

/// Recorded quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RecordedQuantity {
    /// The displacement.
    Displacement,
    /// The amplitude, from a detector whose noise has two quadratures (Rician).
    Envelope,
    /// The velocity, in m/s.
    Velocity,
    /// The acceleration, in m/s^2.
    Acceleration,
    /// In-phase and quadrature components relative to a reference that drifts by [`DETUNING_RAD`] per decay time.
    LockIn,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub(super) what: RecordedQuantity,
    pub(super) q: f64,
    pub(super) share: f64,
    pub(super) snr_db: f64,
    pub(super) decay_times: f64,
    pub(super) samples_per_cycle: f64,
    /// Drag as a part of the non-sliding loss at the start.
    pub(super) drag: f64,
    pub(super) nuisance: Nuisance,
}

/// The cell to which disturbances and drag are added.
pub(super) const USUAL: Cell = Cell {
    what: RecordedQuantity::Displacement,
    q: 300.0,
    share: 0.0,
    snr_db: 40.0,
    decay_times: 2.5,
    samples_per_cycle: 30.0,
    drag: 0.0,
    nuisance: Nuisance::None,
};

impl Cell {
    /// Whether this quantity is recorded with white noise and without drag.
    pub(super) fn plain(&self, what: RecordedQuantity) -> bool {
        self.what == what && self.drag == 0.0 && self.nuisance == Nuisance::None
    }

    pub(super) fn name(&self) -> String {
        let Self { what, q, share, snr_db, decay_times, samples_per_cycle, drag, nuisance } = self;
        format!(
            "{what:?} Q={q} share={share} snr={snr_db} L={decay_times} spc={samples_per_cycle} drag={drag} {};",
            nuisance.name()
        )
    }

    pub(super) fn row(&self) -> String {
        let Self { q, share, snr_db, decay_times, samples_per_cycle, drag, nuisance, .. } = self;
        let with = if *drag > 0.0 { format!("drag {drag}") } else { nuisance.name().to_owned() };
        format!("{q} | {share} | {snr_db} | {decay_times} | {samples_per_cycle} | {with}")
    }
}

pub(super) fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for q in Q {
        for share in SHARE {
            for snr_db in SNR_DB {
                for decay_times in DECAY_TIMES {
                    cells.extend(SAMPLES_PER_CYCLE.map(|samples_per_cycle| Cell {
                        what: RecordedQuantity::Displacement,
                        q,
                        share,
                        snr_db,
                        decay_times,
                        samples_per_cycle,
                        ..USUAL
                    }));
                }
            }
        }
    }
    for q in REST_Q {
        for share in REST_SHARE {
            cells.extend(REST_SNR_DB.map(|snr_db| Cell { q, share, snr_db, ..USUAL }));
        }
    }
    for nuisance in DISTURBANCES {
        let decay_times = match nuisance {
            Nuisance::CoarseSteps => COARSE_DECAY_TIMES,
            _ => USUAL.decay_times,
        };
        for q in NUISANCE_Q {
            cells.extend(NUISANCE_SHARE.map(|share| Cell { q, share, nuisance, decay_times, ..USUAL }));
        }
    }
    for drag in DRAG {
        for q in NUISANCE_Q {
            for snr_db in SNR_DB {
                cells.extend(NUISANCE_SHARE.map(|share| Cell { q, share, drag, snr_db, ..USUAL }));
            }
        }
    }
    for what in [RecordedQuantity::Velocity, RecordedQuantity::Acceleration] {
        for q in DERIVATIVE_Q {
            for share in DERIVATIVE_SHARE {
                cells.extend(DERIVATIVE_SNR_DB.map(|snr_db| Cell { what, q, share, snr_db, ..USUAL }));
            }
        }
    }
    for share in SHARE {
        for snr_db in SNR_DB {
            for decay_times in ENVELOPE_DECAY_TIMES {
                for what in [RecordedQuantity::Envelope, RecordedQuantity::LockIn] {
                    cells.extend(ENVELOPE_SAMPLES_PER_CYCLE.map(|samples_per_cycle| Cell {
                        what,
                        q: 300.0,
                        share,
                        snr_db,
                        decay_times,
                        samples_per_cycle,
                        ..USUAL
                    }));
                }
            }
        }
    }
    cells
}
