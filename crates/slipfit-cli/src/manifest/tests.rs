//! What a manifest may contain, and what is refused.

use super::*;

fn read(text: &str) -> Result<Manifest, String> {
    parse(text, Path::new("data")).map_err(|problem| problem.in_text(text))
}

#[test]
fn a_manifest_is_read() {
    let m = read(
        r#"
        title = "Pohl wheel"
        condition = "brake current"
        condition_unit = "mA"
        shared = ["natural_frequency", "drive_amplitude"]
        torsion_stiffness = "0.02±0.001"
        [[measurement]]
        ringdown = "a.csv"
        condition = 400
        start = 1.5
        band = [0.3, 0.9]
        model = "viscous+sliding"
        signal = 3
        run = 2
        [[measurement]]
        name = "swept"
        sweep = ["b.csv", "c.csv"]
        condition = "0.4(1) A"
        reference = "free.csv"
        model = ["paper", "viscous"]
        [[measurement]]
        levels = "d.csv"
        condition = "wet"
        value = "-2±0.5"
        scale = 1e-3
        "#,
    )
    .unwrap();
    assert!(matches!(m.calibration, Some((Calibration::Stiffness { .. }, Coordinate::Angle))));
    assert!(m.shared.natural_frequency);
    assert!(!m.shared.decay_rate);
    assert_eq!(m.entries[0].condition, Condition { label: "400 mA".into(), value: Some([400.0, 0.0]) });
    let Source::Ringdown { file, reading, options } = &m.entries[0].source else { panic!() };
    assert_eq!(file, Path::new("data/a.csv"));
    assert_eq!((options.start_s, options.band_hz), (Some(1.5), Some([0.3, 0.9])));
    assert_eq!((reading.signal.as_deref(), reading.run), (Some("3"), Some(2)));
    assert_eq!((m.entries[0].name.as_str(), m.entries[1].name.as_str()), ("a.csv", "swept"));
    let Source::Sweep { files, reference, options, .. } = &m.entries[1].source else { panic!() };
    assert_eq!(files.len(), 2);
    assert_eq!(reference.as_deref(), Some(Path::new("data/free.csv")));
    assert_eq!(options.method, slipfit::resonance::Method::Paper);
    assert_eq!(options.model.map(|m| m.name()), Some("viscous"));
    assert!(m.entries[1].notes[0].contains("--response paper"), "{:?}", m.entries[1].notes);
    // In the unit of the series.
    assert_eq!(m.entries[1].condition.value, Some([400.0, 100.0]));
    assert_eq!(m.entries[2].condition, Condition { label: "wet".into(), value: Some([-2.0, 0.5]) });
    assert_eq!(m.entries[2].scale, Some(1e-3));
}

/// The numbers of the conditions of a manifest, and their unit.
fn conditions(head: &str, each: &[&str]) -> Result<(Vec<Option<f64>>, String), String> {
    let measurements: Vec<String> =
        each.iter().map(|keys| format!("[[measurement]]\nringdown = 'a'\n{keys}\n")).collect();
    let m = read(&format!("{head}\n{}", measurements.concat()))?;
    Ok((m.entries.iter().map(|e| e.condition.value.map(|v| v[0])).collect(), m.condition_unit))
}

/// Numbers of one column: 0.1 N and 200 mN were once read as 0.1 and 200, and a current without `condition_unit`
/// as a load.
#[test]
fn labels_are_brought_to_one_unit() {
    let all = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
    let mixed = ["condition = '0.5 N'", "condition = '250 mN'", "condition = '1 kN'"];
    assert_eq!(conditions("", &mixed).unwrap(), (all(&[0.5, 0.25, 1000.0]), "N".into()));
    assert_eq!(
        conditions("condition_unit = 'mN'", &mixed).unwrap(),
        (all(&[500.0, 250.0, 1e6]), "mN".into())
    );
    let current = ["condition = '100 mA'", "condition = '200 mA'"];
    assert_eq!(conditions("", &current).unwrap(), (all(&[100.0, 200.0]), "mA".into()));
    let names = ["condition = '2 thin'", "condition = '3 thick'", "condition = 'wet'"];
    assert_eq!(conditions("", &names).unwrap(), (vec![None; 3], String::new()));
    // A number in quotes is a number.
    let m = read("condition_unit = 'N'\n[[measurement]]\nringdown = 'a'\ncondition = '2'\n").unwrap();
    assert_eq!(m.entries[0].condition, Condition { label: "2 N".into(), value: Some([2.0, 0.0]) });
    for (head, each, word) in [
        (
            "condition_unit = 'N'",
            ["condition = 1", "condition = '400 mA'"],
            "measurement 2: condition = \"400 mA\" is not in N",
        ),
        ("", ["condition = '1 N'", "condition = 2"], "measurement 2: condition = 2 has no unit"),
        (
            "",
            ["condition = 'a'\nvalue = 1", "condition = 'a'\nvalue = 2"],
            "measurement 2: condition \"a\" has another value",
        ),
    ] {
        let said = conditions(head, &each).unwrap_err();
        assert!(said.contains(word), "{said}");
    }
}

