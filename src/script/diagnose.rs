//! Errors of the script engine as diagnostics: where, what, and what to do about it, in the words
//! of scripts.

use super::engine::{Limits, Setup, Stop};
use super::fault::Fault;
use super::lexer;
use super::marks::plain;
use super::options::{self, describe, with_article};
use super::slips;
use super::wording::{function_name, lower_first, type_text, without_position};
use crate::diag::{Diagnostic, Place, Sources};
use rhai::{Dynamic, EvalAltResult, LexError, Map, ParseErrorType, Position};
use std::sync::Arc;

/// What a trace says before the name of a function.
const CALL: &str = "in the call of ";

/// What stands where a script throws an error.
const THROWN: &str = "thrown here";

/// What is needed to explain an error.
pub struct Explainer<'a> {
    /// The engine that raised it.
    pub setup: &'a Setup,
    /// How much the script may use.
    pub limits: &'a Limits,
    /// The main script's file.
    pub main: &'a str,
}

impl Explainer<'_> {
    /// The diagnostic of an error.
    pub fn explain(&self, error: &EvalAltResult) -> Diagnostic {
        let (mut error, mut file, mut trace) = (error, self.main.to_owned(), Vec::new());
        let (mut fallback, mut is_called) = (Position::NONE, false);
        loop {
            let (what, inner, source, position) = match error {
                EvalAltResult::ErrorInFunctionCall(name, source, inner, pos) => {
                    is_called = true;
                    (format!("{CALL}{}", function_name(name)), inner, source.as_str(), *pos)
                }
                EvalAltResult::ErrorInModule(name, inner, pos) => {
                    (format!("in the import of {name}"), inner, name.as_str(), *pos)
                }
                _ => break,
            };
            if let Some(place) = self.place(&file, position) {
                trace.insert(0, (what, place));
                fallback = Position::NONE;
            }
            if !source.is_empty() {
                source.clone_into(&mut file);
            }
            if let EvalAltResult::ErrorInFunctionCall(name, ..) = error {
                file = self.home(&plain(name), file);
            }
            error = inner;
        }
        let position = if error.position().is_none() { fallback } else { error.position() };
        let place = self.place(&file, position);
        let mut d = self.innermost(error, &file, is_called);
        let blamed = self.blamed(error);
        if let (Some(own), Some(call)) = (&blamed, &place)
            && own.file != call.file
        {
            trace.insert(0, ("asked for".to_owned(), call.clone()));
        }
        d.place = blamed.or_else(|| self.key_place(error, place.as_ref())).or(place);
        if let Some(argument) = fault_of(error).and_then(|fault| fault.argument)
            && !trace.is_empty()
        {
            let (call, place) = trace.remove(0);
            d.hints.extend(usage(call.trim_start_matches(CALL), &file));
            d.place = self.argument_place(&place, argument).or(Some(place));
        }
        if let EvalAltResult::ErrorParsing(kind, _) = error
            && !self.blame_a_slip(&mut d, kind, &file)
        {
            self.blame_the_bracket(&mut d, &file);
        }
        d.trace = trace;
        self.blame_the_user(&mut d, error);
        if d.message.ends_with("not nothing ()") {
            d.hints.push(
                "a function gives back what its last line is, and nothing if that is a `let`".to_owned(),
            );
        }
        d
    }

    /// The file in which a function is defined that is called in `file`: of the texts that a session has run, the engine knows
    /// the last only.
    fn home(&self, name: &str, file: String) -> String {
        let sources = self.sources();
        let defines = |text: &str| lexer::definitions(text).iter().any(|d| d.name == name);
        if file != self.main || sources.get(&*file).is_some_and(|text| defines(text)) {
            return file;
        }
        let others = sources.iter().filter(|(other, _)| !other.starts_with("std/"));
        others.filter(|(_, text)| defines(text)).map(|(other, _)| other.to_string()).next().unwrap_or(file)
    }

    pub(super) fn sources(&self) -> Sources {
        self.setup.loaded.sources.borrow().clone()
    }

    /// A position in a file, as wide as the token there; none on the lines that are added to modules.
    fn place(&self, file: &str, position: Position) -> Option<Place> {
        let line = position.line()?;
        let is_added = self.sources().get(file).is_some_and(|text| line > text.lines().count() + 1);
        let column = position.position().unwrap_or(1).max(1) as u32;
        (!is_added).then(|| self.measured(file, line as u32, column))
    }

    /// A place as wide as the token there.
    fn measured(&self, file: &str, line: u32, column: u32) -> Place {
        let sources = self.sources();
        let width = sources.get(file).map_or(1, |text| lexer::width_at(text, line, column));
        Place { file: Arc::from(file), line, column, width }
    }

    /// Where a fault itself lays the blame.
    fn blamed(&self, error: &EvalAltResult) -> Option<Place> {
        let place = *fault_of(error)?.place?;
        Some(if place.width > 1 { place } else { self.measured(&place.file, place.line, place.column) })
    }

    /// An argument of the call at a place.
    fn argument_place(&self, call: &Place, number: usize) -> Option<Place> {
        let sources = self.sources();
        let (line, column, width) =
            lexer::argument_of(sources.get(&call.file)?, call.line, call.column, number)?;
        Some(Place { file: call.file.clone(), line, column, width })
    }

    /// The key of an object map that a fault is about.
    fn key_place(&self, error: &EvalAltResult, call: Option<&Place>) -> Option<Place> {
        let key = fault_of(error)?.key?;
        let call = call?;
        let sources = self.sources();
        let text = sources.get(&call.file)?;
        let (line, column, width) = lexer::key_after(text, call.line, call.column, &key)?;
        Some(Place { file: call.file.clone(), line, column, width })
    }

    /// Where it is plain to see what was meant, that is what is wrong. Whether it is.
    fn blame_a_slip(&self, d: &mut Diagnostic, kind: &ParseErrorType, file: &str) -> bool {
        let sources = self.sources();
        // What is wrong with a text in quotation marks the engine says itself.
        let is_text =
            matches!(kind, ParseErrorType::BadInput(e) if !matches!(e, LexError::UnexpectedInput(_)));
        let text = sources.get(file).filter(|_| !is_text);
        let place = d.place.as_ref().map(|place| (place.line, place.column));
        let wants_semicolon = matches!(kind, ParseErrorType::MissingToken(token, _) if token == ";");
        let slip = text.and_then(|text| slips::slip(text, place, wants_semicolon));
        let Some(fault) = slip.map(|slip| slip.fault(file)) else { return false };
        d.place = fault.place.map(|place| *place);
        (d.message, d.label, d.hints) = (fault.message, fault.label, fault.hints);
        true
    }

    /// Where the text ends too early, the bracket that was left open is what is wrong. The engine sees more of modules than
    /// they have.
    fn blame_the_bracket(&self, d: &mut Diagnostic, file: &str) {
        let sources = self.sources();
        let Some(text) = sources.get(file) else { return };
        let Some(open) = lexer::unclosed(text) else { return };
        let is_after = |place: &Place| {
            lexer::code(text).iter().any(|t| (t.line, t.column) >= (place.line, place.column))
        };
        if !d.place.as_ref().is_some_and(is_after) {
            let place = Place { file: Arc::from(file), line: open.line, column: open.column, width: 1 };
            *d = Diagnostic::error(format!("`{}` is never closed", open.text)).at(place).label("opened here");
        }
    }

    /// An error inside the standard library is shown at the call in the user's own script.
    fn blame_the_user(&self, d: &mut Diagnostic, error: &EvalAltResult) {
        if !d.place.as_ref().is_some_and(Place::is_embedded) {
            return;
        }
        let Some(own) = d.trace.iter().position(|(_, place)| !place.is_embedded()) else { return };
        let (what, place) = d.trace[own].clone();
        let inner = d.place.replace(place.clone());
        if let Some(inner) = inner {
            d.trace.truncate(own);
            d.trace.insert(0, ("raised".to_owned(), inner));
        }
        // What the library throws itself is a sentence about the call, what comes of it inside is not.
        let is_sentence = matches!(error, EvalAltResult::ErrorRuntime(payload, _) if payload.is_string());
        if d.hints.is_empty()
            && !is_sentence
            && let Some((_, called)) = d.trace.last()
        {
            d.hints.extend(usage(what.trim_start_matches(CALL), &called.file));
        }
        d.place = self.key_place(error, Some(&place)).or(Some(place));
        // It is not the user who throws.
        d.label.take_if(|label| *label == THROWN);
        d.label.get_or_insert(what);
    }

    fn innermost(&self, error: &EvalAltResult, file: &str, is_called: bool) -> Diagnostic {
        use EvalAltResult as E;
        match error {
            E::ErrorParsing(kind, _) => parsing(kind),
            E::ErrorRuntime(payload, _) => runtime(payload),
            E::ErrorTerminated(token, _) => self.stopped(token),
            E::ErrorVariableNotFound(name, _) => self.unknown_variable(name, file, is_called),
            E::ErrorFunctionNotFound(signature, _) => self.unknown_function(signature, file),
            E::ErrorModuleNotFound(name, _) => self.unknown_module(name, file),
            E::ErrorPropertyNotFound(name, _) => {
                Diagnostic::error(format!("the object map has no property `{name}`"))
            }
            E::ErrorDotExpr(text, _) => property(text),
            E::ErrorTooManyOperations(_) => {
                Diagnostic::error(format!("the script took more than {} steps", self.limits.operations))
                    .label("still running here")
                    .hint("does a loop never end? Otherwise build less with loops and more with fields")
            }
            E::ErrorStackOverflow(_) => {
                Diagnostic::error(format!("calls are nested more than {} deep", self.limits.calls))
                    .label("one call too many")
                    .hint("does a function call itself without end?")
            }
            E::ErrorTooManyVariables(_) => {
                Diagnostic::error(format!("the script has more than {} variables", self.limits.variables))
            }
            E::ErrorTooManyModules(_) => {
                Diagnostic::error(format!("the script imports more than {} times", self.limits.modules))
                    .hint("an import inside a loop or function runs every time; move it to the top")
            }
            E::ErrorDataTooLarge(what, _) => self.too_large(what),
            E::ErrorMismatchDataType(wanted, given, _) | E::ErrorMismatchOutputType(wanted, given, _) => {
                let (wanted, given) = (with_article(&type_text(wanted)), with_article(&type_text(given)));
                let d = Diagnostic::error(format!("{wanted} is needed here, not {given}"));
                match (wanted.as_str(), given.as_str()) {
                    ("a bool", "a Field" | "a Noise") => d.hint(
                        "true or false is not a matter of place: union(a, b) and intersection(a, b) combine solids, mix(a, b, smoothstep(low, high, f)) goes from one to the other",
                    ),
                    _ => d,
                }
            }
            E::ErrorIndexingType(name, _) => {
                let ty = type_text(name.split(" [").next().unwrap_or(name));
                let d = Diagnostic::error(format!("{} has no elements to take with [ ]", with_article(&ty)));
                match ty.as_str() {
                    "Vec3" | "VectorField" => d.hint("its parts are .x, .y and .z"),
                    _ => d,
                }
            }
            E::ErrorArrayBounds(n, i, _) => {
                Diagnostic::error(format!("there is no element {i}: the array has {n}"))
                    .hint("the first element is 0")
            }
            E::ErrorStringBounds(n, i, _) => {
                Diagnostic::error(format!("there is no character {i}: the text has {n}"))
            }
            E::ErrorBitFieldBounds(n, i, _) => {
                Diagnostic::error(format!("there is no bit {i}: there are {n}"))
            }
            E::ErrorIndexNotFound(index, _) => {
                Diagnostic::error(format!("there is no element {}", describe(index)))
            }
            E::ErrorFor(_) => {
                Diagnostic::error("a `for` loop needs an array, a text or a range of whole numbers")
                    .hint("for i in 0..10 { ... }")
            }
            E::ErrorArithmetic(text, _) => arithmetic(text),
            E::ErrorAssignmentToConstant(name, _) if name.is_empty() => {
                Diagnostic::error("this is a constant and cannot be changed")
            }
            E::ErrorAssignmentToConstant(name, _) => {
                Diagnostic::error(format!("`{name}` is a constant and cannot be changed"))
                    .hint(format!("declare a variable of your own: let {name} = ..."))
            }
            E::ErrorUnboundThis(_) => {
                Diagnostic::error("`this` is bound only in functions that are called as methods")
            }
            E::ErrorVariableExists(name, _) => {
                Diagnostic::error(format!("there is a variable `{name}` already"))
            }
            E::ErrorForbiddenVariable(name, _) => {
                Diagnostic::error(format!("`{name}` cannot be the name of a variable"))
            }
            E::ErrorDataRace(..) => Diagnostic::error("a value is changed while it is in use"),
            E::ErrorNonPureMethodCallOnConstant(name, _) => {
                Diagnostic::error(format!("`{}` would change a constant", function_name(name)))
            }
            E::LoopBreak(..) => Diagnostic::error("`break` and `continue` stand inside a loop only"),
            E::ErrorSystem(text, e) => {
                Diagnostic::error(if text.is_empty() { e.to_string() } else { text.clone() })
            }
            other => Diagnostic::error(type_text(&without_position(&other.to_string()))),
        }
    }

    fn stopped(&self, token: &Dynamic) -> Diagnostic {
        match token.clone().try_cast::<Stop>() {
            Some(Stop::Cancelled) => Diagnostic::error("the script was stopped"),
            Some(Stop::Overran(name)) => Diagnostic::error(format!(
                "`{name}` was at work when the script's {:?} were up",
                self.limits.time
            ))
            .label("still at work here")
            .hint("a smaller `size` or fewer steps take less time"),
            _ => Diagnostic::error(format!("the script ran for more than {:?}", self.limits.time))
                .label("still running here")
                .hint("does a loop never end? Otherwise build less with loops and more with fields"),
        }
    }

    fn too_large(&self, what: &str) -> Diagnostic {
        let what = what.to_lowercase();
        let (thing, limit) = match () {
            () if what.contains("string") => ("a text", format!("{} characters", self.limits.text)),
            () if what.contains("array") => ("an array", format!("{} elements", self.limits.elements)),
            () if what.contains("map") => ("an object map", format!("{} elements", self.limits.elements)),
            () => ("a value", "allowed".to_owned()),
        };
        Diagnostic::error(format!("{thing} is larger than {limit}"))
            .hint("does a loop add to it without end?")
    }
}

