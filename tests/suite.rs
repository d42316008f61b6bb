//! Runs `tests/suite/*.rhai`: scripts annotated with what must become of them.
//!
//! A file holds cases, each after a line `// --- name`. Comments at the top of a case say what is
//! expected; the script starts after them, at line 1:
//!
//! ```text
//! // Error: 3:17+4 message        a diagnostic at line 3, column 17, 4 wide
//! // Error: lib/a.rhai:1:1+1 ...  the same in an imported file
//! // Error: message               one without a place
//! // Error: ? message             one wherever it happens to be
//! // Warning: ...                 likewise
//! // Label: text                  under the caret of the diagnostic before
//! // Hint: text                   of the diagnostic before
//! // Trace: text 3:5              a call on the way there
//! // Class: C1                    continuity of the surface
//! // At: 1 0 0 = 0.5              the surface's field at a point, to 1e-12
//! // Color: 1 0 0 = 1 0 0         its colour at a point
//! // Output: text                 a line that the script prints
//! // Param: relief = 0.02         a parameter and its value
//! // Set: relief = 0.04           as the user sets it
//! // Limit: operations = 1000     likewise calls, nodes, elements, text, samples,
//!                               milliseconds
//! // Time: 0.5                    animation time
//! ```
//!
//! Lines from `// File: name` on are another file. Without an `Error` there must be a scene, and no
//! diagnostic may appear that is not expected. Messages must be equal; hints and labels are checked
//! where they are given.

use orogen::diag::{Diagnostic, Severity};
use orogen::script::{Compiled, Request, Script, compile};
use orogen::tape::{Evaluator, Tape};
use orogen::world::Memory;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

struct Case {
    name: String,
    expectations: Vec<(String, String)>,
    request: Request,
}

fn cases(path: &Path) -> Vec<Case> {
    let text = std::fs::read_to_string(path).unwrap();
    let file = path.file_stem().unwrap().to_string_lossy().into_owned();
    text.split("// --- ").skip(1).map(|part| case(&file, part)).collect()
}

fn case(file: &str, part: &str) -> Case {
    let (name, body) = part.split_once('\n').unwrap();
    let mut expectations = Vec::new();
    let mut rest = body;
    while let Some((line, after)) = rest.split_once('\n')
        && let Some((key, value)) = line.strip_prefix("// ").and_then(|l| l.split_once(": "))
        && key != "File"
    {
        expectations.push((key.to_owned(), value.trim().to_owned()));
        rest = after;
    }
    let mut world = Memory::default();
    let mut files = rest.split("// File: ");
    world.0.insert(PathBuf::from("main.rhai"), files.next().unwrap().trim_end().to_owned() + "\n");
    for other in files {
        let (name, text) = other.split_once('\n').unwrap();
        world.0.insert(PathBuf::from(name.trim()), text.trim_end().to_owned() + "\n");
    }
    let mut request = Request::new(Script::File(PathBuf::from("main.rhai")), Arc::new(world));
    for (key, value) in &expectations {
        match key.as_str() {
            "Set" => {
                let (name, value) = value.split_once('=').unwrap();
                request.params.insert(name.trim().to_owned(), value.trim().into());
            }
            "Time" => request.time = value.parse().unwrap(),
            "Limit" => limit(&mut request, value),
            _ => {}
        }
    }
    Case { name: format!("{file}: {}", name.trim()), expectations, request }
}

fn limit(request: &mut Request, text: &str) {
    let (name, value) = text.split_once('=').unwrap();
    let value: u64 = value.trim().parse().unwrap();
    let limits = &mut request.limits;
    match name.trim() {
        "operations" => limits.operations = value,
        "calls" => limits.calls = value as usize,
        "nodes" => limits.nodes = value as usize,
        "elements" => limits.elements = value as usize,
        "text" => limits.text = value as usize,
        "samples" => limits.samples = value as usize,
        "milliseconds" => limits.time = Duration::from_millis(value),
        other => panic!("no limit {other}"),
    }
}

/// The place and message as annotations have them.
fn headline(d: &Diagnostic) -> String {
    match &d.place {
        Some(p) if &*p.file == "main.rhai" => format!("{}:{}+{} {}", p.line, p.column, p.width, d.message),
        Some(p) => format!("{}:{}:{}+{} {}", p.file, p.line, p.column, p.width, d.message),
        None => d.message.clone(),
    }
}

