//! `orogen repl`, on a pipe and on a terminal.

mod support;

use orogen::script::{Interpreter, Limits};
use orogen::world::Memory;
use std::path::PathBuf;
use std::sync::Arc;
use support::{Bench, SLOW, has, stderr, stdout};

/// A session without a program around it, which goes on after errors.
fn interpreter() -> Interpreter {
    Interpreter::new(Arc::new(Memory::default()), PathBuf::new(), Limits::default(), None).unwrap()
}

#[test]
fn answers_on_a_pipe() {
    let bench = Bench::new(&[]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines).assert();
    assert_eq!(stdout(&run("1 + 1\n").success()), "2\n");
    let said = stdout(&run("let f = sphere(1.0);\nf.at([3, 0, 0])\n").success());
    assert_eq!(said, "2.0\n");
    has(&stdout(&run("interval(1, 2) + interval(1, 2)\n").success()), &["[1.99", ", 4.00"]);
    has(&stdout(&run("fn double(n) {\n  2 * n\n}\ndouble(21)\n").success()), &["42"]);
    assert_eq!(stderr(&run("1\n").success()), "");
    // What is hardly meant is said once.
    let doubtful = run("-2.0 ** 2\n1\n").success();
    assert_eq!((stdout(&doubtful).as_str(), stderr(&doubtful).matches("the minus").count()), ("4.0\n1\n", 1));
}

/// A script is loaded as it runs: with the files of its own folder.
#[test]
fn what_is_loaded_imports_from_its_folder() {
    let rock = "fn rock() { sphere(2.0) }";
    let main = "import \"rock\" as rock; let f = rock::rock();";
    let bench = Bench::new(&[("a/rock.rhai", rock), ("a/main.rhai", main), ("a/plain.rhai", "let g = 1.0;")]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines).assert();
    has(
        &stdout(&run(":load a/main.rhai\nf.at([3, 0, 0])\nrock::rock().at([4, 0, 0])\n").success()),
        &["1.0\n2.0\n"],
    );
    has(&stderr(&run(":load a/plain.rhai\nimport \"rock\" as rock;\n").code(1)), &["no module", "rock.rhai"]);
}

#[test]
fn fails_on_a_pipe_when_a_line_fails() {
    let bench = Bench::new(&[]);
    let run = bench.command("repl").write_stdin("sphre(1.0)\nprint(\"on\")\n").assert().code(1);
    has(&stderr(&run), &["sphre", "sphere"]);
    assert_eq!(stdout(&run), "");
    has(&stderr(&bench.command("repl").write_stdin(":lod x\n").assert().code(1)), &[":lod", ":load"]);
    has(&stderr(&bench.command("repl").write_stdin("fn f(\n").assert().code(1)), &["Error"]);
    has(&stderr(&bench.command("repl gone.rhai").write_stdin("1\n").assert().code(1)), &["gone.rhai"]);
}

/// What goes wrong in a function of the script is shown where it is written.
#[test]
fn errors_are_shown_in_the_script_that_is_loaded() {
    let bench = Bench::new(&[("a.rhai", "\nfn rock(r) { sphere(r) + undefined }")]);
    let run = |lines: &str| bench.command("repl a.rhai").write_stdin(lines).assert().code(1);
    has(&stderr(&run("rock(1.0)\n")), &["a.rhai:2:26", "rock at input:1:1"]);
    has(&stderr(&run("fn rock(r) { nowhere }\nrock(1.0)\n")), &["input:1:14"]);
}

#[test]
fn commands_answer() {
    let bench =
        Bench::new(&[("a.rhai", "let s = param(\"size\", 1.0, 0.5..2.0);\nlet ball = sphere(s);\nball")]);
    let run = |lines: &str| bench.command("repl a.rhai").write_stdin(lines).assert();
    has(&stdout(&run(":params\n").success()), &["size", "0.5", "2"]);
    has(&stdout(&run("ball.at([3, 0, 0])\n").success()), &["2"]);
    has(&stdout(&run(":help\n").success()), &[":load", ":render", ":params", ":quit"]);
    has(&stdout(&run(":help sphere\n").success()), &["sphere("]);
    has(&stderr(&run(":help sphre\n").code(1)), &["sphere"]);
    assert_eq!(stdout(&run(":quit\n1 + 1\n").success()), "");
    run(":render out.png\n").success();
    assert!(bench.picture("out.png").2[0] > 5.0);
    run(":render\n").success();
    assert_eq!(bench.names(), ["a.png", "a.rhai", "out.png"]);
}

