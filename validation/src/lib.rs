//! The worked examples of the book, compiled and run as documentation tests.

#[cfg(doctest)]
#[doc = include_str!("../../docs/extending.md")]
struct Extending;
