//! The graphics protocol of kitty, which Ghostty, WezTerm and Konsole understand too: a PNG in base 64, in pieces.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Characters of a piece, as the protocol wants it.
const PIECE: usize = 4096;

/// A PNG as the terminal wants to be told of it, at the place of the cursor.
pub fn encode(png: &[u8]) -> String {
    let text = STANDARD.encode(png);
    let mut out = String::with_capacity(text.len() + text.len() / 100 + 64);
    let mut rest = text.as_str();
    // Transmit and show; a PNG; and without an answer, which would come as if it were typed.
    let mut keys = "a=T,f=100,q=2,";
    loop {
        let (piece, after) = rest.split_at(PIECE.min(rest.len()));
        let more = u8::from(!after.is_empty());
        out += &format!("\x1b_G{keys}m={more};{piece}\x1b\\");
        (rest, keys) = (after, "");
        if rest.is_empty() {
            return out;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_marked_and_make_up_the_whole() {
        let png: Vec<u8> = (0..7000u32).map(|i| (i * 37 % 251) as u8).collect();
        let text = encode(&png);
        let pieces: Vec<&str> = text.split("\x1b\\").filter(|p| !p.is_empty()).collect();
        assert_eq!(pieces.len(), 3);
        assert!(pieces[0].starts_with("\x1b_Ga=T,f=100,q=2,m=1;") && pieces[1].starts_with("\x1b_Gm=1;"));
        assert!(pieces[2].starts_with("\x1b_Gm=0;"));
        let data: String = pieces.iter().map(|p| p.split_once(';').unwrap().1).collect();
        assert_eq!(STANDARD.decode(data).unwrap(), png);
    }
}
