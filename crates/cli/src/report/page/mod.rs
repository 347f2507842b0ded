//! Pages for a browser: one file each that needs nothing else, neither a server nor the network.

use anyhow::Context as _;
use base64::{Engine as _, prelude::BASE64_STANDARD};
use minijinja::{
    Environment,
    value::{Serde, Value},
};
use serde::Serialize;
use sheer_lab::plot::Plot;

use super::chart::Chart;

pub(crate) mod benchmark;
pub(crate) mod calibration;
pub(crate) mod comparison;
pub(crate) mod experiments;
pub(crate) mod pictures;
mod viewer;

/// What all pages have and what they draw with; then the pages. The ending makes the engine escape everything
/// that is not marked as safe.
const TEMPLATES: [(&str, &str); 8] = [
    ("base.html", include_str!("base.html")),
    ("parts.html", include_str!("parts.html")),
    ("benchmark.html", include_str!("benchmark.html")),
    ("calibration.html", include_str!("calibration.html")),
    ("comparison.html", include_str!("comparison.html")),
    ("experiments.html", include_str!("experiments.html")),
    ("pictures.html", include_str!("pictures.html")),
    ("chart.svg.html", include_str!("chart.svg")),
];

/// What makes a file of markup an SVG picture.
const SVG_NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// Fills in one of the templates.
///
/// # Errors
/// If it is broken, which the tests would have found.
fn fill(template: &str, context: impl Serialize) -> anyhow::Result<String> {
    let mut environment = Environment::new();
    for (name, source) in TEMPLATES {
        environment.add_template(name, source)?;
    }
    environment.add_global("css", Value::from_safe_string(include_str!("page.css").to_owned()));
    // Pages are checked for addresses; this one is a name that is never visited.
    environment.add_global("namespace", SVG_NAMESPACE);
    environment.add_global("js", Value::from_safe_string(include_str!("page.js").to_owned()));
    environment.get_template(template)?.render(Serde(context)).context("cannot fill in the report page")
}

/// A chart as an SVG file, which Markdown can show: light, whatever the page.
///
/// # Errors
/// If the template is broken, which the tests would have found.
pub(crate) fn chart_file(plot: Plot) -> anyhow::Result<String> {
    #[derive(Serialize)]
    struct Context {
        chart: Chart,
        css: &'static str,
    }
    let svg = fill("chart.svg.html", Context { chart: plot.into(), css: include_str!("chart.css") })?;
    Ok(svg.trim_start().to_owned())
}

/// A picture within the page.
fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png))
}

#[cfg(test)]
mod tests {
    use crate::report::json::Run;

    pub(super) fn run_of(scene: &str) -> Run {
        Run {
            scene: scene.to_owned(),
            scene_hash: "0123".to_owned(),
            camera: "default".to_owned(),
            alpha: None,
            size: [8, 4],
            frames: 2,
            first_frame: 0,
            time_secs: 0.0,
            shadow: "deep".to_owned(),
            environment: "scene".to_owned(),
            environment_strength: 1.0,
            tone: "pbr-neutral",
            exposure_ev: 0.0,
            backend: "cpu",
            adapter: "a processor".to_owned(),
            seed: 0,
            seeds: None,
            version: "0",
            commit: "c0ffee",
            threads: 1,
        }
    }

    /// Asserts that nothing is taken from elsewhere and that names cannot become markup.
    pub(super) fn assert_sound(page_of: impl Fn(&str) -> String) {
        let page = page_of("layers");
        for outside in ["http:", "https:", "src=\"/", "@import", "<link"] {
            assert!(!page.contains(outside), "{outside}");
        }
        let page = page_of("<script>alert(1)</script>&\"");
        assert!(!page.contains("<script>alert"));
        assert!(page.contains("&lt;script&gt;alert(1)"));
    }

    #[test]
    #[should_panic(expected = "https:")]
    fn a_page_with_an_address_is_found_out() {
        assert_sound(|scene| format!("{scene} <img src=\"https://example.org/a.png\">"));
    }
}
