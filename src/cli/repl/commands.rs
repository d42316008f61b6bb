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
    /// Writes the session as a script.
    Save,
    /// Renders the scene.
    Render,
    /// Draws a function along a line.
    Plot,
    /// Draws a field on a plane.
    Slice,
    /// Shows the expression graph.
    Tree,
    /// Says what an evaluation costs.
    Cost,
    /// Says what a solid is connected with.
    Topology,
    /// Lists the parameters.
    Params,
    /// Leaves.
    Quit,
}

/// A command.
pub struct Command {
    /// How it is called.
    pub name: &'static str,
    /// What stands behind it.
    pub argument: &'static str,
    /// What it does, in a line.
    pub meaning: &'static str,
    /// What it does, for the program.
    pub action: Action,
    /// More about it.
    more: &'static str,
    /// How it is used.
    pub examples: &'static [&'static str],
}

/// Every command.
pub const COMMANDS: &[Command] = &[
    Command {
        name: ":help",
        argument: "[NAME]",
        meaning: "what there is, or what a name, module, word or command means",
        action: Action::Help,
        more: "Functions are explained with their signatures and an example; a module or a heading by what is in \
               it; another word by the functions that speak of it.",
        examples: &[":help sphere", ":help fractal", ":help hurst", ":help :slice"],
    },
    Command {
        name: ":load",
        argument: "FILE",
        meaning: "run a script and keep what it defines",
        action: Action::Load,
        more: "Files that it imports at its top are looked for in its folder, and so are later ones, unless some of another \
               folder were imported before.",
        examples: &[":load rock.rhai"],
    },
    Command {
        name: ":save",
        argument: "FILE",
        meaning: "write what was typed and loaded, as a script that runs",
        action: Action::Save,
        more: "Inputs that failed are left out. Where a function was defined again, the last one counts, and it is an \
               error if that makes a difference; the last solid or scene becomes the value of the script. A file that is \
               there, and was neither loaded nor saved in this session, is kept as FILE~.",
        examples: &[":save rock.rhai"],
    },
    Command {
        name: ":render",
        argument: "[FILE]",
        meaning: "make a picture of the last solid or scene",
        action: Action::Render,
        more: "The last one is what was answered last, or given to a variable with `let` or `=`. It is shown in the \
               terminal, as large as fits. With FILE, or where the terminal shows no pictures, it is as large as the \
               script says and goes to that file, or to one named after the script.",
        examples: &[":render", ":render rock.png"],
    },
    Command {
        name: ":plot",
        argument: "F, .. along FROM..TO",
        meaning: "draw functions along a ray or against a variable",
        action: Action::Plot,
        more: "FROM and TO are points, or numbers with the name of a variable before them: x, y, z or time; all \
               others are 0. With `to FILE.png` at the end the curves go to a file.",
        examples: &[
            ":plot sphere(1.0) along [-2, 0, 0]..[2, 1, 0]",
            ":plot sin(x), cos(x) along x=0..TAU",
            ":plot gradient(7) along x=0..8 to noise.png",
        ],
    },
    Command {
        name: ":slice",
        argument: "[F] [z=0] [in R]",
        meaning: "draw a plane through a field: inside, outside, lines of equal value",
        action: Action::Slice,
        more: "Blue is inside, ochre outside, the dark line is the surface. The plane is across x, y or z; it \
               shows the solid, or with `in` what is between -R and R, or within LOW..HIGH, along both axes. With \
               `to FILE.png` at the end it goes to a file.",
        examples: &[
            ":slice f",
            ":slice torus(1.0, 0.4) y=0.1",
            ":slice f z=0 in 0.2..0.6",
            ":slice f to f.png",
        ],
    },
    Command {
        name: ":tree",
        argument: "[F]",
        meaning: "show the expression graph",
        action: Action::Tree,
        more: "What is used in several places is drawn once and has a number.",
        examples: &[":tree f"],
    },
    Command {
        name: ":cost",
        argument: "[F]",
        meaning: "say what an evaluation is made of, and measure how long it takes",
        action: Action::Cost,
        more: "Instructions are counted, speeds are measured on one thread, at places in and around the solid.",
        examples: &[":cost f"],
    },
    Command {
        name: ":topology",
        argument: "[F]",
        meaning: "say what a solid is connected with",
        action: Action::Topology,
        more: "Reports the components, the pieces that the solid is in; the genus of one is how many handles it has. They \
               follow from the critical points of the field inside: a minimum begins a piece, a 1-saddle joins two or \
               makes a handle, a 2-saddle closes a handle or makes a void, a maximum fills a void. What is certified \
               is proven. `orogen topology` of a script says more.",
        examples: &[":topology sphere(1.0) + 0.3 * gradient(7).scaled(2.0)"],
    },
    Command {
        name: ":params",
        argument: "",
        meaning: "list the parameters",
        action: Action::Params,
        more: "",
        examples: &[],
    },
    Command {
        name: ":quit",
        argument: "",
        meaning: "leave, as does Ctrl-D",
        action: Action::Quit,
        more: "",
        examples: &[],
    },
];

