//! A browser without a window, driven through the DevTools protocol as its user's hands and eyes would.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket, connect};

/// Names that Chromium goes by.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// How long anything on a page may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// Keeps the WebSockets of a page.
const RECORD: &str = "window.sockets = []; \
    window.WebSocket = class extends WebSocket { constructor(...all) { super(...all); sockets.push(this); } };";

/// A browser; it ends with the test.
pub struct Browser {
    child: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    last: u64,
    _folder: tempfile::TempDir,
}

/// A page of it.
pub struct Page(String);

impl Browser {
    /// Starts one, if there is one on this machine; `ORO_BROWSER=required` makes it an error that there is none.
    pub fn start() -> Option<Browser> {
        let folder = tempfile::tempdir().unwrap();
        let started = NAMES.iter().find_map(|name| launch(name, &folder));
        if started.is_none() {
            let required = std::env::var("ORO_BROWSER").is_ok_and(|v| v == "required");
            assert!(!required, "there is no Chromium");
            eprintln!("skipped: there is no Chromium on this machine");
        }
        let mut child = started?;
        let stderr = BufReader::new(child.stderr.take().unwrap());
        let mut lines = stderr.lines().map_while(Result::ok);
        let address = lines.find_map(|line| line.strip_prefix("DevTools listening on ").map(str::to_owned));
        let address = address.expect("Chromium starts");
        // It stops if nobody hears what it says.
        std::thread::spawn(move || lines.for_each(drop));
        let (socket, _) = connect(address).unwrap();
        Some(Browser { child, socket, last: 0, _folder: folder })
    }

    /// Opens a page in a window of its own. Its `sockets` are all WebSockets that it ever opened.
    pub fn open(&mut self, address: &str) -> Page {
        let context = self.call(None, "Target.createBrowserContext", json!({}));
        let target = self.call(
            None,
            "Target.createTarget",
            json!({
                "url": "about:blank", "newWindow": true, "width": 1200, "height": 800,
                "browserContextId": context["browserContextId"],
            }),
        );
        let session = self.call(
            None,
            "Target.attachToTarget",
            json!({ "targetId": target["targetId"], "flatten": true }),
        );
        let page = Page(session["sessionId"].as_str().unwrap().to_owned());
        self.call(Some(&page), "Page.enable", json!({}));
        self.call(Some(&page), "Page.addScriptToEvaluateOnNewDocument", json!({ "source": RECORD }));
        self.call(Some(&page), "Page.navigate", json!({ "url": address }));
        self.wait(&page, "document.readyState === 'complete'");
        page
    }

    /// Says something to the browser, and gives what it answers.
    pub fn call(&mut self, page: Option<&Page>, method: &str, params: Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": params });
        if let Some(Page(session)) = page {
            message["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            if answer["id"] == self.last {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].take();
            }
        }
    }

    /// What an expression is on a page.
    pub fn ask(&mut self, page: &Page, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call(Some(page), "Runtime.evaluate", params);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true on a page. Gives how long that took.
    #[track_caller]
    pub fn wait(&mut self, page: &Page, expression: &str) -> Duration {
        let start = Instant::now();
        while self.ask(page, expression) != json!(true) {
            if start.elapsed() > PATIENCE {
                let text = self.ask(page, "document.body.innerText");
                panic!("never came true: {expression}\n{text}");
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        start.elapsed()
    }

    /// Presses the mouse at the first place, given as shares of an element, and lets go at the last.
    pub fn drag(&mut self, page: &Page, element: &str, places: &[[f64; 2]]) {
        let rect = format!(
            "(({{x, y, width, height}}) => [x, y, width, height])(document.querySelector('{element}').getBoundingClientRect())"
        );
        let rect = self.ask(page, &rect);
        let [x, y, width, height] = [0, 1, 2, 3].map(|i| rect[i].as_f64().unwrap());
        let kinds = ["mousePressed"].into_iter().chain(std::iter::repeat("mouseMoved"));
        let mut last = json!({});
        for ([u, v], kind) in places.iter().zip(kinds) {
            let (x, y) = (x + u * width, y + v * height);
            last = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
            self.call(Some(page), "Input.dispatchMouseEvent", last.clone());
        }
        last["type"] = json!("mouseReleased");
        self.call(Some(page), "Input.dispatchMouseEvent", last);
    }

    /// Presses a key and lets it go.
    pub fn press(&mut self, page: &Page, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.call(Some(page), "Input.dispatchKeyEvent", json!({ "type": kind, "key": key }));
        }
    }

    /// A picture of the page, as PNG.
    pub fn photograph(&mut self, page: &Page) -> Vec<u8> {
        use base64::Engine;
        let shot = self.call(Some(page), "Page.captureScreenshot", json!({}));
        base64::engine::general_purpose::STANDARD.decode(shot["data"].as_str().unwrap()).unwrap()
    }
}

fn launch(name: &str, folder: &tempfile::TempDir) -> Option<Child> {
    let options =
        ["--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0", "about:blank"];
    let profile = format!("--user-data-dir={}", folder.path().display());
    let mut command = Command::new(name);
    command.arg(profile).args(options).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().ok()
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It has perhaps ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
