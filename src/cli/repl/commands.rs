//! The commands of the REPL, beside the scripting language: one list, from which reading, help and
//! completion follow.

use crate::diag::{Diagnostic, nearest};

/// What a command does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Action {
    /// Says what there is, or explains a name.
    Help,
    /// Runs a script and keeps its names.
    Load,
    /// Renders the scene.
    Render,
    /// Lists the parameters.
    Params,
    /// Leaves.
    Quit,
}

/// Name, argument, meaning.
pub const COMMANDS: &[(&str, &str, &str, Action)] = &[
    (":help", "[NAME]", "what there is, or what a name, module or word means", Action::Help),
    (":load", "FILE", "run a script and keep what it defines", Action::Load),
    (":render", "[FILE]", "make a picture of the last solid or scene", Action::Render),
    (":params", "", "list the parameters", Action::Params),
    (":quit", "", "leave, as does Ctrl-D", Action::Quit),
];

/// The command in a line, with its argument; `None` if the line is not a command.
///
/// # Errors
/// For a command that there is not, or that has too much or too little behind it.
pub fn parse(line: &str) -> Option<Result<(Action, Option<&str>), Diagnostic>> {
    let line = line.trim();
    if !line.starts_with(':') {
        return None;
    }
    let (name, argument) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let argument = Some(argument.trim()).filter(|a| !a.is_empty());
    // The beginning of a name will do, as long as there is one such name.
    let mut matching = COMMANDS.iter().filter(|c| c.0.starts_with(name) && name.len() > 1);
    let (Some(&(name, wanted, _, action)), None) = (matching.next(), matching.next()) else {
        return Some(Err(unknown(name)));
    };
    Some(match (wanted, argument) {
        ("", Some(_)) => Err(Diagnostic::error(format!("`{name}` takes nothing behind it"))),
        (wanted, None) if !wanted.is_empty() && !wanted.starts_with('[') => {
            Err(Diagnostic::error(format!("`{name}` needs a file"))
                .hint(format!("for example: {name} rock.rhai")))
        }
        _ => Ok((action, argument)),
    })
}

fn unknown(name: &str) -> Diagnostic {
    let error = Diagnostic::error(format!("there is no command `{name}`"));
    match nearest(name, COMMANDS.iter().map(|c| c.0)) {
        Some(near) => error.hint(format!("did you mean `{near}`?")),
        None => {
            error.hint(format!("there are {}", COMMANDS.iter().map(|c| c.0).collect::<Vec<_>>().join(", ")))
        }
    }
}

/// One line a command.
pub fn help() -> String {
    let line = |(name, argument, meaning, _): &(&str, &str, &str, Action)| {
        format!("  {:<16} {meaning}", format!("{name} {argument}"))
    };
    COMMANDS.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read() {
        assert!(parse("1 + 1").is_none());
        assert_eq!(parse(" :help  sphere ").unwrap().unwrap(), (Action::Help, Some("sphere")));
        assert_eq!(parse(":q").unwrap().unwrap(), (Action::Quit, None));
        assert_eq!(parse(":load a b.rhai").unwrap().unwrap().1, Some("a b.rhai"));
        for bad in [":", ":x", ":quit now", ":load", ":lod x"] {
            assert!(parse(bad).unwrap().is_err(), "{bad}");
        }
    }
}
