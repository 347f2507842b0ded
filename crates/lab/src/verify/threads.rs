//! The number of threads is no part of a picture.

use sheer_image::Planes;
use sheer_render::{Antialiasing, Settings, method::METHODS};

use super::{
    check::exact,
    picture::{play, stage},
};
use crate::{Result, verify::check::Check};

const SIZE: [u32; 2] = [64, 36];
const FRAMES: u32 = 3;

pub(super) fn checks() -> Result<Vec<Check>> {
    let mut alone = stage("smoke-square", Some(1))?;
    let mut together = stage("smoke-square", Some(2))?;
    let settings = Settings { size: SIZE, ..Settings::default() };
    let check = |method: &str| {
        let one = play(&mut alone, method, Antialiasing::TAA, settings, FRAMES)?;
        let two = play(&mut together, method, Antialiasing::TAA, settings, FRAMES)?;
        let name = format!("{method}: pixels that differ between 1 and 2 threads");
        Ok(exact(name, "every method", 0.0, None, differing(&one, &two)))
    };
    METHODS.iter().map(|info| info.id).map(check).collect()
}

/// How many pixels differ in any bit of any plane.
fn differing(one: &Planes, two: &Planes) -> f64 {
    let bits = |planes: &Planes, x, y| {
        let pixel = planes.pixel(x, y);
        let floats = (pixel.colour.map(f32::to_bits), pixel.depth.to_bits(), pixel.motion.map(f32::to_bits));
        (floats, pixel.instance, pixel.primitive, pixel.transparent)
    };
    let places = (0..one.height()).flat_map(|y| (0..one.width()).map(move |x| (x, y)));
    places.filter(|&(x, y)| bits(one, x, y) != bits(two, x, y)).count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_differing_bit_is_noticed() {
        let one = Planes::new(8, 4).unwrap();
        let mut two = one.clone();
        assert_eq!(differing(&one, &two), 0.0);
        two.motion[(7, 3)] = [0.0, -0.0];
        assert_eq!(differing(&one, &two), 1.0);
    }
}