/// How a function of the standard library is called, which is defined in a file.
fn usage(name: &str, file: &str) -> Option<String> {
    let module = file.strip_suffix(".rhai")?;
    let is_it = |e: &super::library::Entry| e.group == module && e.name.rsplit("::").next() == Some(name);
    let entries = super::std_entries().into_iter().filter(is_it);
    let signatures: Vec<String> = entries.map(|e| e.signature).collect();
    (!signatures.is_empty()).then(|| format!("it is called as {}", signatures.join(" or ")))
}

fn fault_of(error: &EvalAltResult) -> Option<Fault> {
    match error {
        EvalAltResult::ErrorRuntime(payload, _) => fault_in(payload),
        _ => None,
    }
}

fn fault_in(payload: &Dynamic) -> Option<Fault> {
    let thrown = || options::thrown(&*payload.read_lock::<Map>()?);
    payload.clone().try_cast::<Fault>().or_else(thrown)
}

fn runtime(payload: &Dynamic) -> Diagnostic {
    if let Some(fault) = fault_in(payload) {
        let mut d = Diagnostic::error(fault.message);
        (d.label, d.hints) = (fault.label, fault.hints);
        return d;
    }
    match payload.clone().into_string() {
        Ok(text) if !text.is_empty() => Diagnostic::error(text).label(THROWN),
        _ => Diagnostic::error(format!("the script threw {}", describe(payload))).label(THROWN),
    }
}

