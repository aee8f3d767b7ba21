//! Words in a list between blanks.

/// Whether a list of words between blanks has a word.
pub(crate) fn listed(list: &str, word: &str) -> bool {
    list.split_ascii_whitespace().any(|known| known == word)
}
