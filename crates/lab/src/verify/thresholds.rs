//! The papers' listings, threshold by threshold: what methods give for single pixels, against the few lines
//! that define it.

use std::collections::BTreeSet;

use sheer_core::hash::Pcg32;
use sheer_metrics::statistics::wilson_hilferty;
use sheer_render::{
    Method,
    contract::{OrderedCompositing, Selection, Site, Tables, Threshold, UnorderedCompositing, Visitor},
};

use super::{
    check::exact,
    model::{Model, listing_1, listing_4},
};
use crate::{
    Result,
    verify::check::{Check, Value},
};

/// Thresholds that may differ from a listing's by rounding: a division of 32-bit numbers below 1.
const ROUNDING: f64 = 2e-7;
/// An opacity with no threshold of any method nearer than rounding.
const ALPHA: f32 = 0.3;
/// Random pixels and frames that a listing is held against.
const PLACES: u32 = 4096;
/// Objects whose maps are found again: ten for each map.
const OBJECTS: u32 = 2880;

/// Where a threshold is asked for.
#[derive(Clone, Copy, Debug)]
struct Place {
    pixel: [u32; 2],
    frame: u32,
    /// Which object is hit.
    instance: u32,
}

pub(super) fn checks() -> Result<Vec<Check>> {
    let model = Model::new();
    let mut checks = vec![listing_1_check(&model, "dtaa", listing_1)?];
    checks.extend(listing_4_checks(&model, "std")?);
    checks.push(distinct("stbn", 16)?);
    for (method, period, levels) in [
        ("std", [192, 192, 9], 9 * 4096),
        ("std:noise=object", [192, 192, 9], 9 * 4096),
        ("dtaa", [320, 320, 5], 5 * 4096),
        ("dtaa-unique", [320, 320, 5], 5 * 4096),
        ("stbn", [64, 64, 16], 65_536),
        ("joint", [192, 192, 9], 9 * 4096),
    ] {
        checks.push(share_of_one_layer(method, period, levels)?);
    }
    Ok(checks)
}

/// A method's thresholds at some places, with seed 0.
fn thresholds(method: &str, places: &[Place]) -> Result<Vec<f64>> {
    struct At<'a>(&'a [Place]);
    impl Visitor for At<'_> {
        type Output = Vec<f64>;

        fn threshold(self, method: &impl Threshold) -> Vec<f64> {
            let tables = Tables::get();
            let at = |place: &Place| {
                let Place { pixel, frame, instance } = *place;
                f64::from(method.threshold(&Site { pixel, frame, instance, ..Site::default() }, &tables))
            };
            self.0.iter().map(at).collect()
        }

        fn selection(self, method: &impl Selection) -> Vec<f64> {
            let tables = Tables::get();
            self.0.iter().map(|at| f64::from(method.threshold(at.pixel, at.frame, 0, &tables))).collect()
        }

        fn ordered(self, _: &impl OrderedCompositing) -> Vec<f64> {
            Vec::new()
        }

        fn unordered(self, _: &impl UnorderedCompositing) -> Vec<f64> {
            Vec::new()
        }
    }
    Ok(method.parse::<Method>()?.visit(At(places)))
}

fn random_places(count: u32, instance: impl Fn(&mut Pcg32) -> u32) -> Vec<Place> {
    let mut random = Pcg32::new(41, 0);
    let place = |_| Place {
        pixel: [random.below(4096), random.below(4096)],
        frame: random.below(100_000),
        instance: instance(&mut random),
    };
    (0..count).map(place).collect()
}

/// STD Listing 1: the frame is added to both coordinates of the pixel, the blue noise stays.
fn listing_1_check(
    model: &Model,
    method: &str,
    stratum: impl Fn(usize, usize, usize) -> usize,
) -> Result<Check> {
    let places = random_places(PLACES, |random| random.below(9));
    let found = thresholds(method, &places)?;
    let differs = |(place, found): &(&Place, f64)| {
        let [x, y] = place.pixel.map(|coordinate| coordinate as usize);
        let expected = (stratum(x, y, place.frame as usize) as f64 + model.noise(x, y)) / 5.0;
        (found - expected).abs() > ROUNDING
    };
    let count = places.iter().zip(found).filter(differs).count();
    let name = format!("{method}: thresholds that are not those of the listing, of {PLACES}");
    Ok(exact(name, "STD Listing 1", 0.0, None, count as f64))
}