#[test]
fn finds_modules_headings_and_words() {
    let bench = Bench::new(&[]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines).assert();
    has(&stdout(&run(":help fractal\n").success()), &["std/fractal", "import", "fractal::ridged("]);
    has(&stdout(&run(":help warp\n").success()), &["std/warp", "warp::by_noise("]);
    has(&stdout(&run(":help noise\n").success()), &["Noise", "gradient(seed)", "octave_sum("]);
    has(&stdout(&run(":help hurst\n").success()), &["`hurst`", "octave_sum(", "spectral("]);
    has(&stderr(&run(":help ridgd\n").code(1)), &["did you mean `fractal::ridged`?"]);
    assert_eq!(stdout(&run("let noise = 42;\n:help noise\n").success()), "42\n");
    let said = stdout(&run("gradient(-3)\n").success());
    has(&said, &["seed -3"]);
}

#[test]
fn modules_of_ones_own_are_explained() {
    let rocks = "/// A stone of a size.\n///\n///     rocks::boulder(2.0)\nfn boulder(size) { sphere(size) }";
    let bench = Bench::new(&[("rocks.rhai", rocks)]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines).assert();
    let said = stdout(&run("import \"rocks\" as stones;\n:help stones::boulder\n").success());
    has(&said, &["stones::boulder(size)", "A stone of a size."]);
    has(&stderr(&run(":help stones::boulder\n").code(1)), &["stones::boulder"]);
}

#[test]
fn fields_are_drawn_to_files_on_a_pipe() {
    let bench = Bench::new(&[]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines).assert();
    let said = stdout(&run("let f = torus(1.0, 0.4);\n:slice f\n:slice f y=0.1 in 2 to top.png\n").success());
    has(&said, &["slice.png: ", "blue is inside", "x -2..2, z -2..2", "top.png: "]);
    assert!(bench.picture("top.png").2[2] > 50.0);
    let said = stdout(&run(":plot sphere(1.0) along [-2, 0, 0]..[2, 0, 0]\n").success());
    has(&said, &["plot.png: ", "from -1 to 1, zero near 1, 3"]);
    has(
        &stdout(&run(":plot sin(x), cos(x) along x=0..PI to waves.png\n").success()),
        &["waves.png: ", "cos(x): from -1 to 1"],
    );
    has(&stdout(&run(":plot sin(time) along time=0..1\n").success()), &["sin(time): from 0 to 0.841"]);
    assert_eq!(bench.names(), ["plot.png", "slice.png", "top.png", "waves.png"]);
    assert_eq!(bench.picture("waves.png").0, 800);
}

#[test]
fn pictures_are_characters_or_pixels_where_that_is_wanted() {
    let bench = Bench::new(&[]);
    let run = |how: &str, lines: &str| {
        let mut command = bench.command(&format!("repl --pictures {how}"));
        stdout(&command.env("COLORTERM", "truecolor").write_stdin(lines.to_owned()).assert().success())
    };
    let blocks = run("blocks", "sphere(1.0)\n:slice z=0\n");
    has(&blocks, &["\x1b[38;2;", "▀", "\x1b[0m", "blue is inside"]);
    has(&run("blocks", ":plot x ** 2 along x=-1..1\n"), &["┤", "└─", "x ** 2: from 0 to 1"]);
    has(&run("kitty", ":slice sphere(1.0)\n"), &["\x1b_Ga=T,f=100,q=2,m=1;", "\x1b_Gm=0;"]);
    has(&run("iterm", ":plot x along x=0..1\n"), &["\x1b]1337;File=inline=1;size="]);
    has(
        &run("sixel", "scene(#{ surface: sphere(1.0), film: film(#{ width: 40, height: 30 }) })\n:render\n"),
        &["\x1bP0;1;0q\"1;1;", "\x1b\\"],
    );
    assert_eq!(bench.names(), [""; 0]);
    // A file that is named is written besides.
    has(&run("blocks", "sphere(1.0)\n:slice to s.png\n"), &["▀", "s.png: "]);
    assert_eq!(bench.names(), ["s.png"]);
    assert!(!run("none", "sphere(1.0)\n:slice\n").contains('\x1b'));
}

