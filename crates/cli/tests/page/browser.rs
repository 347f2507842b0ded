//! A browser without a window, and what a visitor does in it.

use std::{
    fs,
    path::Path,
    sync::{Arc, Mutex},
    time::Duration,
};

use headless_chrome::{
    Browser, LaunchOptions, Tab,
    browser::default_executable,
    protocol::cdp::{
        Emulation::{MediaFeature, SetDeviceMetricsOverride, SetEmulatedMedia},
        Input::{DispatchMouseEvent, DispatchMouseEventTypeOption as Mouse, MouseButton},
        Network,
        types::Event,
    },
};
use serde::de::DeserializeOwned;

/// Generous: a machine that tests other things meanwhile starts a browser slowly.
const PATIENCE: Duration = Duration::from_secs(60);

/// A page in a browser of its own, as wide as a desk.
pub(crate) struct Visit {
    tab: Arc<Tab>,
    requests: Arc<Mutex<Vec<String>>>,
    complaints: Arc<Mutex<Vec<String>>>,
    _browser: Browser,
}

impl Visit {
    /// Opens a file.
    pub(crate) fn to(file: &Path) -> Self {
        let path = default_executable().unwrap_or_else(|problem| {
            panic!(
                "{problem}: the pages are looked at in Chromium; `cargo xtask test` installs it, or install the package \
                 `chromium`, or name a browser in the environment variable CHROME"
            )
        });
        let options = LaunchOptions {
            path: Some(path),
            // The page is our own, and a container has no room for a sandbox.
            sandbox: false,
            idle_browser_timeout: PATIENCE,
            ..LaunchOptions::default()
        };
        let browser = Browser::new(options).unwrap();
        let tab = browser.new_tab().unwrap();
        tab.set_default_timeout(PATIENCE);
        let visit = Self { tab, requests: Arc::default(), complaints: Arc::default(), _browser: browser };
        visit.listen();
        visit.set_width(1280);
        let address = format!("file://{}", file.display());
        visit.tab.navigate_to(&address).unwrap().wait_until_navigated().unwrap();
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

    fn listen(&self) {
        let (requests, complaints) = (Arc::clone(&self.requests), Arc::clone(&self.complaints));
        let listener = move |event: &Event| match event {
            Event::NetworkRequestWillBeSent(event) => {
                requests.lock().unwrap().push(event.params.request.url.clone());
            }
            Event::LogEntryAdded(event) => complaints.lock().unwrap().push(event.params.entry.text.clone()),
            Event::RuntimeExceptionThrown(event) => {
                complaints.lock().unwrap().push(format!("{:?}", event.params.exception_details));
            }
            Event::RuntimeConsoleAPICalled(event) => {
                complaints.lock().unwrap().push(format!("{:?}", event.params.args));
            }
            _ => {}
        };
        self.tab.add_event_listener(Arc::new(listener)).unwrap();
        let enable = Network::Enable {
            max_total_buffer_size: None,
            max_resource_buffer_size: None,
            max_post_data_size: None,
            report_direct_socket_traffic: None,
            enable_durable_messages: None,
        };
        self.tab.call_method(enable).unwrap();
        self.tab.enable_log().unwrap();
        self.tab.enable_runtime().unwrap();
    }

    /// Addresses that the page asked for, itself and what it carries within left out.
    pub(crate) fn requests(&self) -> Vec<String> {
        let all = self.requests.lock().unwrap();
        assert!(
            all.iter().any(|address| address.starts_with("file:")),
            "not even the page was seen: {all:?}"
        );
        let is_outside = |address: &&String| {
            !(address.starts_with("data:") || address.starts_with("file:") && address.ends_with(".html"))
        };
        all.iter().filter(is_outside).cloned().collect()
    }

    /// What the browser had to say about the page: errors, warnings, exceptions.
    pub(crate) fn complaints(&self) -> Vec<String> {
        self.complaints.lock().unwrap().clone()
    }

    /// The value of a JavaScript expression.
    pub(crate) fn evaluate<T: DeserializeOwned>(&self, expression: &str) -> T {
        let answer = self.tab.evaluate(&format!("JSON.stringify({expression})"), false);
        let answer = answer.unwrap_or_else(|error| panic!("{expression}: {error}"));
        let text = answer.value.unwrap_or_else(|| panic!("{expression}: {:?}", answer.description));
        serde_json::from_str(text.as_str().unwrap())
            .unwrap_or_else(|error| panic!("{expression}: {error}, {text}"))
    }

    /// Takes the window to another width in pixels; a phone's height.
    pub(crate) fn set_width(&self, width: u32) {
        let metrics = SetDeviceMetricsOverride {
            width,
            height: 844,
            device_scale_factor: 1.0,
            mobile: false,
            scale: None,
            screen_width: None,
            screen_height: None,
            position_x: None,
            position_y: None,
            dont_set_visible_size: None,
            screen_orientation: None,
            viewport: None,
            display_feature: None,
            device_posture: None,
        };
        self.tab.call_method(metrics).unwrap();
    }

    /// Lets the visitor like it dark or light.
    pub(crate) fn set_dark(&self, is_dark: bool) {
        let value = if is_dark { "dark" } else { "light" }.to_owned();
        let feature = MediaFeature { name: "prefers-color-scheme".to_owned(), value };
        self.tab.call_method(SetEmulatedMedia { media: None, features: Some(vec![feature]) }).unwrap();
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
            (Mouse::MouseMoved, from, false),
            (Mouse::MousePressed, from, true),
            (Mouse::MouseMoved, to, true),
            (Mouse::MouseReleased, to, true),
        ] {
            let event = DispatchMouseEvent {
                Type: kind,
                x,
                y,
                modifiers: None,
                timestamp: None,
                button: is_down.then_some(MouseButton::Left),
                buttons: is_down.then_some(1),
                click_count: is_down.then_some(1),
                force: None,
                tangential_pressure: None,
                tilt_x: None,
                tilt_y: None,
                twist: None,
                delta_x: None,
                delta_y: None,
                pointer_Type: None,
            };
            self.tab.call_method(event).unwrap();
        }
    }
}
