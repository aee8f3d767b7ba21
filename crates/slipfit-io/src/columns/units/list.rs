//! Lists of words separated by blanks.

/// Whether a word is in a list of words separated by blanks.
pub(crate) fn listed(list: &str, word: &str) -> bool {
    list.split_ascii_whitespace().any(|known| known == word)
}