#[test]
fn expressions_are_taken_apart_and_counted() {
    let bench = Bench::new(&[]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines).assert();
    let tree = stdout(
        &run("let r = length(p - vec3(1, 2, 3)) * 2.0;\n:tree min(r, r ** 3 + gradient(7))\n").success(),
    );
    has(&tree, &["min\n├─ #1 = ", "└─ +", "gradient(7, 1)"]);
    let cost = stdout(&run("sphere(1.0) + gradient(7)\n:cost\n").success());
    has(&cost, &["instructions", "octaves of noise", "a second, measured on one thread"]);
    let topology = stdout(&run(":topology sphere(1.0)\n").success());
    has(&topology, &["1 component, certified", "yes"]);
}

#[test]
fn a_session_is_saved_as_a_script_that_comes_to_the_same() {
    let bench = Bench::new(&[("part.rhai", "fn grown(r) { r + 0.5 }\nlet r = 0.5;")]);
    let lines = "import \"std/fractal\" as fractal;\n:load part.rhai\nfn ball(r) { sphere(r) }\n\
                 fn ball(r) {\n    sphere(grown(r))\n}\nlet f = ball(r)\nf\nf.at([2, 0, 0])\n:save all.rhai\n";
    let said = stdout(&bench.command("repl").write_stdin(lines).assert().success());
    has(&said, &["1.0\n", "all.rhai: "]);
    let script = String::from_utf8(bench.read("all.rhai")).unwrap();
    has(&script, &["let f = ball(r);", "f.at([2, 0, 0]);", "// From part.rhai.", "sphere(grown(r))"]);
    assert!(!script.contains("{ sphere(r) }") && !script.contains(":load"), "{script}");
    bench.run("check all.rhai").success();
    let again = stdout(&bench.command("repl all.rhai").write_stdin("f.at([3, 0, 0])\n").assert().success());
    assert_eq!(again, "2.0\n");
    let over = stdout(
        &bench.command("repl").write_stdin("y\n:save all.rhai\nx\n:save all.rhai\n").assert().success(),
    );
    has(&over, &["all.rhai: 3 lines; what was there before is in all.rhai~ now", "\nall.rhai: "]);
    assert!(!over.contains("all.rhai~2"), "{over}");
    let again = stdout(&bench.command("repl").write_stdin("z\n:save ./all.rhai\n").assert().success());
    has(&again, &["all.rhai~2"]);
    assert_eq!(String::from_utf8(bench.read("all.rhai~")).unwrap(), script);
    // What was loaded is the session's own, whatever it is called.
    let loaded =
        stdout(&bench.command("repl ./all.rhai").write_stdin("1\n:save all.rhai\n").assert().success());
    assert!(!loaded.contains('~'), "{loaded}");
    has(&stderr(&bench.command("repl").write_stdin(":save a.rhai\n").assert().code(1)), &["nothing to save"]);
    has(&stderr(&bench.command("repl").write_stdin("1\n:save a.txt\n").assert().code(1)), &[":save a.rhai"]);
}

#[test]
fn a_session_that_a_script_cannot_repeat_says_so_when_it_is_saved() {
    let bench = Bench::new(&[]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines.to_owned()).assert();
    let changed = "fn rad(a) { a }\nlet s = sphere(rad(1.0));\nfn rad(a) { a * 3.0 }\ns\n:save b.rhai\n";
    has(&stderr(&run(changed).code(1)), &["`s` differs", "`rad` was used", "another name"]);
    // A library's function counts as well, and what was only looked at does not.
    let library = "let s = sphere(1.0)\nfn sphere(r) { length(p) - 2.0 * r }\n:save b.rhai\n";
    has(&stderr(&run(library).code(1)), &["`s` differs", "`sphere` was used"]);
    let tried = "fn rad(a) { a }\nrad(1.0)\nfn rad(a) { a * 3.0 }\nlet s = sphere(rad(1.0))\n:save b.rhai\n";
    assert_eq!(stderr(&run(tried).success()), "");
    // The remedies that the message names.
    let again = "let s = sphere(rad(1.0));\nfn rad(a) { a * 3.0 }\nlet s = sphere(rad(1.0));\n:save b.rhai\n";
    assert_eq!(stderr(&run(&format!("fn rad(a) {{ a }}\n{again}")).success()), "");
    assert_eq!(stdout(&bench.command("repl b.rhai").write_stdin("s.at([4, 0, 0])").assert()), "1.0\n");
}

