//! Hostile input generated from bytes: records, curves, levels and series as produced by instruments, accidents and
//! adversaries, and the conditions that every answer to them must meet.
//!
//! The property tests and the fuzzer share this generator: each choice is a byte, so that changing a byte changes one
//! thing. Scales range from 1e-300 to 1e300; columns may contain equal points, steps, gaps, repeated and decreasing
//! stamps, infinities and NaN.

use slipfit::answer::{Parameters, Warning};
use slipfit::motion::steady::Phasor;
use slipfit::series::{Condition, Data, Measurement, SingleAnswer};
use slipfit::{LossModel, Parameter, Record, SignalKind, levels, resonance, ringdown, series};

/// Maximum number of samples of a record and points of a curve.
const MOST_SAMPLES: usize = 400;
const MOST_POINTS: usize = 80;

/// Bytes that are converted to numbers; zeros after their end.
#[derive(Debug)]
pub(crate) struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// Starts reading at the first byte.
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    /// Whether one of `n` choices was made; never after the end.
    fn one_in(&mut self, n: u8) -> bool {
        self.byte() % n == 1
    }

    /// Uniform from zero to one.
    fn part(&mut self) -> f64 {
        f64::from(u16::from_le_bytes([self.byte(), self.byte()])) / 65535.0
    }

    /// Mostly one, otherwise any power of ten in the range of doubles.
    fn scale(&mut self) -> f64 {
        const LIST: [f64; 9] = [1e-300, 1e-200, 1e-100, 1e-9, 1e-3, 1e6, 1e150, 1e200, 1e300];
        match self.byte() {
            k @ 0..=8 => LIST[usize::from(k)],
            9..=31 => 10f64.powi((self.part() * 600.0 - 300.0) as i32),
            _ => 1.0,
        }
    }

    fn value(&mut self) -> f64 {
        const SPECIAL: [f64; 12] = [
            0.0,
            -0.0,
            5e-324,
            -1e-308,
            1e-300,
            1e300,
            -1e300,
            f64::MAX,
            f64::MIN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        match self.byte() {
            0..=15 => SPECIAL[self.below(SPECIAL.len())],
            16..=23 => f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.byte()))),
            24..=39 => (2.0 * self.part() - 1.0) * self.scale(),
            _ => 2.0 * self.part() - 1.0,
        }
    }

    fn values(&mut self, most: usize) -> Vec<f64> {
        (0..=self.below(most)).map(|_| self.value()).collect()
    }

    /// A column of `n` values, in pieces of different kinds.
    fn column(&mut self, n: usize) -> Vec<f64> {
        let scale = self.scale();
        let mut out = Vec::with_capacity(n);
        while out.len() < n {
            let kind = self.below(9);
            let length = if self.one_in(2) { 1 + self.below(60) } else { n }.min(n - out.len());
            let [a, b] = [self.part(), self.part()];
            let repeated = if kind == 8 { self.values(12) } else { Vec::new() };
            let constant = if (5..=7).contains(&kind) { self.value() } else { 0.0 };
            let mut state = u64::from(self.byte());
            out.extend((0..length).map(|i| {
                let t = i as f64;
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let noise = (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
                let x = t / length as f64 - a;
                scale
                    * match kind {
                        0 => (-0.1 * a * t).exp() * (3.2 * b * t).cos(),
                        1 => {
                            (1.0 - a * t / length as f64 * 2.0).max(0.0) * (3.2 * b * t).cos() + 1e-3 * noise
                        }
                        2 => 1.0 / (1.0 + (x / (0.3 * b + 1e-3)).powi(2)).sqrt() + 1e-2 * noise,
                        3 => noise,
                        4 => (-4.0 * a * t / length as f64).exp(),
                        5 => constant,
                        6 => constant * t,
                        7 => {
                            if x < 0.0 {
                                constant
                            } else {
                                b
                            }
                        }
                        _ => repeated[i % repeated.len()],
                    }
            }));
        }
        out
    }

    /// Stamps or frequencies: uniform, or with steps that may be zero, huge, tiny or backwards.
    fn axis(&mut self, n: usize) -> Vec<f64> {
        let scale = self.scale();
        let start = if self.one_in(2) { scale * (1.0 + 30.0 * self.part()) } else { 0.0 };
        match self.below(6) {
            0..=2 => {
                let step = 0.2 * self.part();
                (0..n).map(|i| start + scale * step * i as f64).collect()
            }
            3 => self.column(n),
            4 => {
                let list = self.values(12);
                (0..n).map(|i| list[i % list.len()]).collect()
            }
            _ => {
                const STEPS: [f64; 10] = [1.0, 1.0, 1.0, 0.5, 0.0, 1e-12, 30.0, 1e6, -1.0, f64::NAN];
                let steps: Vec<f64> = (0..16).map(|_| STEPS[self.below(STEPS.len())]).collect();
                let mut now = start;
                let stamp = |i: usize| {
                    let step = steps[i % steps.len()];
                    now += if step.is_nan() { 0.0 } else { scale * step };
                    now + 0.0 * step
                };
                (0..n).map(stamp).collect()
            }
        }
    }

    fn length(&mut self, most: usize) -> usize {
        match self.byte() {
            k @ 0..=15 => usize::from(k),
            k => 16 + usize::from(k) * most / 256,
        }
    }

    fn maybe(&mut self) -> Option<f64> {
        self.one_in(9).then(|| self.value())
    }

    fn band(&mut self) -> Option<[f64; 2]> {
        self.one_in(9).then(|| [self.value(), self.value()])
    }

    fn model(&mut self) -> Option<LossModel> {
        let all: Vec<LossModel> = LossModel::all().collect();
        self.one_in(9).then(|| all[self.below(all.len())])
    }

    /// A record with its options, if there is one.
    pub(crate) fn record(&mut self) -> Option<(Record, ringdown::Options)> {
        use SignalKind::{Acceleration, Displacement, Envelope, Velocity};
        let mut options = ringdown::Options::default();
        options.start_s = self.maybe();
        options.end_s = self.maybe();
        options.min_amplitude = self.maybe();
        options.frequency_hz = self.maybe();
        options.band_hz = self.band();
        options.model = self.model();
        let n = self.length(MOST_SAMPLES);
        let kind = [Displacement, Displacement, Velocity, Acceleration, Envelope][self.below(5)];
        let even = self.below(3) > 0;
        let (rate_hz, time_s) =
            if even { (self.scale() * (1.0 + self.part()), Vec::new()) } else { (0.0, self.axis(n)) };
        let mut signal = self.column(n);
        if kind == Envelope {
            signal.iter_mut().for_each(|v| *v = v.abs());
        }
        let record = match (self.one_in(6), even) {
            (true, true) => Record::lock_in_uniform(rate_hz, signal, self.column(n)),
            (true, false) => Record::lock_in(time_s, signal, self.column(n)),
            (false, true) => Record::uniform(rate_hz, signal).map(|r| r.with_kind(kind)),
            (false, false) => Record::new(time_s, signal).map(|r| r.with_kind(kind)),
        };
        Some((record.ok()?, options))
    }

    fn points(&mut self) -> Option<resonance::Curve> {
        let n = self.length(MOST_POINTS);
        let frequency_hz: Vec<f64> = self.axis(n).into_iter().map(f64::abs).collect();
        let amplitude = self.column(n);
        let mut builder = match self.below(3) {
            0 => resonance::Curve::builder(frequency_hz, amplitude.into_iter().map(f64::abs).collect()),
            1 => {
                let z = amplitude.into_iter().zip(self.column(n)).map(|(a, b)| Phasor::new(a, b)).collect();
                resonance::Curve::complex(frequency_hz, z)
            }
            _ => resonance::Curve::builder(frequency_hz, amplitude.into_iter().map(f64::abs).collect())
                .phase_rad(self.column(n)),
        };
        if self.one_in(6) {
            builder = builder.drive(self.column(n).into_iter().map(f64::abs).collect());
        }
        if self.one_in(6) {
            builder = builder.std_error(self.column(n).into_iter().map(f64::abs).collect());
        }
        builder.build().ok()
    }

    /// A curve with its options, if there is one.
    pub(crate) fn curve(&mut self) -> Option<(resonance::Curve, resonance::Options)> {
        use resonance::{DriveAmplitude, Method};
        let mut options = resonance::Options::default();
        options.band_hz = self.band();
        options.model = self.model();
        options.method = [Method::Exact, Method::Exact, Method::Leading, Method::Paper][self.below(4)];
        match self.below(9) {
            1 => {
                options.drive_amplitude =
                    Some(DriveAmplitude { value: self.value(), std_error: self.value() })
            }
            2 => options.reference = self.points(),
            _ => {}
        }
        options.terms.background = self.one_in(9).then(|| self.one_in(2));
        options.terms.delay = self.one_in(9).then(|| self.one_in(2));
        options.terms.duffing = self.one_in(9).then(|| self.one_in(2));
        Some((self.points()?, options))
    }

    /// A work limit, mostly from a tenth of a millisecond upwards, so that a search may be cut at any point; one
    /// curve in 250 has the full limit.
    fn criteria(&mut self) -> resonance::Criteria {
        let mut criteria = resonance::Criteria::default();
        let chosen = self.byte();
        if chosen < 255 {
            criteria.search.most_work = 4000 * (1 + usize::from(chosen % 64));
            criteria.search.work_per_point = 0;
        }
        criteria
    }

    /// Drive levels with their options, if there are any.
    pub(crate) fn levels(&mut self) -> Option<(levels::Levels, levels::Options)> {
        let mut options = levels::Options::default();
        options.frequency_hz = self.maybe();
        options.drive_gain = self.band();
        options.q_factor = self.band();
        let n = self.length(MOST_POINTS);
        let drive = self.axis(n).into_iter().map(f64::abs).collect();
        let amplitude = self.column(n).into_iter().map(f64::abs).collect();
        let mut builder = levels::Levels::builder(drive, amplitude);
        if self.one_in(6) {
            builder = builder.std_error(self.column(n).into_iter().map(f64::abs).collect());
        }
        Some((builder.build().ok()?, options))
    }

    /// Up to four measurements with their options.
    pub(crate) fn series(&mut self) -> (Vec<Measurement>, series::Options) {
        let mut options = series::Options::default();
        options.shared.natural_frequency = self.one_in(2);
        options.shared.drive_amplitude = self.one_in(2);
        options.shared.decay_rate = self.one_in(2);
        let mut list = Vec::new();
        for i in 0..=self.below(4) {
            let condition = Condition {
                label: format!("{}", self.below(3)),
                value: self.one_in(2).then(|| [self.value(), self.value()]),
            };
            let scale = if self.one_in(4) { self.value() } else { 1.0 };
            // Levels are the quickest.
            let data = match self.below(6) {
                0 => self.record().map(|(record, options)| Data::RingDown {
                    record: Box::new(record),
                    options: Box::new(options),
                }),
                1 => self.curve().map(|(curve, options)| Data::Sweep {
                    curve: Box::new(curve),
                    options: Box::new(options),
                }),
                _ => self.levels().map(|(levels, options)| Data::Levels {
                    levels: Box::new(levels),
                    options: Box::new(options),
                }),
            };
            if let Some(data) = data {
                list.push(Measurement { name: format!("{i}"), condition, data, scale });
            }
        }
        (list, options)
    }
}

