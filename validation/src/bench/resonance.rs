//! Fit of a resonance curve, compared with SciPy's fit of the same model and lmfit's Lorentzian.

use std::f64::consts::{FRAC_PI_4, TAU};
use std::io::{BufWriter, Write};

use slipfit::Oscillator;
use slipfit::motion::steady::{Phasor, scan};
use slipfit::resonance::{Curve, fit};

use super::contest::{Contestant, Peer, Task, Timing, race};
use super::report::Row;
use super::signal::Noise;
use super::{Against, Bench, faster, words};
use crate::Failure;

const POINTS: u32 = 401;
const FREQUENCY_HZ: f64 = 1000.0;
const Q: f64 = 50.0;
const FRICTION_RATIO: f64 = 0.3;
const DRIVE: f64 = 1.0;
/// Extent of the window on either side, in half widths of the viscous line.
const REACH: f64 = 5.0;
/// Standard deviation of the noise of one quadrature.
const NOISE_RMS: f64 = 0.05;
/// Start values of the peers relative to the truth.
const OFF: f64 = 1.1;

struct Sweep {
    hz: Vec<f64>,
    z: Vec<Phasor>,
    /// Decay rate, friction displacement.
    truth: [f64; 2],
}

impl Sweep {
    fn new() -> Result<Self, Failure> {
        let x_f = FRAC_PI_4 * FRICTION_RATIO * DRIVE;
        let o = Oscillator::builder()
            .frequency_hz(FREQUENCY_HZ)
            .q_factor(Q)
            .friction_displacement(x_f)
            .build()?;
        let half = REACH * FREQUENCY_HZ / (2.0 * Q);
        let mut noise = Noise::new(0x05ee_d401);
        let (mut hz, mut z) = (Vec::new(), Vec::new());
        for i in 0..POINTS {
            let f = FREQUENCY_HZ - half + 2.0 * half * f64::from(i) / f64::from(POINTS - 1);
            let read = scan::reading(&o, DRIVE, f)?.fundamental;
            hz.push(f);
            z.push(read + Phasor::new(NOISE_RMS * noise.normal(), NOISE_RMS * noise.normal()));
        }
        Ok(Self { hz, z, truth: [TAU * FREQUENCY_HZ / (2.0 * Q), x_f] })
    }

    /// Start values in the peers' order: width and friction are off by a tenth, the peak by a tenth of a width.
    fn start(&self) -> [f64; 5] {
        let [delta, x_f] = self.truth;
        let shift = (OFF - 1.0) * delta;
        [OFF * delta, OFF * x_f, TAU * FREQUENCY_HZ + shift, OFF * DRIVE, OFF - 1.0]
    }
}

impl Bench {
    pub(super) fn resonance_fit(&self) -> Result<Vec<Row>, Failure> {
        let sweep = Sweep::new()?;
        let path = self.folder.join("resonance.f64");
        let mut file = BufWriter::new(std::fs::File::create(&path)?);
        let omega = sweep.hz.iter().map(|f| TAU * f);
        for value in omega.chain(sweep.z.iter().map(|z| z.re)).chain(sweep.z.iter().map(|z| z.im)) {
            file.write_all(&value.to_le_bytes())?;
        }
        file.flush()?;
        drop(file);
        let curve = Curve::complex(sweep.hz.clone(), sweep.z.clone()).build()?;
        let mut own = Task(Box::new(move || {
            let found = fit(&curve, None)?;
            Ok(vec![found.decay_rate_per_s[0], found.friction_displacement[0]])
        }));
        let (data, start) = (path.to_string_lossy().into_owned(), sweep.start());
        let peer = |who: &str| Peer::start(&self.python, "resonance_fit.py", words(&[who, &data], &start));
        let (mut scipy, mut minpack, mut lmfit) =
            (peer("least_squares")?, peer("curve_fit")?, peer("lmfit")?);
        let mut all: [&mut dyn Contestant; 4] = [&mut own, &mut scipy, &mut minpack, &mut lmfit];
        let best = race(self.rounds, &mut all)?;
        let [ours, scipy, minpack, lmfit] = &best[..] else { return Err("four were expected".into()) };
        let work = "fit, resonance curve, 401 points, 5 parameters";
        let row = |peer: &'static str, at_least: Option<f64>, theirs: &Timing, apart: Option<f64>| {
            faster('l', work, ours, &Against { peer, at_least }, theirs, apart)
        };
        let same = |peer: &str, theirs: &Timing| difference(&sweep, peer, ours, theirs).map(Some);
        Ok(vec![
            row("SciPy `least_squares`", Some(100.0), scipy, same("least_squares", scipy)?),
            row("SciPy `curve_fit`", None, minpack, same("curve_fit", minpack)?),
            row("lmfit `LorentzianModel`, no friction", Some(20.0), lmfit, None),
        ])
    }
}

/// The larger difference of decay rate and friction displacement, in the peer's standard errors; a peer that ended in
/// another minimum would make the time ratio meaningless.
fn difference(sweep: &Sweep, peer: &str, ours: &Timing, theirs: &Timing) -> Result<f64, Failure> {
    let mut most = 0.0f64;
    for (k, truth) in sweep.truth.into_iter().enumerate() {
        let (value, error, own) = (theirs.estimates[k], theirs.errors[k], ours.estimates[k]);
        if !((value - truth).abs() < 6.0 * error && error < truth) {
            return Err(format!("{peer} found {value} ± {error} where {truth} was put in").into());
        }
        most = most.max((own - value).abs() / error);
    }
    Ok(most)
}
