//! Vendor metadata that are not in the layout of a text: units, clocks and names of values.
//!
//! A text is read by its layout alone. If the program or instrument that wrote it is recognised by its first lines, the
//! information in its documentation is added. One entry per vendor.

use super::{
    dialect, igor,
    layout::{self, Layout},
};
use crate::{
    columns::{name::Name, stated},
    report::Note,
};

/// The lines above the numbers.
struct Preamble {
    /// All lines before the first row of numbers.
    lines: Vec<String>,
    /// The names of the columns as written.
    headers: Vec<String>,
}

impl Preamble {
    /// Whether a line contains a word, ignoring case.
    fn says(&self, word: &str) -> bool {
        self.lines.iter().any(|l| l.to_lowercase().contains(word))
    }

    /// The first value with this name, ignoring case: `Sweep Time,7.98 s`.
    fn value(&self, name: &str) -> Option<&str> {
        self.lines.iter().find_map(|line| {
            let (key, value) =
                line.trim_start_matches(['#', '%', '!', ' ']).split_once([',', ';', '\t', ':', '='])?;
            let key = key.trim().trim_matches('"').to_lowercase();
            key.starts_with(name).then(|| value.trim().trim_matches('"'))
        })
    }
}

/// A program or instrument: its name, whether it wrote a text, and the information that it does not write.
type Vendor = (&'static str, fn(&Preamble) -> bool, fn(&Preamble, &mut Layout));

/// Name of the vendor that writes headers of blocks among the rows.
pub(super) const LABVIEW: &str = "LabVIEW";

const VENDORS: &[Vendor] = &[
    ("Zurich Instruments LabOne", is_labone, add_labone_units),
    ("Nanonis", |p| p.lines.iter().any(|l| l == "[DATA]"), add_nanonis_values),
    (LABVIEW, |p| p.headers.first().is_some_and(|h| h == "X_Value"), add_labview_units),
    ("a Rigol oscilloscope", |p| rigol_columns(p).is_some(), add_rigol_columns),
    ("a Hantek oscilloscope", |p| p.says("#channel:") && p.value("clock").is_some(), add_hantek_step),
    ("Qualisys", |p| p.value("no_of_frames").is_some(), add_qualisys_markers),
    (igor::WRITER, |p| p.lines.first().is_some_and(|line| line == "IGOR"), |_, _| {}),
    ("Klipper", is_klipper, add_klipper_units),
    ("Moku", |p| p.lines.iter().any(|l| l.starts_with('%') && l.contains("Moku")), |_, _| {}),
    ("a spectrum analyser", is_analyser, add_analyser_axes),
    ("PASCO Capstone", is_capstone, |_, _| {}),
    ("Vernier", is_vernier, |_, _| {}),
    ("Tracker", is_tracker, add_tracker_names),
    ("phyphox", is_phyphox, |_, _| {}),
    ("Physics Toolbox", |p| p.headers.iter().any(|h| h == "gFx" || h == "TgF"), add_g),
    ("Sensor Logger", is_sensor_logger, note_sensor_kinds),
];

/// Adds the vendor's metadata to a layout; returns the vendor's name.
pub(super) fn apply(lines: &[&[u8]], layout: &mut Layout) -> Option<&'static str> {
    let above = lines[..layout.first_line.min(lines.len())].iter();
    let preamble = Preamble {
        lines: above.map(|l| layout::text(l).trim().to_owned()).collect(),
        headers: layout.head.names.iter().map(|n| n.header.clone()).collect(),
    };
    let (name, _, add) = VENDORS.iter().find(|(_, wrote, _)| wrote(&preamble))?;
    add(&preamble, layout);
    Some(name)
}

/// A header with a unit that it does not state.
fn with_unit(header: &str, unit: &str) -> Name {
    Name { unit: unit.to_owned(), ..Name::parse(header) }
}

/// `chunk;timestamp;x;y;…`, or `timestamp` below a `clockbase`: times in ticks of the instrument's clock.
fn is_labone(preamble: &Preamble) -> bool {
    let has = |name: &str| preamble.headers.iter().any(|h| h.trim_start_matches(['%', ' ']) == name);
    has("timestamp") && (has("chunk") || preamble.value("clockbase").is_some())
}

/// Ticks are converted to seconds by a clock rate, which the file may state (`clockbase`) but mostly does not.
fn add_labone_units(preamble: &Preamble, layout: &mut Layout) {
    let clock = preamble.value("clockbase").and_then(|v| v.parse::<f64>().ok()).filter(|v| *v > 0.0);
    let ticks = clock.map_or_else(|| "ticks".to_owned(), |c| format!("{c} Hz"));
    for name in &mut layout.head.names {
        let plain = name.header.trim_start_matches(['%', ' ']);
        let unit = match plain {
            "timestamp" => ticks.as_str(),
            "x" | "y" | "r" | "auxin0" | "auxin1" => "V",
            "freq" | "frequency" => "Hz",
            "phase" => "rad",
            _ => continue,
        };
        *name = with_unit(plain, unit);
    }
}

