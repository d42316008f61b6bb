//! Sixels: pictures for terminals of DEC's kind, such as foot, mlterm, xterm and Windows Terminal.
//!
//! A picture has up to 256 colours of its own, and comes in bands of six rows: for each colour of a band a row of
//! characters, whose six bits say which of the pixels in a column have it. (A crate that does this brings thirty
//! others along; there is no more to it than this file.)
//!
//! The colours are chosen by median cut (Heckbert 1982): the box of all colours is halved where its pixels
//! are, again and again, always the box that has the most of both pixels and extent. What is lost is handed on to
//! neighbouring pixels (Floyd and Steinberg 1976).

use crate::analysis::plot::Figure;
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;

/// Colours of a picture.
const COLORS: usize = 256;
/// Bits of a channel that are told apart when colours are chosen.
const BITS: u32 = 5;

/// A picture as the terminal wants to be told of it, at the place of the cursor.
pub fn encode(figure: &Figure) -> String {
    let palette = palette(figure);
    let indices = dithered(figure, &palette);
    // Square pixels, and the size.
    let mut out = format!("\x1bP0;1;0q\"1;1;{};{}", figure.width, figure.height);
    for (i, color) in palette.iter().enumerate() {
        let [r, g, b] = color.map(|c| (u32::from(c) * 100 + 127) / 255);
        // Writing to a text cannot fail.
        let _ = write!(out, "#{i};2;{r};{g};{b}");
    }
    for band in indices.chunks(6 * figure.width.max(1) as usize) {
        write_band(&mut out, band, figure.width.max(1) as usize);
    }
    out + "\x1b\\"
}

/// Six rows, colour by colour.
fn write_band(out: &mut String, band: &[u8], width: usize) {
    let mut rows: BTreeMap<u8, Vec<u8>> = BTreeMap::new();
    for (i, color) in band.iter().enumerate() {
        rows.entry(*color).or_insert_with(|| vec![0; width])[i % width] |= 1 << (i / width);
    }
    for (color, bits) in rows {
        let _ = write!(out, "#{color}");
        for run in bits.chunk_by(|a, b| a == b) {
            let character = char::from(63 + run[0]);
            match run.len() {
                n if n > 3 => drop(write!(out, "!{n}{character}")),
                n => out.extend(std::iter::repeat_n(character, n)),
            }
        }
        // Back to the start of the band.
        out.push('$');
    }
    out.push('-');
}

/// Colours that stand for those of a picture.
fn palette(figure: &Figure) -> Vec<[u8; 3]> {
    // The pixels of a cell of colour space, and the sum of their colours.
    let mut cells: BTreeMap<[u8; 3], (u64, [u64; 3])> = BTreeMap::new();
    for pixel in figure.rgb.chunks_exact(3) {
        let cell = cells.entry([0, 1, 2].map(|c| pixel[c] >> (8 - BITS))).or_default();
        cell.0 += 1;
        (0..3).for_each(|c| cell.1[c] += u64::from(pixel[c]));
    }
    let mut boxes = vec![cells.into_iter().collect::<Vec<_>>()];
    while boxes.len() < COLORS {
        let worth = |cells: &[Cell]| widest(cells).1 * cells.iter().map(|c| c.1.0).sum::<u64>();
        let Some(largest) = (0..boxes.len()).max_by_key(|i| worth(&boxes[*i])) else { break };
        if worth(&boxes[largest]) == 0 {
            break;
        }
        let (low, high) = halves(boxes.swap_remove(largest));
        boxes.extend([low, high]);
    }
    boxes.iter().map(|cells| mean(cells)).collect()
}

/// A cell of colour space with the number of its pixels and the sum of their colours.
type Cell = ([u8; 3], (u64, [u64; 3]));

/// The channel in which cells differ most, and how much.
fn widest(cells: &[Cell]) -> (usize, u64) {
    let extent = |channel: usize| {
        let values = cells.iter().map(|cell| cell.0[channel]);
        u64::from(values.clone().max().unwrap_or(0) - values.min().unwrap_or(0))
    };
    (0..3).map(|channel| (channel, extent(channel))).max_by_key(|(_, extent)| *extent).unwrap_or((0, 0))
}

/// The cells on both sides of the median pixel, at least one on each.
fn halves(mut cells: Vec<Cell>) -> (Vec<Cell>, Vec<Cell>) {
    let channel = widest(&cells).0;
    cells.sort_by_key(|cell| cell.0[channel]);
    let half = cells.iter().map(|c| c.1.0).sum::<u64>() / 2;
    let mut below = 0;
    let median = cells.iter().position(|cell| {
        below += cell.1.0;
        below > half
    });
    let high = cells.split_off(median.unwrap_or(0).clamp(1, cells.len() - 1));
    (cells, high)
}

fn mean(cells: &[Cell]) -> [u8; 3] {
    let count = cells.iter().map(|c| c.1.0).sum::<u64>().max(1);
    [0, 1, 2].map(|channel| ((cells.iter().map(|c| c.1.1[channel]).sum::<u64>() + count / 2) / count) as u8)
}

