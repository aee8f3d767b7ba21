//! Zarr arrays in both versions in use: a folder with a description and chunks of numbers.

mod blosc;
mod codec;
mod cube;
mod description;
mod unpack;

pub(crate) use cube::Cube;

use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::error::ReadProblem;
use crate::tables::known::{Known, not_found};
use cube::refused;
use description::{Array, Node, node};

/// Maximum depth of nested groups, and maximum number of nodes examined.
const DEEPEST: usize = 16;
const MOST_NODES: usize = 10_000;

/// Shape, unit and numbers of the three-dimensional array called `name`, or of the only one.
pub(crate) fn cube(path: &Path, name: Option<&str>) -> Result<([usize; 3], String, Cube), ReadProblem> {
    let mut found = Vec::new();
    if let Some(name) = name {
        let inner = Path::new(name.trim_start_matches('/'));
        if !inner.components().all(|part| matches!(part, Component::Normal(_))) {
            return Err(refused(format!("{name} is not a path in a zarr store")));
        }
        let folder = path.join(inner);
        match node(&folder)? {
            Some(Node::Array(array)) => found.push((name.to_owned(), folder, array)),
            _ => return Err(refused(not_found("array", Some(name), &known(path)))),
        }
    } else {
        let mut left = MOST_NODES;
        search(path, "", DEEPEST, &mut left, &mut found)?;
        found.retain(|(_, _, array)| array.shape().len() == 3);
    }
    let Some((name, folder, array)) = found.pop() else {
        return Err(refused(not_found("array of zarr", None, &known(path))));
    };
    if !found.is_empty() {
        let names: Vec<String> = found.into_iter().map(|(name, ..)| name).chain([name]).collect();
        return Err(refused(format!("{} have three axes each, name one of them", names.join(", "))));
    }
    let (unit, cube) = array.cube(folder)?;
    Ok((cube.shape, unit, cube))
}

type Found = (String, PathBuf, Array);

/// The readable content of the store.
fn known(path: &Path) -> Vec<Known> {
    let (mut left, mut found) = (MOST_NODES, Vec::new());
    // Unreadable nodes are not listed.
    let _ = search(path, "", DEEPEST, &mut left, &mut found);
    found.into_iter().map(|(path, _, array)| Known { path, shape: array.shape() }).collect()
}

/// The arrays in a group and in its subgroups.
fn search(
    folder: &Path,
    name: &str,
    deep: usize,
    left: &mut usize,
    found: &mut Vec<Found>,
) -> Result<(), ReadProblem> {
    if deep == 0 || *left == 0 {
        return Ok(());
    }
    *left -= 1;
    match node(folder)? {
        Some(Node::Array(array)) => found.push((name.to_owned(), folder.to_owned(), array)),
        Some(Node::Group) => {
            let entries = fs::read_dir(folder).map_err(ReadProblem::Io)?;
            let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
            names.sort();
            for inner in names {
                let path = folder.join(&inner);
                if path.is_dir() {
                    search(&path, &format!("{name}/{}", inner.to_string_lossy()), deep - 1, left, found)?;
                }
            }
        }
        _ => {}
    }
    Ok(())
}
