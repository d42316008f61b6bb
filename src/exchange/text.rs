//! Lines, words and numbers of text files. These are bytes here, since names and comments in such files
//! are in any encoding.

use super::fault::{Fault, Place};

/// The lines of a text, each with its number, counted from one. A line that ends with a backslash goes
/// on in the next.
pub struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    /// The lines of a text, without the mark of its encoding that some programs begin with.
    pub fn of(text: &'a [u8]) -> Self {
        Lines { rest: text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text), number: 1 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let (first, mut end) = (self.number, 0);
        loop {
            let Some(length) = self.rest[end..].iter().position(|b| *b == b'\n') else {
                end = self.rest.len();
                break;
            };
            end += length + 1;
            self.number += 1;
            let line = &self.rest[..end - 1];
            if !line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\") {
                break;
            }
        }
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        Some((first, line))
    }
}

/// The words of a line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|b| b.is_ascii_whitespace() || *b == b'\\').filter(|word| !word.is_empty())
}

/// The finite number that a word is.
pub fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok().filter(|x: &f64| x.is_finite())
}

/// The next word as a finite number.
pub fn next_number<'a>(words: &mut impl Iterator<Item = &'a [u8]>, line: usize) -> Result<f64, Fault> {
    let word = words.next().ok_or_else(|| Fault::new(Place::Line(line), "a number is missing"))?;
    number(word).ok_or_else(|| Fault::new(Place::Line(line), format!("{} is no finite number", shown(word))))
}

/// The next three words as finite numbers.
pub fn next_three<'a>(words: &mut impl Iterator<Item = &'a [u8]>, line: usize) -> Result<[f64; 3], Fault> {
    Ok([next_number(words, line)?, next_number(words, line)?, next_number(words, line)?])
}

/// A word for a message.
pub fn shown(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(40)]);
    let short: String = text.chars().take(20).collect();
    format!("{short:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_of_the_encoding_is_no_part_of_the_first_line() {
        let lines: Vec<_> = Lines::of(b"\xef\xbb\xbfv 1\nv 2\n").collect();
        assert_eq!(lines, [(1, &b"v 1\n"[..]), (2, b"v 2\n")]);
    }
}
