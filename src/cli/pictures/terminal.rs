//! The terminal itself: how large it is, and what it answers.

/// What a terminal says of the pictures that it shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Answer {
    /// It knows the graphics protocol of kitty.
    pub kitty: bool,
    /// It knows sixels.
    pub sixel: bool,
}

/// Size of a terminal.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Size {
    /// Characters in a line.
    pub columns: u32,
    /// Lines.
    pub rows: u32,
    /// Width and height of a character in pixels.
    pub cell: (u32, u32),
}

impl Default for Size {
    /// What is taken for the size where there is none.
    fn default() -> Size {
        Size { columns: 80, rows: 40, cell: (10, 20) }
    }
}

/// The question: whether a picture of one pixel could be shown, by the protocol of kitty, and what kind of terminal
/// this is. Only the second is answered by all.
const QUESTION: &str = "\x1b_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\\x1b[c";

/// What an answer means: `ESC _ G i=31;OK ESC \` and `ESC [ ? 62 ; 4 ; 22 c`, where 4 stands for sixels.
fn understood(answer: &str) -> Answer {
    let kind =
        answer.rsplit_once("\x1b[?").and_then(|(_, rest)| rest.split_once('c')).map_or("", |(kind, _)| kind);
    Answer { kitty: answer.contains("_Gi=31;OK"), sixel: kind.split(';').skip(1).any(|n| n == "4") }
}

#[cfg(unix)]
mod system {
    use super::{QUESTION, Size};
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use rustix::io::read;
    use rustix::termios::{OptionalActions, tcgetattr, tcgetwinsize, tcsetattr};
    use std::io::{Write, stdin, stdout};

    /// A terminal that has not answered for so long, in nanoseconds, does not.
    const PATIENCE: i64 = 300_000_000;

    pub fn size() -> Option<Size> {
        let found = tcgetwinsize(stdout()).ok().filter(|s| s.ws_col > 0 && s.ws_row > 0)?;
        let (columns, rows) = (u32::from(found.ws_col), u32::from(found.ws_row));
        let cell = (u32::from(found.ws_xpixel) / columns, u32::from(found.ws_ypixel) / rows);
        let cell = if cell.0 > 0 && cell.1 > 0 { cell } else { Size::default().cell };
        Some(Size { columns, rows, cell })
    }

    /// What the terminal answers, character by character, to the letter that ends it.
    pub fn ask() -> Option<String> {
        let before = tcgetattr(stdin()).ok()?;
        let mut raw = before.clone();
        raw.make_raw();
        tcsetattr(stdin(), OptionalActions::Now, &raw).ok()?;
        let answer = exchange();
        // There is nobody to tell that a terminal cannot be set as it was.
        let _ = tcsetattr(stdin(), OptionalActions::Now, &before);
        answer
    }

    fn exchange() -> Option<String> {
        stdout().write_all(QUESTION.as_bytes()).and_then(|()| stdout().flush()).ok()?;
        let mut answer = Vec::new();
        while answer.last() != Some(&b'c') && answer.len() < 256 {
            let input = stdin();
            let mut fds = [PollFd::new(&input, PollFlags::IN)];
            let wait = Timespec { tv_sec: 0, tv_nsec: PATIENCE };
            if poll(&mut fds, Some(&wait)).ok()? == 0 {
                break;
            }
            let mut byte = [0u8; 1];
            if read(&input, &mut byte).ok()? == 0 {
                break;
            }
            answer.push(byte[0]);
        }
        Some(String::from_utf8_lossy(&answer).into_owned())
    }
}

#[cfg(not(unix))]
mod system {
    use super::Size;

    pub fn size() -> Option<Size> {
        None
    }

    pub fn ask() -> Option<String> {
        None
    }
}

/// Size of the terminal on standard output, or what is taken for it.
pub fn size() -> Size {
    system::size().unwrap_or_default()
}

/// Asks the terminal; one that does not answer shows nothing.
pub fn ask() -> Answer {
    system::ask().map_or(Answer::default(), |answer| understood(&answer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_understood() {
        let of = |kitty, sixel| Answer { kitty, sixel };
        assert_eq!(understood("\x1b_Gi=31;OK\x1b\\\x1b[?62;c"), of(true, false));
        assert_eq!(understood("\x1b[?62;4;22c"), of(false, true));
        assert_eq!(understood("\x1b[?64;14;c"), of(false, false));
        assert_eq!(understood("\x1b_Gi=31;EINVAL:bad\x1b\\\x1b[?1;2c"), of(false, false));
        // A kind of terminal, not what it can do.
        assert_eq!(understood("\x1b[?4c"), of(false, false));
        assert_eq!(understood(""), of(false, false));
    }
}
