//! What scripts read from files other than scripts.

use super::{Call, Library};
use crate::diag::Diagnostic;
use crate::expr::text;
use crate::script::fault::{Fault, Outcome};
use crate::script::modules::Resolver;
use crate::script::value::Field;
use rhai::{Dynamic, Map};

pub(super) fn register(lib: &mut Library<'_>) {
    let folder = lib.folder.clone();
    lib.def(
        "load_expression(file)",
        "The field that a text file describes, one operation a line, as Fidget and its relatives write them (`.vm`). The file is in the folder of the main script or below; its last line is the result. Its z axis is ours: what stands upright along z there is turned up by .rotated([1, 0, 0], -90).",
        "load_expression(\"nut.vm\")",
        move |c| {
            let hint = "load_expression reads plain text, a line `name operation arguments` for each operation";
            let (file, text) = folder.file(&c.text(0)?).map_err(|fault| match fault.hints.is_empty() {
                true => fault.hint(hint),
                false => fault,
            })?;
            let node = text::read(&mut c.host.graph.borrow_mut(), &file, &text).map_err(Fault::from)?;
            Ok(Dynamic::from(Field { node, color: None }))
        },
    );
}

/// Declares a function of a file and options, and the same without options.
pub(super) fn with_options(
    lib: &mut Library<'_>,
    name: &str,
    doc: &str,
    example: &str,
    f: fn(&Call<'_>, &Resolver) -> Outcome<Dynamic>,
) {
    let folder = lib.folder.clone();
    lib.def(&format!("{name}(file, options)"), doc, example, move |c| f(c, &folder));
    let folder = lib.folder.clone();
    lib.bind(name, 1, move |c| {
        let args = [c.args[0].clone(), Dynamic::from(Map::new())];
        f(&Call { args: &args, place: c.place.clone(), ..*c }, &folder)
    });
}

impl From<Box<Diagnostic>> for Fault {
    fn from(d: Box<Diagnostic>) -> Self {
        let fault = Fault::new(d.message).at(d.place);
        d.hints.into_iter().fold(fault, Fault::hint)
    }
}
