//! Arrays of a file or a store, by name.

/// Maximum number of names in a message.
const NAMED: usize = 20;

/// An array of a file or a store.
pub(crate) struct Known {
    /// Its path from the root.
    pub(crate) path: String,
    pub(crate) shape: Vec<u64>,
}

/// Message that there is no array of this name, or none with three axes, and which arrays there are.
pub(crate) fn not_found(what: &str, name: Option<&str>, known: &[Known]) -> String {
    let missing = match name {
        Some(name) => format!("there is no {what} {name} in it"),
        None => format!("no {what} in it has three axes"),
    };
    let with_shape = |Known { path, shape }: &Known| {
        let lengths: Vec<String> = shape.iter().map(u64::to_string).collect();
        format!("{} ({})", if path.is_empty() { "/" } else { path }, lengths.join(" × "))
    };
    // Arrays with three axes come first: one of them is intended.
    let (cubes, others): (Vec<_>, Vec<_>) = known.iter().partition(|one| one.shape.len() == 3);
    let mut names: Vec<String> = cubes.into_iter().chain(others).take(NAMED).map(with_shape).collect();
    if known.len() > NAMED {
        names.push(format!("others, {} in all", known.len()));
    }
    if names.is_empty() {
        format!("{missing}, nor any other")
    } else {
        format!("{missing}; there are {}", names.join(", "))
    }
}
