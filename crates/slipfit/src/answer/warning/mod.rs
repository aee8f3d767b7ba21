//! Warnings: what limits an answer, and what would help.

mod hints;
mod text;

use super::misfit::Misfit;
use super::parameter::Parameter;
use crate::model::loss::LossModel;

/// A reason to treat an answer with caution.
///
/// Its text says what was found; [`Warning::hints`] say what helps, naming options by their field, so
/// that each program spells them its own way.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Viscous and sliding loss cannot be separated by these data.
    NotSeparable {
        /// Correlation of delta and x_F.
        correlation: f64,
        /// Decay times recorded; `None` for a curve.
        decay_times: Option<f64>,
    },
    /// Too few cycles to say anything but the total loss.
    TooFewCycles {
        /// Cycles recorded.
        cycles: f64,
    },
    /// The record holds more than one mode.
    SeveralModes {
        /// Frequency of the main one, Hz.
        main_hz: f64,
        /// Frequency of the strongest other one, Hz.
        other_hz: f64,
        /// Its amplitude relative to the main one.
        relative_amplitude: f64,
    },
    /// A second mode was fitted and subtracted.
    SecondMode {
        /// Frequency of the stronger one, Hz.
        main_hz: f64,
        /// Frequency of the one subtracted, Hz.
        other_hz: f64,
        /// Its amplitude relative to the stronger one.
        relative_amplitude: f64,
    },
    /// The residual is far above the noise: the law does not hold to this accuracy.
    ModelMisfit {
        /// Residual over the noise.
        ratio: f64,
        /// What it is along a decay, where there are amplitudes enough.
        misfit: Option<Misfit>,
    },
    /// A law whose shape is fitted describes the decay better than those compared.
    FurtherLaw {
        /// The model with it.
        model: LossModel,
        /// Its BIC is lower than that of the best model without it by this.
        delta_bic: f64,
        /// Residual over the noise that it leaves.
        ratio: f64,
    },
    /// The amplitudes give no law without a model.
    NoFreeLaw {
        /// Amplitudes in the free decay.
        amplitudes: usize,
        /// As many are needed.
        needed: usize,
    },
    /// The amplitude lost follows another law in part of the record.
    LawChanges {
        /// Instant of the change, s.
        time_s: f64,
    },
    /// A tail below the sliding threshold that no Coulomb law gives.
    SlowTail {
        /// Amplitude below which the law fails, signal unit.
        amplitude: f64,
        /// Instant where it begins, s.
        time_s: f64,
        /// Signal unit.
        unit: String,
    },
    /// A baseline along a curve, subtracted.
    Baseline {
        /// Its range over the first amplitude.
        relative: f64,
    },
    /// A reading that bends with the deflection, straightened.
    SensorCurve {
        /// By how much at most at the first amplitude, as a part of it.
        relative: f64,
    },
    /// The level follows the amplitude, as that of the square of a deflection.
    SquaredReading {
        /// It is the acceleration along a pendulum, gravity included.
        along_pendulum: bool,
    },
    /// An acceleration across a pendulum holds gravity, which turns with it.
    TurningGravity,
    /// Another motion in the record, apart from the one analysed.
    OtherMotion {
        /// Where the longest other one begins, s.
        from_s: f64,
        /// Where it ends, s.
        to_s: f64,
    },
    /// Single samples far off their neighbours, left out.
    Spikes {
        /// How many of the part used.
        samples: usize,
        /// Instant of the first, s.
        time_s: f64,
    },
    /// Samples at the rails of the converter.
    Clipped {
        /// How many.
        samples: usize,
        /// Whether some lie inside the fitted window.
        inside: bool,
    },
    /// Two loss models explain the data equally well, or a further one than those compared explains them better.
    AmbiguousModel {
        /// The one reported.
        chosen: LossModel,
        /// Its rival.
        rival: LossModel,
        /// BIC of the rival above the chosen one's; below zero where that is a further one.
        delta_bic: f64,
    },
    /// The model asked for is not the one the data prefer.
    ModelNotPreferred {
        /// The one asked for.
        asked: LossModel,
        /// The one preferred.
        preferred: LossModel,
        /// BIC of the one asked for above the preferred one's.
        delta_bic: f64,
    },
    /// The data do not determine all parameters of the model asked for.
    ModelUndetermined {
        /// The one asked for.
        asked: LossModel,
        /// The largest within it that they determine: the one reported.
        reported: LossModel,
    },
    /// Sliding friction was found in samples that went through a lossy compression.
    LossyCompression {
        /// Sliding share of the loss at the start.
        share: f64,
    },
    /// The stamps were not those of the samples, and a clock was rebuilt from them.
    ClockRebuilt {
        /// Samples of a burst, where each had one stamp.
        burst_samples: Option<usize>,
        /// Rounding of the stamps, s, where they were rounded.
        quantum_s: Option<f64>,
        /// How far the rate may be off, over it.
        rate_error: f64,
    },
    /// Fewer than three samples a cycle: the frequency may be an alias.
    CoarseSampling {
        /// Samples per cycle.
        samples_per_cycle: f64,
    },
    /// A velocity or acceleration that loses much in each cycle, described by its amplitudes alone.
    LowQDerivative {
        /// Quality factor of all losses together at the first amplitude.
        quality_factor: f64,
    },
    /// A change of the signal that no decay makes (a jolt, a new start); the record is used up to it.
    Disturbance {
        /// Its instant, s.
        time_s: f64,
    },
    /// The phase jumps, as after a knock. A knock changes the amplitude as well, which cannot be told from a loss.
    PhaseStep {
        /// Its instant, s.
        time_s: f64,
        /// By how much, rad.
        radians: f64,
    },
    /// The waveform is far from sinusoidal.
    Harmonics {
        /// Multiple of the frequency.
        order: usize,
        /// Amplitude relative to the fundamental's.
        relative_amplitude: f64,
    },
    /// The frequency changes with time by more than with the amplitude.
    FrequencyDrift {
        /// By which part, along the decay.
        relative: f64,
    },
    /// The reading lags by a constant, as one with play does.
    Play {
        /// Third harmonic in quadrature over the first amplitude.
        relative_amplitude: f64,
    },
    /// An amplitude record without its frequency: no friction displacement.
    FrequencyUnknown,
    /// The data set no upper limit to a parameter.
    Undetermined {
        /// The parameter.
        parameter: Parameter,
    },
    /// The drive amplitude is not known: the shape of a curve alone says little about friction.
    ShapeAlone {
        /// Interval of the friction ratio.
        friction_ratio: [f64; 2],
    },
    /// The phases given have the opposite sign and were conjugated.
    PhaseSign,
    /// The phases fit no resonance while the amplitudes do: only amplitudes were used.
    PhasesIgnored,
    /// The curve jumps: more than one amplitude at one frequency.
    Jump {
        /// Where, Hz.
        frequency_hz: f64,
        /// Whether up and down sweeps differ.
        hysteresis: bool,
    },
    /// The curve has a second peak.
    SecondPeak {
        /// Frequency of the main one, Hz.
        main_hz: f64,
        /// Frequency of the other one, Hz.
        other_hz: f64,
        /// Its height relative to the main one.
        relative_height: f64,
    },
    /// All points lie on one flank of the peak.
    OneFlank {
        /// Whether the points lie below the resonance.
        below: bool,
    },
    /// Too few points within the width of the peak.
    FewPointsInLine {
        /// How many.
        points: usize,
    },
    /// The peak is skewed (Duffing): the frequency depends on the amplitude.
    Skewed {
        /// Relative shift of the frequency at the highest amplitude.
        relative_shift: f64,
        /// The same shift over the full width of the peak.
        line_widths: f64,
    },
    /// A background was added automatically or asked for.
    Background {
        /// Its size over the highest amplitude.
        relative: f64,
        /// Whether phases separate it from friction.
        phases: bool,
    },
    /// A constant in every amplitude was added automatically or asked for.
    AmplitudeOffset {
        /// Its size over the highest amplitude, with its sign.
        relative: f64,
    },
    /// A noise floor in every amplitude was added automatically or asked for.
    NoiseFloor {
        /// Its size over the highest amplitude.
        relative: f64,
    },
    /// Beside a further loss such as drag the curve leaves no viscous one, as that of a detector that is cut off does.
    NoViscousLoss {
        /// The model reported.
        model: LossModel,
    },
    /// Other terms beside the losses than those fitted explain the curve as well, and give other losses.
    RivalInstrument {
        /// They have a background.
        background: bool,
        /// They have a delay.
        delay: bool,
        /// Whether they have a constant in every amplitude, where that is a difference.
        offset: Option<bool>,
        /// Whether they have a noise floor in every amplitude, where that is a difference.
        floor: Option<bool>,
        /// Whether they have a Duffing term, where that is the difference.
        duffing: Option<bool>,
        /// They have drag, which those fitted have not.
        drag: bool,
        /// They are the same terms, at another minimum.
        other_minimum: bool,
        /// BIC with them above the one reported.
        delta_bic: f64,
        /// Friction displacement with them, and its standard error.
        friction_displacement: [f64; 2],
        /// Unit of the response.
        unit: String,
    },
    /// A delay was added automatically or asked for.
    Delay {
        /// s.
        delay_s: f64,
    },
    /// The delay that was fitted is below zero by more than its error: no instrument answers before its drive, so that the curve
    /// departs from the model.
    NegativeDelay {
        /// s.
        delay_s: f64,
        /// Standard errors below zero.
        errors: f64,
    },
    /// Up and down sweeps of one file differ.
    RunsDiffer {
        /// Mean difference over its standard error.
        z: f64,
    },
    /// The points lag behind the frequency: each keeps a part of the one before.
    Lag {
        /// By how much that moves the natural frequency, Hz.
        shift_hz: f64,
    },
    /// The reference curve belongs to another resonator, or another drive.
    ReferenceDiffers {
        /// Relative difference of the natural frequencies.
        relative_frequency: f64,
        /// Decay rate of the reference over that of the curve.
        decay_rate_ratio: f64,
    },
    /// The shape of a curve asks for another drive than the one given.
    DriveDiffers {
        /// The one given.
        given: f64,
        /// By the shape, with its standard error.
        by_shape: [f64; 2],
        /// BIC with it above that of the one reported.
        delta_bic: f64,
        /// Friction displacement then, and its standard error.
        friction_displacement: [f64; 2],
        /// Unit of the response.
        unit: String,
    },
    /// The shape of a curve asks for another drive than that of its reference.
    ReferenceGain {
        /// Drive of the curve by its shape over that of the reference.
        ratio: f64,
        /// BIC with a drive for each above that of the one reported.
        delta_bic: f64,
        /// Friction displacement then, and its standard error.
        friction_displacement: [f64; 2],
        /// Unit of the response.
        unit: String,
    },
    /// The reference curve itself shows sliding friction.
    ReferenceSlides {
        /// p value of it.
        p_value: f64,
    },
    /// The drive of some points lies within the friction: the mass sticks there.
    Stuck {
        /// How many points.
        points: usize,
    },
    /// The paper's inversion is biased here by this much.
    PaperBias {
        /// Relative bias of the friction.
        friction: f64,
        /// Relative bias of Q.
        q_factor: f64,
    },
    /// Points left out: not finite, or at frequency zero.
    Dropped {
        /// Not finite.
        not_finite: usize,
        /// At frequency zero.
        zero_frequency: usize,
    },
    /// The search for the fit or its intervals was ended after a set amount of work.
    SearchCut,
    /// Outliers left out of the fit.
    Outliers {
        /// How many points.
        points: usize,
    },
    /// Errors of the points scatter from point to point and the residuals do not follow them: they were set aside.
    ScatteredErrors {
        /// Standard deviation of their logarithm from one point to the next.
        scatter: f64,
        /// No fit was found with them; else the residuals do not follow them.
        no_fit: bool,
    },
    /// A measured drive scatters and the response does not follow it: its smooth course was used.
    DriveReadback {
        /// Its standard deviation about that course, over the drive.
        scatter: f64,
        /// No fit was found with it as read; else the response does not follow it.
        no_fit: bool,
    },
    /// So few levels move that their scatter gives the errors of the line to no better than a factor.
    FewLevels {
        /// Levels that move.
        moving: usize,
    },
    /// No drive level lies below the threshold: it is extrapolated.
    ThresholdExtrapolated {
        /// Lowest level over the threshold.
        ratio: f64,
    },
    /// The amplitude does not rise along a straight line: drag or a nonlinear spring besides. Slope and threshold are those of
    /// a curve at small amplitudes.
    NotStraight {
        /// p value of a straight line.
        p_value: f64,
        /// Whether the slope falls with the drive.
        falling: bool,
    },
    /// Levels at which the mass sticks read more than noise: the zero or the noise of the detector, taken off every level.
    LevelPlateau {
        /// What they read.
        reading: f64,
        /// How many.
        levels: usize,
        /// It was taken off in squares, else as a constant.
        in_squares: bool,
        /// Unit of the amplitudes.
        unit: String,
    },
    /// The line through the levels lies above zero without a drive.
    AboveZero {
        /// By how much.
        reading: f64,
        /// p value of a line through zero.
        p_value: f64,
        /// Unit of the amplitudes.
        unit: String,
    },
    /// Nothing relates drive and amplitude, as two lengths or two angles are related, or what does gives a Q below 1/2:
    /// no Q and no friction displacement.
    DriveUncalibrated,
    /// Levels at which the mass stuck lie above those at which it moved.
    Hysteresis {
        /// Highest stuck level.
        stuck_at: f64,
        /// Lowest moving level.
        moving_at: f64,
    },
    /// Ring-down and resonance disagree at one condition of a series.
    Disagree {
        /// The condition.
        condition: String,
        /// p value of their agreement.
        p_value: f64,
    },
    /// The measurements of a series differ by more than their errors from one joint fit.
    NotShared {
        /// p value of its chi square.
        p_value: f64,
        /// What they were said to share beside damping and friction of one condition.
        shared: Vec<Parameter>,
    },
    /// A measurement of a series could not be analysed; the others were.
    Failed {
        /// Its name.
        name: String,
    },
    /// A condition of a series is a load below zero, which is in no law of friction.
    NegativeLoad {
        /// Its label.
        condition: String,
        /// The load, in the unit of the conditions.
        load: f64,
    },
    /// A measurement of a series gives no friction displacement and damping.
    NotUsed {
        /// Its name.
        name: String,
        /// Why.
        why: &'static str,
    },
}

