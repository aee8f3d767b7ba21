//! Arrays of a file or a store by their names.

/// Names that a message holds.
const NAMED: usize = 20;

/// An array of a file or a store.
pub(crate) struct Known {
    /// Its path, from the root on.
    pub(crate) path: String,
    pub(crate) shape: Vec<u64>,
}

/// Says that there is no array of this name, or none of three axes, and which there are.
pub(crate) fn not_found(what: &str, name: Option<&str>, known: &[Known]) -> String {
    let missing = match name {
        Some(name) => format!("there is no {what} {name} in it"),
        None => format!("no {what} in it has three axes"),
    };
    let with_shape = |Known { path, shape }: &Known| {
        let lengths: Vec<String> = shape.iter().map(u64::to_string).collect();
        format!("{} ({})", if path.is_empty() { "/" } else { path }, lengths.join(" × "))
    };
    // Those of three axes first: one of them is meant.
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
