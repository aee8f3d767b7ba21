//! Keys in the order in which they are written down.

use serde::{Serialize, Serializer};
use slipfit::Quantity;

/// A value of the contract.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    Null,
    Bool(bool),
    Count(u64),
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Object(Vec<(&'static str, Node)>),
    /// Keys that the data name.
    Named(Vec<(String, Node)>),
}

impl Serialize for Node {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Null => serializer.serialize_none(),
            Self::Bool(value) => serializer.serialize_bool(*value),
            Self::Count(value) => serializer.serialize_u64(*value),
            Self::Number(value) => serializer.serialize_f64(*value),
            Self::Text(value) => serializer.serialize_str(value),
            Self::List(list) => serializer.collect_seq(list),
            Self::Object(keys) => serializer.collect_map(keys.iter().map(|(k, v)| (k, v))),
            Self::Named(keys) => serializer.collect_map(keys.iter().map(|(k, v)| (k, v))),
        }
    }
}

impl From<bool> for Node {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<u64> for Node {
    fn from(value: u64) -> Self {
        Self::Count(value)
    }
}

impl From<usize> for Node {
    fn from(value: usize) -> Self {
        Self::Count(value as u64)
    }
}

impl From<f64> for Node {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for Node {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for Node {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl From<&Quantity> for Node {
    fn from(q: &Quantity) -> Self {
        Self::Object(vec![
            ("value", q.value.into()),
            ("std_error", q.std_error.into()),
            ("interval_95", q.interval_95.into()),
            ("unit", q.unit.as_str().into()),
            ("unbounded_value", q.unbounded_value.into()),
        ])
    }
}

impl<T: Into<Node>> From<Option<T>> for Node {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Null, Into::into)
    }
}

impl<T: Into<Node>> From<Vec<T>> for Node {
    fn from(values: Vec<T>) -> Self {
        Self::List(values.into_iter().map(Into::into).collect())
    }
}

impl<T: Into<Node>, const N: usize> From<[T; N]> for Node {
    fn from(values: [T; N]) -> Self {
        Self::List(values.into_iter().map(Into::into).collect())
    }
}

/// A list of what each item becomes.
pub(super) fn list<T>(items: &[T], each: impl Fn(&T) -> Node) -> Node {
    Node::List(items.iter().map(each).collect())
}

/// A column of numbers.
pub(super) fn numbers<T>(items: &[T], each: impl Fn(&T) -> f64) -> Node {
    Node::List(items.iter().map(|i| Node::Number(each(i))).collect())
}
