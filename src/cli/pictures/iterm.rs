//! The protocol of iTerm2, which WezTerm, Konsole, mintty and the terminal of VS Code understand too: a file in base 64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// A PNG as the terminal wants to be told of it, at the place of the cursor.
pub fn encode(png: &[u8]) -> String {
    format!("\x1b]1337;File=inline=1;size={}:{}\x07", png.len(), STANDARD.encode(png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_announced_with_its_size() {
        assert_eq!(encode(b"abc"), "\x1b]1337;File=inline=1;size=3:YWJj\x07");
    }
}
