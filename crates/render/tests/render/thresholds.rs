//! What the threshold methods promise of their thresholds: spread, stratification, and how stacked layers
//! mask one another.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::Vec3;
use sheer_gallery::{LayerColours, layers_closed_form};
use sheer_render::{
    Antialiasing, Method, Pipeline, Settings, Stage,
    contract::{
        OrderedCompositing, Selection, Site, Tables, Threshold, UnorderedCompositing, Visitor, keeps,
    },
    method::{Family, METHODS},
};
use sheer_scene::CameraChoice;

/// All methods with a threshold for each hit.
fn methods() -> impl Iterator<Item = Method> {
    METHODS.iter().map(|info| parse(info.id)).filter(|method| method.family() == Family::Threshold)
}

/// The threshold of a method at one site.
struct At<'a>(&'a Site);

impl Visitor for At<'_> {
    type Output = f32;

    fn threshold(self, method: &impl Threshold) -> f32 {
        method.threshold(self.0, &Tables::get())
    }

    fn selection(self, _: &impl Selection) -> f32 {
        unreachable!("only threshold methods are asked")
    }

    fn ordered(self, _: &impl OrderedCompositing) -> f32 {
        unreachable!("only threshold methods are asked")
    }

    fn unordered(self, _: &impl UnorderedCompositing) -> f32 {
        unreachable!("only threshold methods are asked")
    }
}

fn threshold(method: &Method, site: &Site) -> f32 {
    method.visit(At(site))
}

fn parse(method: &str) -> Method {
    method.parse().unwrap()
}

/// Sites of an object all over a square of pixels in some frames.
fn sites(side: u32, frames: std::ops::Range<u32>, instance: u32) -> impl Iterator<Item = Site> {
    frames.flat_map(move |frame| {
        (0..side * side).map(move |index| {
            let [x, y] = [index % side, index / side];
            Site {
                pixel: [x, y],
                frame,
                instance,
                position: Vec3::new(x as f32, y as f32, instance as f32),
                position_in_object: Vec3::new(x as f32, y as f32, 0.0),
                footprint_in_object: 0.8,
                ..Site::default()
            }
        })
    })
}

