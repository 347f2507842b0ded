//! Alpha 0 is not there and alpha 1 hides what is behind it: exactly, under every method.

use sheer_image::Planes;
use sheer_render::{Antialiasing, Settings, method::METHODS};

use super::{check::exact, picture::render};
use crate::{Result, verify::check::Check};

const SIZE: [u32; 2] = [18, 18];
/// Each pixel meets each threshold of a 3×3 map.
const FRAMES: u32 = 9;

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let mut checks = Vec::new();
    for method in METHODS {
        for (alpha, seen) in [(0, [0.0, 0.0, 1.0]), (1, [1.0, 0.0, 0.0])] {
            let scene = format!("layers:count=4,alpha={alpha},colours=red-green,background=1");
            let settings = Settings { size: SIZE, ..Settings::default() };
            let planes = render(&scene, method.id, Antialiasing::ACCUMULATE, settings, FRAMES, threads)?;
            let name = format!("{}: error at alpha {alpha}", method.id);
            checks.push(exact(name, "every method", 0.0, None, greatest_error(&planes, seen)));
        }
    }
    Ok(checks)
}

/// Over all pixels and channels.
fn greatest_error(planes: &Planes, seen: [f64; 3]) -> f64 {
    let errors = planes
        .colour
        .as_slice()
        .iter()
        .flat_map(|pixel| pixel.iter().zip(seen).map(|(&value, seen)| (f64::from(value) - seen).abs()));
    errors.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_are_exact_under_every_method() {
        let failed: Vec<Check> = checks(None).unwrap().into_iter().filter(|check| !check.pass).collect();
        assert!(failed.is_empty(), "{failed:?}");
    }

    #[test]
    fn one_stray_dot_is_noticed() {
        let mut planes = Planes::new(18, 18).unwrap();
        planes.colour.as_mut_slice().fill([0.0, 0.0, 1.0, 1.0]);
        assert_eq!(greatest_error(&planes, [0.0, 0.0, 1.0]), 0.0);
        planes.colour[(3, 5)] = [0.0, 0.0, 1.0_f32.next_down(), 1.0];
        assert!(greatest_error(&planes, [0.0, 0.0, 1.0]) > 0.0);
    }
}