/// Analyses the ring-down in these bytes and checks the result.
pub(crate) fn ringdown(bytes: &[u8]) {
    if let Some((record, options)) = Bytes::new(bytes).record()
        && let Ok(answer) = ringdown::analyse(&record, &options)
    {
        check_ringdown(&answer);
    }
}

/// Analyses the curve in these bytes and checks the result.
pub(crate) fn resonance(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let criteria = bytes.criteria();
    if let Some((curve, options)) = bytes.curve()
        && let Ok(answer) = resonance::analyse_with(&curve, &options, &criteria)
    {
        check_resonance(&answer);
    }
}

/// Analyses the drive levels in these bytes and checks the result.
pub(crate) fn levels(bytes: &[u8]) {
    if let Some((levels, options)) = Bytes::new(bytes).levels()
        && let Ok(answer) = levels::analyse(&levels, &options)
    {
        check_levels(&answer);
    }
}

/// Analyses the series in these bytes and checks the result.
pub(crate) fn series(bytes: &[u8]) {
    let (measurements, options) = Bytes::new(bytes).series();
    let Ok(answer) = series::analyse(&measurements, &options) else { return };
    assert_eq!(answer.singles.len(), measurements.len(), "every measurement has its line");
    for (_, single) in &answer.singles {
        match single {
            Ok(SingleAnswer::RingDown(a)) => check_ringdown(a),
            Ok(SingleAnswer::Sweep(a)) => check_resonance(a),
            Ok(SingleAnswer::Levels(a)) => check_levels(a),
            _ => {}
        }
    }
    for row in &answer.table {
        for estimate in [&row.ring_down, &row.resonance, &row.joint].into_iter().flatten() {
            is_finite("friction", &estimate.friction);
            is_finite("damping", &estimate.damping);
            assert!(estimate.correlation.abs() <= 1.0 + 1e-9, "{row:?}");
        }
        for agreement in [&row.friction, &row.damping].into_iter().flatten() {
            is_probability(agreement.p_value);
        }
        row.p_value.into_iter().for_each(is_probability);
    }
    answer.agreement_p_value.into_iter().for_each(is_probability);
    if let Some(joint) = &answer.joint {
        is_probability(joint.p_value);
        let shared = [&joint.natural_frequency_hz, &joint.drive_amplitude, &joint.decay_rate_per_s];
        shared.into_iter().flatten().for_each(|q| is_finite("shared", q));
    }
    speak(&answer.warnings);
}

