//! Tables side by side and runs in groups of columns.

use super::{name::Name, role::Role};

/// Columns that belong together.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Group {
    pub(crate) table: usize,
    pub(crate) run: usize,
    /// Indices of its columns.
    pub(crate) columns: Vec<usize>,
}

/// Groups the columns into tables and runs. `empty` marks the columns without any number.
pub(crate) fn groups(names: &[Name], empty: &[bool]) -> Vec<Group> {
    let mut groups = Vec::new();
    let gap = |i: usize| names[i].header.is_empty() && empty[i];
    let mut table = 0;
    let mut i = 0;
    while i < names.len() {
        if gap(i) {
            i += 1;
            continue;
        }
        let start = i;
        while i < names.len() && !gap(i) {
            i += 1;
        }
        table += 1;
        let runs = runs(names, &(start..i).collect::<Vec<_>>());
        groups.extend(runs.into_iter().enumerate().map(|(r, columns)| Group { table, run: r + 1, columns }));
    }
    merge_if_timeless(groups, names)
}

/// Merges tables separated by empty columns if one of them has no times of its own.
fn merge_if_timeless(groups: Vec<Group>, names: &[Name]) -> Vec<Group> {
    let named = names.iter().any(|n| !n.header.is_empty());
    let tables = groups.last().map_or(0, |g| g.table);
    let timed = |table: usize| {
        groups
            .iter()
            .filter(|g| g.table == table)
            .any(|g| g.columns.iter().any(|&c| Role::in_record(&names[c]) == Role::Time))
    };
    if tables < 2 || (named && (1..=tables).all(timed)) {
        return groups;
    }
    let columns = groups.into_iter().flat_map(|g| g.columns).collect();
    vec![Group { table: 1, run: 1, columns }]
}

/// Splits the columns of a table at run tags or at repeated time columns.
fn runs(names: &[Name], columns: &[usize]) -> Vec<Vec<usize>> {
    let mut tags: Vec<&str> = Vec::new();
    for &c in columns {
        if let Some(tag) = names[c].run.as_deref()
            && !tags.contains(&tag)
        {
            tags.push(tag);
        }
    }
    if tags.len() > 1 {
        let of = |tag: &str| {
            columns.iter().copied().filter(|&c| names[c].run.as_deref().is_none_or(|t| t == tag)).collect()
        };
        return tags.into_iter().map(of).collect();
    }
    let Some(first) = columns.iter().position(|&c| Role::in_record(&names[c]) == Role::Time) else {
        return vec![columns.to_vec()];
    };
    let stem = names[columns[first]].stem();
    let starts: Vec<usize> = (first..columns.len())
        .filter(|&i| Role::in_record(&names[columns[i]]) == Role::Time && names[columns[i]].stem() == stem)
        .collect();
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for (k, &start) in starts.iter().enumerate() {
        let from = if k == 0 { 0 } else { start };
        let to = starts.get(k + 1).copied().unwrap_or(columns.len());
        runs.push(columns[from..to].to_vec());
    }
    // Adjacent time columns do not start separate runs: there are no data between them.
    if runs.iter().any(|r| r.len() < 2) { vec![columns.to_vec()] } else { runs }
}
