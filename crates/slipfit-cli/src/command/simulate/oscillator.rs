//! The oscillator, its friction and its drive from the flags.

use super::sheet;
use crate::args::{DriveArgs, MinusArgs, OscillatorArgs};
use crate::failure::Failure;
use slipfit::Oscillator;
use slipfit::model::displacement::DisplacementUnit;
use slipfit::motion::simulate::Friction;

/// The oscillator, whose displacements are in `unit`; `reference` is the amplitude to which `--beta` refers.
pub(super) fn oscillator(
    args: &OscillatorArgs,
    unit: &str,
    reference: impl Fn(&Oscillator) -> Result<f64, Failure>,
) -> Result<Oscillator, Failure> {
    let mut builder = Oscillator::builder().displacement_unit(unit);
    if let Some(v) = args.frequency_hz {
        builder = builder.frequency_hz(v);
    }
    if let Some(v) = args.stiffness {
        builder = builder.stiffness(v);
    }
    if let Some(v) = args.mass {
        builder = builder.mass(v);
    }
    if let Some(v) = args.q {
        builder = builder.q_factor(v);
    }
    if let Some(v) = args.viscous {
        builder = builder.viscous_coefficient(v);
    }
    if let Some(beta) = args.beta {
        let bare = builder.clone().build().map_err(in_flags)?;
        builder =
            builder.friction_displacement(Oscillator::friction_displacement_for(beta, reference(&bare)?));
    }
    if let Some(v) = args.friction_displacement {
        builder = builder.friction_displacement(v);
    }
    if let Some(v) = args.coulomb_force {
        builder = builder.coulomb_force(v);
    }
    if let Some(v) = args.static_force {
        builder = builder.static_force(v);
    }
    if let Some(v) = args.static_displacement {
        builder = builder.static_displacement(v);
    }
    builder.build().map_err(in_flags)
}

/// Friction, which may differ by direction.
pub(super) fn friction(args: &MinusArgs, o: &Oscillator, unit: &str) -> Result<Friction, Failure> {
    let over_stiffness = |flag: &str, displacement: Option<f64>, force: Option<f64>| match force {
        None => Ok(displacement),
        Some(f) => under_force(o, unit, f, flag, "--stiffness or --mass gives it").map(Some),
    };
    let kinetic =
        over_stiffness("--coulomb-force-minus", args.friction_displacement_minus, args.coulomb_force_minus)?;
    let holding =
        over_stiffness("--static-force-minus", args.static_displacement_minus, args.static_force_minus)?;
    let minus = kinetic.unwrap_or(o.friction_displacement());
    let held = holding.unwrap_or(o.static_displacement().max(minus));
    if held < minus {
        let (flag, value) = match args.static_force_minus {
            Some(f) => ("--static-force-minus", f),
            None => ("--static-displacement-minus", held),
        };
        return Err(Failure::new(format!(
            "{flag} = {} is out of range; allowed: at least the sliding friction in the same direction \
             (F_s- >= F-), {} as a displacement",
            sheet::number(value),
            sheet::number(minus)
        )));
    }
    Friction::asymmetric([o.friction_displacement(), minus], [o.static_displacement(), held])
        .map_err(in_flags)
}

/// The displacement equivalent to a force given by a flag, in the unit of displacements.
fn under_force(o: &Oscillator, unit: &str, force: f64, flag: &str, hint: &str) -> Result<f64, Failure> {
    DisplacementUnit::of_forces(unit).map_err(in_flags)?;
    o.displacement_under(force).ok_or_else(|| Failure::new(format!("{flag} needs a stiffness")).hint(hint))
}

/// Amplitude `x_0` of the base, or a force over the stiffness.
pub(super) fn base_amplitude(drive: &DriveArgs, o: &Oscillator, unit: &str) -> Result<f64, Failure> {
    let hint = "--stiffness or --mass gives it; --drive-amplitude drives the base instead";
    match (drive.drive_amplitude, drive.drive_force) {
        (None, Some(p)) => under_force(o, unit, p, "--drive-force", hint),
        // One of them is given: the group of arguments is required.
        (x, _) => Ok(x.unwrap_or_default()),
    }
}

/// The oscillator and the drive's amplitude, which `--beta` needs.
pub(super) fn driven_oscillator(
    args: &OscillatorArgs,
    drive: &DriveArgs,
    unit: &str,
) -> Result<(Oscillator, f64), Failure> {
    let oscillator = oscillator(args, unit, |o| base_amplitude(drive, o, unit))?;
    let amplitude = base_amplitude(drive, &oscillator, unit)?;
    Ok((oscillator, amplitude))
}

/// Errors of the core name parameters as its functions do; here they are renamed to flags.
pub(super) fn in_flags(error: slipfit::Error) -> Failure {
    let flags = |text: &str| {
        let mut text = text.to_owned();
        for (name, flag) in [
            ("drive frequency_hz", "--drive-frequency-hz"),
            ("drive amplitude", "--drive-amplitude"),
            (" frequency_hz", " --frequency-hz"),
            ("omega_0", "--frequency-hz"),
            ("viscous_coefficient", "--viscous"),
            ("q_factor", "--q"),
            ("friction_displacement", "--friction-displacement"),
            ("static_displacement", "--static-displacement"),
            ("coulomb_force", "--coulomb-force"),
            ("static_force", "--static-force"),
            ("sweep_time_s", "--sweep-time"),
            ("wait_s", "--wait"),
            ("rate_hz", "--rate-hz"),
        ] {
            text = text.replace(name, flag);
        }
        text
    };
    match error {
        slipfit::Error::Parameter { name, value, range } => {
            let name = flags(&format!(" {name}"));
            let name = name.trim_start();
            let name = if name.starts_with("--") || name.contains(' ') {
                name.to_owned()
            } else {
                format!("--{name}")
            };
            let value = sheet::number(value);
            Failure::new(format!("{name} = {value} is out of range; allowed: {}", flags(range)))
        }
        slipfit::Error::MissingParameter { name: "frequency_hz", .. } => {
            Failure::new(
                "the oscillator is not determined: give --frequency-hz, or two of --mass, --stiffness and \
                 --frequency-hz",
            )
        }
        slipfit::Error::MissingParameter { .. } | slipfit::Error::ConflictingParameters { .. } => {
            let text = flags(&format!(" {error}"));
            Failure::new(text.replace(" mass", " --mass").replace(" stiffness", " --stiffness").trim_start())
        }
        slipfit::Error::NeitherLengthNorAngle { .. } => Failure::new(error.to_string()).hint(
            "--unit names a length, as nm, or an angle, as rad; --friction-displacement, --static-displacement and \
             --drive-amplitude are displacements in any unit",
        ),
        _ => Failure::new(flags(&format!(" {error}")).trim_start()),
    }
}