/// The colours of all pixels, by number.
fn dithered(figure: &Figure, palette: &[[u8; 3]]) -> Vec<u8> {
    let width = figure.width.max(1) as usize;
    let mut known: HashMap<[u8; 3], u8> = HashMap::new();
    let mut indices = Vec::with_capacity(figure.rgb.len() / 3);
    // What this row and the next still owe, with a pixel more on both sides.
    let mut owed = [vec![[0.0f32; 3]; width + 2], vec![[0.0f32; 3]; width + 2]];
    for row in figure.rgb.chunks(3 * width) {
        for (x, pixel) in row.chunks_exact(3).enumerate() {
            let wanted: [f32; 3] = std::array::from_fn(|c| f32::from(pixel[c]) + owed[0][x + 1][c]);
            let rounded = wanted.map(|c| c.round().clamp(0.0, 255.0) as u8);
            let index = *known.entry(rounded).or_insert_with(|| nearest(palette, rounded));
            indices.push(index);
            let color = palette.get(usize::from(index)).copied().unwrap_or_default();
            for c in 0..3 {
                let rest = wanted[c].clamp(0.0, 255.0) - f32::from(color[c]);
                owed[0][x + 2][c] += rest * (7.0 / 16.0);
                owed[1][x][c] += rest * (3.0 / 16.0);
                owed[1][x + 1][c] += rest * (5.0 / 16.0);
                owed[1][x + 2][c] += rest * (1.0 / 16.0);
            }
        }
        owed.swap(0, 1);
        owed[1].fill([0.0; 3]);
    }
    indices
}

/// The colour that is nearest, by number.
fn nearest(palette: &[[u8; 3]], color: [u8; 3]) -> u8 {
    let distance =
        |other: &[u8; 3]| -> u32 { (0..3).map(|c| u32::from(color[c].abs_diff(other[c])).pow(2)).sum() };
    (0..palette.len()).min_by_key(|i| distance(&palette[*i])).unwrap_or(0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads sixels back, as a terminal would.
    fn decode(text: &str) -> (usize, usize, Vec<[u8; 3]>) {
        let body = text.strip_prefix("\x1bP0;1;0q\"1;1;").unwrap().strip_suffix("\x1b\\").unwrap();
        let number = |s: &mut &str| {
            let end = s.find(|c: char| !c.is_ascii_digit()).unwrap_or(s.len());
            let (digits, rest) = s.split_at(end);
            *s = rest;
            digits.parse::<usize>().unwrap()
        };
        let mut s = body;
        let width = number(&mut s);
        s = &s[1..];
        let height = number(&mut s);
        let (mut colors, mut pixels) = (HashMap::new(), vec![[0u8; 3]; width * height]);
        let (mut x, mut band, mut color) = (0, 0, 0);
        while let Some(first) = s.chars().next() {
            s = &s[1..];
            match first {
                '#' => {
                    color = number(&mut s);
                    if s.starts_with(';') {
                        let parts: Vec<usize> = (0..4)
                            .map(|_| {
                                s = &s[1..];
                                number(&mut s)
                            })
                            .collect();
                        colors.insert(color, [1, 2, 3].map(|i| ((parts[i] * 255 + 50) / 100) as u8));
                    }
                }
                '$' => x = 0,
                '-' => (x, band) = (0, band + 1),
                _ => {
                    let (n, c) = if first == '!' {
                        let n = number(&mut s);
                        let c = s.chars().next().unwrap();
                        s = &s[1..];
                        (n, c)
                    } else {
                        (1, first)
                    };
                    for column in x..x + n {
                        for bit in 0..6 {
                            if (c as u8 - 63) >> bit & 1 == 1 {
                                pixels[(6 * band + bit) * width + column] = colors[&color];
                            }
                        }
                    }
                    x += n;
                }
            }
        }
        (width, height, pixels)
    }

    #[test]
    fn few_colours_come_back_as_they_are() {
        let rgb: Vec<u8> =
            (0..9 * 11).flat_map(|i| [[255, 0, 0], [0, 0, 0], [255, 255, 255]][i * i % 3]).collect();
        let figure = Figure { width: 9, height: 11, rgb: rgb.clone() };
        let (width, height, pixels) = decode(&encode(&figure));
        assert_eq!((width, height), (9, 11));
        assert_eq!(pixels.concat(), rgb);
    }

    #[test]
    fn many_colours_are_right_on_average() {
        let side = 64u32;
        let rgb: Vec<u8> = (0..side * side)
            .flat_map(|i| [(i % side * 4) as u8, (i / side * 4) as u8, (i % 7 * 36) as u8])
            .collect();
        let figure = Figure { width: side, height: side, rgb: rgb.clone() };
        assert_eq!(palette(&figure).len(), COLORS);
        let shown = decode(&encode(&figure)).2.concat();
        let mean =
            |bytes: &[u8], c: usize| bytes.iter().skip(c).step_by(3).map(|b| f64::from(*b)).sum::<f64>();
        for c in 0..3 {
            let count = f64::from(side * side);
            assert!((mean(&shown, c) - mean(&rgb, c)).abs() / count < 2.0);
        }
        let worst = shown.iter().zip(&rgb).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(worst < 90, "{worst}");
    }
}