/// Share of sites at which the second of two layers of opacity `alpha` is seen, as mean and standard error
/// over pairs of objects.
fn second_layer_share(method: &str, alpha: f32, frames: std::ops::Range<u32>) -> (f64, f64) {
    const PAIR_COUNT: u32 = 400;
    let method = parse(method);
    let shares: Vec<f64> = (0..PAIR_COUNT)
        .map(|pair| {
            let seen = sites(15, frames.clone(), 2 * pair).filter(|first| {
                let second = Site { instance: 2 * pair + 1, ..*first };
                !keeps(alpha, || threshold(&method, first)) && keeps(alpha, || threshold(&method, &second))
            });
            seen.count() as f64 / sites(15, frames.clone(), 0).count() as f64
        })
        .collect();
    let count = f64::from(PAIR_COUNT);
    let mean = shares.iter().sum::<f64>() / count;
    let variance = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

#[test]
fn dtaa_masks_the_second_of_two_equal_layers_and_methods_with_maps_of_their_own_do_not() {
    for alpha in [0.25, 0.5, 0.75] {
        assert_eq!(second_layer_share("dtaa", alpha, 0..3), (0.0, 0.0), "alpha {alpha}");
        let free = f64::from(alpha * (1.0 - alpha));
        for method in methods().filter(|method| method.info().id != "dtaa") {
            let (mean, _) = second_layer_share(&method.to_string(), alpha, 0..3);
            // Pairs of objects draw from few maps with few thresholds each: not quite as if they were
            // independent.
            assert!((mean - free).abs() < 0.03, "{method} at alpha {alpha}: {mean} of {free}");
        }
    }
}

#[test]
fn a_cycle_shows_each_pixel_every_stratum_once() {
    for (method, count) in [("dtaa", 5), ("dtaa-unique", 5), ("std", 9), ("std:rehash=9", 9)] {
        let method = parse(method);
        for first in [0, count * 1000] {
            for start in sites(20, first..first + 1, 3) {
                let seen = (first..first + count).fold(0_u32, |seen, frame| {
                    let stratum = threshold(&method, &Site { frame, ..start }) * count as f32;
                    seen | 1 << stratum as u32
                });
                assert_eq!(seen, (1 << count) - 1, "{method} at {:?} from frame {first}", start.pixel);
            }
        }
    }
}

#[test]
fn a_cycle_of_random_thresholds_misses_strata() {
    let method = parse("roulette");
    let complete = sites(20, 0..1, 3).all(|start| {
        let strata = (0..9).map(|frame| (threshold(&method, &Site { frame, ..start }) * 9.0) as u32);
        strata.fold(0_u32, |seen, stratum| seen | 1 << stratum) == 0b1_1111_1111
    });
    assert!(!complete, "the check of the strata is blind");
}

#[test]
fn maps_drawn_anew_free_any_two_objects_of_masking_one_another_for_good() {
    // Between pairs the share differs far less once each has been through many pairs of maps.
    let (_, fixed) = second_layer_share("std", 0.5, 0..36);
    let (mean, redrawn) = second_layer_share("std:rehash=3", 0.5, 0..36);
    assert!(redrawn < 0.5 * fixed, "standard errors {redrawn} and {fixed}");
    assert!((mean - 0.25).abs() < 0.03, "{mean}");
}

/// Standard deviations by which the chi-square statistic of 64 equally likely bins exceeds its mean, over
/// objects, pixels and frames.
fn chi_square_z(value: impl Fn(&Site) -> f32) -> f64 {
    let mut counts = [0_u32; 64];
    // Far from one another: neighbours share cells and strata.
    for number in 0..1_u32 << 16 {
        let [x, y] = [number.wrapping_mul(2_654_435_761) >> 20, number.wrapping_mul(2_246_822_519) >> 20];
        let site = Site {
            pixel: [x, y],
            frame: number,
            instance: number,
            primitive: number,
            position: Vec3::new(x as f32 / 16.0, y as f32 / 16.0, 1.0),
            position_in_object: Vec3::new(x as f32, y as f32, 1.0),
            footprint_in_object: 0.3 + x as f32 / 4096.0,
            ..Site::default()
        };
        counts[(value(&site) * 64.0) as usize] += 1;
    }
    let expected = f64::from(counts.iter().sum::<u32>()) / 64.0;
    let chi_square: f64 = counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
    (chi_square - 63.0) / (2.0 * 63.0_f64).sqrt()
}

#[test]
fn the_thresholds_of_every_method_are_uniform_over_objects_and_pixels() {
    for method in methods() {
        // Dithered thresholds are more even than chance would have them: only the upper end says something.
        let z = chi_square_z(|site| threshold(&method, site));
        assert!(z < 4.0, "{method}: z = {z}");
    }
}

#[test]
fn a_slightly_skewed_threshold_fails_the_test_of_uniformity() {
    let method = parse("roulette");
    let z = chi_square_z(|site| threshold(&method, site).powf(1.1));
    assert!(z > 4.0, "z = {z}");
}

#[test]
fn hashed_layers_converge_to_the_closed_form() {
    const FRAMES: u32 = 200;
    let [width, height] = [32, 18];
    let scene = sheer_gallery::open("layers:count=3,alpha=0.4,background=0").unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    let settings = Settings { size: [width, height], ..Settings::default() };
    let mut pipeline = Pipeline::new(parse("hashed"), Antialiasing::ACCUMULATE, settings).unwrap();
    for index in 0..FRAMES {
        stage.advance(pipeline.clock().at(index));
        pipeline.render(&stage, index).unwrap();
    }
    // White layers over black: each sample is 0 or 1 with a chance that is known, and so is its variance.
    let chance = f64::from(layers_closed_form(3, 0.4, LayerColours::White, 0.0).x);
    let colours = pipeline.planes().colour.as_slice();
    let error = (chance * (1.0 - chance) / f64::from(FRAMES)).sqrt();
    let squares: f64 = colours.iter().map(|colour| ((f64::from(colour[0]) - chance) / error).powi(2)).sum();
    let mean = colours.iter().map(|colour| f64::from(colour[0])).sum::<f64>() / colours.len() as f64;
    // Up to four pixels share a cell, so the mean over pixels varies at most twice as much as of as many free
    // ones.
    let z = (mean - chance) / (error / (colours.len() as f64).sqrt());
    assert!(z.abs() < 8.0, "the mean over all pixels: z = {z}");
    assert!((squares / colours.len() as f64 - 1.0).abs() < 0.3, "squared z a pixel: {squares}");
}
