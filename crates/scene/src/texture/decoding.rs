//! From bytes to linear light.

use std::sync::OnceLock;

use sheer_core::colour::linear_from_srgb;

/// Linear values of all bytes: first of those that are linear, then of those that are sRGB-encoded.
#[must_use]
pub fn decode_tables() -> &'static [[f32; 256]; 2] {
    static TABLES: OnceLock<[[f32; 256]; 2]> = OnceLock::new();
    TABLES.get_or_init(|| {
        let byte = |index: usize| index as f32 / 255.0;
        [std::array::from_fn(byte), std::array::from_fn(|index| linear_from_srgb(byte(index)))]
    })
}
