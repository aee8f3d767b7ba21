//! Exact motion compared with heyoka's Taylor integrator with terminal events.

use std::f64::consts::TAU;
use std::time::Instant;

use slipfit::Oscillator;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::{Drive, Motion};

use super::contest::{Contestant, Peer, Task, Timing, race};
use super::report::{Row, three_digits};
use super::{Against, Bench, faster};
use crate::Failure;
use crate::places::{command, peer};

/// `delta` and `x_F` of the free decay, `omega_0 = 1`, from `x = 1`.
const FREE: [f64; 2] = [1e-4, 1e-4];
const CYCLES: f64 = 1000.0;
const SAMPLES: u32 = 100_000;
/// `delta`, `x_F`, `x_S` and `omega` of the driven motion, which has two slips and two stops per cycle.
const DRIVEN: [f64; 4] = [0.05, 0.5, 0.65, 0.3];

impl Bench {
    fn heyoka(&self, way: &str, numbers: &[f64]) -> Result<Peer, Failure> {
        let words = std::iter::once(way.to_owned()).chain(numbers.iter().map(ToString::to_string));
        Peer::start(&self.python, "motion_events.py", words)
    }

    /// Times one task against heyoka; the answers are the last position and a count.
    fn motion(
        &self,
        line: char,
        work: &str,
        against: Against,
        mut own: Task,
        mut peer: Peer,
    ) -> Result<Vec<Row>, Failure> {
        let best = race(self.rounds, &mut [&mut own as &mut dyn Contestant, &mut peer])?;
        let [ours, theirs] = &best[..] else { return Err("two contestants were expected".into()) };
        let difference = difference(ours, theirs)?;
        let mut row = faster(line, work, ours, &against, theirs, None);
        row.apart = Some(format!("{difference:.0e}"));
        Ok(vec![row])
    }

    pub(super) fn free_motion(&self) -> Result<Vec<Row>, Failure> {
        let (o, until) = free()?;
        let peer = || self.heyoka("decay", &[FREE[0], FREE[1], until]);
        let decay = FreeDecay::from_rest(&o, 1.0)?;
        let turning = Task(Box::new(|| {
            // Times and positions are both summed, so that the compiler cannot drop either computation.
            let (mut turns, mut times, mut positions) = (0, 0.0, 0.0);
            for p in decay.turning_points().take_while(|p| p.time_s <= until) {
                turns += 1;
                times += p.time_s;
                positions += p.position;
            }
            std::hint::black_box((times, positions));
            // heyoka does not count the release as a turning point.
            Ok(vec![decay.displacement(until), f64::from(turns - 1)])
        }));
        let machine = Task(Box::new(|| {
            let mut motion = Motion::new(&o, Drive::none(), 0.0, 1.0, 0.0)?;
            let turns = motion.events(until).count();
            Ok(vec![motion.state_at(until)?.position, turns as f64])
        }));
        let asked = Against { peer: "heyoka, terminal events", at_least: Some(500.0) };
        let mut rows =
            self.motion('g', "free decay, 1000 cycles, turning points", asked, turning, peer()?)?;
        let general = Against { peer: "heyoka, terminal events", at_least: None };
        rows.extend(self.motion('g', "the same by the event machine", general, machine, peer()?)?);
        Ok(rows)
    }

    pub(super) fn dense_motion(&self) -> Result<Vec<Row>, Failure> {
        let (o, until) = free()?;
        let last = f64::from(SAMPLES - 1);
        let times: Vec<f64> = (0..SAMPLES).map(|i| until * f64::from(i) / last).collect();
        let decay = FreeDecay::from_rest(&o, 1.0)?;
        let mut out = vec![0.0; times.len()];
        let own = Task(Box::new(move || {
            decay.fill(&times, &mut out)?;
            Ok(vec![out[out.len() - 1], out.len() as f64])
        }));
        let peer = self.heyoka("dense", &[FREE[0], FREE[1], until, f64::from(SAMPLES)])?;
        let asked = Against { peer: "heyoka, grid output", at_least: Some(100.0) };
        self.motion('h', "dense trace, 100 k samples", asked, own, peer)
    }

    pub(super) fn stick_slip(&self) -> Result<Vec<Row>, Failure> {
        let (o, drive, period) = driven()?;
        let until = CYCLES * period;
        let own = Task(Box::new(move || {
            let mut motion = Motion::new(&o, drive.clone(), 0.0, 0.0, 0.0)?;
            let events = motion.events(until).count();
            Ok(vec![motion.state_at(until)?.position, events as f64])
        }));
        let [delta, x_f, x_s, omega] = DRIVEN;
        let peer = self.heyoka("stick", &[delta, x_f, x_s, omega, until])?;
        let asked = Against { peer: "heyoka, terminal events", at_least: Some(30.0) };
        self.motion('i', "driven stick-slip, 1000 cycles, 4000 events", asked, own, peer)
    }

