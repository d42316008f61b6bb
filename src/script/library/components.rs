//! Which components of a solid are kept: floating crumbs, and their shadows, vanish from pictures and files.

use super::{Call, Library};
use crate::scene::{Keep, Measure};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::Options;
use crate::script::value::{Field, number};
use rhai::Dynamic;

/// A solid of which only some components are kept. It is no function of space any more, so nothing can be computed
/// with it: it is the last thing that happens to a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corrected {
    /// The solid with all its components.
    pub field: Field,
    /// Which are kept.
    pub keep: Keep,
}

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Corrected>("Corrected");
    lib.def(
        "largest_component(f)",
        "The solid without what floats beside its main component, the one with the most minima; of several with as many, the one of largest volume. It is for scene(#{ surface: ... }), or the end of a script; colour it before. Of a field that is not C2, or whose critical points are not all found, it is the one of largest volume.",
        "largest_component(sphere(1.0) + 0.8 * gradient(7).scaled(4.0))",
        |c| corrected(c, Keep::Most(Measure::Minima)),
    );
    lib.def(
        "largest_component(f, by)",
        "The same by \"minima\" or by \"volume\".",
        "largest_component(sphere(1.0) + 0.8 * gradient(7).scaled(4.0), \"volume\")",
        |c| {
            let by = match c.text(1)?.as_str() {
                "minima" => Measure::Minima,
                "volume" => Measure::Volume,
                _ => return Err(c.wrong(1, "\"minima\" or \"volume\"")),
            };
            corrected(c, Keep::Most(by))
        },
    );
    let sentence = "The solid without the components that have fewer minima than a share of the main one's, 0.1 if none is given; of a field that is not C2, or whose critical points are not all found, that are smaller than that share of its volume.";
    let example = "without_specks(sphere(1.0) + 0.8 * gradient(7).scaled(4.0))";
    lib.def("without_specks(f)", sentence, example, |c| corrected(c, Keep::Share(0.1)));
    lib.def(
        "without_specks(f, share)",
        sentence,
        "without_specks(sphere(1.0) + 0.8 * gradient(7).scaled(4.0), 0.5)",
        |c| {
            let share = number(&c.args[1]).filter(|s| (0.0..=1.0).contains(s));
            let wrong = || Fault::new("the share must be a number from 0 to 1").hint("for example: 0.1");
            corrected(c, Keep::Share(share.ok_or_else(wrong)?))
        },
    );
    lib.def(
        "component_of(f, p)",
        "The component of a solid that holds a point.",
        "component_of(sphere(1.0) + 0.8 * gradient(7).scaled(4.0), [0, 0, 0])",
        |c| {
            let p = c.vec3(1)?;
            corrected(c, Keep::Holding(p))
        },
    );
    lib.def(
        "component_of(f, p, options)",
        "The same, found out as rays need it: for planets, on which there is too much to find it all at once. Options: feature, the size of the smallest features of the field, which must be C2; of gradient(7).scaled(4e4) that is 1 / 4e4. What is known of a place is known faster the closer to p it is.",
        "component_of(sphere(1.0) + 2e-4 * gradient(7).scaled(4e4), [0, 0, 0], #{ feature: 2.5e-5 })",
        |c| {
            let core = c.vec3(1)?;
            let mut o = Options::new(c, 2)?;
            let feature = o.number("feature", 1e-9..=1e3, 0.0)?;
            o.finish()?;
            if feature == 0.0 {
                let fault = Fault::new("the size of the smallest features is missing");
                return Err(fault.key("feature").hint("for example: #{ feature: 2.5e-5 }"));
            }
            corrected(c, Keep::Near { core, feature })
        },
    );
}

fn corrected(c: &Call<'_>, keep: Keep) -> Outcome<Dynamic> {
    Ok(Dynamic::from(Corrected { field: c.field(0)?, keep }))
}
