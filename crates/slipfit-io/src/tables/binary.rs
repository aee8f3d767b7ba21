//! Numbers as they are stored in binary files.

/// Interpretation of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Float,
    Signed,
    Unsigned,
}

/// Storage of a number in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stored {
    pub(crate) kind: Kind,
    /// 1 to 8; 2, 4 or 8 for floats.
    pub(crate) bytes: usize,
    pub(crate) big_endian: bool,
}

impl Stored {
    /// A number with a kind and a size; `None` if this size does not exist.
    pub(crate) fn new(kind: Kind, bytes: usize, big_endian: bool) -> Option<Self> {
        let known = match kind {
            Kind::Float => matches!(bytes, 2 | 4 | 8),
            Kind::Signed | Kind::Unsigned => (1..=8).contains(&bytes),
        };
        known.then_some(Self { kind, bytes, big_endian })
    }

    /// The number in the first bytes; NaN if there are too few.
    #[inline]
    pub(crate) fn read(self, bytes: &[u8]) -> f64 {
        let Some(bytes) = bytes.get(..self.bytes) else { return f64::NAN };
        let mut word = [0; 8];
        let from = if self.big_endian { 8 - self.bytes } else { 0 };
        word[from..from + self.bytes].copy_from_slice(bytes);
        let word = if self.big_endian { u64::from_be_bytes(word) } else { u64::from_le_bytes(word) };
        match (self.kind, self.bytes) {
            (Kind::Float, 2) => half(word as u16),
            (Kind::Float, 4) => f64::from(f32::from_bits(word as u32)),
            (Kind::Float, _) => f64::from_bits(word),
            (Kind::Signed, bytes) => {
                let shift = 64 - 8 * bytes as u32;
                ((word << shift) as i64 >> shift) as f64
            }
            (Kind::Unsigned, _) => word as f64,
        }
    }

    /// Successive numbers; bytes at the end that do not form a number are ignored.
    pub(crate) fn all(self, bytes: &[u8]) -> Vec<f64> {
        bytes.chunks_exact(self.bytes).map(|number| self.read(number)).collect()
    }
}

/// Sixteen-bit floats.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        31 => f64::NAN,
        e => (1024.0 + fraction) * 2f64.powi(e - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_kind_are_read() {
        for (kind, bytes, value) in [
            (Kind::Float, &[0x3c, 0x00][..], 1.0),
            (Kind::Float, &[0xc0, 0x00], -2.0),
            (Kind::Float, &[0x00, 0x01], 2f64.powi(-24)),
            (Kind::Float, &[0x7b, 0xff], 65504.0),
            (Kind::Float, &[0x3f, 0x80, 0, 0], 1.0),
            (Kind::Signed, &[0xff], -1.0),
            (Kind::Unsigned, &[0xff], 255.0),
            (Kind::Signed, &[0xff, 0xff, 0xfe], -2.0),
            (Kind::Unsigned, &[1, 0, 0, 0, 0], 2f64.powi(32)),
        ] {
            let big = Stored::new(kind, bytes.len(), true).unwrap();
            assert_eq!(big.read(bytes), value);
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(Stored { big_endian: false, ..big }.read(&reversed), value);
            assert!(big.read(&bytes[1..]).is_nan());
        }
        assert!(half(0x7e00).is_nan());
        assert_eq!(Stored::new(Kind::Float, 3, false), None);
    }
}