/// STD Listing 4: each object has one of the 288 maps, whichever, and each as likely as another.
fn listing_4_checks(model: &Model, method: &str) -> Result<[Check; 2]> {
    // Nine pixels of a frame show all nine cells, so that no two maps look alike; further frames show the
    // walk.
    let frames = [0, 4, 8, 31, 62];
    let grid: Vec<[u32; 3]> = frames
        .into_iter()
        .flat_map(|frame| (0..9).map(move |at| [957 + at % 3, 537 + at / 3, frame]))
        .collect();
    let mut counts = vec![0_u32; model.maps().len()];
    let mut unknown = 0;
    for instance in 0..OBJECTS {
        let places: Vec<Place> =
            grid.iter().map(|&[x, y, frame]| Place { pixel: [x, y], frame, instance }).collect();
        let found = thresholds(method, &places)?;
        let is_map = |map: &[u8; 9]| {
            grid.iter().zip(&found).all(|(&[x, y, frame], found)| {
                let [x, y, frame] = [x, y, frame].map(|number| number as usize);
                let expected = (f64::from(listing_4(map, x, y, frame)) + model.noise(x, y)) / 9.0;
                (found - expected).abs() <= ROUNDING
            })
        };
        match model.maps().iter().position(is_map) {
            Some(map) => counts[map] += 1,
            None => unknown += 1,
        }
    }
    let name = format!("{method}: objects that no map of the paper explains, of {OBJECTS}");
    let expected = f64::from(OBJECTS) / counts.len() as f64;
    let chi_square = counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
    let degrees = counts.len() as f64 - 1.0;
    let drawn = Check {
        name: format!("{method}: chi-square of the maps that objects draw"),
        source: "STD Listing 4".to_owned(),
        closed_form: Some(Value::Number(degrees)),
        paper: None,
        measured: Some(Value::Number(chi_square)),
        samples: Some(u64::from(OBJECTS)),
        z: Some(wilson_hilferty(chi_square, degrees)),
        pass: false,
    };
    Ok([exact(name, "STD Listing 4", 0.0, None, f64::from(unknown)), drawn])
}

/// The most thresholds that a pixel sees of one object.
fn distinct(method: &str, period: u32) -> Result<Check> {
    let mut most = 0;
    for pixel in [[0, 0], [37, 5], [1919, 1079]] {
        let places: Vec<Place> =
            (0..3 * period).map(|frame| Place { pixel, frame: 1000 + frame, instance: 7 }).collect();
        let seen: BTreeSet<u64> = thresholds(method, &places)?.into_iter().map(f64::to_bits).collect();
        most = most.max(seen.len());
    }
    let name = format!("{method}: thresholds that a pixel sees in {} frames", 3 * period);
    Ok(exact(name, "STD section 7.2", f64::from(period), None, most as f64))
}

/// The share of pixels and frames that keep a layer, over a whole period of columns, rows and frames: as many
/// of the threshold's equally likely levels as lie below the opacity.
fn share_of_one_layer(method: &str, [width, height, frames]: [u32; 3], levels: u32) -> Result<Check> {
    let mut kept = 0_u32;
    for frame in 0..frames {
        let pixels = (0..width * height).map(|at| [at % width, at / width]);
        let places: Vec<Place> = pixels.map(|pixel| Place { pixel, frame, instance: 3 }).collect();
        kept += thresholds(method, &places)?
            .into_iter()
            .map(|found| u32::from(f64::from(ALPHA) >= found))
            .sum::<u32>();
    }
    // Levels are the middles of equal intervals.
    let below = (f64::from(ALPHA) * f64::from(levels) + 0.5).floor() / f64::from(levels);
    let share = f64::from(kept) / f64::from(width * height * frames);
    let name = format!("{method}: share of a layer of alpha {ALPHA} over a whole period");
    Ok(exact(name, "every method without bias of one layer", below, None, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_listing_is_found() {
        let model = Model::new();
        assert!(listing_1_check(&model, "dtaa", listing_1).unwrap().pass);
        assert!(
            !listing_1_check(&model, "dtaa", |x, y, frame| (x + frame + 3 * (y + frame)) % 5).unwrap().pass
        );
        assert!(!listing_1_check(&model, "dtaa", |x, y, frame| (x + frame + 2 * y) % 5).unwrap().pass);
        assert!(!listing_1_check(&model, "dtaa:noise=off", listing_1).unwrap().pass);
    }

    #[test]
    fn objects_without_a_map_of_the_paper_are_found() {
        let model = Model::new();
        for (method, is_listing_4) in [("std", true), ("std:noise=object", false), ("stbn", false)] {
            let [known, drawn] = listing_4_checks(&model, method).unwrap();
            assert_eq!(known.pass, is_listing_4, "{method}");
            // Where no map is found none is drawn evenly.
            assert_eq!(drawn.z.unwrap().abs() < 4.0, is_listing_4, "{method}: {drawn:?}");
        }
    }

    #[test]
    fn a_share_over_less_than_a_period_is_found() {
        assert!(share_of_one_layer("std", [192, 192, 9], 9 * 4096).unwrap().pass);
        assert!(!share_of_one_layer("std", [100, 192, 9], 9 * 4096).unwrap().pass);
        assert!(!share_of_one_layer("std:noise=off", [192, 192, 9], 9 * 4096).unwrap().pass);
    }

    #[test]
    fn thresholds_that_are_never_the_same_again_are_found() {
        assert!(distinct("stbn", 16).unwrap().pass && !distinct("roulette", 16).unwrap().pass);
        assert!(!distinct("std", 16).unwrap().pass);
    }
}
