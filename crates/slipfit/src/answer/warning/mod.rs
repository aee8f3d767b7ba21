//! Warnings: what limits the validity of an answer, and what would help.

mod hints;
mod text;

use super::misfit::Misfit;
use super::parameter::Parameter;
use crate::model::loss::LossModel;

/// A reason to treat an answer with caution.
///
/// Its text states what was found; [`Warning::hints`] state what helps and name options by their field, so that each
/// program can spell them in its own way.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Viscous and sliding loss cannot be separated by these data.
    NotSeparable {
        /// Correlation of `delta` and `x_F`.
        correlation: f64,
        /// Length of the record in decay times; `None` for a curve.
        decay_times: Option<f64>,
    },
    /// Too few cycles to determine more than the total loss.
    TooFewCycles {
        /// Cycles recorded.
        cycles: f64,
    },
    /// The record contains more than one mode.
    SeveralModes {
        /// Frequency of the main mode, Hz.
        main_hz: f64,
        /// Frequency of the strongest other mode, Hz.
        other_hz: f64,
        /// Its amplitude relative to the main one.
        relative_amplitude: f64,
    },
    /// A second mode was fitted and subtracted.
    SecondMode {
        /// Frequency of the stronger mode, Hz.
        main_hz: f64,
        /// Frequency of the mode subtracted, Hz.
        other_hz: f64,
        /// Its amplitude relative to that of the stronger mode.
        relative_amplitude: f64,
    },
    /// The residuals are far above the noise: the law does not hold to this accuracy.
    ModelMisfit {
        /// Residuals over the noise.
        ratio: f64,
        /// Size and shape along a decay, if there are enough amplitudes.
        misfit: Option<Misfit>,
    },
    /// A law with a fitted shape describes the decay better than the models compared.
    FurtherLaw {
        /// The model with this law.
        model: LossModel,
        /// BIC of the best model without it minus that of the model with it.
        delta_bic: f64,
        /// Its residuals over the noise.
        ratio: f64,
    },
    /// There are too few amplitudes to determine the loss without a model.
    NoFreeLaw {
        /// Amplitudes in the free decay.
        amplitudes: usize,
        /// Number of amplitudes required.
        needed: usize,
    },
    /// The loss of amplitude follows another law in part of the record.
    LawChanges {
        /// Instant of the change, s.
        time_s: f64,
    },
    /// A tail below the sliding threshold that a Coulomb law does not produce.
    SlowTail {
        /// Amplitude below which the law fails, signal unit.
        amplitude: f64,
        /// Instant where the tail begins, s.
        time_s: f64,
        /// Signal unit.
        unit: String,
    },
    /// A curved baseline was subtracted.
    Baseline {
        /// Its range over the first amplitude.
        relative: f64,
    },
    /// The reading is a nonlinear function of the deflection and was linearised.
    SensorCurve {
        /// Largest deviation at the first amplitude, relative to it.
        relative: f64,
    },
    /// The mean level follows the amplitude, as it does if the square of a deflection is read.
    SquaredReading {
        /// Whether it is the acceleration along the arc of a pendulum, gravity included.
        along_pendulum: bool,
    },
    /// An acceleration measured across a pendulum contains gravity, whose direction turns with it.
    TurningGravity,
    /// The record contains another motion apart from the one analysed.
    OtherMotion {
        /// Start of the longest other motion, s.
        from_s: f64,
        /// Its end, s.
        to_s: f64,
    },
    /// Outliers (single samples far from their neighbours) were left out.
    Spikes {
        /// Their number within the part used.
        samples: usize,
        /// Instant of the first, s.
        time_s: f64,
    },
    /// Samples are clipped at the limits of the converter.
    Clipped {
        /// Number of samples.
        samples: usize,
        /// Whether some lie inside the fitted window.
        inside: bool,
    },
    /// Two loss models explain the data equally well, or a model other than those compared explains them better.
    AmbiguousModel {
        /// The model reported.
        chosen: LossModel,
        /// Its rival.
        rival: LossModel,
        /// BIC of the rival minus that of the chosen model; negative if the rival has the lower one: a model other than
        /// those compared, or one whose further terms are not significant.
        delta_bic: f64,
    },
    /// The model requested is not the one that the data prefer.
    ModelNotPreferred {
        /// The model requested.
        asked: LossModel,
        /// The model preferred.
        preferred: LossModel,
        /// BIC of the requested model minus that of the preferred one.
        delta_bic: f64,
    },
    /// The data do not determine all parameters of the model requested.
    ModelUndetermined {
        /// The model requested.
        asked: LossModel,
        /// The largest model within it that they determine, which is reported.
        reported: LossModel,
    },
    /// Sliding friction was found in samples that had undergone lossy compression.
    LossyCompression {
        /// Share of sliding friction in the loss at the start.
        share: f64,
    },
    /// The time stamps were not those of the samples; a uniform clock was reconstructed from them.
    ClockRebuilt {
        /// Samples per burst, if each burst had one time stamp.
        burst_samples: Option<usize>,
        /// Rounding step of the time stamps, s, if they were rounded.
        quantum_s: Option<f64>,
        /// Relative uncertainty of the sampling rate.
        rate_error: f64,
    },
    /// There are fewer than three samples per cycle: the frequency may be an alias.
    CoarseSampling {
        /// Samples per cycle.
        samples_per_cycle: f64,
    },
    /// A velocity or acceleration with a large loss per cycle, described by its amplitudes alone.
    LowQDerivative {
        /// Quality factor of all losses together at the first amplitude.
        quality_factor: f64,
    },
    /// A change of the signal that no decay produces (a shock, a new start); the record is used up to it.
    Disturbance {
        /// Its instant, s.
        time_s: f64,
    },
    /// The phase jumps, as after a knock. A knock also changes the amplitude, which cannot be distinguished from a
    /// loss.
    PhaseStep {
        /// Its instant, s.
        time_s: f64,
        /// Size of the jump, rad.
        radians: f64,
    },
    /// The waveform is far from sinusoidal.
    Harmonics {
        /// Order: multiple of the frequency.
        order: usize,
        /// Amplitude relative to the fundamental.
        relative_amplitude: f64,
    },
    /// The frequency changes more with time than with the amplitude.
    FrequencyDrift {
        /// Relative change along the decay.
        relative: f64,
    },
    /// The reading lags by a constant deflection, as a mechanism with play does.
    Play {
        /// Third harmonic in quadrature, relative to the first amplitude.
        relative_amplitude: f64,
    },
    /// The frequency of an amplitude record is not known: there is no friction displacement.
    FrequencyUnknown,
    /// The data give no upper limit for a parameter.
    Undetermined {
        /// The parameter.
        parameter: Parameter,
    },
    /// The drive amplitude is not known: the shape of a curve alone says little about friction.
    ShapeAlone {
        /// Interval of the friction ratio.
        friction_ratio: [f64; 2],
    },
    /// The given phases have the opposite sign and were conjugated.
    PhaseSign,
    /// The phases fit no resonance although the amplitudes do: only the amplitudes were used.
    PhasesIgnored,
    /// The curve jumps: there is more than one amplitude at one frequency.
    Jump {
        /// Frequency of the jump, Hz.
        frequency_hz: f64,
        /// Whether up and down sweeps differ.
        hysteresis: bool,
    },
    /// The curve has a second peak.
    SecondPeak {
        /// Frequency of the main peak, Hz.
        main_hz: f64,
        /// Frequency of the other peak, Hz.
        other_hz: f64,
        /// Its height relative to the main peak.
        relative_height: f64,
    },
    /// All points lie on one flank of the peak.
    OneFlank {
        /// Whether the points lie below the resonance frequency.
        below: bool,
    },
    /// Too few points within the width of the peak.
    FewPointsInLine {
        /// Number of points.
        points: usize,
    },
    /// The peak is skewed (Duffing): the frequency depends on the amplitude.
    Skewed {
        /// Relative shift of the frequency at the highest amplitude.
        relative_shift: f64,
        /// The same shift over the full width of the peak.
        line_widths: f64,
    },
    /// A background was added automatically or on request.
    Background {
        /// Its size over the highest amplitude.
        relative: f64,
        /// Whether phases separate it from friction.
        phases: bool,
    },
    /// A constant in every amplitude was added automatically or on request.
    AmplitudeOffset {
        /// Its size over the highest amplitude, with its sign.
        relative: f64,
    },
    /// A noise floor in every amplitude was added automatically or on request.
    NoiseFloor {
        /// Its size over the highest amplitude.
        relative: f64,
    },
    /// With a further loss such as drag the fit contains no viscous loss, as for a detector that is cut off or
    /// saturates.
    NoViscousLoss {
        /// The model reported.
        model: LossModel,
    },
    /// Other instrument terms than those fitted explain the curve as well and give other losses.
    RivalInstrument {
        /// Whether they include a background.
        background: bool,
        /// Whether they include a delay.
        delay: bool,
        /// Whether they include a constant in every amplitude; `None` if there is no difference.
        offset: Option<bool>,
        /// Whether they include a noise floor in every amplitude; `None` if there is no difference.
        floor: Option<bool>,
        /// Whether they include a Duffing term; `None` if there is no difference.
        duffing: Option<bool>,
        /// Whether they include drag, which those fitted do not.
        drag: bool,
        /// Whether they are the same terms at another minimum.
        other_minimum: bool,
        /// BIC with them minus that of the reported fit.
        delta_bic: f64,
        /// Friction displacement with them, and its standard error.
        friction_displacement: [f64; 2],
        /// Unit of the response.
        unit: String,
    },
    /// A delay was added automatically or on request.
    Delay {
        /// Delay, s.
        delay_s: f64,
    },
    /// The fitted delay is negative by more than its error. No instrument responds before its drive, so the curve
    /// deviates from the model.
    NegativeDelay {
        /// Delay, s.
        delay_s: f64,
        /// Number of standard errors below zero.
        errors: f64,
    },
    /// Up and down sweeps of one file differ.
    RunsDiffer {
        /// Mean difference over its standard error.
        z: f64,
    },
    /// The points lag behind the frequency: each retains a part of the previous one.
    Lag {
        /// Resulting shift of the natural frequency, Hz.
        shift_hz: f64,
    },
    /// The reference curve belongs to another resonator or another drive.
    ReferenceDiffers {
        /// Relative difference of the natural frequencies.
        relative_frequency: f64,
        /// Decay rate of the reference over that of the curve.
        decay_rate_ratio: f64,
    },
    /// The shape of a curve implies another drive amplitude than the one given.
    DriveDiffers {
        /// The drive amplitude given.
        given: f64,
        /// The drive amplitude implied by the shape, with its standard error.
        by_shape: [f64; 2],
        /// BIC with this drive minus that of the reported fit.
        delta_bic: f64,
        /// Friction displacement with this drive, and its standard error.
        friction_displacement: [f64; 2],
        /// Unit of the response.
        unit: String,
    },
    /// The shape of a curve implies another drive amplitude than that of its reference.
    ReferenceGain {
        /// Drive of the curve implied by its shape, over that of the reference.
        ratio: f64,
        /// BIC with separate drives minus that of the reported fit.
        delta_bic: f64,
        /// Friction displacement with separate drives, and its standard error.
        friction_displacement: [f64; 2],
        /// Unit of the response.
        unit: String,
    },
    /// The reference curve itself shows sliding friction.
    ReferenceSlides {
        /// p value of the reference without sliding friction.
        p_value: f64,
    },
    /// The drive at some points is smaller than the friction: the mass sticks there.
    Stuck {
        /// Number of points.
        points: usize,
    },
    /// The inversion of the paper has this bias here.
    PaperBias {
        /// Relative bias of the friction.
        friction: f64,
        /// Relative bias of Q.
        q_factor: f64,
    },
    /// Points left out because they are not finite or are at zero frequency.
    Dropped {
        /// Number of points that are not finite.
        not_finite: usize,
        /// Number of points at zero frequency.
        zero_frequency: usize,
    },
    /// The search for the fit or its intervals was stopped after a fixed amount of work.
    SearchCut,
    /// Outliers were left out of the fit.
    Outliers {
        /// Number of points.
        points: usize,
    },
    /// The given errors scatter from point to point and the residuals do not follow them: they were not used.
    ScatteredErrors {
        /// Standard deviation of their logarithm from one point to the next.
        scatter: f64,
        /// Whether no fit was found with them; otherwise the residuals do not follow them.
        no_fit: bool,
    },
    /// A measured drive scatters and the response does not follow it: a smoothed drive was used.
    DriveReadback {
        /// Standard deviation about the smoothed drive, relative to the drive.
        scatter: f64,
        /// Whether no fit was found with the drive as read; otherwise the response does not follow it.
        no_fit: bool,
    },
    /// There are so few levels with motion that their scatter determines the errors of the line only to within a
    /// factor.
    FewLevels {
        /// Number of levels with motion.
        moving: usize,
    },
    /// No drive level lies below the threshold: the threshold is extrapolated.
    ThresholdExtrapolated {
        /// Lowest level over the threshold.
        ratio: f64,
    },
    /// The amplitude does not rise along a straight line, because of drag or a nonlinear spring. Slope and threshold
    /// are those of a curve in the limit of small amplitudes.
    NotStraight {
        /// p value of a straight line.
        p_value: f64,
        /// Whether the slope decreases with the drive.
        falling: bool,
    },
    /// Levels at which the mass sticks read more than noise: the zero or the noise of the detector, subtracted from
    /// every level.
    LevelPlateau {
        /// Their reading.
        reading: f64,
        /// Number of levels.
        levels: usize,
        /// Whether it was subtracted in quadrature; otherwise as a constant.
        in_squares: bool,
        /// Unit of the amplitudes.
        unit: String,
    },
    /// The line through the levels is above zero at zero drive.
    AboveZero {
        /// Its value there.
        reading: f64,
        /// p value of a line through zero.
        p_value: f64,
        /// Unit of the amplitudes.
        unit: String,
    },
    /// Drive and amplitude are not related as two lengths or two angles are, or their relation gives a Q below 1/2:
    /// there is no Q and no friction displacement.
    DriveUncalibrated,
    /// Levels at which the mass stuck lie above levels at which it moved.
    Hysteresis {
        /// Highest level at which the mass stuck.
        stuck_at: f64,
        /// Lowest level at which it moved.
        moving_at: f64,
        /// Unit of the drive.
        unit: String,
    },
    /// Ring-down and resonance disagree at one condition of a series.
    Disagree {
        /// The condition.
        condition: String,
        /// p value of their agreement.
        p_value: f64,
    },
    /// The measurements of a series differ from one joint fit by more than their errors.
    NotShared {
        /// p value of the chi square of the joint fit.
        p_value: f64,
        /// Parameters assumed to be shared in addition to damping and friction of one condition.
        shared: Vec<Parameter>,
    },
    /// A measurement of a series could not be analysed; the others were analysed.
    Failed {
        /// Its name.
        name: String,
    },
    /// A condition of a series is a negative load, for which no law of friction is defined.
    NegativeLoad {
        /// Its label.
        condition: String,
        /// The load, in the unit of the conditions.
        load: f64,
    },
    /// A measurement of a series does not determine friction displacement and damping.
    NotUsed {
        /// Its name.
        name: String,
        /// The reason.
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
