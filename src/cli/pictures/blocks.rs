//! Pictures of characters, for every terminal that has colours: the upper half block `▀` has the colour of one pixel
//! and stands on that of the pixel below it.

use crate::analysis::plot::Figure;
use std::fmt::Write;

/// A picture in lines of text, a column for each pixel and a line for each two rows.
pub fn encode(figure: &Figure, true_color: bool) -> String {
    let pixel = |x: u32, y: u32| {
        // Below the last row of an odd number there is more of the same.
        let i = 3 * (y.min(figure.height.saturating_sub(1)) * figure.width + x) as usize;
        color([figure.rgb[i], figure.rgb[i + 1], figure.rgb[i + 2]], true_color)
    };
    let mut out = String::new();
    for y in (0..figure.height).step_by(2) {
        let mut last = None;
        for x in 0..figure.width {
            let colors = (pixel(x, y), pixel(x, y + 1));
            // Writing to a text cannot fail.
            if last.as_ref() != Some(&colors) {
                let _ = write!(out, "\x1b[38;{};48;{}m", colors.0, colors.1);
            }
            out.push('▀');
            last = Some(colors);
        }
        out += "\x1b[0m\n";
    }
    out.trim_end_matches('\n').to_owned()
}

/// A colour as terminals want it: of 16 million, or the nearest in the cube of 216.
fn color([r, g, b]: [u8; 3], true_color: bool) -> String {
    if true_color {
        return format!("2;{r};{g};{b}");
    }
    let level = |c: u8| match c {
        0..48 => 0,
        48..115 => 1,
        _ => (u32::from(c) - 35) / 40,
    };
    format!("5;{}", 16 + 36 * level(r) + 6 * level(g) + level(b))
}

/// The same picture in another size: each pixel is the mean of what it covers.
pub fn resized(figure: &Figure, width: u32, height: u32) -> Figure {
    let (width, height) = (width.max(1), height.max(1));
    let mut rgb = Vec::with_capacity(3 * (width * height) as usize);
    let covers = |i: u32, n: u32, of: u32| {
        let at = |i: u32| (u64::from(i) * u64::from(of) / u64::from(n)) as u32;
        at(i)..at(i + 1).max(at(i) + 1).min(of)
    };
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut count) = ([0u64; 3], 0);
            for row in covers(y, height, figure.height) {
                for column in covers(x, width, figure.width) {
                    let i = 3 * (row as usize * figure.width as usize + column as usize);
                    (0..3).for_each(|c| sum[c] += u64::from(figure.rgb[i + c]));
                    count += 1;
                }
            }
            rgb.extend(sum.map(|s| (s / count.max(1)) as u8));
        }
    }
    Figure { width, height, rgb }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_rows_are_a_line() {
        let figure =
            Figure { width: 2, height: 3, rgb: vec![1, 2, 3, 1, 2, 3, 4, 5, 6, 4, 5, 6, 7, 8, 9, 0, 0, 0] };
        let text = encode(&figure, true);
        let first = "\x1b[38;2;1;2;3;48;2;4;5;6m▀▀\x1b[0m";
        let second = "\x1b[38;2;7;8;9;48;2;7;8;9m▀\x1b[38;2;0;0;0;48;2;0;0;0m▀\x1b[0m";
        assert_eq!(text, format!("{first}\n{second}"));
    }

    #[test]
    fn without_true_colour_the_nearest_is_taken() {
        assert_eq!(color([255, 0, 95], false), "5;197");
        assert_eq!(color([0; 3], false), "5;16");
        assert_eq!(color([255; 3], false), "5;231");
    }

    #[test]
    fn sizes_change_by_means() {
        let figure = Figure::grey(4, 2, [0, 10, 20, 30, 100, 110, 120, 130].into_iter());
        assert_eq!(resized(&figure, 2, 1).rgb, [55, 55, 55, 75, 75, 75]);
        assert_eq!(resized(&figure, 8, 2).width, 8);
        assert_eq!(resized(&figure, 4, 2).rgb, figure.rgb);
    }
}
