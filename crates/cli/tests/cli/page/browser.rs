//! A browser without a window, and what a visitor does in it.
//!
//! The browser is asked by the Chrome DevTools Protocol over a pair of pipes: JSON messages, each ended by a
//! zero byte. That needs no crate for sockets and none for the protocol, of which a dozen methods out of a
//! thousand types are used.

use std::{
    cell::RefCell,
    env, fs,
    io::{BufRead as _, BufReader, Write as _},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, Command, Stdio},
    sync::mpsc::{self, Receiver},
    thread,
    time::Duration,
};

use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tempfile::TempDir;

/// Generous: a machine that tests other things meanwhile starts a browser slowly.
const PATIENCE: Duration = Duration::from_secs(60);
/// Names under which browsers of the right kind are installed.
const BROWSERS: &str = include_str!("browsers.txt");
/// No window and no sandbox (the page is our own, and a container has no room for one), nothing that talks to
/// the network by itself, nothing that slows a page down because nobody seems to look.
const OPTIONS: [&str; 13] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-background-timer-throttling",
    "--disable-renderer-backgrounding",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-extensions",
    "--disable-sync",
    "--force-color-profile=srgb",
    "--no-first-run",
];

/// The browser named in the environment variable `CHROME`, or the first that is installed.
fn installed() -> PathBuf {
    let named = env::var_os("CHROME").map(PathBuf::from).filter(|path| path.exists());
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect();
    let files = BROWSERS.lines().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    named.or_else(|| files.into_iter().find(|file| file.is_file())).unwrap_or_else(|| {
        panic!(
            "no browser is installed: the pages are looked at in Chromium; `cargo xtask setup` installs it, or install the package \
             `chromium`, or name a browser in the environment variable CHROME"
        )
    })
}

/// A browser with one page, and what came of it so far.
struct Session {
    browser: Child,
    to_browser: Option<ChildStdin>,
    from_browser: Receiver<Value>,
    /// The page's own part of the conversation; empty before there is a page.
    id: String,
    calls: u64,
    events: Vec<Value>,
    _profile: TempDir,
}

impl Session {
    fn start() -> Self {
        let profile = tempfile::tempdir().unwrap();
        // The protocol goes through the descriptors 3 and 4 of the browser.
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1", "sh"]).arg(installed());
        command.args(OPTIONS).arg("--remote-debugging-pipe");
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        let mut browser = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let to_browser = browser.stdin.take();
        let output = BufReader::new(browser.stdout.take().unwrap());
        let (sender, from_browser) = mpsc::channel();
        // Ends when the browser does, or when nobody listens any more.
        thread::spawn(move || {
            for message in output.split(0).map_while(Result::ok) {
                if sender.send(serde_json::from_slice(&message).unwrap()).is_err() {
                    break;
                }
            }
        });
        let id = String::new();
        let events = Vec::new();
        let mut session = Self { browser, to_browser, from_browser, id, calls: 0, events, _profile: profile };
        let page = session.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": page["targetId"], "flatten": true});
        let attached = session.call("Target.attachToTarget", attach);
        session.id = attached["sessionId"].as_str().unwrap().to_owned();
        session
    }

