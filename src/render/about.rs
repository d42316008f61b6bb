//! What a picture file says about its picture, whatever the format.

use super::{Metadata, Picture, Rect};

/// The line of a recipe that says that the picture is not finished.
const UNFINISHED: &str = "unfinished";

/// What a picture file says about its picture.
#[derive(Clone, Debug, PartialEq)]
pub struct About {
    /// Width of the whole picture in pixels.
    pub width: u32,
    /// Height of the whole picture in pixels.
    pub height: u32,
    /// The part of it that the file holds.
    pub window: Rect,
    /// Text of the script.
    pub script: String,
    /// Parameters with the values used, one a line.
    pub parameters: String,
    /// How to make the same picture again; see [`Metadata::recipe`].
    pub recipe: String,
}

impl About {
    /// What there is to say about a picture. One that is not finished says so, so that nobody takes it for a part of a
    /// picture, or for a frame.
    pub(super) fn new(picture: &Picture, metadata: &Metadata) -> About {
        let Picture { width, height, window, finished, .. } = *picture;
        let mut recipe = metadata.recipe.clone();
        if !finished {
            recipe =
                if recipe.is_empty() { UNFINISHED.to_owned() } else { format!("{recipe}\n{UNFINISHED}") };
        }
        let (script, parameters) = (metadata.script.clone(), metadata.parameters());
        About { width, height, window, script, parameters, recipe }
    }

    /// Whether the window is all of the picture.
    pub fn is_whole(&self) -> bool {
        self.window == Rect::whole(self.width, self.height)
    }

    /// Whether the picture was stopped before it was finished.
    pub fn is_unfinished(&self) -> bool {
        self.recipe.lines().next_back() == Some(UNFINISHED)
    }
}
