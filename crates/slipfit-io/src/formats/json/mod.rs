//! JSON: lists of rows, lists of objects, objects of lists, nested or one per line.
//!
//! Each table is written out as text, so that its header, units, stamps and numbers are read like those of any table.

mod parse;

use std::{collections::HashMap, fmt::Write as _};

use self::parse::{Node, parse};
use crate::{
    error::ReadProblem,
    format::Format,
    tables::{arrays::NamedValues, table::LoadedTables, text},
};

/// Maximum length of a list whose elements are columns of one row.
const WIDEST: usize = 64;
/// Lists of values inside the elements of a list form separate tables for at most this number of elements.
const MOST_PLACES: usize = 64;
/// The field that names the sensor of a row, as written by Sensor Logger.
const SENSOR: &str = "sensor";
/// Maximum number of columns of a table.
const MOST_COLUMNS: usize = 4096;

/// Cells of a table: a header if there is one, and its rows.
struct Grid<'a> {
    name: String,
    /// Its path in the document.
    place: String,
    header: Option<Vec<String>>,
    rows: Vec<Vec<Option<&'a Node>>>,
}

/// Results of the search.
#[derive(Default)]
struct Found<'a> {
    grids: Vec<Grid<'a>>,
    named: NamedValues,
    /// Number of values that belong to no table, and the place of the first.
    left_out: usize,
    first_left_out: Option<String>,
}

/// The tables of a text.
pub(crate) fn tables(bytes: &[u8]) -> Result<LoadedTables, ReadProblem> {
    let mut values = parse(bytes).map_err(|problem| Format::Json.broken(problem))?;
    let root = if values.len() == 1 { values.remove(0) } else { Node::List(values) };
    let mut found = Found::default();
    found.look(&root, "");
    let mut tables = LoadedTables::default();
    tables.must_choose = true;
    let mut problems = Vec::new();
    for grid in &found.grids {
        let held = grid.text().and_then(|text| text::load_tables(text.as_bytes()).map_err(|e| e.to_string()));
        match held {
            Ok(mut several) => {
                for held in &mut several {
                    held.dialect = None;
                    held.head.named_values.extend(found.named_from(&grid.place));
                    held.head.has_variables = matches!(root, Node::Object(_));
                    if grid.header().is_some() {
                        held.skipped.iter_mut().for_each(|skipped| skipped.first_row -= 1);
                    }
                }
                tables.absorb(several, &grid.name);
            }
            Err(problem) => problems.push(match &*grid.name {
                "" => problem,
                name => format!("`{name}`: {problem}"),
            }),
        }
    }
    if tables.is_empty() {
        let reason =
            if problems.is_empty() { "it holds no list of numbers".to_owned() } else { problems.join("; ") };
        return Err(ReadProblem::Without { format: Format::Json, reason });
    }
    if let Some(first) = found.first_left_out {
        problems.push(format!(
            "{} values that make no table were left out, the first at `{first}`",
            found.left_out
        ));
    }
    tables.note_all(&problems);
    Ok(tables)
}

fn is_scalar(node: &Node) -> bool {
    matches!(node, Node::Missing | Node::Number(_) | Node::Text(_))
}

/// A list of scalars, or an object of scalars by index, as pandas writes a column.
fn column(node: &Node) -> Option<Vec<&Node>> {
    let values: Vec<&Node> = match node {
        Node::List(values) => values.iter().collect(),
        Node::Object(entries) if entries.len() > 1 && entries.iter().all(|(key, _)| is_index(key)) => {
            entries.iter().map(|(_, value)| value).collect()
        }
        _ => return None,
    };
    (values.len() > 1 && values.iter().all(|value| is_scalar(value))).then_some(values)
}

