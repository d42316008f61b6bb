//! The frames of an animation: their numbers, their times, and the names of their files.

use super::report::Failure;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Highest number of a frame: more than a week at 24 frames a second would need.
const LAST: u32 = 99_999_999;

/// Numbers of frames: from the first to the last, by steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    first: u32,
    last: u32,
    step: u32,
}

impl Frames {
    /// The numbers, one after the other.
    pub fn numbers(self) -> impl Iterator<Item = u32> {
        (self.first..=self.last).step_by(self.step as usize)
    }

    /// Whether none is left out.
    pub fn are_consecutive(self) -> bool {
        self.step == 1
    }

    /// The first number.
    pub fn first(self) -> u32 {
        self.first
    }

    /// From each number to the next.
    pub fn step(self) -> u32 {
        self.step
    }

    /// Those from the least of some rising numbers to the greatest, as close as the closest two of them; of two it is not
    /// known whether those between them were meant. None of no numbers.
    pub fn through(numbers: &[u32]) -> Option<Frames> {
        let (&first, &last) = (numbers.first()?, numbers.last()?);
        let closest = numbers.windows(2).map(|w| w[1] - w[0]).min().filter(|_| numbers.len() > 2);
        Some(Frames { first, last, step: closest.unwrap_or(1) })
    }
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Frames, String> {
        let example = "for example: --frames 1-250, or every fifth: --frames 1-250:5";
        let number = |s: &str| s.trim().parse::<u32>().ok().filter(|n| *n <= LAST);
        let (range, step) = text.split_once(':').unwrap_or((text, "1"));
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (Some(first), Some(last), Some(step)) = (number(first), number(last), number(step)) else {
            return Err(format!("frames are whole numbers up to {LAST}; {example}"));
        };
        if first > last {
            return Err(format!("the first frame, {first}, comes after the last, {last}; {example}"));
        }
        if step == 0 {
            return Err(format!("a step of 0 never arrives; {example}"));
        }
        Ok(Frames { first, last, step })
    }
}

/// Parses a number of frames a second.
pub fn rate(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(rate) if rate > 0.0 && rate <= 1000.0 => Ok(rate),
        _ => Err("a number above 0, up to 1000, is needed; for example: --fps 25".into()),
    }
}

/// The names of frames: a path with a row of `#` where the number goes, filled up with zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    /// The pattern in a path.
    ///
    /// # Errors
    /// A sentence if its file name has no row of `#`, or more than one.
    pub fn of(path: &Path) -> Result<Pattern, Failure> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let rows: Vec<&str> = name.split(|c| c != '#').filter(|row| !row.is_empty()).collect();
        let [row] = rows[..] else {
            let message = match rows.len() {
                0 => format!("`{name}` does not say where the number of a frame goes"),
                _ => format!("`{name}` has two places for the number of a frame"),
            };
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().replace('#', "");
            let ending = path.extension().unwrap_or("png".as_ref()).to_string_lossy();
            let example = format!("{}.####.{ending}", stem.trim_end_matches('.'));
            return Err(Failure::usage(
                message,
                format!("for example: {}", path.with_file_name(example).display()),
            ));
        };
        let (before, after) = name.split_once(row).unwrap_or((&name, ""));
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Pattern { folder, before: before.into(), digits: row.len(), after: after.into() })
    }

    /// The file of a frame.
    pub fn path(&self, number: u32) -> PathBuf {
        let Pattern { before, digits, after, .. } = self;
        self.folder.join(format!("{before}{number:0digits$}{after}"))
    }

    /// The pattern as `printf` has it, which is how ffmpeg names frames.
    pub fn printf(&self) -> PathBuf {
        let plain = |text: &str| text.replace('%', "%%");
        let name = format!("{}%0{}d{}", plain(&self.before), self.digits, plain(&self.after));
        Path::new(&plain(&self.folder.to_string_lossy())).join(name)
    }

    /// The numbers of the files that there are, in order.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn numbers(&self) -> std::io::Result<Vec<u32>> {
        let folder = if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder };
        let mut numbers = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            numbers.extend(self.number(&entry?.file_name().to_string_lossy()));
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    /// The number in a file name of this pattern.
    fn number(&self, name: &str) -> Option<u32> {
        let digits = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let number = digits.parse().ok()?;
        // Not `+1`, nor a number with more zeros than it is written with.
        (self.path(number).file_name() == Some(name.as_ref())).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_frames() {
        let of = |text: &str| text.parse::<Frames>().map(|f| f.numbers().collect::<Vec<_>>());
        assert_eq!(of("3-5").unwrap(), [3, 4, 5]);
        assert_eq!(of("0-10:4").unwrap(), [0, 4, 8]);
        assert_eq!(of("7").unwrap(), [7]);
        assert!(of("5-1").unwrap_err().contains("5, comes after the last, 1"));
        for bad in ["", "a-b", "1-", "-3", "1-5:0", "1-5:x", "1-999999999"] {
            assert!(of(bad).unwrap_err().contains("--frames 1-250:5"), "{bad}");
        }
    }

    #[test]
    fn steps_of_frames_are_seen() {
        let through = |numbers: &[u32]| Frames::through(numbers).map(|f| (f.first, f.last, f.step));
        assert_eq!(through(&[1, 6, 11, 16]), Some((1, 16, 5)));
        assert_eq!(through(&[1, 11, 16]), Some((1, 16, 5)));
        assert_eq!(through(&[7, 9]), Some((7, 9, 1)));
        assert_eq!((through(&[7]), through(&[])), (Some((7, 7, 1)), None));
    }

    #[test]
    fn names_of_frames() {
        let pattern = Pattern::of(Path::new("out/rock.####.png")).unwrap();
        assert_eq!(pattern.path(7), Path::new("out/rock.0007.png"));
        assert_eq!(pattern.path(12345), Path::new("out/rock.12345.png"));
        assert_eq!(pattern.printf(), Path::new("out/rock.%04d.png"));
        assert_eq!(Pattern::of(Path::new("50%/a%#.png")).unwrap().printf(), Path::new("50%%/a%%%01d.png"));
        let number = |name: &str| pattern.number(name);
        assert_eq!((number("rock.0007.png"), number("rock.12345.png")), (Some(7), Some(12345)));
        for other in
            ["rock.007.png", "rock.00012.png", "rock.+001.png", "rock.0007.2of4.png", ".rock.0007.png.claim"]
        {
            assert_eq!(number(other), None, "{other}");
        }
        for (bad, better) in [("out/rock.png", "out/rock.####.png"), ("a#b#.exr", "ab.####.exr")] {
            let Err(Failure::Usage(error)) = Pattern::of(Path::new(bad)) else { panic!("{bad}") };
            assert!(error.hints[0].contains(better), "{:?}", error.hints);
        }
    }
}
