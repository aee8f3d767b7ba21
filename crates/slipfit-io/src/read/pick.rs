//! Selection of one of several tables.

use crate::{
    columns::head::Head,
    error::{OptionProblem, ReadProblem},
};

/// Index of the table selected by name, by part of a name or by number. The only table of a text has no name.
pub(super) fn find(wanted: &str, names: &[&str], is_text: bool) -> Result<usize, ReadProblem> {
    let key = wanted.trim().trim_matches('/').to_lowercase();
    let plain = |n: &str| n.trim_matches('/').to_lowercase();
    if let Some(index) = names.iter().position(|n| plain(n) == key) {
        return Ok(index);
    }
    if let Ok(number) = key.parse::<usize>()
        && (1..=names.len()).contains(&number)
    {
        return Ok(number - 1);
    }
    let fits = |i: &usize| !key.is_empty() && plain(names[*i]).contains(&key);
    let parts: Vec<usize> = (0..names.len()).filter(fits).collect();
    match parts[..] {
        [index] => Ok(index),
        _ => {
            let tables = names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
            let problem = match names {
                [""] if is_text => OptionProblem::NoSheets,
                _ => OptionProblem::NoSuchTable(tables),
            };
            Err(ReadProblem::Option { option: "sheet", value: wanted.to_owned(), problem })
        }
    }
}

/// The names of the other tables, up to a maximum number.
pub(super) fn others(names: &[&str], taken: usize) -> String {
    const MOST: usize = 8;
    let others: Vec<&&str> = names.iter().enumerate().filter(|(i, _)| *i != taken).map(|(_, n)| n).collect();
    let mut list = others.iter().take(MOST).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    if others.len() > MOST {
        list += &format!(" and {} more", others.len() - MOST);
    }
    list
}

/// ``swing` with `t`, `x` ``.
pub(super) fn describe(head: &Head) -> String {
    const MOST: usize = 6;
    let header = |(i, name): (usize, &crate::columns::name::Name)| match name.header.as_str() {
        "" => format!("column {}", i + 1),
        header => header.to_owned(),
    };
    let columns: Vec<String> = head.names.iter().enumerate().take(MOST).map(header).collect();
    let more = if head.names.len() > MOST { ", …" } else { "" };
    format!("`{}` ({}{more})", head.name, columns.join(", "))
}