/// Accelerations in units of gravity, and their modulus.
fn add_g(_: &Preamble, layout: &mut Layout) {
    for name in &mut layout.head.names {
        if matches!(name.header.as_str(), "gFx" | "gFy" | "gFz" | "TgF") {
            *name = with_unit(&name.header, "g");
        }
    }
}

/// Every line before `[DATA]` names a value, which is text or a number.
fn add_nanonis_values(preamble: &Preamble, layout: &mut Layout) {
    layout.head.named_values = preamble
        .lines
        .iter()
        .take_while(|l| *l != "[DATA]")
        .filter_map(|l| l.split_once('\t'))
        .map(|(name, value)| (name.trim().to_owned(), value.trim().to_owned()))
        .filter(|(_, value)| !value.is_empty())
        .collect();
}

/// Units and the step are stated above the table, one per channel; the times are rounded.
fn add_labview_units(preamble: &Preamble, layout: &mut Layout) {
    let Some(separator) = dialect::separator(layout.shape.delimiter).map(char::from) else { return };
    let of_channels = |name: &str| -> Vec<String> {
        let cells = |l: &str| l.split(separator).skip(1).map(|c| c.trim().to_owned()).collect();
        let named = |l: &&String| l.split(separator).next().is_some_and(|key| key.trim() == name);
        // The last such line belongs to the rows below it.
        preamble.lines.iter().rev().find(named).map(|l| cells(l)).unwrap_or_default()
    };
    let (units, over) = (of_channels("Y_Unit_Label"), of_channels("X_Dimension"));
    let over_time = over.first().is_none_or(|d| d.is_empty() || d == "Time");
    let mut units = units.iter();
    for name in &mut layout.head.names {
        let unit = match name.header.as_str() {
            "X_Value" if over_time => "s",
            "X_Value" => continue,
            _ => units.next().map_or("", String::as_str),
        };
        if !unit.is_empty() {
            *name = with_unit(&name.header, unit);
        }
    }
    let steps = of_channels("Delta_X");
    let step = steps.first().and_then(|step| step.replace(',', ".").parse::<f64>().ok());
    layout.head.step_s = step.filter(|step| over_time && *step > 0.0 && step.is_finite());
}

/// The cells of both lines: `X,CH1,Start,Increment` over `Sequence,Volt,-1.0e-01,1.0e-04`.
fn rigol_columns(preamble: &Preamble) -> Option<Vec<(&str, &str)>> {
    let [.., names, values] = &preamble.lines[..] else { return None };
    let columns: Vec<(&str, &str)> =
        names.split(',').map(str::trim).zip(values.split(',').map(str::trim)).collect();
    let stated = |name: &str| columns.iter().any(|(n, v)| *n == name && v.parse::<f64>().is_ok());
    (names.starts_with("X,") && stated("Start") && stated("Increment")).then_some(columns)
}

/// Sample numbers, counted from the first, then the channels with their units; the step is stated beside them.
fn add_rigol_columns(preamble: &Preamble, layout: &mut Layout) {
    let Some(columns) = rigol_columns(preamble) else { return };
    let step = columns.iter().find(|(name, _)| *name == "Increment").and_then(|(_, v)| v.parse::<f64>().ok());
    let head = &mut layout.head;
    head.stated_rate_hz = step.map(|step| 1.0 / step).filter(|rate| *rate > 0.0 && rate.is_finite());
    // Removes the note on a line of numbers among words: it is read here.
    head.notes.clear();
    let channels = columns.iter().take_while(|(name, _)| *name != "Start");
    for (name, (header, unit)) in head.names.iter_mut().zip(channels) {
        *name = if *header == "X" { Name::parse(unit) } else { with_unit(header, unit) };
    }
}

/// The step is named as a clock: `#CLOCK=200.0us`.
fn add_hantek_step(preamble: &Preamble, layout: &mut Layout) {
    let step = preamble.value("clock").map(|step| format!("Sample interval={step}"));
    let stated = stated::rate_hz(step.as_deref().into_iter(), &[','], layout.shape.decimal);
    layout.head.stated_rate_hz = layout.head.stated_rate_hz.or(stated);
    if let [name] = &mut layout.head.names[..] {
        let [channel, unit] = ["channel", "units"].map(|key| preamble.value(key).unwrap_or_default());
        *name = with_unit(channel, unit);
    }
}

