//! The page of `orogen watch`: in a browser, and by those who should not be there.

#![cfg(unix)] // Ctrl-C is sent as a signal

mod support;

use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use support::browser::{Browser, Page};
use support::{Bench, Running};
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// A ball whose size is a parameter.
const BALL: &str = "let r = param(\"radius\", 0.5, 0.1..1.5);
scene(#{ surface: sphere(r), film: film(#{ width: 128, height: 96, samples: 1 }) })";

const PICTURE: &str = "document.querySelector('#picture')";

/// A watch with its page.
struct Watch {
    bench: Bench,
    run: Running,
    address: String,
}

impl Watch {
    fn start(script: &str, options: &str) -> Watch {
        let bench = Bench::new(&[("a.rhai", script)]);
        let run = bench.start(&format!("watch a.rhai {options}"));
        run.wait_for("/\n", 1);
        let log = run.log();
        let address = log.lines().find_map(|line| line.strip_prefix("a.rhai is at ")).expect("an address");
        Watch { address: address.to_owned(), bench, run }
    }

    /// Host and port.
    fn host(&self) -> &str {
        self.address.split('/').nth(2).unwrap()
    }

    fn path(&self) -> &str {
        &self.address["http://".len() + self.host().len()..]
    }

    /// What the server answers to a request with these headers.
    fn request(&self, path: &str, headers: &str) -> String {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// A client that is no browser.
    fn client(&self) -> Client {
        let mut request = format!("ws://{}{}live", self.host(), self.path()).into_client_request().unwrap();
        request.headers_mut().insert("origin", format!("http://{}", self.host()).parse().unwrap());
        let (socket, _) = tungstenite::connect(request).unwrap();
        Client(socket)
    }
}

struct Client(WebSocket<MaybeTlsStream<TcpStream>>);

impl Client {
    fn say(&mut self, message: Value) {
        self.0.send(Message::text(message.to_string())).unwrap();
    }

    /// Looks on until a report is as wanted.
    fn until(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        loop {
            match self.0.read().unwrap() {
                Message::Binary(picture) => {
                    let tick = u64::from_le_bytes(picture[..8].try_into().unwrap());
                    self.say(json!({ "shown": tick }));
                }
                Message::Text(text) => {
                    let told: Value = serde_json::from_str(&text).unwrap();
                    if wanted(&told["report"]) {
                        return told["report"].clone();
                    }
                }
                _ => {}
            }
        }
    }
}

/// A ball with a colour, one of two sizes, that is there or not.
const PICKED: &str = "let tint = param(\"tint\", \"#c0c0c0\");
let size = param(\"size\", \"small\", [\"small\", \"very \\\"large\\\"\"]);
let there = param(\"there\", true);
let r = if !there { 0.01 } else if size == \"small\" { 0.5 } else { 1.2 };
scene(#{ surface: sphere(r).colored(tint), film: film(#{ width: 128, height: 96, samples: 1 }) })";

/// Share of the picture that is bright: the ball.
const BRIGHT: &str = "(() => { const c = document.querySelector('#picture'); \
    const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0; \
    for (let i = 0; i < d.length; i += 4) n += d[i] + d[i + 1] + d[i + 2] > 150; return 4 * n / d.length; })()";

fn bright(browser: &mut Browser, page: &Page) -> f64 {
    browser.ask(page, BRIGHT).as_f64().unwrap()
}

fn done(browser: &mut Browser, page: &Page) {
    browser.wait(page, "document.body.dataset.stage === 'done'");
}

#[test]
fn a_page_shows_steers_and_follows() {
    let Some(mut browser) = Browser::start() else { return };
    let watch = Watch::start(BALL, "");
    let page = browser.open(&watch.address);
    done(&mut browser, &page);
    let first = bright(&mut browser, &page);
    assert!(first > 0.02 && first < 0.4, "{first}");

    // A slider makes the ball larger, and resets.
    let slide = "(() => { const s = document.querySelector('input[type=range][data-param=radius]'); \
        s.value = 1.0; s.dispatchEvent(new Event('input')); return true; })()";
    browser.ask(&page, slide);
    browser.wait(&page, &format!("{BRIGHT} > {}", 2.0 * first));
    done(&mut browser, &page);
    browser.ask(&page, "document.querySelector('#reset').click()");
    browser.wait(&page, &format!("Math.abs({BRIGHT} - {first}) < 0.01"));

    // Dragging turns the camera, and R snaps it back.
    let camera = browser.ask(&page, "document.querySelector('#camera').textContent");
    browser.drag(&page, "#picture", &[[0.5, 0.5], [0.6, 0.5], [0.7, 0.6]]);
    browser.wait(&page, &format!("document.querySelector('#camera').textContent !== {camera}"));
    browser.press(&page, "r");
    browser.wait(&page, &format!("document.querySelector('#camera').textContent === {camera}"));
    browser.press(&page, "ArrowLeft");
    browser.wait(&page, &format!("document.querySelector('#camera').textContent !== {camera}"));

    // A rectangle is a region of interest.
    browser.press(&page, "f");
    browser.drag(&page, "#picture", &[[0.25, 0.25], [0.4, 0.4], [0.75, 0.5]]);
    let [asked, none] = ["document.body.dataset.region !== ''", "document.body.dataset.region === ''"];
    let hidden = "document.querySelector('#frame').hidden";
    browser.wait(&page, &format!("{asked} && !{hidden}"));
    browser.press(&page, "f");
    browser.wait(&page, &format!("{none} && {hidden}"));

    // So it is by keys alone; what is not taken is forgotten.
    for key in ["f", "ArrowRight", "Escape"] {
        browser.press(&page, key);
    }
    browser.wait(&page, hidden);
    for key in ["f", "ArrowRight", "ArrowDown", "Enter"] {
        browser.press(&page, key);
    }
    let left = "document.querySelector('#frame').offsetLeft - document.querySelector('#picture').offsetLeft";
    let width = "document.querySelector('#picture').clientWidth";
    browser.wait(&page, &format!("{asked} && Math.abs(({left}) / {width} - 0.28) < 0.02"));

    // A save changes the picture; the camera stays where it was moved.
    let moved = browser.ask(&page, "document.querySelector('#camera').textContent");
    watch.bench.write("a.rhai", BALL.replace("0.5", "1.2"));
    browser.wait(&page, &format!("{BRIGHT} > {}", 2.0 * first));
    assert_eq!(browser.ask(&page, "document.querySelector('#camera').textContent"), moved);

    // An error is shown with its line, and the picture stays.
    watch.bench.write("a.rhai", "let x = 1;\nsphre(1.0)");
    browser.wait(&page, "document.querySelector('.message.error mark')?.textContent === 'sphre'");
    assert!(bright(&mut browser, &page) > 2.0 * first);
    watch.bench.write("a.rhai", BALL);
    browser.wait(&page, "!document.querySelector('.message.error')");
    browser.wait(&page, &format!("{BRIGHT} < {}", 1.5 * first));
}

#[test]
fn colors_names_and_switches_are_picked_reset_and_written() {
    let Some(mut browser) = Browser::start() else { return };
    let watch = Watch::start(PICKED, "");
    let page = browser.open(&watch.address);
    done(&mut browser, &page);
    let first = bright(&mut browser, &page);
    assert!(first > 0.02 && first < 0.4, "{first}");
    let control = |name: &str| format!("document.querySelector('[data-param={name}]')");
    let reset =
        |name: &str| format!("document.querySelector('[aria-label=\"{name} as the script has it\"]')");
    let set = |name: &str, how: &str| {
        format!(
            "(() => {{ const c = {}; {how}; c.dispatchEvent(new Event('input')); return true; }})()",
            control(name)
        )
    };
    for (name, kind) in [("tint", "color"), ("size", "select-one"), ("there", "checkbox")] {
        assert_eq!(browser.ask(&page, &format!("{}.type", control(name))), json!(kind));
        assert_eq!(browser.ask(&page, &format!("{}.labels[0].textContent", control(name))), json!(name));
    }

    // Each changes the picture, and goes back alone. By keys, too.
    for (name, how, change) in [
        ("size", "c.selectedIndex = 1", format!("{BRIGHT} > {}", 2.0 * first)),
        ("there", "c.checked = false", format!("{BRIGHT} < {}", 0.5 * first)),
        ("tint", "c.value = '#000000'", format!("{BRIGHT} < {}", 0.5 * first)),
    ] {
        browser.ask(&page, &set(name, how));
        browser.wait(&page, &change);
        browser.wait(&page, &format!("getComputedStyle({}).visibility === 'visible'", reset(name)));
        browser.ask(&page, &format!("{}.click()", reset(name)));
        browser.wait(&page, &format!("Math.abs({BRIGHT} - {first}) < 0.01"));
        browser.wait(&page, &format!("getComputedStyle({}).visibility === 'hidden'", reset(name)));
    }
    browser.ask(&page, &format!("{}.focus()", control("size")));
    browser.press(&page, "ArrowDown");
    browser.wait(&page, &format!("{BRIGHT} > {}", 2.0 * first));

    // All of it goes into the script, as it is written there.
    browser.ask(&page, &set("there", "c.checked = false"));
    browser.ask(&page, &set("tint", "c.value = '#ffffff'"));
    browser.wait(&page, "document.querySelectorAll('.param.changed').length === 3");
    browser.ask(&page, "document.querySelector('#write').click()");
    let written = PICKED
        .replace("#c0c0c0", "#ffffff")
        .replace("\"small\", [", "\"very \\\"large\\\"\", [")
        .replace("true", "false");
    watch.run.wait_until("the script has it", || {
        String::from_utf8(watch.bench.read("a.rhai")).unwrap() == written
    });
    browser.wait(&page, "document.querySelectorAll('.param.changed').length === 0");
    assert_eq!(browser.ask(&page, &format!("{}.checked", control("there"))), json!(false));
    assert_eq!(browser.ask(&page, &format!("{}.value", control("tint"))), json!("#ffffff"));
}

#[test]
fn a_browser_is_opened_on_request() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new(&[("a.rhai", BALL), ("desktop/xdg-open", "#!/bin/sh\necho $1 >opened\n")]);
    let opener = bench.path("desktop/xdg-open");
    std::fs::set_permissions(&opener, std::fs::Permissions::from_mode(0o755)).unwrap();
    let [desktop, none] = ["desktop", "nothing"].map(|name| bench.path(name).display().to_string());
    let run = bench.start_with("watch a.rhai --open", &[("PATH", &desktop)]);
    run.wait_for("/\n", 1);
    let opened = || std::fs::read_to_string(bench.path("opened")).unwrap_or_default();
    run.wait_until("a browser", || opened().ends_with("/\n") && run.log().contains(&opened()));
    run.kill();
    // Where there is none, the address still serves.
    let run = bench.start_with("watch a.rhai --open", &[("PATH", &none)]);
    run.wait_for("no browser could be opened", 1);
    run.wait_for("/\n", 1);
    run.kill();
}

#[test]
fn two_pages_see_the_same_and_come_back() {
    let Some(mut browser) = Browser::start() else { return };
    let mut watch = Watch::start(BALL, "");
    let pages = [browser.open(&watch.address), browser.open(&watch.address)];
    for page in &pages {
        done(&mut browser, page);
    }
    let slide = "(() => { const s = document.querySelector('input[type=number][data-param=radius]'); \
        s.value = 1.25; s.dispatchEvent(new Event('input')); return true; })()";
    browser.ask(&pages[0], slide);
    let other = "document.querySelector('input[type=range][data-param=radius]').value === '1.25'";
    browser.wait(&pages[1], other);
    browser.wait(&pages[1], &format!("{BRIGHT} > 0.4"));

    // What the sliders say goes into the script.
    browser.ask(&pages[1], "document.querySelector('#write').click()");
    watch.run.wait_until("the script has it", || {
        String::from_utf8(watch.bench.read("a.rhai")).unwrap() == BALL.replace("0.5", "1.25")
    });

    // A connection that is lost is opened again, and everything is as it was.
    browser.ask(&pages[0], "sockets.at(-1).close()");
    browser.wait(&pages[0], "sockets.length === 2 && document.querySelector('#offline').hidden");
    watch.bench.write("a.rhai", BALL.replace("0.5", "0.3"));
    browser.wait(&pages[0], &format!("{BRIGHT} < 0.2"));

    // Without a server the page says so.
    watch.run.interrupt();
    let (code, said) = std::mem::replace(&mut watch.run, watch.bench.start("--version")).end();
    assert_eq!(code, Some(0), "{said}");
    browser.wait(&pages[0], "!document.querySelector('#offline').hidden");
}

#[test]
fn a_save_is_seen_soon() {
    let Some(mut browser) = Browser::start() else { return };
    let watch = Watch::start(BALL, "");
    let page = browser.open(&watch.address);
    done(&mut browser, &page);
    let mut delays = Vec::new();
    for i in 0..5 {
        let painted = browser.ask(&page, &format!("{PICTURE}.dataset.painted"));
        let start = Instant::now();
        watch.bench.write("a.rhai", BALL.replace("0.5", if i % 2 == 0 { "1.0" } else { "0.5" }));
        browser.wait(&page, &format!("{PICTURE}.dataset.painted !== {painted}"));
        delays.push(start.elapsed());
        done(&mut browser, &page);
    }
    // What is asked of the program itself is in its reports; here is what a person sees, printed for who wants to know.
    println!("from a save to the first changed pixels on the page: {delays:?}");
}

#[test]
fn strangers_are_refused_and_logged() {
    let watch = Watch::start(BALL, "");
    let (host, path) = (watch.host().to_owned(), watch.path().to_owned());
    let ours = format!("Host: {host}\r\n");
    let refused = |path: &str, headers: &str, code: &str| {
        let before = watch.run.log().matches("refused").count();
        let answer = watch.request(path, headers);
        assert!(answer.starts_with(&format!("HTTP/1.1 {code}")), "{path} {headers}: {answer}");
        watch.run.wait_until("a log line", || watch.run.log().matches("refused").count() > before);
    };
    assert!(watch.request(&path, &ours).starts_with("HTTP/1.1 200"));
    let page = watch.request(&path, &ours);
    assert!(page.to_lowercase().contains("content-security-policy: default-src 'none'"), "{page}");
    for path in ["/", "/00000000000000000000000000000000/", "/live", "/picture/a.png"] {
        refused(path, &ours, "404");
    }
    for trick in [
        "../../etc/passwd",
        "..%2f..%2fetc/passwd",
        "%2e%2e/a.rhai",
        "a.rhai",
        "//etc/passwd",
        "style.css/",
        "a\\b",
    ] {
        refused(&format!("{path}{trick}"), &ours, "404");
    }
    refused(&path, "Host: evil.example\r\n", "403");
    refused(&path, &format!("{ours}Origin: http://evil.example\r\n"), "403");
    let handshake =
        "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n";
    refused(&format!("{path}live"), &format!("{ours}{handshake}"), "403");
    refused(&format!("{path}live"), &format!("{ours}{handshake}Origin: http://evil.example\r\n"), "403");
}

#[test]
fn messages_that_make_no_sense_end_the_connection() {
    let watch = Watch::start(BALL, "");
    let wrong = [
        Message::text("nonsense"),
        Message::text("{\"do\":{\"fly\":1}}"),
        Message::text("{\"do\":{\"set\":{\"radius\":[1]}}}"),
        Message::text(format!("{{\"do\":{{\"caster\":\"{}\"}}}}", "x".repeat(20_000))),
        Message::text("[".repeat(5000)),
        Message::binary(vec![0; 10]),
    ];
    for (i, message) in wrong.into_iter().enumerate() {
        let mut client = watch.client();
        client.until(|report| report.is_object());
        client.0.send(message).unwrap();
        while client.0.read().is_ok() {}
        watch.run.wait_for("refused", i + 1);
    }
    // What makes sense but cannot be done is only answered.
    let mut client = watch.client();
    client.until(|report| report["stage"] == "done");
    for command in [
        json!({ "do": { "set": { "colour": 1.0 } } }),
        json!({ "do": { "set": { "radius": "large" } } }),
        json!({ "do": { "caster": "fishing" } }),
        json!({ "do": { "move": { "zoom": { "by": 0.0, "at": null } } } }),
    ] {
        client.say(command);
        let notice = loop {
            if let Message::Text(text) = client.0.read().unwrap() {
                let told: Value = serde_json::from_str(&text).unwrap();
                if told["notice"]["error"] == true {
                    break told["notice"]["message"].as_str().unwrap().to_owned();
                }
            }
        };
        assert!(!notice.is_empty());
    }
}

#[test]
#[cfg(target_os = "linux")]
fn saving_five_hundred_times_leaves_nothing_behind() {
    let watch = Watch::start(BALL, "--size 32x32");
    let mut client = watch.client();
    client.until(|report| report["stage"] == "done");
    let mut revision = 1;
    let mut save = |n: u64| {
        for _ in 0..n {
            revision += 1;
            watch.bench.write("a.rhai", BALL.replace("0.5", &format!("0.{}", 300 + revision)));
            client.until(|report| report["revision"] == revision);
        }
    };
    save(100);
    let before = watch.run.usage();
    save(400);
    let after = watch.run.usage();
    assert_eq!((after.threads, after.handles), (before.threads, before.handles));
    // Pages of memory come and go; what grew with every save would be far more.
    assert!(after.memory < before.memory + (8 << 20), "{before:?} {after:?}");
}
