//! `orogen explore`: its page in a browser, requests of those who should not be there, and its files.

#![cfg(unix)] // Ctrl-C is sent as a signal

mod support;

use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use support::browser::Browser;
use support::{BALL, Bench, Running, has, stderr};

/// A ball with two parameters, one of them whole.
const DICE: &str = "let r = param(\"radius\", 0.5, 0.2..1.2);
let n = param(\"bumps\", 3, 0..9);
sphere(r) - 0.05 * sin(n * x) * sin(n * y)";

/// A gallery with its page.
struct Exploration {
    run: Running,
    address: String,
    _bench: Bench,
}

impl Exploration {
    fn start(script: &str, options: &str) -> Exploration {
        Exploration::start_with(script, &format!("--size 48x36 {options}"), &[])
    }

    fn start_with(script: &str, options: &str, environment: &[(&str, &str)]) -> Exploration {
        let bench = Bench::new(&[("a.rhai", script)]);
        let run = bench.start_with(&format!("explore a.rhai {options}"), environment);
        run.wait_for("/\n", 1);
        let log = run.log();
        let address = log.lines().find_map(|line| line.strip_prefix("a.rhai is at ")).expect("an address");
        Exploration { address: address.to_owned(), run, _bench: bench }
    }

    /// Host and port.
    fn host(&self) -> &str {
        self.address.split('/').nth(2).unwrap()
    }

    /// What the server answers, head and all.
    fn request(&self, method: &str, name: &str, headers: &str, body: &str) -> String {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let path = format!("{}{name}", &self.address["http://".len() + self.host().len()..]);
        let length = body.len();
        write!(stream, "{method} {path} HTTP/1.1\r\nHost: {}\r\n{headers}Content-Length: {length}\r\nConnection: close\r\n\r\n{body}", self.host()).unwrap();
        let mut answer = Vec::new();
        // Whoever says too much may be cut off while speaking.
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// What our own page would be answered.
    fn command(&self, body: &str) -> String {
        self.request("POST", "do", &format!("Origin: http://{}\r\n", self.host()), body)
    }

    fn gallery(&self) -> Value {
        let answer = self.request("GET", "gallery", "", "");
        serde_json::from_str(answer.split("\r\n\r\n").nth(1).unwrap()).unwrap()
    }
}

#[test]
fn a_page_shows_stars_breeds_and_exports() {
    let Some(mut browser) = Browser::start() else { return };
    let exploration = Exploration::start(DICE, "--count 6");
    let page = browser.open(&exploration.address);
    browser.wait(&page, "document.body?.dataset.state === 'done'");
    browser.wait(&page, "document.querySelectorAll('.specimen.drawn img').length === 6");
    assert_eq!(browser.ask(&page, "document.querySelector('#narrow').disabled"), json!(true));

    // Stars by mouse and by key, and they outlive the page.
    browser.ask(&page, "document.querySelector('[data-id=\"2\"] .star').click()");
    browser.wait(&page, "document.querySelector('[data-id=\"2\"]').matches('.starred')");
    browser.ask(&page, "document.querySelector('[data-id=\"0\"]').focus()");
    browser.press(&page, "ArrowRight");
    browser.wait(&page, "document.activeElement.dataset.id === '1'");
    browser.press(&page, "s");
    browser.wait(&page, "document.querySelectorAll('.specimen.starred').length === 2");
    browser.ask(&page, "window.before = true");
    browser.call(Some(&page), "Page.reload", json!({}));
    browser.wait(&page, "!window.before && document.querySelectorAll('.specimen.starred').length === 2");

    // Children have two parents; the generation before is a key away.
    browser.ask(&page, "document.querySelector('#breed').click()");
    browser.wait(&page, "document.body.dataset.generation === '1' && document.body.dataset.state === 'done'");
    browser.wait(&page, "document.querySelectorAll('.specimen.drawn').length === 6");
    has(browser.ask(&page, "document.querySelector('figcaption').innerText").as_str().unwrap(), &["6"]);
    browser.press(&page, "[");
    browser.wait(&page, "document.body.dataset.generation === '0'");
    browser.press(&page, "m");
    browser.wait(&page, "document.querySelectorAll('.specimen.drawn').length === 12");

    // One can be seen large, with its values and its command.
    browser.ask(&page, "document.querySelector('[data-id=\"2\"] .picture').click()");
    browser.wait(&page, "document.querySelector('#large').dataset.state === 'done'");
    browser.wait(&page, "document.querySelector('#large img').naturalWidth === 192");
    let command = browser.ask(&page, "document.querySelector('#large .command').textContent");
    has(command.as_str().unwrap(), &["orogen render a.rhai --set ", "radius="]);

    // What is saved is the script with the values.
    browser.ask(
        &page,
        "(() => { const make = URL.createObjectURL; URL.createObjectURL = (blob) => make.call(URL, window.blob = blob); \
            HTMLAnchorElement.prototype.click = function () { window.saved = this; }; return true; })()",
    );
    browser.press(&page, "e");
    browser.wait(&page, "window.saved?.download === 'a-2.rhai'");
    let text = browser.ask(&page, "window.blob.text()");
    let gallery = exploration.gallery();
    let [radius, bumps] = [0, 1].map(|i| gallery["specimens"][2]["values"][i].as_f64().unwrap());
    let expected =
        DICE.replace("0.5, 0.2", &format!("{radius:?}, 0.2")).replace("3, 0..9", &format!("{bumps}, 0..9"));
    assert_eq!(text, json!(expected));
}

/// A ball that takes more than a moment, on one thread.
const CRAGS: &str = "import \"std/fractal\" as fractal;
let crags = fractal::turbulence(gradient(7), #{ octaves: 9 }).scaled(3.0);
sphere(param(\"radius\", 0.8, 0.7..0.9)) - 0.2 * crags";

#[test]
fn what_takes_long_is_rough_at_first_and_says_so() {
    let Some(mut browser) = Browser::start() else { return };
    // Pictures that take some seconds each, however fast this machine is.
    let (bench, start) = (Bench::new(&[("a.rhai", CRAGS)]), Instant::now());
    bench.run("render a.rhai --size 100x75 --samples 1 --threads 1 -o a.png").success();
    let width = (100.0 * (4.0 / start.elapsed().as_secs_f64()).sqrt()).clamp(40.0, 1000.0);
    let options = format!("--size {width:.0}x{:.0} --count 2", 0.75 * width);
    let exploration = Exploration::start_with(CRAGS, &options, &[("RAYON_NUM_THREADS", "1")]);
    let page = browser.open(&exploration.address);
    // Both are seen before one is finished, and whoever cannot see them is told what they are.
    browser.wait(&page, "document.querySelectorAll('.specimen.rough img[src]').length === 2");
    let told = |what: &str| format!("document.querySelector('[data-id=\"0\"]').{what}");
    assert_eq!(browser.ask(&page, &told("getAttribute('aria-busy')")), json!("true"));
    has(browser.ask(&page, &told("getAttribute('aria-label')")).as_str().unwrap(), &["rough so far"]);
    let status = browser.ask(&page, "document.querySelector('#drawn').textContent");
    assert_eq!(status, json!("0 of 2 pictures, 2 rough so far"));
    assert_eq!(browser.ask(&page, "document.body.dataset.state"), json!("drawing"));

    browser.wait(&page, "document.body.dataset.state === 'done'");
    assert_eq!(browser.ask(&page, "document.querySelectorAll('.specimen.rough').length"), json!(0));
    assert_eq!(browser.ask(&page, &told("getAttribute('aria-busy')")), json!("false"));
    let label = browser.ask(&page, &told("getAttribute('aria-label')"));
    assert!(!label.as_str().unwrap().contains("rough"), "{label}");
    // What is finished is not drawn again, and not roughly either.
    has(&exploration.request("GET", "rough/0.png", "", ""), &["200 OK", "picture: finished"]);
}

#[test]
fn colours_names_and_switches_are_explored() {
    let Some(mut browser) = Browser::start() else { return };
    let script = "let tint = param(\"tint\", \"#c98f5a\");
let size = param(\"size\", \"small\", [\"small\", \"very large\"]);
sphere(if param(\"bumps\", true) { 0.9 } else { 0.3 } + if size == \"small\" { 0.0 } else { 0.2 }).colored(tint)";
    let exploration = Exploration::start(script, "--count 6");
    let page = browser.open(&exploration.address);
    browser.wait(&page, "document.querySelectorAll('.specimen.drawn img').length === 6");
    let gallery = exploration.gallery();
    let kinds: Vec<_> = gallery["axes"].as_array().unwrap().iter().map(|axis| axis["kind"].clone()).collect();
    assert_eq!(kinds, [json!("color"), json!("choice"), json!("switch")]);
    assert_eq!(gallery["specimens"][0]["values"], json!(["#c98f5a", "small", true]));
    let large =
        (1..6).find(|id| gallery["specimens"][*id]["values"][1] == "very large").expect("a large one");
    let values = &gallery["specimens"][large]["values"];
    browser.ask(&page, &format!("document.querySelector('[data-id=\"{large}\"] .picture').click()"));
    browser.wait(&page, "document.querySelector('#large').dataset.state === 'done'");
    let said = browser.ask(&page, "document.querySelector('#large .values').innerText");
    let (tint, bumps) = (values[0].as_str().unwrap(), values[2].as_bool().unwrap());
    has(said.as_str().unwrap(), &["tint", tint, "size", "very large", "bumps", &bumps.to_string()]);
    let command = browser.ask(&page, "document.querySelector('#large .command').textContent");
    has(command.as_str().unwrap(), &[&format!(" --set tint={tint}"), " --set size='very large'"]);
    let answer = exploration.request("GET", &format!("script/{large}.rhai"), "", "");
    let expected = script.replace("#c98f5a", tint).replace("\"small\", [", "\"very large\", [");
    has(&answer, &[&expected.replace("true", &bumps.to_string())]);
}

/// A ball with noise, whose expressions may change.
const ROCK: &str = "import \"std/fractal\" as fractal;
let r = param(\"radius\", 0.7, 0.5..0.9);
let bumps = 0.2 * fractal::fbm(gradient(7), #{ octaves: 3 }).scaled(2.0);
max(sphere(r), box([1.0, 1.5, 1.0])) + bumps";

#[test]
fn expressions_are_bred_on_request() {
    let Some(mut browser) = Browser::start() else { return };
    let exploration = Exploration::start(ROCK, "--count 6");
    let page = browser.open(&exploration.address);
    browser.wait(&page, "document.querySelectorAll('.specimen.drawn img').length === 6");
    for id in [1, 3] {
        browser.ask(&page, &format!("document.querySelector('[data-id=\"{id}\"] .star').click()"));
        browser.wait(&page, &format!("document.querySelector('[data-id=\"{id}\"]').matches('.starred')"));
    }
    // Without the switch there is nothing new but the values; it has a label, and a key.
    assert_eq!(
        browser.ask(&page, "document.querySelector('#expressions').labels[0].innerText.trim()"),
        json!("also the expressions")
    );
    browser.press(&page, "x");
    browser.wait(&page, "document.querySelector('#expressions').checked");
    browser.press(&page, "b");
    browser.wait(&page, "document.body.dataset.generation === '1' && document.body.dataset.state === 'done'");
    browser.wait(&page, "document.querySelectorAll('.specimen.drawn').length === 6");
    let gallery = exploration.gallery();
    let specimens = gallery["specimens"].as_array().unwrap();
    let is_changed = |id: &usize| specimens[*id].get("changes").is_some();
    let changed: Vec<usize> = (6..12).filter(is_changed).collect();
    assert!(changed.len() > 1 && !(0..6).any(|id| is_changed(&id)), "{changed:?}");
    let head = |name: &str| {
        let answer = exploration.request("GET", name, "", "");
        assert!(answer.starts_with("HTTP/1.1 200"), "{name}: {answer}");
        answer.split_once("\r\n\r\n").unwrap().1.to_owned()
    };
    let pictures: Vec<String> = changed.iter().map(|id| head(&format!("thumb/{id}.png"))).collect();
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));

    // What is new is said beside the picture, and line by line beside the large one.
    let id = changed[0];
    let change = &specimens[id]["changes"][0];
    let news = format!("{}, line {}", change["what"].as_str().unwrap(), change["line"]);
    let said =
        browser.ask(&page, &format!("document.querySelector('[data-id=\"{id}\"] .novelty').textContent"));
    assert_eq!(said, json!(news));
    browser.ask(&page, &format!("document.querySelector('[data-id=\"{id}\"] .picture').click()"));
    browser.wait(&page, "document.querySelector('#large').dataset.state === 'done'");
    for (part, what) in [("del", "before"), ("ins", "after")] {
        let line =
            browser.ask(&page, &format!("document.querySelector('#large .change {part}').textContent"));
        assert_eq!(line, change[what]);
    }
    let command = browser.ask(&page, "document.querySelector('#large .command').textContent");
    assert_eq!(command, json!(format!("orogen render a-{id}.rhai")));

    // Its script has the picture of the specimen.
    let text = head(&format!("script/{id}.rhai"));
    assert!(text.contains("param(\"radius\", "), "{text}");
    let bench = Bench::new(&[("b.rhai", &text)]);
    bench.run("explore b.rhai --headless -o out --count 1 --size 48x36").success();
    let again = String::from_utf8_lossy(&bench.read("out/0.png")).into_owned();
    // Their values are noted otherwise, so only what is drawn is compared.
    let pixels = |png: &str| png.split_once("IDAT").unwrap().1.to_owned();
    assert_eq!(pixels(&again), pixels(&pictures[0]));

    // A generation may go on, and what is starred goes on into the next one.
    assert!(exploration.command(&format!("{{\"star\":{{\"id\":{id},\"on\":true}}}}")).contains("200 OK"));
    assert!(exploration.command("{\"more\":1}").contains("200 OK"));
    assert!(exploration.command("{\"evolve\":0.5}").contains("200 OK"));
    has(&exploration.command("{\"evolve\":-0.5}"), &["409", "from 0 to 1"]);
    assert_eq!(exploration.gallery()["specimens"].as_array().unwrap().len(), 24);
}

#[test]
fn strangers_and_nonsense_are_refused_and_logged() {
    let exploration = Exploration::start(DICE, "--count 2");
    let before = exploration.gallery();
    let mut refusals = 0;
    let mut refused = |answer: String, code: &str| {
        assert!(answer.starts_with(&format!("HTTP/1.1 {code}")), "{code}: {answer}");
        refusals += 1;
        exploration.run.wait_for("refused", refusals);
    };
    refused(exploration.request("POST", "do", "", "\"clear\""), "403");
    refused(exploration.request("POST", "do", "Origin: http://evil.example\r\n", "\"clear\""), "403");
    for nonsense in
        ["", "clear", "{\"fly\":1}", "{\"star\":{\"id\":-1,\"on\":true}}", "{\"more\":0,\"breed\":1}"]
    {
        refused(exploration.command(nonsense), "400");
    }
    refused(exploration.command(&"[".repeat(10_000)), "400");
    refused(exploration.command(&format!("\"{}\"", "x".repeat(20_000))), "413");
    for name in ["thumb/9.png", "thumb/0.exr", "thumb/..%2fa.png", "script/9.rhai", "huge/0.png", "a.rhai"] {
        refused(exploration.request("GET", name, "", ""), "404");
    }
    // What makes sense but cannot be done is only answered.
    for (command, why) in [
        ("\"narrow\"", "no favourites"),
        ("{\"breed\":2.0}", "from 0 to 1"),
        ("{\"more\":7}", "no generation 7"),
        ("{\"star\":{\"id\":77,\"on\":true}}", "no picture 77"),
    ] {
        has(&exploration.command(command), &["409", why]);
    }
    assert_eq!(exploration.gallery(), before);
}

#[test]
fn what_cannot_be_drawn_says_why_and_is_exported_all_the_same() {
    let script =
        "let r = param(\"r\", 0.25 + 0.25, 0.1..1.0); if r != 0.5 { throw \"too \" + \"odd\" } sphere(r)";
    let exploration = Exploration::start(script, "--count 2");
    assert!(exploration.request("GET", "thumb/0.png", "", "").starts_with("HTTP/1.1 200"));
    for folder in ["rough", "thumb", "large"] {
        has(&exploration.request("GET", &format!("{folder}/1.png"), "", ""), &["409", "too odd"]);
    }
    let exported = exploration.request("GET", "script/1.rhai", "", "");
    let value = &exploration.gallery()["specimens"][1]["values"][0];
    has(&exported, &["HTTP/1.1 200", &format!("preset(\"r\", {value});\n{script}")]);
}

#[test]
fn ctrl_c_ends_it() {
    let exploration = Exploration::start(DICE, "--count 2");
    exploration.run.interrupt();
    let (code, said) = exploration.run.end();
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn without_a_page_there_are_files() {
    let bench = Bench::new(&[("a.rhai", DICE)]);
    let run = bench.run("explore a.rhai --headless -o out --count 4 --size 32x24 --set bumps=5").success();
    has(&stderr(&run), &["a.rhai: 4 pictures in out"]);
    let gallery: Value = serde_json::from_slice(&bench.read("out/gallery.json")).unwrap();
    assert_eq!(gallery["fixed"], json!({ "bumps": 5.0 }));
    assert_eq!(gallery["specimens"].as_array().unwrap().len(), 4);
    assert_eq!(gallery["axes"][0]["name"], "radius");
    for id in 0..4 {
        assert_eq!(bench.picture(&format!("out/{id}.png")).0, 32);
    }
    assert_ne!(bench.read("out/1.png"), bench.read("out/2.png"));
    let page = String::from_utf8(bench.read("out/index.html")).unwrap();
    let radius = gallery["specimens"][3]["values"][0].as_f64().unwrap();
    has(&page, &["the script as it is", &format!("<dt>radius</dt><dd>{radius}</dd>")]);
    has(&page, &["src=\"3.png\"", &format!("orogen render a.rhai --set bumps=5 --set radius={radius}<")]);
    // The same again.
    bench.run("explore a.rhai --headless -o again --count 4 --size 32x24 --set bumps=5").success();
    assert_eq!(bench.read("out/3.png"), bench.read("again/3.png"));
}

#[test]
fn parameters_that_are_not_asked_for_with_some_values_of_others_do_not_matter_then() {
    let script = "let size = param(\"size\", 1.0, 0.5..1.5);
let depth = if param(\"bumpy\", true) { param(\"depth\", 0.1, 0.0..0.3) } else { 0.0 };
sphere(size) + depth * sin(9.0 * x)";
    let bench = Bench::new(&[("a.rhai", script)]);
    bench.run("explore a.rhai --headless -o out --count 8 --size 32x24").success();
    let gallery: Value = serde_json::from_slice(&bench.read("out/gallery.json")).unwrap();
    let specimens = gallery["specimens"].as_array().unwrap();
    let place = gallery["axes"].as_array().unwrap().iter().position(|axis| axis["name"] == "bumpy").unwrap();
    assert!(specimens.iter().any(|specimen| specimen["values"][place] == json!(false)));
    (0..8).for_each(|id| assert_eq!(bench.picture(&format!("out/{id}.png")).0, 32));
    // Of what is fixed for all it is an error.
    let run = bench.run("explore a.rhai --headless -o out --set bumpy=false --set depth=0.2");
    has(&stderr(&run), &["no parameter `depth`"]);
}

#[test]
fn where_there_is_nothing_to_explore_that_is_said() {
    let bench = Bench::new(&[("a.rhai", DICE), ("ball.rhai", BALL), ("bad.rhai", "sphre(1.0)")]);
    for (arguments, pieces) in [
        ("explore ball.rhai", &["ball.rhai has no parameters to explore", "param(name, default, range)"][..]),
        ("explore a.rhai --set radius=0.5 --set bumps=1", &["leaves no parameter", "leave one of them out"]),
        ("explore a.rhai --set radius=5", &["out of range"]),
        ("explore a.rhai --set size=1", &["no parameter `size`"]),
        ("explore bad.rhai", &["sphre"]),
        ("explore none.rhai", &["none.rhai"]),
        ("explore a.rhai --headless -o a.rhai", &["a.rhai is a file"]),
    ] {
        has(&stderr(&bench.run(arguments).code(1)), pieces);
    }
    assert_eq!(bench.names(), ["a.rhai", "bad.rhai", "ball.rhai"]);
}
