//! Columns, tables and runs as a person asks for them.

use super::{Chooser, Group, info, info_of, label, names::Name};
use crate::ReadProblem;

impl Chooser<'_> {
    /// The group to read, how many tables there are and how many runs in its.
    pub(super) fn group(&self, groups: &[Group]) -> Result<(Group, usize, usize), ReadProblem> {
        let tables = groups.iter().map(|g| g.table).max().unwrap_or(0);
        let all = || (0..self.columns.len()).collect::<Vec<_>>();
        let holder = match &self.options.signal {
            Some(wanted) if self.options.table.is_none() && self.options.run.is_none() => {
                let index =
                    self.find("--signal", wanted, &groups.first().map_or_else(all, |g| g.columns.clone()))?;
                groups.iter().find(|g| g.columns.contains(&index))
            }
            _ => None,
        };
        let table = holder.map(|g| g.table).or(self.options.table).unwrap_or(1);
        if table == 0 || table > tables {
            return Err(ReadProblem::UnknownGroup { flag: "--part", wanted: table, found: tables });
        }
        let runs = groups.iter().filter(|g| g.table == table).count();
        let run = holder.map(|g| g.run).or(self.options.run).unwrap_or(1);
        let group = groups.iter().find(|g| g.table == table && g.run == run).cloned();
        let group = group.ok_or(ReadProblem::UnknownGroup { flag: "--run", wanted: run, found: runs })?;
        Ok((group, tables, runs))
    }

    /// A column by number or name; names are looked for in `near` first.
    pub(super) fn find(
        &self,
        flag: &'static str,
        wanted: &str,
        near: &[usize],
    ) -> Result<usize, ReadProblem> {
        find(&self.head.names, flag, wanted, near)
    }

    pub(super) fn list(&self, indices: &[usize]) -> String {
        list(&self.head.names, indices)
    }

    pub(super) fn label(&self, index: usize) -> String {
        label(&info(self.head, index))
    }
}

/// A column by number or name; names are looked for in `near` first.
pub(crate) fn find(
    names: &[Name],
    flag: &'static str,
    wanted: &str,
    near: &[usize],
) -> Result<usize, ReadProblem> {
    let all: Vec<usize> = (0..names.len()).collect();
    let key = wanted.trim().to_lowercase();
    let whole = |i: &usize| names[*i].header.to_lowercase() == key;
    let bare = |i: &usize| !names[*i].bare.is_empty() && names[*i].bare.to_lowercase() == key;
    let part = |i: &usize| names[*i].header.to_lowercase().contains(&key);
    let unknown =
        || ReadProblem::UnknownColumn { flag, wanted: wanted.to_owned(), columns: list(names, &all) };
    let tests: [&dyn Fn(&usize) -> bool; 3] = [&whole, &bare, &part];
    if !key.is_empty() {
        for test in &tests[..2] {
            for place in [near, &all] {
                if let Some(index) = place.iter().copied().find(|i| test(i)) {
                    return Ok(index);
                }
            }
        }
    }
    if let Ok(number) = key.parse::<usize>() {
        return if (1..=all.len()).contains(&number) { Ok(number - 1) } else { Err(unknown()) };
    }
    if key.is_empty() {
        return Err(unknown());
    }
    for place in [near, &all] {
        let fits: Vec<usize> = place.iter().copied().filter(|i| part(i)).collect();
        match fits[..] {
            [] => {}
            [index] => return Ok(index),
            _ => {
                let candidates = list(names, &fits);
                return Err(ReadProblem::AmbiguousColumn { flag, wanted: wanted.to_owned(), candidates });
            }
        }
    }
    Err(unknown())
}

/// Columns as a sentence names them.
pub(crate) fn list(names: &[Name], indices: &[usize]) -> String {
    const MOST: usize = 12;
    let mut labels: Vec<String> = indices.iter().take(MOST).map(|&i| label(&info_of(names, i))).collect();
    if indices.len() > MOST {
        labels.push(format!("{} more", indices.len() - MOST));
    }
    labels.join(", ")
}
