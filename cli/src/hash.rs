//! A hash that tells a file from its earlier self.
//!
//! In: bytes. Out: FNV-1a of 64 bits, in hexadecimal digits. Never: safe against whoever wants two files to look alike.

/// FNV-1a (Fowler, Noll, Vo): the same on every machine, which the standard library's hash does not promise.
pub fn fnv1a(bytes: &[u8]) -> String {
    let hash = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_value() {
        assert_eq!(fnv1a(b"a"), "af63dc4c8601ec8c");
    }
}