    /// Calls a method of the protocol and waits for its result. Events that come meanwhile are kept.
    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.calls += 1;
        let mut message = json!({"id": self.calls, "method": method, "params": parameters});
        if !self.id.is_empty() {
            message["sessionId"] = json!(self.id);
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to_browser.as_mut().unwrap().write_all(&bytes).unwrap();
        loop {
            let answer = self.receive(method);
            if answer["id"] == self.calls {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    /// Waits for an event, which may have come already.
    fn wait_for(&mut self, is_wanted: impl Fn(&Value) -> bool, what: &str) {
        while !self.events.iter().any(&is_wanted) {
            let event = self.receive(what);
            self.events.push(event);
        }
    }

    fn receive(&self, what: &str) -> Value {
        let message = self.from_browser.recv_timeout(PATIENCE);
        message.unwrap_or_else(|problem| panic!("waiting for {what} of the browser: {problem}"))
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // Without anybody to talk to the browser ends, and all of its processes with it.
        self.to_browser = None;
        let _ = self.browser.wait();
    }
}

/// A page in a browser of its own, as wide as a desk.
pub(crate) struct Visit {
    session: RefCell<Session>,
}

impl Visit {
    /// Opens a file.
    pub(crate) fn to(file: &Path) -> Self {
        let visit = Self { session: RefCell::new(Session::start()) };
        for domain in ["Network", "Log", "Runtime", "Page"] {
            visit.call(&format!("{domain}.enable"), json!({}));
        }
        visit.call("Page.setLifecycleEventsEnabled", json!({"enabled": true}));
        visit.set_width(1280);
        let address = format!("file://{}", file.display());
        let loader = visit.call("Page.navigate", json!({"url": address}))["loaderId"].clone();
        // Half a second without a request: what a page asks for late is seen, too.
        let is_idle = |event: &Value| {
            event["method"] == "Page.lifecycleEvent"
                && event["params"]["loaderId"] == loader
                && event["params"]["name"] == "networkIdle"
        };
        visit.session.borrow_mut().wait_for(is_idle, "a page that is at rest");
        visit
    }

    /// Opens a page that is another one after a change, which has to change it.
    pub(crate) fn to_changed(page: &Path, change: impl Fn(&str) -> String) -> Self {
        let text = fs::read_to_string(page).unwrap();
        let changed = change(&text);
        assert_ne!(changed, text, "the page does not have what was to be changed");
        let file = tempfile::Builder::new().suffix(".html").tempfile().unwrap();
        fs::write(file.path(), changed).unwrap();
        Self::to(file.path())
    }

    fn call(&self, method: &str, parameters: Value) -> Value {
        self.session.borrow_mut().call(method, parameters)
    }

    /// The parameters of all events of a kind until now.
    fn events(&self, method: &str) -> Vec<Value> {
        // What the browser has said before it answers has been read by then.
        self.call("Runtime.evaluate", json!({"expression": "0"}));
        let session = self.session.borrow();
        let events = session.events.iter().filter(|event| event["method"] == method);
        events.map(|event| event["params"].clone()).collect()
    }

    /// Addresses that the page asked for, itself and what it carries within left out.
    pub(crate) fn requests(&self) -> Vec<String> {
        let events = self.events("Network.requestWillBeSent");
        let all: Vec<String> =
            events.iter().map(|event| event["request"]["url"].as_str().unwrap().to_owned()).collect();
        assert!(
            all.iter().any(|address| address.starts_with("file:")),
            "not even the page was seen: {all:?}"
        );
        let is_outside = |address: &String| {
            !(address.starts_with("data:") || address.starts_with("file:") && address.ends_with(".html"))
        };
        all.into_iter().filter(is_outside).collect()
    }

    /// What the browser had to say about the page: errors, warnings, exceptions, and what the page itself
    /// said.
    pub(crate) fn complaints(&self) -> Vec<String> {
        let said = [
            ("Log.entryAdded", "entry"),
            ("Runtime.exceptionThrown", "exceptionDetails"),
            ("Runtime.consoleAPICalled", "args"),
        ];
        let said = said
            .iter()
            .flat_map(|(method, part)| self.events(method).into_iter().map(|event| event[*part].to_string()));
        said.collect()
    }

    /// The value of a JavaScript expression.
    pub(crate) fn evaluate<T: DeserializeOwned>(&self, expression: &str) -> T {
        let answer =
            self.call("Runtime.evaluate", json!({"expression": format!("JSON.stringify({expression})")}));
        let text = answer["result"]["value"].as_str().unwrap_or_else(|| panic!("{expression}: {answer}"));
        serde_json::from_str(text).unwrap_or_else(|error| panic!("{expression}: {error}, {text}"))
    }

    /// Takes the window to another width in pixels; a phone's height.
    pub(crate) fn set_width(&self, width: u32) {
        let metrics = json!({"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    /// Lets the visitor like it dark or light.
    pub(crate) fn set_dark(&self, is_dark: bool) {
        let value = if is_dark { "dark" } else { "light" };
        let features = json!({"features": [{"name": "prefers-color-scheme", "value": value}]});
        self.call("Emulation.setEmulatedMedia", features);
    }

    /// Clicks in the middle of the element that a JavaScript expression finds.
    pub(crate) fn click(&self, element: &str) {
        let middle = self.place(element, 0.5);
        self.drag(middle, middle);
    }

    /// A place on an element, in the window, at a share of its width and half its height.
    pub(crate) fn place(&self, element: &str, share: f64) -> [f64; 2] {
        let [left, top, width, height]: [f64; 4] = self.evaluate(&format!(
            "(() => {{ const e = {element}; e.scrollIntoView({{ block: 'center', inline: 'center' }}); \
             const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()"
        ));
        [left + share * width, top + 0.5 * height]
    }

    /// Presses the mouse at one place of the window and lets go at another.
    pub(crate) fn drag(&self, from: [f64; 2], to: [f64; 2]) {
        for (kind, [x, y], is_down) in [
            ("mouseMoved", from, false),
            ("mousePressed", from, true),
            ("mouseMoved", to, true),
            ("mouseReleased", to, true),
        ] {
            let mut event = json!({"type": kind, "x": x, "y": y});
            if is_down {
                event["button"] = json!("left");
                event["buttons"] = json!(1);
                event["clickCount"] = json!(1);
            }
            self.call("Input.dispatchMouseEvent", event);
        }
    }
}
