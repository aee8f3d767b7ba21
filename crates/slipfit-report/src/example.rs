//! A ring-down for tests of reports.

use crate::AnalysedRingdown;
use slipfit::LossModel;
use slipfit::LossTerm;
use slipfit::Parameter;
use slipfit::Quantity;
use slipfit::answer::hint::HintValue;
use slipfit::ringdown::{Answer, EndReason, Options, StartReason, analyse};
use std::path::Path;

/// Writes options by their own names.
pub(crate) fn spell(option: &'static str, _: Option<&HintValue>) -> String {
    option.to_owned()
}

/// The answer of the example.
pub(crate) fn answer() -> Answer {
    by_hand(|_| (), |analysed| analysed.answer.clone())
}

/// Calls `look` with an answer whose numbers are set by hand and then changed by `change`.
pub(crate) fn by_hand<T>(
    change: impl FnOnce(&mut Answer),
    look: impl FnOnce(&AnalysedRingdown<'_>) -> T,
) -> T {
    let decay = slipfit::Oscillator::kinematic(8.0, 0.03, 0.002)
        .and_then(|o| slipfit::motion::decay::FreeDecay::from_rest(&o, 0.35))
        .unwrap();
    let mut text = String::from("t (s);angle (rad)\n");
    for i in 0..1500 {
        let t = 0.02 * f64::from(i);
        text += &format!("{t:.2};{:.5}\n", decay.displacement(t) + 1e-4 * (7.7 * f64::from(i * i)).sin());
    }
    let reading = slipfit_io::read_from(text.as_bytes(), "swing.csv", &Default::default()).unwrap();
    let mut options = Options::default();
    options.model = Some(LossModel::VISCOUS_SLIDING);
    let mut answer = analyse(&reading.record, &options).unwrap();

    let mut x_f = Quantity::normal(0.002, 2e-5, "rad");
    x_f.interval_95 = [0.001_98, 0.002_1];
    let mut drag = Quantity::normal(0.0, 2e-3, "1/(rad s)");
    drag.interval_95 = [0.0, 4e-3];
    answer.parameters = [
        (Parameter::Frequency, Quantity::normal(1.2732, 1.2e-5, "Hz")),
        (Parameter::DECAY_RATE, Quantity::normal(0.0302, 4e-4, "1/s")),
        (Parameter::FRICTION_DISPLACEMENT, x_f),
        (Parameter::SlidingRate, Quantity::normal(0.0102, 1e-4, "rad/s")),
        (Parameter::DRAG_RATE, drag),
        (Parameter::InitialAmplitude, Quantity::normal(0.35, 1e-5, "rad")),
    ]
    .into_iter()
    .collect();
    let template = answer.comparison[0].clone();
    answer.comparison = [
        (LossModel::VISCOUS_SLIDING, 0.0),
        (LossModel::VISCOUS_SLIDING_DRAG, 7.3),
        (LossModel::VISCOUS, 1530.2),
    ]
    .into_iter()
    .map(|(model, delta_bic)| slipfit::answer::Candidate {
        model,
        delta_bic,
        rms: if delta_bic > 10.0 { 2.2e-3 } else { 1.0e-4 },
        converged: true,
        at_limit: model.has(LossTerm::Drag).then_some(Parameter::DRAG_RATE),
        values: [
            (Parameter::DECAY_RATE, 0.0302),
            (Parameter::FRICTION_DISPLACEMENT, if model.has_sliding() { 0.002 } else { 0.0 }),
        ]
        .into_iter()
        .collect(),
        ..template.clone()
    })
    .collect();
    answer.model = LossModel::VISCOUS_SLIDING;
    answer.preferred_model = answer.model;
    answer.sliding.detected = true;
    answer.sliding.share_at_highest = 0.41;
    answer.sliding.dominates_from_s = Some(16.0);
    answer.sliding.viscous_only_p_value = 0.0;
    answer.segment.start_s = 0.0;
    answer.segment.end_s = 24.0;
    answer.segment.samples = 1200;
    answer.segment.cycles = 30.6;
    answer.segment.start_reason = StartReason::RecordStart;
    answer.segment.end_reason = EndReason::Rest;
    answer.stop = Some(slipfit::ringdown::Stop {
        time_s: 24.1,
        position: 0.001_2,
        position_std_error: 2e-5,
        static_displacement: Some([0.001_2, 0.002_4]),
    });
    answer.diagnostics.method = "waveform";
    answer.diagnostics.noise_rms = 1e-4;
    answer.diagnostics.signal_to_noise_db = 68.0;
    answer.diagnostics.residual_excess = 1.02;
    answer.diagnostics.decay_times = 4.3;
    answer.diagnostics.left_out = 0;
    answer.warnings = Vec::new();
    change(&mut answer);
    look(&AnalysedRingdown {
        file: Path::new("swing.csv"),
        reading: &reading,
        options: &options,
        answer: &answer,
    })
}
