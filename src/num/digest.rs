//! Fingerprints of data, to tell whether they are the same as before without keeping them.

use super::mix;
use std::fmt::{self, Display};
use std::hash::Hasher;

/// A fingerprint of data, of 128 bits: as good as the data themselves, since two that meet by chance
/// are not to be expected in the age of the universe. It is shown as 32 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct Digest([u64; 2]);

impl Digest {
    /// Takes a whole number in.
    pub fn whole(&mut self, x: u64) {
        let [a, b] = self.0;
        self.0 = [mix(a ^ x), mix(b.wrapping_add(x) ^ 0x5851_f42d_4c95_7f2d)];
    }

    /// Takes numbers in.
    pub fn numbers(&mut self, x: impl IntoIterator<Item = f64>) {
        x.into_iter().for_each(|x| self.whole(x.to_bits()));
    }

    /// Takes another fingerprint in.
    pub fn join(&mut self, other: Digest) {
        other.0.into_iter().for_each(|x| self.whole(x));
    }

    /// Takes bytes in, and how many they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.whole(bytes.len() as u64);
        for eight in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..eight.len()].copy_from_slice(eight);
            self.whole(u64::from_le_bytes(word));
        }
    }

    /// Takes a text in.
    pub fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }
}

/// Whatever can be hashed has a fingerprint.
impl Hasher for Digest {
    fn write(&mut self, bytes: &[u8]) {
        self.bytes(bytes);
    }

    fn write_u64(&mut self, x: u64) {
        self.whole(x);
    }

    fn write_usize(&mut self, x: usize) {
        self.whole(x as u64);
    }

    /// Half of the fingerprint.
    fn finish(&self) -> u64 {
        self.0[0]
    }
}

impl Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}{:016x}", self.0[0], self.0[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(bytes: &[u8]) -> Digest {
        let mut digest = Digest::default();
        digest.bytes(bytes);
        digest
    }

    #[test]
    fn every_byte_and_the_length_count() {
        let data: Vec<u8> = (0..20).collect();
        for i in 0..data.len() {
            let mut other = data.clone();
            other[i] ^= 1;
            assert_ne!(of(&data), of(&other));
            assert_ne!(of(&data[..i]), of(&data));
        }
        assert_ne!(of(&[0]), of(&[0, 0]));
        assert_eq!(of(&data), of(&data.clone()));
        assert_eq!(of(&data).to_string().len(), 32);
    }
}
