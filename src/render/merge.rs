//! Parts of a picture put together: the result is, byte for byte, the file of the picture rendered whole.
//!
//! Nothing is blended. Parts must have no pixel in common and leave none out, and say the same about the picture: its
//! size, script, parameters and recipe. Since pixels have the same bits in every window (8-bit ones are dithered by their
//! place in the whole picture), putting them in their places is all there is to do.

use super::saved::Content;
use super::{About, Format, Rect, Saved, openexr::Sheet};
use std::path::{Path, PathBuf};

/// Why parts are not those of one picture.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum MergeError {
    /// There are none.
    #[error("there are no parts; name the files to put together")]
    Nothing,
    /// One is a PNG, another an EXR, or their channels are not the same.
    #[error("{part:?} does not hold the same channels as {first:?}; give parts of one format and precision")]
    Format {
        /// The part that differs.
        part: PathBuf,
        /// From this one.
        first: PathBuf,
    },
    /// The whole is to be of another format than the parts.
    #[error("{part:?} and {whole:?} are of different formats; give the whole the ending of its parts")]
    Ending {
        /// A part.
        part: PathBuf,
        /// The file of the whole.
        whole: PathBuf,
    },
    /// One is not finished.
    #[error("{0:?} was stopped before it was finished; render it again")]
    Unfinished(PathBuf),
    /// One says something else about the picture.
    #[error(
        "{part:?} is no part of the same picture as {first:?}: {what}; render it again as the others, or leave it out"
    )]
    Stranger {
        /// The part that differs.
        part: PathBuf,
        /// From this one.
        first: PathBuf,
        /// In what.
        what: String,
    },
    /// Two have pixels in common.
    #[error("{part:?} and {other:?} both hold the pixels {both}; leave one of them out")]
    Overlap {
        /// One part.
        part: PathBuf,
        /// Another.
        other: PathBuf,
        /// The pixels.
        both: Rect,
    },
    /// Pixels are in none.
    #[error("no part holds the pixels {0}; render them with --region {0}, or name the part that is missing")]
    Hole(Rect),
}

/// Puts parts together to a picture that is to be written to `path`.
///
/// # Errors
/// [`MergeError`] names the part that does not belong, and what to do about it.
pub fn merge(parts: &[Saved], path: &Path) -> Result<Saved, MergeError> {
    let first = parts.first().ok_or(MergeError::Nothing)?;
    for part in parts {
        belongs(part, first)?;
    }
    let windows: Vec<Rect> = parts.iter().map(|p| p.about.window).collect();
    for (i, part) in parts.iter().enumerate() {
        let overlap = |other: &Saved| part.about.window.intersection(&other.about.window);
        if let Some((other, both)) = parts[..i].iter().find_map(|other| Some((other, overlap(other)?))) {
            return Err(MergeError::Overlap { part: part.path.clone(), other: other.path.clone(), both });
        }
    }
    let whole = Rect::whole(first.about.width, first.about.height);
    if let Some(hole) = hole(&windows, whole) {
        return Err(MergeError::Hole(hole));
    }
    let content = joined(parts, whole, path)?;
    Ok(Saved { path: path.to_owned(), about: About { window: whole, ..first.about.clone() }, content })
}

/// Whether a part says about its picture what the first one does.
fn belongs(part: &Saved, first: &Saved) -> Result<(), MergeError> {
    let (a, b) = (&part.about, &first.about);
    if a.is_unfinished() {
        return Err(MergeError::Unfinished(part.path.clone()));
    }
    let what = if (a.width, a.height) != (b.width, b.height) {
        format!("that has {} x {} pixels, not {} x {}", b.width, b.height, a.width, a.height)
    } else if a.script != b.script {
        "the script was another".to_owned()
    } else if a.parameters != b.parameters {
        format!("the parameters were {}, not {}", one_line(&a.parameters), one_line(&b.parameters))
    } else if let Some(what) = difference(&a.recipe, &b.recipe) {
        what
    } else {
        return Ok(());
    };
    Err(MergeError::Stranger { part: part.path.clone(), first: first.path.clone(), what })
}

fn one_line(parameters: &str) -> String {
    if parameters.is_empty() { "none".to_owned() } else { parameters.replace('\n', ", ") }
}