#[test]
fn a_line_that_fails_changes_nothing() {
    let mut session = interpreter();
    for line in ["let a = [1, [2]];", "let m = #{ k: 1 };", "let n = 1;", "fn f() { 1 }"] {
        session.eval(line).unwrap();
    }
    // What functions without a name take along is shared with them.
    for line in ["let kept = [2]; let add = || { kept.push(3); n += 1; n };", "let deep = [#{ f: add }];"] {
        session.eval(line).unwrap();
    }
    for bad in [
        "let q = 5; nosuch",
        "a.push(3); a[1].push(3); m.k = 2; m.l = 3; nosuch",
        "n = 7; kept.push(4); nosuch",
        "add.call(); deep[0].f.call(); nosuch",
        "fn f() { 2 } nosuch",
        "let w = param(\"w\", 1.0, 0.0..2.0); nosuch",
    ] {
        assert!(session.eval(bad).is_err(), "{bad}");
    }
    assert!(session.eval("q").is_err());
    for (line, answer) in [
        ("a", "[1, [2]]"),
        ("m", "#{ k: 1 }"),
        ("[n, kept]", "[1, [2]]"),
        ("f()", "1"),
        ("add.call()", "2"),
        ("[n, kept]", "[2, [2, 3]]"),
        ("param(\"w\", 0.5, 0.0..1.0)", "0.5"),
    ] {
        assert_eq!(session.eval(line).unwrap().as_deref(), Some(answer), "{line}");
    }
    assert!(!session.script().unwrap().contains('q'), "{:?}", session.script());
}

#[test]
fn questions_leave_no_trace() {
    let mut session = interpreter();
    session.eval("let a = [1.0]; let f = sphere(1.0)").unwrap();
    session.numbers("a.push(2.0); a[1]").unwrap();
    session.solid(Some("f = torus(1.0, 0.3); f")).unwrap();
    assert_eq!(session.eval("a").unwrap().as_deref(), Some("[1.0]"));
    assert!(session.eval("f").unwrap().unwrap().starts_with("length(x, y, z) - 1"));
}

#[test]
fn the_last_solid_is_what_was_answered_or_named_last() {
    let bench = Bench::new(&[("part.rhai", "let size = 2.0;\nlet ball = sphere(size);\n")]);
    let run = |lines: &str| bench.command("repl").write_stdin(lines.to_owned()).assert();
    for (lines, tree) in [
        ("let f = sphere(1.0);", "length(x, y, z) - 1"),
        ("let f = max(x, y);\nlet r = 2.0;\nr = 3.0;", "max(x, y)"),
        ("sphere(1.0)\nlet f = max(x, y);", "max(x, y)"),
        ("let f = x;\nf = min(x, y);\nf.at([1, 2, 3])", "min(x, y)"),
        ("let f = x; f\nconst g = y;\nx", "x"),
    ] {
        let said = stdout(&run(&format!("{lines}\n:tree\n")).success());
        assert_eq!(said.lines().last(), Some(tree), "{lines}");
    }
    has(&stdout(&run(":load part.rhai\n:topology\n").success()), &["1 component, certified"]);
    // A script has it for its value, under its own name where that still is it.
    let saved = |lines: &str| {
        run(&format!("{lines}\n:save all.rhai\n")).success();
        bench.run("check all.rhai").success();
        String::from_utf8(bench.read("all.rhai")).unwrap()
    };
    assert!(saved("let f = sphere(1.0)\nf.at([2, 0, 0])").ends_with("f.at([2, 0, 0]);\n\nf\n"));
    bench.write(
        "blocks.rhai",
        "let g = #{ f: sphere(1.0) };\nif true { g.f = box(1.0); }\nscene(#{ surface: g.f })\n",
    );
    has(&saved(":load blocks.rhai\n1"), &["}\nlet last_solid = scene(#{"]);
    let kept = saved("let f = sphere(1.0);\nf = 2.0;");
    has(&kept, &["let last_solid = f;\n\nf = 2.0;\n\nlast_solid\n"]);
}

#[test]
fn the_session_of_the_readme_runs() {
    let readme = include_str!("../README.md");
    let (_, section) = readme.split_once("\n## A session\n").unwrap();
    let lines = section.split("\n## ").next().unwrap().lines();
    // What is behind a command is told from it by a wide gap.
    let typed = lines.filter_map(|line| line.trim_start().strip_prefix("> "));
    let typed: Vec<&str> = typed.map(|line| line.split("   ").next().unwrap_or(line)).collect();
    assert!(typed.len() > 6, "{typed:?}");
    // A picture in full size and the critical points of noise take long, and are not what this is about.
    let small = "scene(#{ surface: f, film: film(#{ width: 40, height: 30 }) })\n:render";
    let lines = typed.join("\n").replace(":topology f", ":topology sphere(1.0)");
    let lines = lines.replace("\n:render", &format!("\n:tree\n{small}")) + "\n";
    let bench = Bench::new(&[]);
    has(
        &stdout(&bench.command("repl").write_stdin(lines).assert().success()),
        &["blue is inside", "rock.rhai"],
    );
    assert_eq!(bench.names(), ["plot.png", "repl.png", "rock.rhai", "slice.png"]);
    bench.run("check rock.rhai").success();
}