#[test]
fn what_cannot_be_meant_is_said() {
    for (text, word) in [
        ("", "no [[measurement]]"),
        ("[[measurements]]\nringdown = 'a'\n", "unknown key `measurements`; did you mean `measurement`?"),
        ("[[measurement]]\nringdwn = 'a'\n", "`ringdwn`: did you mean `ringdown`?"),
        ("[[measurement]]\nfile = 'a'\n", "; `file` does not say of what the file is"),
        ("stifness = 3\n", "unknown key `stifness`; did you mean `stiffness`?"),
        ("[[measurement]]\ncondition = 1\n", "give one of the keys ringdown, sweep or levels"),
        ("[[measurement]]\nringdown = 'a'\nsweep = 'b'\n", "exclude"),
        (
            "[[measurement]]\nringdown = 'a'\n  bamd = [1, 2]\n",
            "line 3, column 3: measurement 1: unknown key `bamd`; did you mean `band`?",
        ),
        ("[[measurement]]\nlevels = 'a'\nband = [1, 2]\n", "unknown key `band`"),
        (
            "[[measurement]]\nringdown = 'a'\nrate_hz = -1\n",
            "line 3, column 11: measurement 1: -1: must be above zero",
        ),
        ("[[measurement]]\nlevels = 'a'\nq = 3\ndrive_gain = 2\n", "exclude each other"),
        ("measurement = 3\n", "line 1, column 15"),
        ("[[measurement]]\nringdown = 'a'\nstart = 'soon'\n", "soon"),
        ("[[measurement]]\nringdown = 'a'\nplot = 'x.svg'\n", "command line"),
        ("[[measurement]]\nringdown = 'a'\nmass = 3\n", "above the measurements"),
        ("mass = 1\nstiffness = 2\n[[measurement]]\nringdown = 'a'\n", "both given"),
        ("mass = -1\n[[measurement]]\nringdown = 'a'\n", "above zero"),
        ("shared = ['colour']\n[[measurement]]\nringdown = 'a'\n", "`colour` cannot be shared"),
        ("[[measurement]]\nringdown = 'a'\nscale = -1\n", "scale"),
        ("[[measurement\n", "line 1"),
    ] {
        let said = read(text).unwrap_err();
        assert!(said.contains(word), "{text}: {said}");
    }
}

/// Checks that what can be typed and what can be written are the fields of one structure.
fn agrees<T: clap::Args + for<'de> Deserialize<'de>>() {
    let command = T::augment_args(clap::Command::new("test"));
    let mut typed = Vec::new();
    for arg in command.get_arguments() {
        typed.push(arg.get_id().as_str().to_owned());
        let aliases = arg.get_all_aliases().unwrap_or_default();
        typed.extend(aliases.into_iter().map(|alias| alias.replace('-', "_")));
    }
    let mut written: Vec<String> = keys::fields::<T>().iter().map(|&f| f.to_owned()).collect();
    typed.sort();
    written.sort();
    assert_eq!(typed, written);
    assert!(!typed.is_empty());
}

#[test]
fn keys_are_flags() {
    agrees::<ReadingArgs>();
    agrees::<RingdownAnalysisArgs>();
    agrees::<CurveArgs>();
    agrees::<ResonanceAnalysisArgs>();
    agrees::<LevelReadingArgs>();
    agrees::<LevelAnalysisArgs>();
}

/// Fills `T` with every key that can be written.
fn full<T: for<'de> Deserialize<'de>>() -> T {
    let text: String = keys::fields::<T>()
        .iter()
        .filter(|key| !["variable", "group", "track", "center_hz"].contains(key))
        .map(|key| match *key {
            "band" => "band = [1, 2]\n".to_owned(),
            "model" => "model = \"viscous\"\n".to_owned(),
            "law" => "law = \"free\"\n".to_owned(),
            "response" => "response = \"paper\"\n".to_owned(),
            "kind" => "kind = \"velocity\"\n".to_owned(),
            "format" => "format = \"text\"\n".to_owned(),
            "background" | "delay" | "amplitude_offset" | "noise_floor" | "phase_offset" | "duffing" => {
                format!("{key} = \"on\"\n")
            }
            key => format!("{key} = 3\n"),
        })
        .collect();
    toml::from_str(&text).unwrap()
}

/// Every option of the libraries can be set, except those that only the command line or another file sets.
#[test]
fn keys_reach_every_option() {
    // Records, curves and levels each use their own part of the same options.
    let unreached = |options: ReadOptions| -> Vec<String> {
        let text = format!("{options:?}");
        text.split([',', '{']).filter_map(|f| Some(f.trim().strip_suffix(": None")?.to_owned())).collect()
    };
    let [curve, levels] =
        [full::<CurveArgs>().options(), full::<LevelReadingArgs>().options()].map(unreached);
    let record = unreached(full::<ReadingArgs>().options());
    let nowhere: Vec<_> = record.iter().filter(|f| curve.contains(f) && levels.contains(f)).collect();
    assert!(nowhere.is_empty(), "{nowhere:?}");
    for (options, elsewhere) in [
        (format!("{:?}", full::<RingdownAnalysisArgs>().options()), vec!["calibration: None"]),
        (
            format!("{:?}", full::<ResonanceAnalysisArgs>().options()),
            vec!["reference: None", "calibration: None"],
        ),
        (format!("{:?}", full::<LevelAnalysisArgs>().options()), vec!["calibration: None"]),
    ] {
        let rest = elsewhere.iter().fold(options.clone(), |text, option| text.replace(option, ""));
        assert!(!rest.contains("None"), "{options}");
    }
}
