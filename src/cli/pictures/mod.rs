//! Pictures in the terminal: as pixels where it shows them, else as coloured characters, else not at all.

mod blocks;
pub mod braille;
mod detect;
mod iterm;
mod kitty;
mod sixel;
mod terminal;

use super::report::{Terminal, out};
use crate::analysis::plot::Figure;
use crate::render::Picture;
use clap::ValueEnum;
use std::cell::OnceCell;
use std::io::{IsTerminal, stdin, stdout};
use terminal::Size;

/// How pictures are shown.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Way {
    /// By the graphics protocol of kitty.
    Kitty,
    /// By the protocol of iTerm2.
    Iterm,
    /// As sixels.
    Sixel,
    /// As half blocks and braille, in every terminal that has colours.
    Blocks,
    /// Not at all.
    None,
}

/// Share of the lines that a picture takes at most, so that what was asked stays in sight.
const SHARE: f64 = 0.75;
/// A picture is no larger than that, however large the terminal is.
const MOST: (u32, u32) = (1200, 900);
/// Characters so high are those of a screen with small pixels, on which the letters of figures would be too small.
const FINE: u32 = 30;

/// A terminal as a place for pictures.
pub struct Screen {
    asked: Option<Way>,
    color: bool,
    /// Found out when the first picture is there.
    found: OnceCell<Way>,
}

impl Screen {
    /// The terminal on standard output, with the way that was asked for.
    pub fn new(asked: Option<Way>, terminal: &Terminal) -> Screen {
        Screen { asked, color: terminal.color, found: OnceCell::new() }
    }

    /// How pictures are shown: nowhere on a pipe, unless a way was asked for.
    pub fn way(&self) -> Way {
        *self.found.get_or_init(|| match self.asked {
            Some(way) => way,
            None if !stdout().is_terminal() || !self.color => Way::None,
            None => detect::by_environment(|name| std::env::var(name).ok()).unwrap_or_else(|| {
                if stdin().is_terminal() { detect::by_answer(&terminal::ask()) } else { Way::Blocks }
            }),
        })
    }

    /// Columns and rows of characters that a picture may take.
    pub fn characters(&self) -> (u32, u32) {
        let Size { columns, rows, .. } = terminal::size();
        (columns.saturating_sub(1).clamp(16, 160), ((f64::from(rows) * SHARE) as u32).max(8))
    }

    /// Pixels that a picture may have.
    pub fn pixels(&self) -> (u32, u32) {
        let (columns, rows) = self.characters();
        let (width, height) = match self.way() {
            Way::Blocks | Way::None => (columns, 2 * rows),
            _ => {
                let cell = terminal::size().cell;
                (columns * cell.0, rows * cell.1)
            }
        };
        (width.min(MOST.0), height.min(MOST.1))
    }

    /// Pixels that a figure with letters may have.
    pub fn figure(&self) -> (u32, u32) {
        let (width, height) = self.pixels();
        (width / self.zoom(), height / self.zoom())
    }

    /// The largest size with the aspect of another that is no larger than that and fits.
    pub fn fitted(&self, width: u32, height: u32) -> (u32, u32) {
        let most = self.pixels();
        let [x, y] =
            [(most.0, width), (most.1, height)].map(|(most, own)| f64::from(most) / f64::from(own.max(1)));
        let scale = x.min(y).min(1.0);
        let side = |own: u32| ((f64::from(own) * scale).round() as u32).max(1);
        (side(width), side(height))
    }

    /// Pixels of the screen for one of a figure.
    fn zoom(&self) -> u32 {
        let pixels = matches!(self.way(), Way::Kitty | Way::Iterm | Way::Sixel);
        if pixels && terminal::size().cell.1 >= FINE { 2 } else { 1 }
    }

    /// A picture as half blocks, one pixel for a column.
    pub fn text(&self, figure: &Figure) -> String {
        blocks::encode(figure, is_true_color())
    }

    /// Shows a picture as large as fits, if pictures are shown.
    pub fn show(&self, figure: &Figure) {
        let (width, height) = self.fitted(figure.width, figure.height);
        if (width, height) == (figure.width, figure.height) {
            self.write(figure);
        } else {
            self.write(&blocks::resized(figure, width, height));
        }
    }

    fn write(&self, figure: &Figure) {
        let png = || {
            let mut png = Vec::new();
            figure.write_png(&mut png).is_ok().then_some(png)
        };
        match self.way() {
            Way::None => {}
            Way::Kitty => png().into_iter().for_each(|png| out(kitty::encode(&png))),
            Way::Iterm => png().into_iter().for_each(|png| out(iterm::encode(&png))),
            Way::Sixel => out(sixel::encode(figure)),
            Way::Blocks => out(self.text(figure)),
        }
    }

    /// Shows a figure with letters, if pixels are shown.
    pub fn show_figure(&self, figure: &Figure) {
        match self.zoom() {
            1 => self.show(figure),
            zoom => self.show(&blocks::resized(figure, zoom * figure.width, zoom * figure.height)),
        }
    }
}

/// Characters in a line.
pub fn columns() -> usize {
    terminal::size().columns as usize
}

/// Whether the terminal says that it has all colours. Nearly all do, but the one of macOS.
fn is_true_color() -> bool {
    std::env::var("COLORTERM").is_ok_and(|v| v == "truecolor" || v == "24bit")
        || std::env::var("TERM_PROGRAM").is_ok_and(|v| v != "Apple_Terminal")
}

/// A picture as a screen shows it.
pub fn figure_of(picture: &Picture) -> Figure {
    let window = picture.window;
    let rgb = (window.y..window.bottom()).flat_map(|y| picture.row_bytes(y)).collect();
    Figure { width: window.width, height: window.height, rgb }
}
