//! What a picture was made of and how, so that whoever finds it later can tell whether it would come out the same.
//!
//! A recipe is a text of lines. It begins with the version of the program and what was asked of it, and goes on with
//! every file that the script read, itself included, with a fingerprint of what it held (or that it was not there):
//!
//! ```text
//! orogen 0.1.0
//! size 800x600
//! caster auto
//! time 0.04
//! set relief=0.04
//! file 5d0e9b3c1f6a48d2b7c4e8a90f1d2c3b rock.rhai
//! none std/fractal.rhai
//! ```
//!
//! A script sees nothing else, so a picture with the recipe of today need not be made again, and finding that out takes
//! reading files, not running the script. Files go by their names from the folder of the script, so that a picture has
//! the same recipe wherever that is. The part of the picture that was wanted is not in it: parts have that of the whole.

use super::{Loaded, Order, Session};
use crate::num::Digest;
use crate::render::{Precision, SOFTWARE};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Fingerprints of files that were read already; `None` for those that are not there. For questions that are asked
/// shortly after one another about the same files.
pub type Digests = BTreeMap<PathBuf, Option<Digest>>;

impl Session {
    /// The recipe of a picture of what was loaded.
    pub fn recipe(&self, loaded: &Loaded, order: &Order) -> String {
        let mut lines = self.wishes(order);
        lines.extend(loaded.reads.contents().map(|(path, bytes)| {
            let name = path.strip_prefix(self.folder()).unwrap_or(path).display();
            match bytes {
                Some(bytes) => format!("file {} {name}", digest(bytes)),
                None => format!("none {name}"),
            }
        }));
        lines.join("\n")
    }

    /// Why a picture with that recipe would now come out otherwise, as a clause such as `rock.rhai has changed`;
    /// `None` if it would not.
    pub fn departure(&self, recipe: &str, order: &Order, known: &mut Digests) -> Option<String> {
        let is_file = |line: &&str| line.starts_with("file ") || line.starts_with("none ");
        let (files, then): (Vec<&str>, Vec<&str>) = recipe.lines().partition(is_file);
        let now = self.wishes(order);
        if let Some(line) = then.iter().find(|line| now.iter().all(|l| l != *line)) {
            return Some(format!("it was made with `{line}`"));
        }
        if let Some(line) = now.iter().find(|line| !then.contains(&line.as_str())) {
            return Some(format!("it was made without `{line}`"));
        }
        files.into_iter().find_map(|line| self.change(line, known)).or_else(|| {
            // A script was read, or there would be no picture.
            (!recipe.contains("\nfile ")).then(|| "it does not say what it was made of".to_owned())
        })
    }

    /// How a file is not what a line of a recipe says.
    fn change(&self, line: &str, known: &mut Digests) -> Option<String> {
        let (kind, rest) = line.split_once(' ')?;
        let (then, name) = if kind == "file" { rest.split_once(' ')? } else { ("", rest) };
        let path = self.folder().join(name);
        let read = || self.world.bytes(&path).ok().map(|bytes| digest(&bytes));
        let now = *known.entry(path.clone()).or_insert_with(read);
        match now {
            None if kind == "file" => Some(format!("{} is gone", path.display())),
            Some(_) if kind == "none" => Some(format!("{} was not there", path.display())),
            Some(now) if now.to_string() != then => Some(format!("{} has changed", path.display())),
            _ => None,
        }
    }

    /// What is asked for, line by line; what follows from the script is not.
    fn wishes(&self, order: &Order) -> Vec<String> {
        let mut lines = vec![SOFTWARE.to_owned()];
        lines.extend(order.size.map(|(width, height)| format!("size {width}x{height}")));
        lines.extend(order.samples.map(|n| format!("samples {n}")));
        let caster = crate::cast::Kind::ALL.iter().find(|kind| kind.0 == order.caster);
        lines.extend(caster.map(|kind| format!("caster {}", kind.1)));
        lines.extend(order.denoise.then(|| "denoised".to_owned()));
        lines.extend(order.components.then(|| "components".to_owned()));
        lines.extend((order.precision == Precision::Half).then(|| "light in halves".to_owned()));
        lines.push(format!("time {}", self.time));
        lines.extend(self.params.iter().map(|(name, value)| format!("set {name}={value}")));
        lines
    }

    /// Where the script is, and everything that it reads.
    fn folder(&self) -> &Path {
        self.script.parent().unwrap_or(Path::new(""))
    }
}

fn digest(bytes: &[u8]) -> Digest {
    let mut digest = Digest::default();
    digest.bytes(bytes);
    digest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Memory;
    use std::sync::Arc;

    fn session(files: &[(&str, &str)]) -> Session {
        let files = files.iter().map(|(name, text)| (name.into(), text.to_string())).collect();
        Session::new("at/a.rhai", Arc::new(Memory(files)))
    }

    #[test]
    fn a_recipe_holds_until_something_changes() {
        let script = "import \"b\" as b; import \"std/fractal\" as f; sphere(b::r())";
        let files = [("at/a.rhai", script), ("at/b.rhai", "fn r() { 1.0 }")];
        let mut first = session(&files);
        let order = Order { samples: Some(2), ..Order::default() };
        let loaded = first.load(&Arc::default());
        assert!(loaded.scene.is_some(), "{:?}", loaded.diagnostics);
        let recipe = first.recipe(&loaded, &order);
        assert!(recipe.contains("\nnone std/fractal.rhai") && recipe.contains(" b.rhai"), "{recipe}");
        let departs =
            |session: &Session, order: &Order| session.departure(&recipe, order, &mut Digests::new());
        assert_eq!(departs(&first, &order), None);
        let more = Order { samples: Some(3), ..order };
        assert_eq!(departs(&first, &more).unwrap(), "it was made with `samples 2`");
        assert_eq!(
            departs(&first, &Order { size: Some((9, 9)), ..order }).unwrap(),
            "it was made without `size 9x9`"
        );
        first.set(BTreeMap::new(), 1.0);
        assert_eq!(departs(&first, &order).unwrap(), "it was made with `time 0`");
        let other = session(&[files[0], ("at/b.rhai", "fn r() { 2.0 }")]);
        assert_eq!(departs(&other, &order).unwrap(), "at/b.rhai has changed");
        assert_eq!(departs(&session(&files[..1]), &order).unwrap(), "at/b.rhai is gone");
        let shadowed = session(&[files[0], files[1], ("at/std/fractal.rhai", "")]);
        assert_eq!(departs(&shadowed, &order).unwrap(), "at/std/fractal.rhai was not there");
        assert!(first.departure("", &order, &mut Digests::new()).is_some());
    }
}