fn arithmetic(text: &str) -> Diagnostic {
    let lower = text.to_lowercase();
    let d = Diagnostic::error(
        if lower.contains("division by zero") || lower.contains("modulo") && lower.contains("zero") {
            "whole numbers cannot be divided by zero".to_owned()
        } else if lower.contains("overflow") {
            "the result does not fit into a whole number".to_owned()
        } else {
            type_text(text)
        },
    );
    if lower.contains("overflow") {
        d.hint("write one of the numbers with a fraction: 2.0 instead of 2")
    } else {
        d
    }
}

fn property(text: &str) -> Diagnostic {
    let mut quoted = text.split('\'').skip(1).step_by(2);
    match (quoted.next(), quoted.next()) {
        (Some(name), Some(ty)) => {
            let ty = type_text(ty);
            let d = Diagnostic::error(format!("{} has no property `{name}`", with_article(&ty)));
            match ty.as_str() {
                "Vec3" | "VectorField" => d.hint("its properties are x, y, z"),
                "Interval" | "Affine" => d.hint("its properties are low, high, mid, width"),
                "Region" => d.hint("its properties are x, y, z, min, max"),
                "Field" if ["x", "y", "z"].contains(&name) => {
                    d.hint(format!("it has one value; `{name}` alone is the coordinate"))
                }
                "array" | "string" if ["length", "size", "count"].contains(&name) => {
                    d.hint("how many elements it has is .len()")
                }
                "array" if ["x", "y", "z"].contains(&name) => {
                    d.hint("its elements are [0], [1] and [2]; vec3(a[0], a[1], a[2]) has x, y and z")
                }
                _ => d.hint(format!("if a function is meant, call it: .{name}()")),
            }
        }
        _ => Diagnostic::error(type_text(text)),
    }
}