/// A command as it was given, or what is wrong with it.
type Given<'a> = Result<(Action, Option<&'a str>), Box<Diagnostic>>;

/// The command in a line, with its argument; `None` if the line is not a command.
///
/// # Errors
/// For a command that there is not, or that has too much or too little behind it.
pub fn parse(line: &str) -> Option<Given<'_>> {
    let line = line.trim();
    if !line.starts_with(':') {
        return None;
    }
    let (name, argument) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let argument = Some(argument.trim()).filter(|a| !a.is_empty());
    Some(find(name).and_then(|command| {
        let Command { name, argument: wanted, .. } = command;
        match argument {
            Some(_) if wanted.is_empty() => {
                Err(Diagnostic::error(format!("`{name}` takes nothing behind it")).into())
            }
            None if !wanted.is_empty() && !wanted.starts_with('[') => {
                let example = command.examples.first().unwrap_or(name);
                Err(Diagnostic::error(format!("`{name}` needs {wanted}"))
                    .hint(format!("for example: {example}"))
                    .into())
            }
            _ => Ok((command.action, argument)),
        }
    }))
}

/// The command of a name. Its beginning will do, as long as there is one such command.
pub fn find(name: &str) -> Result<&'static Command, Box<Diagnostic>> {
    let exact = COMMANDS.iter().find(|c| c.name == name);
    let matching: Vec<&Command> =
        COMMANDS.iter().filter(|c| c.name.starts_with(name) && name.len() > 1).collect();
    match (exact, matching.as_slice()) {
        (Some(command), _) => Ok(command),
        (None, [command]) => Ok(*command),
        (None, []) => Err(Box::new(unknown(name))),
        (None, several) => {
            let names: Vec<&str> = several.iter().map(|c| c.name).collect();
            Err(Diagnostic::error(format!("`{name}` may be {}", names.join(" or ")))
                .hint("a letter more tells them apart")
                .into())
        }
    }
}

fn unknown(name: &str) -> Diagnostic {
    let error = Diagnostic::error(format!("there is no command `{name}`"));
    match nearest(name, COMMANDS.iter().map(|c| c.name)) {
        Some(near) => error.hint(format!("did you mean `{near}`?")),
        None => {
            let names: Vec<&str> = COMMANDS.iter().map(|c| c.name).collect();
            error.hint(format!("there are {}", names.join(", ")))
        }
    }
}

impl Command {
    /// Everything about it, with examples.
    pub fn help(&self) -> String {
        let mut text = format!("{} {}\n    {}.\n", self.name, self.argument, self.meaning);
        for line in crate::script::help::wrapped(self.more) {
            text += &format!("    {line}\n");
        }
        if !self.examples.is_empty() {
            text += &format!("\n    {}\n", self.examples.join("\n    "));
        }
        text
    }
}

/// One line a command.
pub fn help() -> String {
    let line = |c: &Command| format!("  {:<28} {}", format!("{} {}", c.name, c.argument), c.meaning);
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
        for bad in [":", ":x", ":quit now", ":load", ":lod x", ":s f", ":plot"] {
            assert!(parse(bad).unwrap().is_err(), "{bad}");
        }
        assert!(parse(":s").unwrap().unwrap_err().message.contains(":save or :slice"));
    }

    #[test]
    fn help_fits_a_terminal_and_shows_each_command_by_name() {
        assert!(help().lines().all(|line| line.chars().count() <= 100), "{}", help());
        for command in COMMANDS {
            let text = command.help();
            assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
            assert!(
                command.examples.iter().all(|e| parse(e).unwrap().unwrap().0 == command.action),
                "{text}"
            );
        }
    }
}
