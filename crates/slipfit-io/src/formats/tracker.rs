//! Projects of the video analysis program Tracker (.trk): marked points in XML.

use quick_xml::{Reader, events::Event};

use crate::{
    columns::head::Head, error::ReadProblem, format::Format, report::Note, tables::table::LoadedTables,
};

/// Maximum depth of nested properties.
const DEEPEST: usize = 64;
/// Maximum number of frames of a video.
const MOST_FRAMES: usize = 1 << 24;

/// A property: its name, the class of its object, its text and its inner properties.
#[derive(Debug, Default)]
struct Property {
    name: String,
    class: String,
    text: String,
    inner: Vec<Property>,
}

impl Property {
    fn named(&self, name: &str) -> Option<&Self> {
        self.inner.iter().find(|p| p.name == name)
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.named(name)?.text.trim().parse().ok().filter(|v: &f64| v.is_finite())
    }

    /// The first property of a name, at any depth.
    fn anywhere(&self, name: &str) -> Option<&Self> {
        self.inner.iter().find_map(|p| if p.name == name { Some(p) } else { p.anywhere(name) })
    }

    /// All objects of a class, at any depth.
    fn of_class<'a>(&'a self, class: &str, found: &mut Vec<&'a Self>) {
        for p in &self.inner {
            if p.class.ends_with(class) {
                found.push(p);
            }
            p.of_class(class, found);
        }
    }
}

/// Conversion of pixels of the video to lengths, and of frames to times.
struct Scale {
    origin: [f64; 2],
    pixels: [f64; 2],
    angle: f64,
    frame_s: f64,
    start: f64,
}

impl Scale {
    fn of(root: &Property) -> Self {
        let coords = root.anywhere("coords");
        let frame = coords.and_then(|c| c.anywhere("[0]")).or(coords);
        let of = |name: &str, default: f64| frame.and_then(|f| f.number(name)).unwrap_or(default);
        let frame_ms = root.anywhere("delta_t").and_then(|p| p.text.trim().parse().ok());
        let usable = |v: f64| if v != 0.0 { v } else { 1.0 };
        Self {
            origin: [of("xorigin", 0.0), of("yorigin", 0.0)],
            pixels: [usable(of("xscale", 1.0)), usable(of("yscale", 1.0))],
            angle: of("angle", 0.0).to_radians(),
            frame_s: frame_ms.filter(|v: &f64| *v > 0.0).unwrap_or(1000.0 / 30.0) / 1000.0,
            start: root.anywhere("startframe").and_then(|p| p.text.trim().parse().ok()).unwrap_or(0.0),
        }
    }

    /// From video coordinates, whose y axis points down, to the drawn axes.
    fn world(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.origin[0], self.origin[1] - y);
        let (sin, cos) = self.angle.sin_cos();
        [(dx * cos + dy * sin) / self.pixels[0], (dy * cos - dx * sin) / self.pixels[1]]
    }
}

/// Whether a text begins like a project.
pub(crate) fn fits(head: &[u8]) -> bool {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    text.starts_with(b"<?xml") && memchr::memmem::find(head, b"cabrillo.tracker").is_some()
}

/// One table per point mass of the project.
pub(crate) fn tables(bytes: &[u8]) -> Result<LoadedTables, ReadProblem> {
    let text = String::from_utf8_lossy(bytes);
    let root = parse(&text)?;
    let scale = Scale::of(&root);
    let mut masses = Vec::new();
    root.of_class("PointMass", &mut masses);
    let mut tables = LoadedTables::default();
    for (i, mass) in masses.into_iter().enumerate() {
        let name = mass.named("name").map(|n| n.text.trim().to_owned()).filter(|n| !n.is_empty());
        let Some(frames) = mass.named("framedata") else { continue };
        let mut points: Vec<(usize, [f64; 2])> = frames
            .inner
            .iter()
            .filter_map(|f| {
                // The index in the list is the frame; older projects write it as n.
                let index = f.name.trim_matches(['[', ']']).parse().ok();
                let frame = index.or_else(|| f.number("n").map(|n| n.max(0.0) as usize))?;
                Some((frame, [f.number("x")?, f.number("y")?]))
            })
            .filter(|(frame, _)| *frame < MOST_FRAMES)
            .collect();
        points.sort_by_key(|(frame, _)| *frame);
        if points.len() < 2 {
            continue;
        }
        let time = points.iter().map(|(n, _)| (*n as f64 - scale.start) * scale.frame_s).collect();
        let world: Vec<[f64; 2]> = points.iter().map(|(_, p)| scale.world(*p)).collect();
        let angle = world.iter().map(|[x, y]| y.atan2(*x)).collect();
        let head = Head {
            name: name.unwrap_or_else(|| format!("track {}", i + 1)),
            notes: vec![
                Note::new(
                    "x and y are in the unit of the project's calibration, which Tracker takes for metres",
                )
                .hint("unit", "names another"),
            ],
            ..Head::of(["t (s)", "x", "y", "angle of the position (rad)"])
        };
        let columns =
            vec![time, world.iter().map(|p| p[0]).collect(), world.iter().map(|p| p[1]).collect(), angle];
        tables.push(head, columns, Vec::new());
    }
    if tables.is_empty() {
        return Err(Format::Tracker.broken("no point mass in it has marked positions"));
    }
    Ok(tables)
}

/// The tree of properties.
fn parse(text: &str) -> Result<Property, ReadProblem> {
    let mut reader = Reader::from_str(text);
    let mut open = vec![Property::default()];
    loop {
        let event = match reader.read_event() {
            Ok(event) => event,
            // A truncated project is read as far as it goes.
            Err(_) => Event::Eof,
        };
        match event {
            Event::Start(tag) | Event::Empty(tag) if open.len() > DEEPEST => {
                return Err(
                    Format::Tracker.broken(format!("more than {DEEPEST} levels at <{:?}>", tag.name()))
                );
            }
            Event::Start(tag) => {
                let attribute = |wanted: &str| {
                    tag.attributes()
                        .flatten()
                        .find(|a| a.key.as_ref() == wanted)
                        .map(|a| a.value.into_owned())
                };
                if tag.name().as_ref() == "object" {
                    // The object is the value of the property around it.
                    if let (Some(last), Some(class)) = (open.last_mut(), attribute("class"))
                        && last.class.is_empty()
                    {
                        last.class = class;
                    }
                } else {
                    let name = attribute("name").unwrap_or_default();
                    open.push(Property { name, ..Property::default() });
                }
            }
            Event::Text(piece) => {
                if let Some(last) = open.last_mut() {
                    last.text += &piece;
                }
            }
            Event::End(tag) if tag.name().as_ref() != "object" => close(&mut open),
            Event::Eof => break,
            _ => {}
        }
    }
    while open.len() > 1 {
        close(&mut open);
    }
    open.pop().ok_or_else(|| Format::Tracker.broken("no properties"))
}

fn close(open: &mut Vec<Property>) {
    if open.len() > 1
        && let Some(done) = open.pop()
        && let Some(parent) = open.last_mut()
    {
        parent.inner.push(done);
    }
}