impl Warning {
    /// Machine-readable code, as in JSON.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::NotSeparable { .. } => "not_separable",
            Warning::TooFewCycles { .. } => "too_few_cycles",
            Warning::SeveralModes { .. } => "several_modes",
            Warning::SecondMode { .. } => "second_mode",
            Warning::ModelMisfit { .. } => "model_misfit",
            Warning::FurtherLaw { .. } => "further_law",
            Warning::NoFreeLaw { .. } => "no_free_law",
            Warning::LawChanges { .. } => "law_changes",
            Warning::SlowTail { .. } => "slow_tail",
            Warning::Baseline { .. } => "baseline",
            Warning::SensorCurve { .. } => "sensor_curve",
            Warning::SquaredReading { .. } => "squared_reading",
            Warning::TurningGravity => "turning_gravity",
            Warning::OtherMotion { .. } => "other_motion",
            Warning::Spikes { .. } => "spikes",
            Warning::Clipped { .. } => "clipped",
            Warning::AmbiguousModel { .. } => "ambiguous_model",
            Warning::ModelNotPreferred { .. } => "model_not_preferred",
            Warning::ModelUndetermined { .. } => "model_undetermined",
            Warning::LossyCompression { .. } => "lossy_compression",
            Warning::ClockRebuilt { .. } => "clock_rebuilt",
            Warning::CoarseSampling { .. } => "coarse_sampling",
            Warning::LowQDerivative { .. } => "low_q_derivative",
            Warning::Disturbance { .. } => "disturbance",
            Warning::PhaseStep { .. } => "phase_step",
            Warning::Harmonics { .. } => "harmonics",
            Warning::FrequencyDrift { .. } => "frequency_drift",
            Warning::Play { .. } => "play",
            Warning::FrequencyUnknown => "frequency_unknown",
            Warning::Undetermined { .. } => "undetermined",
            Warning::ShapeAlone { .. } => "shape_alone",
            Warning::PhaseSign => "phase_sign",
            Warning::PhasesIgnored => "phases_ignored",
            Warning::Jump { .. } => "jump",
            Warning::SecondPeak { .. } => "second_peak",
            Warning::OneFlank { .. } => "one_flank",
            Warning::FewPointsInLine { .. } => "few_points_in_line",
            Warning::Skewed { .. } => "leaning",
            Warning::Background { .. } => "background",
            Warning::AmplitudeOffset { .. } => "amplitude_offset",
            Warning::NoiseFloor { .. } => "noise_floor",
            Warning::NoViscousLoss { .. } => "no_viscous_loss",
            Warning::RivalInstrument { .. } => "rival_instrument",
            Warning::Delay { .. } => "delay",
            Warning::NegativeDelay { .. } => "negative_delay",
            Warning::RunsDiffer { .. } => "runs_differ",
            Warning::Lag { .. } => "lag",
            Warning::ReferenceDiffers { .. } => "reference_differs",
            Warning::DriveDiffers { .. } => "drive_differs",
            Warning::ReferenceGain { .. } => "reference_gain",
            Warning::ReferenceSlides { .. } => "reference_slides",
            Warning::Stuck { .. } => "stuck",
            Warning::PaperBias { .. } => "paper_bias",
            Warning::Dropped { .. } => "dropped",
            Warning::SearchCut => "search_cut",
            Warning::Outliers { .. } => "outliers",
            Warning::ScatteredErrors { .. } => "scattered_errors",
            Warning::DriveReadback { .. } => "drive_readback",
            Warning::FewLevels { .. } => "few_levels",
            Warning::ThresholdExtrapolated { .. } => "threshold_extrapolated",
            Warning::NotStraight { .. } => "bent",
            Warning::LevelPlateau { .. } => "level_plateau",
            Warning::AboveZero { .. } => "above_zero",
            Warning::DriveUncalibrated => "drive_uncalibrated",
            Warning::Hysteresis { .. } => "hysteresis",
            Warning::Disagree { .. } => "disagree",
            Warning::NotShared { .. } => "not_shared",
            Warning::Failed { .. } => "failed",
            Warning::NegativeLoad { .. } => "negative_load",
            Warning::NotUsed { .. } => "not_used",
        }
    }
}
