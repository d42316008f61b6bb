//! `orogen check`: what a script describes, without a picture.

use super::interrupt::Flag;
use super::options::ScriptOptions;
use super::report::{Failure, Outcome, Terminal, count, out, plural};
use super::work;
use crate::field::Field;
use crate::flow::steps::MOST;
use crate::num::Class;
use crate::scene::{Aabb, Scene};
use crate::session::{self, Session, Whereabouts};
use crate::world::Disk;
use glam::DVec3;
use std::path::PathBuf;
use std::sync::Arc;

/// Check a script and say what it describes
///
/// Prints the errors and warnings of a script, and if there is a scene, its parameters with their
/// ranges, how smooth its surface is, how large its expression is, and where the solid lies.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen check rock.rhai
  orogen check rock.rhai --set relief=0.04")]
pub struct Args {
    /// Script to check
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    #[command(flatten)]
    scripting: ScriptOptions,
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let mut session = Session::new(&args.script, Arc::new(Disk));
    session.set(args.scripting.params()?, args.scripting.time);
    // Nothing is written, so Ctrl-C may end it wherever it is.
    let loaded = session.load(&Flag::default());
    let scene = work::report(&loaded, terminal).ok_or(Failure::Reported)?;
    let solid = Field::new(&scene.graph, scene.surface.field);
    let whereabouts = session::locate(&scene, &solid);
    let doubts = session::doubts(&scene, &solid, &whereabouts.region)
        .map_err(|error| work::failure(error, &loaded, terminal))?;
    doubts.warnings.iter().for_each(|doubt| terminal.diagnostic(doubt, &loaded.sources));
    out(describe(&scene, &solid, &bounds(&scene, &whereabouts, doubts.is_empty), terminal));
    Ok(())
}

/// The summary of a scene, with a name in front of each line.
fn describe(scene: &Scene, solid: &Field, bounds: &str, terminal: &Terminal) -> String {
    let field = scene.surface.field;
    let nodes = scene.graph.reachable(&[field]).len() as u64;
    let mut lines = vec![
        ("parameters", parameters(scene, &" ".repeat(12)).unwrap_or_else(|| "none".into())),
        ("surface", format!("{}; {} nodes", smoothness(scene.graph.class(field)), count(nodes))),
        ("bounds", bounds.to_owned()),
        (
            "picture",
            format!(
                "{}x{}, {} {} per pixel",
                scene.film.width,
                scene.film.height,
                scene.film.samples,
                if scene.film.samples == 1 { "sample" } else { "samples" }
            ),
        ),
    ];
    lines.splice(2..2, flows(&solid.tape().flow_steps()).map(|text| ("flow", text)));
    if scene.surface.color.is_some() {
        lines.insert(2, ("colour", "given by the script".into()));
    }
    let shown =
        lines.iter().map(|(name, text)| format!("{} {text}", terminal.bold(format_args!("{name:<11}"))));
    shown.collect::<Vec<_>>().join("\n")
}

/// In how many steps flows carry what they do; `None` if there are none.
fn flows(steps: &[u32]) -> Option<String> {
    let (fewest, most) = (*steps.iter().min()?, *steps.iter().max()?);
    let taken = match steps.len() {
        1 => format!("carried in {}", plural(most.into(), "step")),
        n if fewest == most => format!("{n} flows, each in {}", plural(most.into(), "step")),
        n => format!("{n} flows, in {fewest} to {most} steps"),
    };
    let is_steep = most == MOST;
    Some(taken + if is_steep { ", the most that are taken: is a velocity too steep somewhere?" } else { "" })
}

/// One line a parameter, all but the first indented; `None` if there are none.
pub fn parameters(scene: &Scene, indent: &str) -> Option<String> {
    let width = scene.params.iter().map(|p| p.name.chars().count()).max()?;
    let line = |p: &crate::scene::Param| {
        let changed =
            if p.value == p.default { String::new() } else { format!(", {} unless set", p.default) };
        format!("{:<width$} = {} ({}{changed})", p.name, p.value, p.domain)
    };
    Some(scene.params.iter().map(line).collect::<Vec<_>>().join(&format!("\n{indent}")))
}

fn smoothness(class: Class) -> &'static str {
    match class {
        Class::Jump => "has jumps",
        Class::C0 => "continuous with creases (C0)",
        Class::C1 => "continuous normals (C1)",
        Class::C2 => "continuous curvature (C2)",
    }
}

fn bounds(scene: &Scene, whereabouts: &Whereabouts, is_empty: bool) -> String {
    let Whereabouts { region: Aabb { min, max }, is_whole } = *whereabouts;
    let origin = match (scene.bounds, is_whole) {
        (Some(_), _) if is_empty => "given by the script; there is nothing within",
        (None, _) if is_empty => return "none: there is no solid".to_owned(),
        (Some(_), true) => "given by the script",
        (Some(_), false) => "given by the script; the solid may go on beyond",
        (None, true) => "found from the field",
        (None, false) => "found from the field; the solid may go on beyond",
    };
    // Five digits of how large it is, or more.
    let digits = (4.0 - libm::log10((max - min).max_element()).floor()).clamp(4.0, 300.0) as usize;
    let corner = |p: DVec3| format!("({:.digits$}, {:.digits$}, {:.digits$})", p.x, p.y, p.z);
    format!("{} to {}, {origin}", corner(min), corner(max))
}