/// In what a recipe differs from another, by the first line that does.
fn difference(recipe: &str, other: &str) -> Option<String> {
    let new = |a: &str, b: &str| a.lines().find(|line| b.lines().all(|l| l != *line)).map(str::to_owned);
    match (new(recipe, other), new(other, recipe)) {
        (Some(a), Some(b)) => Some(format!("it was made with `{a}`, that with `{b}`")),
        (Some(a), None) => Some(format!("it was made with `{a}`, that was not")),
        (None, Some(b)) => Some(format!("it was made without `{b}`")),
        (None, None) => None,
    }
}

/// Pixels of the whole that no window has: a rectangle of them that begins at the first. Windows have none in common.
fn hole(windows: &[Rect], whole: Rect) -> Option<Rect> {
    let held = |x: u32, y: u32| {
        windows.iter().any(|w| (w.x..w.right()).contains(&x) && (w.y..w.bottom()).contains(&y))
    };
    // Above the first such pixel and to its left there are windows, or the picture ends.
    let mut columns: Vec<u32> =
        windows.iter().map(Rect::right).chain([0]).filter(|&x| x < whole.width).collect();
    let mut rows: Vec<u32> =
        windows.iter().map(Rect::bottom).chain([0]).filter(|&y| y < whole.height).collect();
    columns.sort_unstable();
    rows.sort_unstable();
    let places = rows.iter().flat_map(|&y| columns.iter().map(move |&x| (x, y)));
    let (x, y) = places.into_iter().find(|&(x, y)| !held(x, y))?;
    let beside = windows.iter().filter(|w| (w.y..w.bottom()).contains(&y) && w.x > x);
    let right = beside.map(|w| w.x).min().unwrap_or(whole.width);
    let below = windows.iter().filter(|w| w.x < right && w.right() > x && w.y > y);
    let bottom = below.map(|w| w.y).min().unwrap_or(whole.height);
    Some(Rect { x, y, width: right - x, height: bottom - y })
}

/// The pixels of all parts, each in its place, for a file of that name.
fn joined(parts: &[Saved], whole: Rect, path: &Path) -> Result<Content, MergeError> {
    let unlike = |part: &Saved| MergeError::Format { part: part.path.clone(), first: parts[0].path.clone() };
    if Format::of(&parts[0].path).ok() != Format::of(path).ok() {
        return Err(MergeError::Ending { part: parts[0].path.clone(), whole: path.to_owned() });
    }
    match &parts[0].content {
        Content::Png(_) => {
            let mut all = vec![[0; 3]; whole.area() as usize];
            for part in parts {
                let Content::Png(bytes) = &part.content else { return Err(unlike(part)) };
                part.about.window.put(bytes.as_chunks().0, whole, &mut all);
            }
            Ok(Content::Png(all.into_flattened()))
        }
        Content::OpenExr(first) => {
            let mut sheets = Vec::new();
            for part in parts {
                match &part.content {
                    Content::OpenExr(sheet) if sheet.is_like(first) => {
                        sheets.push((part.about.window, &**sheet))
                    }
                    _ => return Err(unlike(part)),
                }
            }
            let sheet = Sheet::joined(&sheets, whole).ok_or_else(|| unlike(&parts[0]))?;
            Ok(Content::OpenExr(Box::new(sheet)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rects(texts: &[&str]) -> Vec<Rect> {
        texts.iter().map(|t| t.parse().unwrap()).collect()
    }

    #[test]
    fn holes_are_found() {
        let whole = Rect::whole(100, 60);
        let of = |texts: &[&str]| hole(&rects(texts), whole).map(|r| r.to_string());
        assert_eq!(of(&["0,0,100x60"]), None);
        assert_eq!(of(&[]).unwrap(), "0,0,100x60");
        assert_eq!(of(&["0,0,50x60", "50,0,50x30", "50,30,50x30"]), None);
        assert_eq!(of(&["0,0,50x60", "50,0,50x30"]).unwrap(), "50,30,50x30");
        assert_eq!(of(&["0,0,50x30", "50,0,50x30", "80,30,20x30"]).unwrap(), "0,30,80x30");
        assert_eq!(of(&["10,0,90x60"]).unwrap(), "0,0,10x60");
        assert_eq!(of(&["0,0,100x20", "0,20,40x20", "60,20,40x20", "0,40,100x20"]).unwrap(), "40,20,20x20");
    }

    #[test]
    fn recipes_differ_in_a_line() {
        assert_eq!(difference("a\nb", "a\nb"), None);
        assert_eq!(difference("a\nb", "a\nc").unwrap(), "it was made with `b`, that with `c`");
        assert_eq!(difference("a", "a\nc").unwrap(), "it was made without `c`");
    }
}