fn is_index(key: &str) -> bool {
    !key.is_empty() && key.bytes().all(|b| b.is_ascii_digit())
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

/// Names of columns, and rows: `columns` and `data` of pandas, `columns` and `values` of InfluxDB.
fn frame(entries: &[(String, Node)]) -> Option<(Vec<String>, &[Node])> {
    let of = |wanted: &str| entries.iter().find(|(key, _)| key == wanted).map(|(_, value)| value);
    let (Node::List(names), Node::List(rows)) = (of("columns")?, of("data").or_else(|| of("values"))?) else {
        return None;
    };
    let names = names
        .iter()
        .map(|n| if let Node::Text(n) = n { Some(n.clone()) } else { None })
        .collect::<Option<_>>()?;
    let is_row = |row: &Node| matches!(row, Node::List(cells) if cells.iter().all(is_scalar));
    rows.iter().all(is_row).then_some((names, rows))
}

/// Whether an object is more than a row: it or its objects contain long lists, or a table with names.
fn holds_table(node: &Node) -> bool {
    match node {
        Node::Object(entries) => {
            frame(entries).is_some()
                || entries
                    .iter()
                    .any(|(_, value)| holds_table(value) || column(value).is_some_and(|c| c.len() > WIDEST))
        }
        Node::List(values) => values.len() > WIDEST || values.iter().any(holds_table),
        _ => false,
    }
}

/// The header of a column; for the samples of a channel, the name and the unit given next to them.
fn header(key: &str, entries: &[(String, Node)]) -> String {
    const SAMPLES: [&str; 6] = ["samples", "sample", "values", "value", "data", "signal"];
    let of = |wanted: [&str; 3]| {
        entries.iter().find_map(|(key, value)| match value {
            Node::Text(text) if wanted.contains(&key.to_lowercase().as_str()) && !text.is_empty() => {
                Some(text.as_str())
            }
            _ => None,
        })
    };
    let is_samples = |key: &str| SAMPLES.contains(&key.to_lowercase().as_str());
    let alone = entries.iter().filter(|(key, value)| is_samples(key) && column(value).is_some()).count() == 1;
    if !is_samples(key) || !alone {
        return key.to_owned();
    }
    let name = of(["name", "label", "channel"]).unwrap_or(key);
    of(["unit", "units", "uom"]).map_or_else(|| name.to_owned(), |unit| format!("{name} ({unit})"))
}

impl<'a> Found<'a> {
    fn look(&mut self, node: &'a Node, path: &str) {
        match node {
            Node::Object(entries) => self.object(entries, path),
            Node::List(elements) => self.list(elements, path),
            _ => self.leave_out(path),
        }
    }

    fn name(&mut self, path: &str, key: &str, value: String) {
        self.named.push((path.to_owned(), key.to_owned(), value));
    }

    /// All named values, those nearest to a place first: each channel may name its own rate.
    fn named_from(&self, place: &str) -> impl Iterator<Item = (String, String)> {
        let holds = |around: &str| {
            let rest = place.strip_prefix(around);
            around.is_empty() || rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let mut named: Vec<(usize, &str, &str)> = Vec::new();
        for (around, name, value) in &self.named {
            named.push((if holds(around) { usize::MAX - around.len() } else { usize::MAX }, name, value));
        }
        named.sort_by_key(|(far, ..)| *far);
        let named: Vec<_> =
            named.iter().map(|(_, name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        named.into_iter()
    }

    fn leave_out(&mut self, path: &str) {
        self.left_out += 1;
        let place = if path.is_empty() { "the beginning" } else { path };
        self.first_left_out.get_or_insert_with(|| place.to_owned());
    }

    /// Lists of equal length in an object are columns of one table; numbers and words are named values.
    fn object(&mut self, entries: &'a [(String, Node)], path: &str) {
        if let Some((names, rows)) = frame(entries) {
            return self.matrix(rows, path, Some(names));
        }
        let mut columns: Vec<(&str, Vec<&'a Node>)> = Vec::new();
        for (key, value) in entries {
            match (value, column(value)) {
                (_, Some(values)) => columns.push((key, values)),
                (Node::Number(number), _) => self.name(path, key, number.to_string()),
                (Node::Text(words), _) => self.name(path, key, words.clone()),
                (Node::Missing, _) => {}
                _ => self.look(value, &join(path, key)),
            }
        }
        while let Some((_, first)) = columns.first() {
            let length = first.len();
            let (together, others): (Vec<_>, Vec<_>) =
                columns.into_iter().partition(|(_, values)| values.len() == length);
            columns = others;
            for together in together.chunks(MOST_COLUMNS) {
                let header: Vec<String> = together.iter().map(|(key, _)| header(key, entries)).collect();
                let rows = (0..length)
                    .map(|row| together.iter().map(|(_, values)| Some(values[row])).collect())
                    .collect();
                let name =
                    if path.is_empty() { header[..header.len().min(3)].join(", ") } else { path.to_owned() };
                self.grids.push(Grid { name, place: path.to_owned(), header: Some(header), rows });
            }
        }
    }

    fn list(&mut self, elements: &'a [Node], path: &str) {
        let lists =
            || elements.iter().filter_map(|e| if let Node::List(cells) = e { Some(cells) } else { None });
        let objects = elements.iter().filter(|e| matches!(e, Node::Object(_))).count();
        if elements.is_empty() {
        } else if elements.iter().all(is_scalar) {
            let rows = elements.iter().map(|value| vec![Some(value)]).collect();
            self.grids.push(Grid { name: path.to_owned(), place: path.to_owned(), header: None, rows });
        } else if objects == elements.len() && !elements.iter().any(holds_table) {
            if !self.sensors(elements, path) {
                self.records(&elements.iter().collect::<Vec<_>>(), path, None);
            }
        } else if lists().count() == elements.len() && lists().flatten().all(is_scalar) {
            self.matrix(elements, path, None);
        } else if elements.len() <= MOST_PLACES {
            for (i, element) in elements.iter().enumerate() {
                self.look(element, &join(path, &(i + 1).to_string()));
            }
        } else {
            elements.iter().for_each(|_| self.leave_out(path));
        }
    }

    /// Lists in a list: rows, or columns if each is longer than their number.
    fn matrix(&mut self, lists: &'a [Node], path: &str, header: Option<Vec<String>>) {
        let cells: Vec<&'a [Node]> = lists
            .iter()
            .filter_map(|e| if let Node::List(cells) = e { Some(&cells[..]) } else { None })
            .collect();
        let length = cells.first().map_or(0, |first| first.len());
        let along = header.is_none() && cells.iter().all(|c| c.len() == length) && length > cells.len();
        let rows: Vec<Vec<Option<&'a Node>>> = if along {
            (0..length).map(|row| cells.iter().map(|column| column.get(row)).collect()).collect()
        } else {
            cells.iter().map(|row| row.iter().map(Some).collect()).collect()
        };
        self.grids.push(Grid { name: path.to_owned(), place: path.to_owned(), header, rows });
    }

    /// Successive rows of several sensors, distinguished by a field, become one table per sensor.
    fn sensors(&mut self, elements: &'a [Node], path: &str) -> bool {
        let sensor = |element: &'a Node| match element {
            Node::Object(entries) => entries.iter().find_map(|(key, value)| match value {
                Node::Text(name) if key.eq_ignore_ascii_case(SENSOR) => Some(name.as_str()),
                _ => None,
            }),
            _ => None,
        };
        let Some(names) = elements.iter().map(sensor).collect::<Option<Vec<&str>>>() else { return false };
        let mut places: HashMap<&str, usize> = HashMap::new();
        let mut groups: Vec<Vec<&'a Node>> = Vec::new();
        for (name, element) in names.iter().zip(elements) {
            let place = *places.entry(*name).or_insert(groups.len());
            if place == groups.len() {
                groups.push(Vec::new());
            }
            groups[place].push(element);
        }
        if groups.len() > MOST_PLACES {
            return false;
        }
        for group in groups {
            match group[..] {
                // Information given only once, such as the version of a program.
                [one] => self.look(one, path),
                _ => self.records(&group, &join(path, sensor(group[0]).unwrap_or_default()), Some(SENSOR)),
            }
        }
        true
    }

    /// Objects in a list: rows of named cells, except the field `without`.
    fn records(&mut self, elements: &[&'a Node], path: &str, without: Option<&str>) {
        let mut header: Vec<String> = Vec::new();
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut rows = Vec::with_capacity(elements.len());
        for element in elements {
            let mut cells = Vec::new();
            self.cells(element, "", &mut cells);
            let mut row = Vec::with_capacity(header.len());
            cells.retain(|(name, _)| without.is_none_or(|without| !name.eq_ignore_ascii_case(without)));
            for (name, value) in cells {
                let place = match places.get(&name) {
                    Some(place) => *place,
                    None if header.len() < MOST_COLUMNS => {
                        places.insert(name.clone(), header.len());
                        header.push(name);
                        header.len() - 1
                    }
                    None => {
                        self.leave_out(&join(path, &name));
                        continue;
                    }
                };
                if row.len() <= place {
                    row.resize(place + 1, None);
                }
                row[place] = Some(value);
            }
            rows.push(row);
        }
        self.grids.push(Grid { name: path.to_owned(), place: path.to_owned(), header: Some(header), rows });
    }

    /// The scalars of a row, with their names: `acc.x`, `v 1`.
    fn cells(&mut self, node: &'a Node, name: &str, cells: &mut Vec<(String, &'a Node)>) {
        match node {
            Node::Object(entries) => {
                entries.iter().for_each(|(key, value)| self.cells(value, &join(name, key), cells))
            }
            Node::List(values) if values.len() <= WIDEST => {
                for (i, value) in values.iter().enumerate() {
                    self.cells(value, &format!("{name} {}", i + 1), cells);
                }
            }
            Node::List(_) => self.leave_out(name),
            scalar => cells.push((name.to_owned(), scalar)),
        }
    }
}

impl Grid<'_> {
    /// The names above the rows; numbers in their place would be a row.
    fn header(&self) -> Option<&Vec<String>> {
        self.header.as_ref().filter(|names| names.iter().all(|name| name.parse::<f64>().is_err()))
    }

    /// One line per row with tabs between cells, or the reason why this is not possible.
    fn text(&self) -> Result<String, String> {
        let width = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let cells: usize = self.rows.iter().map(|row| row.iter().flatten().count()).sum();
        // Rows with hardly any common names would take far more memory than their content.
        if self.rows.len() * width > 64 * cells + (1 << 16) {
            let rows = self.rows.len();
            return Err(format!("its {cells} values are scattered over {rows} rows and {width} columns"));
        }
        let words = |text: &mut String, words: &str| {
            text.extend(words.chars().map(|c| if c.is_control() { ' ' } else { c }))
        };
        let mut text = String::with_capacity(16 * cells);
        if let Some(header) = self.header() {
            for (i, name) in header.iter().enumerate() {
                text.push_str(if i > 0 { "\t" } else { "" });
                words(&mut text, name);
            }
            text.push('\n');
        }
        for row in &self.rows {
            for i in 0..width {
                text.push_str(if i > 0 { "\t" } else { "" });
                match row.get(i).copied().flatten() {
                    // Writing to a String cannot fail. The shortest form reads back exactly.
                    Some(Node::Number(value)) => {
                        let _ = write!(text, "{value:?}");
                    }
                    Some(Node::Text(cell)) => words(&mut text, cell),
                    _ => {}
                }
            }
            text.push('\n');
        }
        Ok(text)
    }
}