/// Motion capture: the rate is named as a frequency, the rows are the positions of the markers in mm.
fn add_qualisys_markers(preamble: &Preamble, layout: &mut Layout) {
    let rate = preamble.value("frequency").map(|rate| format!("Sample rate={rate}"));
    let stated = stated::rate_hz(rate.as_deref().into_iter(), &[','], layout.shape.decimal);
    layout.head.stated_rate_hz = layout.head.stated_rate_hz.or(stated);
    let markers: Vec<&str> = preamble.value("marker_names").unwrap_or_default().split('\t').collect();
    let head = &mut layout.head;
    if head.names.len() == 3 * markers.len() {
        let axes =
            markers.iter().flat_map(|marker| ["X", "Y", "Z"].map(|axis| format!("{marker} {axis} (mm)")));
        head.names = axes.map(|header| Name::parse(&header)).collect();
    }
}

/// Firmware of 3D printers: raw accelerations and their spectra.
fn is_klipper(preamble: &Preamble) -> bool {
    let headers: Vec<&str> = preamble.headers.iter().map(String::as_str).collect();
    matches!(
        headers[..],
        ["time", "accel_x", "accel_y", "accel_z", ..] | ["freq", "psd_x", "psd_y", "psd_z", ..]
    )
}

/// Raw data are in seconds and mm/s², according to Klipper's documentation.
fn add_klipper_units(_: &Preamble, layout: &mut Layout) {
    for name in &mut layout.head.names {
        let unit = match name.header.as_str() {
            "time" => "s",
            "freq" => "Hz",
            header if header.starts_with("accel_") => "mm/s^2",
            _ => continue,
        };
        *name = with_unit(&name.header, unit);
    }
    layout.head.notes.push("Klipper names no units: it writes seconds and mm/s^2".into());
}

/// Spectrum analysers of Keysight and Siglent: lines of names and values, then the trace.
fn is_analyser(preamble: &Preamble) -> bool {
    let sweep = preamble.says("sweep time") || preamble.says("swptime");
    sweep && ["span", "start freq", "rbw", "dbm"].iter().any(|word| preamble.says(word))
}

/// At zero span the first column is time, or it is missing and the spacing of the points follows from the sweep time.
fn add_analyser_axes(preamble: &Preamble, layout: &mut Layout) {
    let of = |name: &str| preamble.value(name).and_then(quantity);
    let first_of = |names: &[&str]| names.iter().find_map(|name| of(name));
    let span = of("span").or_else(|| Some(of("stop freq")? - of("start freq")?));
    let in_seconds = || preamble.value("x axis unit").is_some_and(|u| u.eq_ignore_ascii_case("s"));
    let zero_span = span == Some(0.0) || in_seconds();
    let unit = preamble.value("y axis unit").or_else(|| preamble.value("yunit"));
    let unit = unit.or_else(|| preamble.says("dbm").then_some("dBm")).unwrap_or_default();
    let trace = Name::parse(&format!("Power ({unit})"));
    let head = &mut layout.head;
    match head.names.len() {
        1 if zero_span => {
            head.names[0] = trace;
            let points = first_of(&["number of points", "points", "sweep points"]);
            match (first_of(&["sweep time", "swptime"]), points) {
                (Some(sweep_s), Some(points)) if sweep_s > 0.0 && points > 1.0 => {
                    head.rate_hz = Some((points - 1.0) / sweep_s);
                    let spaced =
                        format!("the {points} points were spaced evenly over the sweep time of {sweep_s} s");
                    head.notes.push(format!("zero span: {spaced}").into());
                }
                _ => head.notes.push("the sweep time or the number of points is missing".into()),
            }
        }
        n if n >= 2 => {
            let unnamed = |n: &Name| n.unit.is_empty();
            if unnamed(&head.names[0]) {
                head.names[0] = Name::parse(if zero_span { "Time (s)" } else { "Frequency (Hz)" });
            }
            for (i, name) in head.names.iter_mut().enumerate().skip(1).filter(|(_, n)| unnamed(n)) {
                *name = if i == 1 { trace.clone() } else { Name::parse(&format!("Trace {i} ({unit})")) };
            }
            if zero_span {
                head.notes.push("zero span: the first column was taken as time in seconds".into());
            }
        }
        _ => {}
    }
}

/// A number with a unit of time or frequency, such as `100 ms`, in s or Hz.
fn quantity(text: &str) -> Option<f64> {
    let text = text.trim();
    let end = text.find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E')).unwrap_or(text.len());
    let number: f64 = text[..end].trim().parse().ok()?;
    let factor = match text[end..].trim().to_lowercase().as_str() {
        "" | "s" | "hz" => 1.0,
        "ms" => 1e-3,
        "us" | "\u{b5}s" => 1e-6,
        "khz" => 1e3,
        "mhz" => 1e6,
        "ghz" => 1e9,
        _ => return None,
    };
    Some(number * factor).filter(|v| v.is_finite())
}