/// The diagnostics as annotations, for comparison and to copy from.
fn annotations(compiled: &Compiled) -> Vec<(String, String)> {
    let mut lines = Vec::new();
    for d in &compiled.diagnostics {
        let kind = if d.severity == Severity::Error { "Error" } else { "Warning" };
        lines.push((kind.to_owned(), headline(d)));
        lines.extend(d.label.iter().map(|l| ("Label".to_owned(), l.clone())));
        lines.extend(d.hints.iter().map(|h| ("Hint".to_owned(), h.clone())));
        for (what, p) in &d.trace {
            let file = if &*p.file == "main.rhai" { String::new() } else { format!("{}:", p.file) };
            lines.push(("Trace".to_owned(), format!("{what} {file}{}:{}", p.line, p.column)));
        }
    }
    lines
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|t| t.parse().unwrap()).collect()
}

/// Whether a message is expected at whatever place.
fn anywhere(case: &Case, key: &str, headline: &str) -> bool {
    let message = headline.split_once(' ').map_or("", |(_, message)| message);
    case.expectations.contains(&(key.to_owned(), format!("? {message}")))
}

/// What is wrong with a case.
fn check(case: &Case) -> Vec<String> {
    let compiled = compile(&case.request);
    let said = annotations(&compiled);
    let mut wrong = Vec::new();
    let expects = |key: &'static str| case.expectations.iter().filter(move |(k, _)| k == key);
    for (key, value) in said.iter().filter(|(k, _)| k == "Error" || k == "Warning") {
        if !case.expectations.contains(&(key.clone(), value.clone())) && !anywhere(case, key, value) {
            wrong.push(format!("not expected\n// {key}: {value}"));
        }
    }
    for key in ["Error", "Warning", "Label", "Hint", "Trace"] {
        for line in expects(key).filter(|line| !said.contains(line) && !line.1.starts_with("? ")) {
            wrong.push(format!("missing\n// {key}: {}", line.1));
        }
    }
    for (_, text) in expects("Output") {
        if !compiled.output.contains(text) {
            wrong.push(format!("not printed: {text}; but {:?}", compiled.output));
        }
    }
    let fails = expects("Error").next().is_some();
    match &compiled.scene {
        None if !fails => wrong.push("there is no scene".to_owned()),
        Some(_) if fails => wrong.push("there is a scene in spite of errors".to_owned()),
        Some(scene) => scene_check(case, scene, &mut wrong),
        None => {}
    }
    if !wrong.is_empty() {
        wrong.push("all that was said:".to_owned());
        wrong.extend(said.iter().map(|(k, v)| format!("// {k}: {v}")));
    }
    wrong
}

fn scene_check(case: &Case, scene: &orogen::scene::Scene, wrong: &mut Vec<String>) {
    for (key, value) in &case.expectations {
        match key.as_str() {
            "Class" => {
                let class = scene.graph.class(scene.surface.field).to_string();
                if class != *value {
                    wrong.push(format!("the class is {class}"));
                }
            }
            "At" | "Color" => {
                let (p, want) = value.split_once('=').unwrap();
                let p: [f64; 3] = numbers(p).try_into().unwrap();
                let roots = match key.as_str() {
                    "At" => vec![scene.surface.field],
                    _ => scene.surface.color.expect("a colour").to_vec(),
                };
                let tape = Arc::new(Tape::new(&scene.graph, &roots));
                let mut evaluator = Evaluator::<f64>::new(tape);
                evaluator.eval(&p);
                let got: Vec<f64> = (0..roots.len()).map(|i| *evaluator.output(i)).collect();
                let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12;
                if !got.iter().zip(&numbers(want)).all(near) {
                    wrong.push(format!("at {p:?} it is {got:?}"));
                }
            }
            "Param" => {
                let found = scene.params.iter().map(|p| format!("{} = {}", p.name, p.value));
                if !found.clone().any(|p| p == *value) {
                    wrong.push(format!("the parameters are {:?}", found.collect::<Vec<_>>()));
                }
            }
            _ => {}
        }
    }
}

#[test]
fn scripts_become_what_their_comments_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let all: Vec<Case> = files.iter().flat_map(|f| cases(f)).collect();
    assert!(all.len() >= 40, "only {} cases were found", all.len());
    let mut report = String::new();
    for case in &all {
        let wrong = check(case);
        if !wrong.is_empty() {
            report += &format!("\n--- {}\n{}\n", case.name, wrong.join("\n"));
        }
    }
    assert!(report.is_empty(), "{report}");
}
