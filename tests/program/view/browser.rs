//! A headless Chromium that tests drive by the DevTools protocol.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Longer than anything takes here, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

pub(super) struct Browser {
    child: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    calls: u64,
    /// Messages of the console, and exceptions.
    pub(super) console: Vec<String>,
    _profile: TempDir,
}

/// A tab of the browser.
#[derive(Clone)]
pub(super) struct Tab(String);

impl Browser {
    pub(super) fn start() -> Self {
        let profile = tempfile::tempdir().unwrap();
        let mut child = Command::new("chromium")
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
            .args([
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
            ])
            .args(["--remote-debugging-port=0", "--window-size=1000,700"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stderr(Stdio::piped())
            .spawn()
            .expect("cannot run chromium, which .ci/run installs");
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let address = lines
            .find_map(|line| Some(line.ok()?.strip_prefix("DevTools listening on ")?.to_owned()))
            .expect("chromium says where it listens");
        // It must not wait for a reader of its messages.
        thread::spawn(move || lines.for_each(drop));
        let (socket, _) = tungstenite::connect(address).unwrap();
        Self { child, socket, calls: 0, console: Vec::new(), _profile: profile }
    }

    /// Opens an address in a tab of its own.
    pub(super) fn open(&mut self, address: &str) -> Tab {
        let target = self.browser("Target.createTarget", json!({ "url": "about:blank" }));
        let target = json!({ "targetId": target["targetId"], "flatten": true });
        let session = self.browser("Target.attachToTarget", target);
        let tab = Tab(session["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Runtime.enable", "Log.enable", "Page.enable"] {
            self.call(&tab, domain, json!({}));
        }
        self.call(&tab, "Page.navigate", json!({ "url": address }));
        tab
    }

    fn browser(&mut self, method: &str, parameters: Value) -> Value {
        self.exchange(json!({ "method": method, "params": parameters }))
    }

    /// Calls a method of the protocol.
    pub(super) fn call(&mut self, tab: &Tab, method: &str, parameters: Value) -> Value {
        self.exchange(json!({ "method": method, "params": parameters, "sessionId": tab.0 }))
    }

    fn exchange(&mut self, mut message: Value) -> Value {
        self.calls += 1;
        message["id"] = json!(self.calls);
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            if answer["id"] == json!(self.calls) {
                assert!(answer["error"].is_null(), "{message}: {}", answer["error"]);
                return answer["result"].take();
            }
            if let Some("Runtime.consoleAPICalled" | "Runtime.exceptionThrown" | "Log.entryAdded") =
                answer["method"].as_str()
            {
                self.console.push(answer["params"].to_string());
            }
        }
    }

    /// The value of an expression of the page, or the exception.
    fn evaluate(&mut self, tab: &Tab, expression: &str) -> Result<Value, String> {
        let parameters =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call(tab, "Runtime.evaluate", parameters);
        match answer["exceptionDetails"].is_null() {
            true => Ok(answer["result"]["value"].take()),
            false => Err(answer.to_string()),
        }
    }

    /// The value of an expression of the page.
    pub(super) fn value(&mut self, tab: &Tab, expression: &str) -> Value {
        self.evaluate(tab, expression).unwrap_or_else(|error| panic!("{expression}: {error}"))
    }

    /// Waits until an expression of the page is true. Its names may be unknown until the page is loaded.
    pub(super) fn wait(&mut self, tab: &Tab, expression: &str) {
        let begin = Instant::now();
        while self.evaluate(tab, expression) != Ok(json!(true)) {
            if begin.elapsed() > PATIENCE {
                let page = self.evaluate(tab, "document.body?.innerText");
                panic!("{expression} never became true on {page:?}, console {:?}", self.console);
            }
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Presses a key for a moment.
    pub(super) fn press(&mut self, tab: &Tab, code: &str) {
        for kind in ["rawKeyDown", "keyUp"] {
            let key = json!({ "type": kind, "code": code, "key": code });
            self.call(tab, "Input.dispatchKeyEvent", key);
            thread::sleep(Duration::from_millis(60));
        }
    }

    /// Drags with the left button, from the middle of the picture to the right.
    pub(super) fn drag(&mut self, tab: &Tab) {
        let middle =
            "(r => [r.x + r.width / 2, r.y + r.height / 2])(canvas.getBoundingClientRect())";
        let middle = self.value(tab, middle);
        let (x, y) = (middle[0].as_f64().unwrap(), middle[1].as_f64().unwrap());
        for (kind, to) in [
            ("mousePressed", 0.0),
            ("mouseMoved", 25.0),
            ("mouseMoved", 50.0),
            ("mouseReleased", 50.0),
        ] {
            let event = json!({ "type": kind, "x": x + to, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
            self.call(tab, "Input.dispatchMouseEvent", event);
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