fn check_ringdown(answer: &ringdown::Answer) {
    check(&answer.parameters);
    speak(&answer.warnings);
    is_probability(answer.sliding.p_value);
    for candidate in &answer.comparison {
        assert!(candidate.bic.is_finite(), "{candidate:?}");
        assert!(candidate.rms.is_finite(), "{candidate:?}");
    }
    assert!(answer.segment.start_s <= answer.segment.end_s, "{:?}", answer.segment);
}

fn check_resonance(answer: &resonance::Answer) {
    check(&answer.parameters);
    speak(&answer.warnings);
    is_probability(answer.sliding.p_value);
    for candidate in &answer.comparison {
        assert!(candidate.bic.is_finite(), "{candidate:?}");
        assert!(candidate.rms.is_finite(), "{candidate:?}");
    }
}

fn check_levels(answer: &levels::Answer) {
    check(&answer.parameters);
    speak(&answer.warnings);
    is_probability(answer.p_value);
    assert!(answer.correlation.abs() <= 1.0 + 1e-9, "correlation {}", answer.correlation);
    assert!(answer.diagnostics.residual_rms.is_finite(), "{:?}", answer.diagnostics);
    for point in &answer.points {
        assert!(point.fitted.is_finite(), "{point:?}");
        assert!(point.std_error.is_finite(), "{point:?}");
    }
}

fn check(parameters: &Parameters) {
    for (parameter, quantity) in parameters.iter() {
        // Without viscous loss Q may be infinite.
        if parameter == Parameter::QFactor {
            let q = quantity;
            let [low, high] = q.interval_95;
            assert!(q.value > 0.0, "{q:?}");
            assert!(low <= high, "{q:?}");
            assert!(!q.std_error.is_nan(), "{q:?}");
        } else {
            is_finite(parameter.name(), quantity);
        }
    }
}

fn is_finite(name: &str, q: &slipfit::Quantity) {
    let [low, high] = q.interval_95;
    assert!(q.value.is_finite(), "{name}: {q:?}");
    assert!(q.unbounded_value.is_finite(), "{name}: {q:?}");
    assert!(q.std_error >= 0.0, "{name}: {q:?}");
    assert!(low <= high, "{name}: {q:?}");
}

fn is_probability(p: f64) {
    assert!((0.0..=1.0).contains(&p), "p value {p}");
}

fn speak(warnings: &[Warning]) {
    for said in warnings.iter().map(ToString::to_string) {
        assert!(!said.contains("NaN"), "{said}");
        assert!(!said.contains("inf "), "{said}");
    }
}