#[test]
fn zeros_are_told_from_poles_and_jumps() {
    let bench = Bench::new(&[]);
    for (asked, said) in [
        ("tan(x) along x=0..6", ", zero near 0, 3.142, jumps over zero near 1.571, 4.712\n"),
        ("1.0 / x along x=-1..1.1", ", jumps over zero near 0\n"),
        ("sign(x - 0.5) along x=0..1", " from -1 to 1, jumps over zero near 0.5\n"),
        ("x along x=0..1", " from 0 to 1, zero near 0\n"),
    ] {
        let answer = bench.command("repl").write_stdin(format!(":plot {asked}\n")).assert().success();
        has(&stdout(&answer), &[said]);
    }
}

#[test]
fn nested_values_are_answered_with_what_is_in_them() {
    let mut session = interpreter();
    for (asked, said) in [
        ("[[1,2],[3]]", "[[1, 2], [3]]"),
        ("#{a: [1,2], b: #{c: 1}}", "#{ a: [1, 2], b: #{ c: 1 } }"),
        ("[#{ \"a b\": \"c\" }, [], #{}, x + 1.0]", "[#{ \"a b\": \"c\" }, [], #{}, x + 1]"),
        ("\"text\"", "text"),
        ("[[[[[[[1]]]]]]]", "[[[[[[[...]]]]]]]"),
    ] {
        assert_eq!(session.eval(asked).unwrap().as_deref(), Some(said), "{asked}");
    }
    let long = session.eval("let a = []; for i in 0..99 { a.push([i]); } [a, a]").unwrap().unwrap();
    assert!(long.contains("[39], ... 59 more], [[0], "), "{long}");
    let wide = "let b = []; for i in 0..30 { b.push(a); } b";
    assert!(session.eval(wide).unwrap().unwrap().len() < 3000);
    // As deep as it gets.
    assert!(session.eval("let d = []; for i in 0..400 { d = [d]; } d").is_ok());
}

#[test]
fn wrong_questions_say_what_to_ask() {
    let bench = Bench::new(&[]);
    for (line, pieces) in [
        (":slice", &["no solid yet", "sphere(1.0)"][..]),
        (":slice 1.0 w=2", &["`w`", "z=0"]),
        (":slice \"text\"", &["a field is needed, not a string"]),
        (":slice sphre(1.0)", &["sphre", "did you mean", "sphere"]),
        (":slice x z=[1, 2, 3]", &["is a point, not a number"]),
        (":slice x in -1", &["larger one", "in 1.5"]),
        (":slice x to x.jpg", &[".png"]),
        (":slice x to gone/x.png", &["gone"]),
        (":plot x", &["along", "for example"]),
        (":plot x along 0..1", &["along which variable", "x=-2..2"]),
        (":plot x along [0, 0, 0]..[0, 0, 0]", &["no length"]),
        (":plot x along [0, 0, 0]..1", &["from a point to a point"]),
        (":plot x along w=0..1", &["`w` is no variable", "time"]),
        (":plot x along x=1..0", &["below the second"]),
        (":plot x along x=0..sphere(1.0)", &["a number or a point is needed"]),
        (":plot 1.0 / (x - x) along x=0..1", &["finite"]),
        (":tree [1, 2]", &["a field is needed"]),
        (":cost", &["no solid yet"]),
        (":topology 3.0", &["a field is needed"]),
        (":s x", &[":save or :slice"]),
        (":help :slyce", &["did you mean `:slice`?"]),
    ] {
        let message = stderr(&bench.command("repl").write_stdin(format!("{line}\n")).assert().code(1));
        has(&message, pieces);
    }
    assert_eq!(bench.names(), [""; 0]);
    has(&stderr(&bench.run("repl --pictures ascii").code(2)), &["--pictures", "ascii"]);
}

#[test]
fn commands_explain_themselves() {
    let bench = Bench::new(&[]);
    let run = |lines: &str| stdout(&bench.command("repl").write_stdin(lines).assert().success());
    has(&run(":help :slice\n"), &[":slice [F] [z=0] [in R]", "Blue is inside", ":slice f"]);
    has(&run(":help plot\n"), &[":plot F, .. along FROM..TO", ":plot sin(x), cos(x) along x=0..TAU"]);
}