fn parsing(kind: &ParseErrorType) -> Diagnostic {
    use ParseErrorType as P;
    match kind {
        P::UnexpectedEOF => {
            Diagnostic::error("the script ends in the middle of something").label("something is missing here")
        }
        P::MissingToken(token, why) => {
            let d = Diagnostic::error(format!("`{token}` is missing {}", lower_first(why)))
                .label(format!("`{token}` expected"));
            match token.as_str() {
                ";" => d.hint("statements end in a semicolon"),
                "," if why.contains("arguments to function call") => d
                    .hint("arguments have no names: cylinder(1.0, 2.0)")
                    .hint("many functions take an object map, #{ ... }"),
                _ => d,
            }
        }
        P::Reserved(word) => {
            let hint = match word.as_str() {
                "#" => "object maps are written #{ ... }, colours \"#ff8000\", and comments begin with //",
                "--" => "there is no `--`: write n -= 1, or put a space between two signs",
                "++" => "there is no `++`: write n += 1",
                "var" => "variables are made by `let`",
                "use" | "module" | "package" => "modules are brought in by import \"std/color\" as color;",
                "match" | "case" => "choices among many are made by `switch`",
                "null" | "nil" => "nothing is ()",
                "===" | "!==" => "equality is `==`, inequality `!=`",
                _ => "choose another name",
            };
            Diagnostic::error(format!("`{word}` is reserved by the language")).hint(hint)
        }
        P::ExprTooDeep => {
            Diagnostic::error("the expression is nested too deeply").hint("give parts of it names with let")
        }
        P::BadInput(e) if e.to_string().contains("'eval'") => {
            Diagnostic::error("`eval` is switched off: a script may only run what its author wrote")
        }
        P::BadInput(LexError::UnterminatedString) => Diagnostic::error("open string is not terminated")
            .hint("a text ends with its line; is there a quotation mark too many, or one too few?"),
        P::BadInput(e) => Diagnostic::error(lower_first(&e.to_string())),
        P::UnknownOperator(op) => {
            let d = Diagnostic::error(format!("there is no operator `{op}`"));
            match op.as_str() {
                "?" => d.hint("a choice is written if condition { a } else { b }"),
                "++" | "--" => d.hint("write n += 1 or n -= 1"),
                _ => d,
            }
        }
        P::AssignmentToConstant(name) => {
            Diagnostic::error(format!("`{name}` is a constant and cannot be changed"))
        }
        P::MismatchedType(wanted, _) if wanted.contains("iterable") => {
            let text = lower_first(&type_text(&kind.to_string()));
            Diagnostic::error(text).hint("a loop counts through a range: for i in 0..5 { ... }")
        }
        P::TooManyFunctions => Diagnostic::error("the script defines too many functions"),
        other => Diagnostic::error(lower_first(&type_text(&other.to_string()))),
    }
}
