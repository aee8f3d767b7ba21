//! Named arrays of MATLAB, NumPy and HDF5 files, joined to tables.

use crate::{columns::head::Head, tables::table::LoadedTables};

/// Maximum number of columns of a table: a wider matrix is not a table.
const MOST_COLUMNS: usize = 4096;

/// An array that will become part of a table.
#[derive(Debug, Clone, Default)]
pub(crate) struct Array {
    /// The struct, group or archive that contains it; empty at the top level.
    pub(crate) parent: String,
    /// Its own name.
    pub(crate) name: String,
    /// Its unit, if the file states one.
    pub(crate) unit: String,
    /// Values that the file names for this array only.
    pub(crate) named: Vec<(String, String)>,
    /// Columns of equal length.
    pub(crate) columns: Vec<Vec<f64>>,
}

impl Array {
    /// A vector, or a matrix whose longer side is the time axis. The first index of `values` varies fastest if
    /// `first_fastest`. `None` for other shapes.
    pub(crate) fn new(
        parent: &str,
        name: &str,
        dims: &[usize],
        values: Vec<f64>,
        first_fastest: bool,
    ) -> Option<Self> {
        let dims: Vec<usize> = dims.iter().copied().filter(|d| *d != 1).collect();
        let columns = match dims[..] {
            [rows] if rows > 1 && values.len() == rows => vec![values],
            [a, b] if a > 1 && b > 1 && values.len() == a.checked_mul(b)? => {
                // The fastest index runs along a column if it is the longer one.
                let (inner, outer) = if first_fastest { (a, b) } else { (b, a) };
                let (rows, columns) = (inner.max(outer), inner.min(outer));
                if columns > MOST_COLUMNS {
                    return None;
                }
                if inner == rows {
                    values.chunks_exact(inner).map(<[f64]>::to_vec).collect()
                } else {
                    (0..columns).map(|c| values.iter().skip(c).step_by(inner).copied().collect()).collect()
                }
            }
            _ => return None,
        };
        Some(Self { parent: parent.to_owned(), name: name.to_owned(), columns, ..Self::default() })
    }

    pub(crate) fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Header of each column.
    fn headers(&self) -> Vec<String> {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" ({})", self.unit) };
        match self.columns.len() {
            1 => vec![format!("{}{unit}", self.name)],
            n => (1..=n).map(|i| format!("{} {i}{unit}", self.name)).collect(),
        }
    }
}

/// Names of the two parts of a complex array, as used for a lock-in or a scattering parameter.
pub(crate) fn parts(name: &str) -> [String; 2] {
    ["in-phase", "quadrature"].map(|part| format!("{name} {part}").trim().to_owned())
}

/// Values named in a struct, group or archive, with their place.
pub(crate) type NamedValues = Vec<(String, String, String)>;

/// One table per place and length: arrays in the same place with equal lengths belong together.
pub(crate) fn tables(arrays: Vec<Array>, named: &NamedValues) -> LoadedTables {
    let mut groups: Vec<Vec<Array>> = Vec::new();
    for array in arrays {
        let same = |g: &&mut Vec<Array>| {
            g[0].parent == array.parent
                && g[0].rows() == array.rows()
                && g.iter().map(|a| a.columns.len()).sum::<usize>() < MOST_COLUMNS
                // A matrix has its own times or shares a vector; two matrices share nothing.
                && (array.columns.len() == 1 || g.iter().all(|a| a.columns.len() == 1))
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(array),
            None => groups.push(vec![array]),
        }
    }
    let mut tables = LoadedTables::default();
    tables.must_choose = true;
    let alone = |parent: &str| groups.iter().filter(|g| g[0].parent == parent).count() == 1;
    let names: Vec<String> = groups
        .iter()
        .map(|group| {
            let parent = &group[0].parent;
            if parent.is_empty() || !alone(parent) {
                let members: Vec<&str> = group.iter().take(3).map(|a| a.name.as_str()).collect();
                let slash = if parent.is_empty() { "" } else { "/" };
                let more = if group.len() > 3 { ", …" } else { "" };
                format!("{parent}{slash}{}{more}", members.join(", "))
            } else {
                parent.clone()
            }
        })
        .collect();
    for (group, name) in groups.into_iter().zip(names) {
        let parent = group[0].parent.clone();
        let around = named
            .iter()
            .filter(|(place, ..)| *place == parent || place.is_empty())
            .map(|(_, name, value)| (name.clone(), value.clone()));
        let own = group.iter().flat_map(|array| array.named.iter().cloned());
        let head = Head {
            name,
            has_variables: true,
            named_values: own.chain(around).collect(),
            ..Head::of(group.iter().flat_map(Array::headers))
        };
        tables.push(head, group.into_iter().flat_map(|a| a.columns).collect(), Vec::new());
    }
    tables
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longer_side_runs_along_time() {
        let rows: Vec<f64> = (0..6).map(f64::from).collect();
        let of = |dims: &[usize], first| Array::new("", "x", dims, rows.clone(), first).unwrap().columns;
        // Three rows of two values, in the two memory orders.
        assert_eq!(of(&[3, 2], true), [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
        assert_eq!(of(&[3, 2], false), [[0.0, 2.0, 4.0], [1.0, 3.0, 5.0]]);
        // Channels as rows.
        assert_eq!(of(&[2, 3], true), [[0.0, 2.0, 4.0], [1.0, 3.0, 5.0]]);
        assert_eq!(of(&[2, 3], false), [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
        assert_eq!(of(&[1, 6, 1], true), [[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]]);
        for dims in [&[2, 2][..], &[1, 1], &[], &[usize::MAX, usize::MAX], &[2, 3, 4]] {
            assert!(Array::new("", "x", dims, rows.clone(), true).is_none(), "{dims:?}");
        }
    }
}
