//! What pages with a viewer have in common.

use serde::Serialize;
use sheer_metrics::false_colour;

/// A picture in the gallery, as the templates want it.
#[derive(Serialize)]
pub(super) struct Card {
    pub(super) id: String,
    pub(super) label: String,
    /// Pictures of another one are not side by side.
    pub(super) aa: String,
    pub(super) is_reference: bool,
    /// As an address with the data in it.
    pub(super) picture: String,
    /// Its error map, likewise.
    pub(super) error: Option<String>,
}

/// The colours of error maps as a CSS gradient.
pub(super) fn legend() -> String {
    const STOPS: u8 = 16;
    let stops = (0..=STOPS).map(|stop| {
        let [r, g, b] = false_colour(f32::from(stop) / f32::from(STOPS));
        format!("#{r:02x}{g:02x}{b:02x}")
    });
    format!("linear-gradient(to right, {})", stops.collect::<Vec<_>>().join(", "))
}