#[cfg(unix)]
mod terminal {
    //! The same with somebody at the keyboard: a pseudo-terminal.

    use super::*;
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use std::fs::File;
    use std::io::{Read, Write};
    use std::process::{Child, Stdio};
    use std::sync::{Arc, Mutex};
    use std::time::{Duration, Instant};

    struct Keyboard {
        keys: File,
        screen: Arc<Mutex<String>>,
        child: Child,
    }

    impl Keyboard {
        fn new(bench: &Bench, arguments: &str) -> Keyboard {
            let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
            grantpt(&master).unwrap();
            unlockpt(&master).unwrap();
            let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
            let side = || Stdio::from(File::options().read(true).write(true).open(&name).unwrap());
            let mut command = bench.plain_command(arguments);
            command.stdin(side()).stdout(side()).stderr(side()).env("TERM", "xterm-256color");
            let child = command.env("COLORTERM", "truecolor").spawn().unwrap();
            let keys = File::from(master);
            let (screen, mut shown) = (Arc::<Mutex<String>>::default(), keys.try_clone().unwrap());
            let written = screen.clone();
            std::thread::spawn(move || {
                let mut piece = [0; 4096];
                while let Ok(n @ 1..) = shown.read(&mut piece) {
                    written.lock().unwrap().push_str(&String::from_utf8_lossy(&piece[..n]));
                }
            });
            Keyboard { keys, screen, child }
        }

        fn press(&mut self, keys: &str) {
            self.keys.write_all(keys.as_bytes()).unwrap();
        }

        /// Waits until the screen shows something, and forgets what it showed up to that.
        #[track_caller]
        fn wait_for(&self, piece: &str) {
            let start = Instant::now();
            loop {
                let mut screen = self.screen.lock().unwrap();
                if let Some(at) = screen.find(piece) {
                    screen.drain(..at + piece.len());
                    return;
                }
                assert!(start.elapsed() < Duration::from_secs(60), "`{piece}` is missing in:\n{screen}");
                drop(screen);
                std::thread::sleep(Duration::from_millis(10));
            }
        }

        /// Waits for the next line to be typed; what is typed before is lost.
        #[track_caller]
        fn wait_for_prompt(&self) {
            self.wait_for("\x1b[?2004h");
        }

        fn interrupt(&self) {
            let id = self.child.id().to_string();
            assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        }
    }

    impl Drop for Keyboard {
        fn drop(&mut self) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }

    #[test]
    fn lines_are_completed_coloured_continued_and_searched() {
        let bench = Bench::new(&[]);
        let mut user = Keyboard::new(&bench, "repl --pictures blocks");
        user.wait_for("orogen");
        user.wait_for_prompt();
        user.press("let ball = sph\t");
        user.wait_for("sphere(radius)");
        user.press("(\r1.0)\r");
        user.wait_for_prompt();
        user.press("ball.at([3, 0, 0])\r");
        user.wait_for("2.0");
        user.wait_for_prompt();
        user.press("\x12ball.at");
        user.wait_for("reverse-i-search");
        user.press("\r");
        user.wait_for("2.0");
        user.wait_for_prompt();
        user.press(":slice ball\r");
        user.wait_for("▀");
        user.wait_for("blue is inside");
        user.wait_for_prompt();
        user.press(":quit\r");
        assert!(user.child.wait().unwrap().success());
    }

    #[test]
    fn an_interrupt_stops_the_evaluation_and_not_the_session() {
        let bench = Bench::new(&[("slow.rhai", SLOW)]);
        let mut user = Keyboard::new(&bench, "repl slow.rhai --pictures none");
        user.wait_for("Ctrl-D leaves");
        user.wait_for_prompt();
        for (slow, stopped) in [
            ("loop { gradient(7).stats(); }\r", "was stopped"),
            (":topology\r", "stopped before it was finished"),
            (":render slow.png\r", "stopped; no file"),
        ] {
            user.press(slow);
            std::thread::sleep(Duration::from_millis(1500));
            user.interrupt();
            user.wait_for(stopped);
            user.wait_for_prompt();
            user.press("20 + 22\r");
            user.wait_for("42");
            user.wait_for_prompt();
        }
        user.press("\x04");
        assert!(user.child.wait().unwrap().success());
        assert!(!bench.names().contains(&"slow.png".to_owned()));
    }
}
