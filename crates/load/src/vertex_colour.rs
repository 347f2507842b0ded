//! Colours of vertices as plain formats write them: meant for the display, and in units that the file does
//! not say.

use glam::Vec4;
use sheer_core::colour::linear_from_srgb;

/// A share well above the whole: colours that reach it are counted in bytes.
const MOST_SHARE: f64 = 2.0;

/// What stands for 1 among colours of which the greatest component is this. They are shares, or bytes in the
/// place of shares, which some programs write.
pub(super) fn whole_of_shares(greatest: f64) -> f64 {
    if greatest > MOST_SHARE { u8::MAX.into() } else { 1.0 }
}

/// The linear colour and alpha of components of which `whole` stands for 1.
pub(super) fn linear(colour: Vec4, whole: f64) -> Vec4 {
    let share = |value: f32| {
        let share = (f64::from(value) / whole) as f32;
        // What is not a number becomes 0.
        if share > 0.0 { share.min(1.0) } else { 0.0 }
    };
    let [r, g, b, a] = colour.to_array();
    let [r, g, b] = [r, g, b].map(|value| linear_from_srgb(share(value)));
    Vec4::new(r, g, b, share(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_in_the_place_of_shares_are_known_by_their_size() {
        for (greatest, whole) in [(0.0, 1.0), (1.0, 1.0), (1.2, 1.0), (3.0, 255.0), (255.0, 255.0)] {
            assert_eq!(whole_of_shares(greatest), whole, "{greatest}");
        }
        assert_eq!(linear(Vec4::new(255.0, 0.0, 300.0, 127.5), 255.0), Vec4::new(1.0, 0.0, 1.0, 0.5));
        assert_eq!(linear(Vec4::new(f32::NAN, -1.0, 0.0, 1.0), 1.0), Vec4::new(0.0, 0.0, 0.0, 1.0));
    }
}