    /// Time per event after a hundred and after ten million events.
    pub(super) fn cost_per_event(&self) -> Result<Vec<Row>, Failure> {
        let gentle = Oscillator::kinematic(1.0, 1e-12, 1e-12)?;
        let free = || Motion::new(&gentle, Drive::none(), 0.0, 1.0, 0.0);
        let (o, drive, _) = driven()?;
        let driven = || Motion::new(&o, drive.clone(), 0.0, 0.0, 0.0);
        Ok(vec![
            cost_growth("an event of a free decay, after 1e7 of them", free)?,
            cost_growth("an event of driven stick-slip, after 1e7 of them", driven)?,
        ])
    }

    /// Peak memory of the command while it streams, compared between a run and one with a thousand times more rows.
    pub(super) fn streaming_memory(&self) -> Result<Vec<Row>, Failure> {
        let peak = |duration_s: &str| -> Result<f64, Failure> {
            let mut script = command(&self.python);
            script.arg(peer("peak_memory.py")).arg(&self.slipfit);
            script.args(["simulate", "driven", "--frequency-hz", "1", "--q", "20", "--beta", "0.6"]);
            script.args(["--drive-amplitude", "1", "--drive-frequency-hz", "0.3", "--rate-hz", "10"]);
            let output = script.args(["--duration", duration_s]).output()?;
            if !output.status.success() {
                return Err(String::from_utf8_lossy(&output.stderr).into());
            }
            let text = String::from_utf8_lossy(&output.stdout);
            text.trim().parse().map_err(|_| format!("`{text}` is no number of bytes").into())
        };
        let (short, long) = (peak("200")?, peak("200000")?);
        let megabytes = |bytes: f64| format!("{} MB", three_digits(bytes / 1e6));
        Ok(vec![Row {
            line: 'k',
            work: "memory, streaming 2 M samples".into(),
            ours: megabytes(long),
            peer: "streaming 2 k samples",
            theirs: megabytes(short),
            ratio: three_digits(long / short),
            asked: Some(("≤ 1.1".into(), long <= 1.1 * short)),
            apart: None,
        }])
    }
}

/// Cost of an event at the end of a long run over that in the first hundred events.
/// Medians over stretches of a hundred events are used: on a busy machine a long measurement would include the time
/// of other processes.
fn cost_growth(work: &str, make: impl Fn() -> Result<Motion, slipfit::Error>) -> Result<Row, Failure> {
    const STRETCH: usize = 100;
    const STRETCHES: usize = 2000;
    const MANY: usize = 10_000_000;
    let timed = |motion: &mut Motion| -> Result<f64, Failure> {
        let begun = Instant::now();
        let events = motion.events(f64::MAX).take(STRETCH).count();
        let seconds = begun.elapsed().as_secs_f64();
        if events == STRETCH { Ok(seconds / STRETCH as f64) } else { Err(format!("{work}: it ended").into()) }
    };
    let median = |mut costs: Vec<f64>| {
        costs.sort_by(f64::total_cmp);
        costs[costs.len() / 2]
    };
    let first = (0..STRETCHES).map(|_| timed(&mut make()?)).collect::<Result<_, Failure>>()?;
    let mut motion = make()?;
    motion.events(f64::MAX).take(MANY - STRETCH * STRETCHES).for_each(drop);
    let last = (0..STRETCHES).map(|_| timed(&mut motion)).collect::<Result<_, Failure>>()?;
    let (first, last) = (median(first), median(last));
    let nanoseconds = |seconds: f64| format!("{} ns", three_digits(seconds * 1e9));
    Ok(Row {
        line: 'j',
        work: work.into(),
        ours: nanoseconds(last),
        peer: "the first hundred",
        theirs: nanoseconds(first),
        ratio: three_digits(last / first),
        asked: Some(("≤ 1.5".into(), last <= 1.5 * first)),
        apart: None,
    })
}

fn free() -> Result<(Oscillator, f64), Failure> {
    let o = Oscillator::kinematic(1.0, FREE[0], FREE[1])?;
    // A little past the last turning point, so that both count it.
    Ok((o, (2.0 * CYCLES + 0.01) * o.half_period_s()))
}

fn driven() -> Result<(Oscillator, Drive, f64), Failure> {
    let [delta, x_f, x_s, omega] = DRIVEN;
    let o = Oscillator::builder()
        .omega_0(1.0)
        .decay_rate_per_s(delta)
        .friction_displacement(x_f)
        .static_displacement(x_s)
        .build()?;
    Ok((o, Drive::harmonic(1.0, omega)?, TAU / omega))
}

/// Largest difference of the last positions; a peer that lost events would make the time ratio meaningless.
fn difference(ours: &Timing, theirs: &Timing) -> Result<f64, Failure> {
    let (Some([x, n]), Some([y, m])) = (ours.estimates.first_chunk(), theirs.estimates.first_chunk()) else {
        return Err("a position and a count were expected".into());
    };
    if n == m && (x - y).abs() < 1e-6 {
        Ok((x - y).abs())
    } else {
        Err(format!("slipfit ends at {x} after {n}, heyoka at {y} after {m}").into())
    }
}