/// `Time (s) Run #1`, with several runs per file.
fn is_capstone(preamble: &Preamble) -> bool {
    let headers = preamble.headers.iter().filter(|h| !h.is_empty());
    let tagged = headers.clone().filter(|h| h.contains("Run #")).count();
    tagged > 0 && tagged * 2 >= headers.count()
}

/// Logger Pro and Graphical Analysis: `Latest: Time (s)`, with further runs in further groups of columns.
fn is_vernier(preamble: &Preamble) -> bool {
    let of_a_set = |h: &String| {
        let h = h.to_lowercase();
        h.starts_with("latest:") || h.starts_with("data set") || h.starts_with("run ") && h.contains(':')
    };
    !preamble.headers.is_empty() && preamble.headers.iter().all(of_a_set)
}

/// Video analysis: names of the tracks above `t x y …`, blanks for missing marks.
fn is_tracker(preamble: &Preamble) -> bool {
    let names: Vec<String> = preamble.headers.iter().map(|h| h.trim().to_lowercase()).collect();
    let letters = names.iter().all(|n| n.is_empty() || n.chars().count() <= 5 && !n.contains(['(', '[']));
    let marked = preamble.says("#multi:") || preamble.says("mass ");
    names.first().is_some_and(|n| n == "t") && letters && marked
}

/// Times are in seconds, lengths in the unit of the calibration; the file does not state whether angles are in degrees
/// or radians.
fn add_tracker_names(preamble: &Preamble, layout: &mut Layout) {
    const ANGLES: &[&str] = &["θ", "θr", "θv", "θa", "φ", "ϕ", "theta"];
    name_tracks(preamble, layout);
    let mut angle = false;
    for name in &mut layout.head.names {
        if name.bare == "t" {
            name.unit = "s".to_owned();
        }
        angle |= ANGLES.contains(&name.bare.to_lowercase().as_str());
    }
    let text = "Tracker writes no units: times were taken as seconds, lengths as the unit of its calibration";
    let note = Note::new(text);
    layout.head.notes.push(if angle {
        note.hint("unit", "says whether its angles are degrees or radians (deg or rad)")
    } else {
        note
    });
}

/// Writes the name of the track before the names of its columns.
fn name_tracks(preamble: &Preamble, layout: &mut Layout) {
    let Some(header) = layout.header_line else { return };
    let above = preamble.lines.get(..header).and_then(|l| l.iter().rev().find(|l| !l.is_empty()));
    let separator = dialect::separator(layout.shape.delimiter).map(char::from);
    let (Some(above), Some(separator)) = (above, separator) else { return };
    let tracks: Vec<&str> = above.trim_start_matches("#multi:").split(separator).map(str::trim).collect();
    if tracks.iter().filter(|t| !t.is_empty()).count() < 2 {
        return;
    }
    let mut current = "";
    for (i, name) in layout.head.names.iter_mut().enumerate() {
        current = tracks.get(i).copied().filter(|t| !t.is_empty()).unwrap_or(current);
        if name.bare != "t" && !current.is_empty() {
            let parsed = Name::parse(&name.header);
            *name = Name { header: format!("{current}: {}", parsed.header), ..parsed };
        }
    }
}

/// `time` in nanoseconds since 1970, `seconds_elapsed`, and the axes of one sensor.
fn is_sensor_logger(preamble: &Preamble) -> bool {
    let has = |name: &str| preamble.headers.iter().any(|header| header == name);
    preamble.headers.len() > 2 && has("time") && has("seconds_elapsed")
}

/// The file name identifies the sensor, the columns do not.
fn note_sensor_kinds(_: &Preamble, layout: &mut Layout) {
    let known = ["time", "seconds_elapsed", "x", "y", "z"];
    if layout.head.names.iter().all(|name| known.contains(&name.header.as_str())) {
        let text = "Sensor Logger names no units: accelerometers are in m/s^2 or g, gyroscopes in rad/s";
        let kind = "says which this is (acceleration, velocity) where the name of the file does not";
        layout.head.notes.push(Note::new(text).hint("kind", kind).hint("unit", "names the unit"));
    }
}

/// Quoted headers with units in brackets, numbers such as `0.000000000E0`, in five dialects.
fn is_phyphox(preamble: &Preamble) -> bool {
    let header = preamble.lines.last().map(String::as_str).unwrap_or_default();
    header.starts_with("\"Time (s)\"") && preamble.headers.iter().all(|h| h.ends_with(')'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_carry_their_prefix() {
        for (text, value) in [("0.1", 0.1), ("100 ms", 0.1), ("1e9", 1e9), ("2.4GHz", 2.4e9), ("0 Hz", 0.0)] {
            assert_eq!(quantity(text), Some(value), "{text}");
        }
        assert_eq!(quantity("10 dB"), None);
    }
}
