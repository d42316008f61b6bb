//! The program: one file per command.
//!
//! Commands return an [`Outcome`]; only this file turns it into text and an exit code:
//!
//! | code | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | the script is wrong, or the picture could not be made or written as asked |
//! | 2 | the command line is wrong; nothing was read or written |

mod animation;
mod check;
mod definitions;
mod doc;
mod explore;
mod folder;
mod frames;
mod grid;
mod heights;
mod interrupt;
mod merge;
mod mesh;
mod new;
mod noise;
mod options;
mod pictures;
mod profile;
mod progress;
mod render;
mod repl;
mod report;
mod serve;
mod snapshots;
mod stats;
mod topology;
mod video;
mod watch;
mod work;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use report::{Color, Failure, Outcome, Terminal};
use std::ffi::OsString;
use std::process::ExitCode;

const ABOUT: &str = "Renders procedural solids, planets and rocks that Rhai scripts describe.";

const EXAMPLES: &str = "\
Examples:
  orogen render                      the built-in planet, to planet.png
  orogen new rock                    a script to start from, rock.rhai
  orogen watch rock.rhai             a page that follows your edits
  orogen explore rock.rhai           pictures with other parameters, to choose and breed
  orogen render rock.rhai --size 1920x1080 --samples 16
  orogen render rock.rhai --frames 1-250
  orogen video rock.####.png -o rock.mp4
                                     its frames, and a video of them
  orogen mesh rock.rhai -o rock.glb  a mesh of triangles, for other programs
  orogen heights planet.rhai -o planet.png
                                     a map of its heights
  orogen topology rock.rhai          what it is connected with
  orogen profile rock.rhai           what its lines cost
  orogen repl rock.rhai              asks questions about its fields
  orogen noise gradient -o figures   what a noise is like: pictures, spectrum, verdicts

Exit codes:
  0  done
  1  an error in the script, or in making or writing the picture
  2  an error in the command line

What took long to find out of a script (components, eroded land) is kept in ~/.cache/orogen, or in the folder that
OROGEN_CACHE names; nowhere if that is off. It may be removed at any time.

`orogen COMMAND --help` says more about a command.";

#[derive(Parser)]
#[command(name = "orogen", version, about = ABOUT, after_help = EXAMPLES)]
struct Cli {
    /// Colours in messages; `auto` is on a terminal, unless NO_COLOR is set
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", hide_possible_values = true)]
    #[arg(help = "Colours in messages: auto, always or never", display_order = 100)]
    color: Color,

    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(render::Args),
    Merge(merge::Args),
    Video(video::Args),
    Watch(watch::Args),
    Explore(explore::Args),
    Mesh(mesh::Args),
    Grid(grid::Args),
    Heights(heights::Args),
    Topology(topology::Args),
    Check(check::Args),
    Profile(profile::Args),
    Repl(repl::Args),
    New(new::Args),
    Noise(noise::Args),
    Doc(doc::Args),
    Definitions(definitions::Args),
}

/// Runs the program on the arguments of the process.
pub fn main() -> ExitCode {
    install_panic_message();
    let arguments: Vec<OsString> = std::env::args_os().collect();
    if arguments.len() <= 1 {
        report::out(Cli::command().render_help());
        return ExitCode::SUCCESS;
    }
    let command = Cli::command().color(Color::of_arguments(&arguments).for_clap());
    let cli = command.try_get_matches_from(arguments).and_then(|found| Cli::from_arg_matches(&found));
    match cli {
        Ok(cli) => {
            let terminal = Terminal::new(cli.color);
            exit_code(cli.command.run(&terminal), &terminal)
        }
        Err(error) => {
            // Nobody reads the message if it cannot be written.
            let _ = error.print();
            ExitCode::from(error.exit_code() as u8)
        }
    }
}

impl Command {
    fn run(self, terminal: &Terminal) -> Outcome {
        match self {
            Command::Render(args) => render::run(&args, terminal),
            Command::Merge(args) => merge::run(&args),
            Command::Video(args) => video::run(&args, terminal),
            Command::Watch(args) => watch::run(&args, terminal),
            Command::Explore(args) => explore::run(&args, terminal),
            Command::Mesh(args) => mesh::run(&args, terminal),
            Command::Grid(args) => grid::run(&args, terminal),
            Command::Heights(args) => heights::run(&args, terminal),
            Command::Topology(args) => topology::run(&args, terminal),
            Command::Check(args) => check::run(&args, terminal),
            Command::Profile(args) => profile::run(&args, terminal),
            Command::Repl(args) => repl::run(&args, terminal),
            Command::New(args) => new::run(&args),
            Command::Noise(args) => noise::run(&args, terminal),
            Command::Doc(args) => doc::run(&args, terminal),
            Command::Definitions(args) => definitions::run(&args),
        }
    }
}

fn exit_code(outcome: Outcome, terminal: &Terminal) -> ExitCode {
    match outcome.and_then(|()| report::lost()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Reported) => ExitCode::from(1),
        Err(Failure::Error(diagnostic)) => {
            terminal.diagnostic(&diagnostic, &Default::default());
            ExitCode::from(1)
        }
        Err(Failure::Usage(diagnostic)) => {
            terminal.diagnostic(&diagnostic, &Default::default());
            ExitCode::from(2)
        }
    }
}

/// A panic is a bug of orogen, never of its user: says so, and what helps to mend it.
fn install_panic_message() {
    std::panic::set_hook(Box::new(|info| {
        let version = env!("CARGO_PKG_VERSION");
        let place = info.location().map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
        let payload = info.payload();
        let text = payload.downcast_ref::<&str>().copied();
        let what = text.or(payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
        report::err(format_args!(
            "\nThis is a bug in orogen {version}, not in your script: {what}{place}.\n\
             Files that were there before are as they were. Please report it, with the script and the\n\
             command line; RUST_BACKTRACE=1 adds details.\n"
        ));
        if std::env::var_os("RUST_BACKTRACE").is_some_and(|v| v != "0") {
            report::err(std::backtrace::Backtrace::force_capture());
        }
        // Other threads may wait for the one that is gone.
        std::process::exit(1);
    }));
}
