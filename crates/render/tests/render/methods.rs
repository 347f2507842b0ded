//! Every method on scenes whose answer is known, and the promises of the CPU backend.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::Vec3;
use sheer_core::colour::Premul;
use sheer_gallery::{LayerColours, layers_closed_form};
use sheer_image::Planes;
use sheer_render::{
    Antialiasing, Counters, Method, Pipeline, Settings, Stage, contract::MethodInfo, method::METHODS,
};
use sheer_scene::CameraChoice;

/// Renders `frames` frames and returns the last picture and the sum of the counters.
fn play(
    scene: &str,
    method: &str,
    aa: Antialiasing,
    frames: u32,
    settings: Settings,
    threads: usize,
) -> (Planes, Counters) {
    let scene = sheer_gallery::open(scene).unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(threads)).unwrap();
    play_on(&mut stage, method, aa, frames, settings)
}

/// The same on a stage that is there: building a scene takes longer than a small picture.
fn play_on(
    stage: &mut Stage,
    method: &str,
    aa: Antialiasing,
    frames: u32,
    settings: Settings,
) -> (Planes, Counters) {
    let mut pipeline = Pipeline::new(method.parse().unwrap(), aa, settings).unwrap();
    let mut total = Counters::default();
    for index in 0..frames {
        stage.advance(pipeline.clock().at(index));
        total = total + pipeline.render(stage, index).unwrap().0;
    }
    (pipeline.planes().clone(), total)
}

fn small(width: u32, height: u32) -> Settings {
    Settings { size: [width, height], ..Settings::default() }
}

/// Those that shade one fragment a pixel, whatever their contract.
fn one_fragment_methods() -> impl Iterator<Item = &'static MethodInfo> {
    METHODS.iter().filter(|info| info.id.parse::<Method>().unwrap().family().shades_one_fragment())
}

fn colours(planes: &Planes) -> impl Iterator<Item = Premul> {
    planes.colour.as_slice().iter().copied().map(Premul::from_array)
}

#[test]
fn the_baseline_gives_the_closed_form_of_stacked_layers() {
    for (count, alpha) in [(1, 0.3), (2, 0.45), (8, 0.2), (20, 0.1), (64, 0.05)] {
        let scene = format!("layers:count={count},alpha={alpha},colours=rainbow,background=0.25");
        let (planes, _) = play(&scene, "baseline", Antialiasing::NONE, 1, small(16, 9), 2);
        let expected = layers_closed_form(count, alpha, LayerColours::Rainbow, 0.25);
        for colour in colours(&planes) {
            assert!(
                (colour.rgb - expected).abs().max_element() < 2e-3,
                "{count} layers: {colour:?}, not {expected}"
            );
            assert!((colour.alpha - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn continuation_rays_and_one_traversal_give_the_same_picture() {
    for scene in ["layers:count=20,alpha=0.1,colours=rainbow", "smoke-square:particles=400"] {
        let settings = Settings { start_secs: 6.0, ..small(64, 36) };
        let (sorted, _) = play(scene, "baseline", Antialiasing::NONE, 1, settings, 2);
        let (continued, counters) =
            play(scene, "baseline:trace=continuation", Antialiasing::NONE, 1, settings, 2);
        assert_eq!(sorted, continued, "{scene}");
        assert!(counters.camera_rays > 64 * 36, "it did continue");
    }
}

#[test]
fn a_list_of_unordered_fragments_gives_the_picture_of_ordered_ones() {
    // The baseline ends at a visibility of 0.001 and the list does not: of light up to 8 that leaves 0.008.
    for scene in ["layers:count=20,alpha=0.1,colours=rainbow", "smoke-square:particles=400", "pane"] {
        let settings = Settings { start_secs: 6.0, ..small(64, 36) };
        let (ordered, _) = play(scene, "baseline", Antialiasing::NONE, 1, settings, 2);
        let (listed, counters) = play(scene, "list", Antialiasing::NONE, 1, settings, 2);
        let worst = colours(&ordered)
            .zip(colours(&listed))
            .map(|(a, b)| (a.rgb - b.rgb).abs().max_element().max((a.alpha - b.alpha).abs()))
            .fold(0.0, f32::max);
        assert!(worst < 0.008, "{scene}: {worst}");
        assert_eq!(listed.transparent, ordered.transparent, "{scene}");
        assert_eq!(counters.camera_rays, 64 * 36);
    }
}

#[test]
fn a_list_of_spread_samples_is_the_mean_of_pictures_through_each_of_them() {
    // Panels of one colour each: shading is once a pixel, edges are every sample's own. The size is such that
    // edges lie within pixels.
    let settings = small(47, 27);
    let scene = "calibration";
    let (spread, _) = play(scene, "list:samples=64", Antialiasing::NONE, 1, settings, 2);
    let (many, _) = play(scene, "list", Antialiasing::ACCUMULATE, 256, settings, 2);
    let (one, _) = play(scene, "list", Antialiasing::NONE, 1, settings, 2);
    let rms = |planes: &Planes| {
        let squares = colours(planes).zip(colours(&many)).map(|(a, b)| (a.rgb - b.rgb).length_squared());
        (squares.sum::<f32>() / (3.0 * 47.0 * 27.0)).sqrt()
    };
    assert!(rms(&spread) < 0.15 * rms(&one), "{} of {}", rms(&spread), rms(&one));
}

#[test]
fn stochastic_methods_shade_one_fragment_a_pixel_at_most() {
    let scene = sheer_gallery::open("smoke-square:particles=400").unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    for info in one_fragment_methods() {
        let (_, counters) = play_on(&mut stage, info.id, Antialiasing::NONE, 1, small(64, 36));
        assert_eq!(counters.camera_rays, 64 * 36, "{}", info.id);
        assert!(counters.shaded <= 64 * 36 && counters.shaded > 0, "{}", info.id);
    }
}

/// Root mean square over pixels, channels and the last 18 frames of 90 by which an exponential average of
/// weight 0.1 without any clipping misses the closed form; mean of squares over four seeds, as STD draws its
/// maps by seed.
fn averaging_error(method: &str, count: u32, alpha: f32) -> f32 {
    let scene = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
    let expected = layers_closed_form(count, alpha, LayerColours::RedGreen, 1.0);
    let scene = sheer_gallery::open(&scene).unwrap().scene;
    let stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    let (mut sum, mut terms) = (0.0, 0.0_f32);
    for seed in 0..4 {
        let settings = Settings { seed, ..small(21, 12) };
        let mut pipeline = Pipeline::new(method.parse().unwrap(), Antialiasing::NONE, settings).unwrap();
        let mut average = vec![Vec3::ZERO; 21 * 12];
        for index in 0..90 {
            pipeline.render(&stage, index).unwrap();
            // A young average is a plain mean, as TAA's.
            let weight = (1.0 / (index as f32 + 1.0)).max(0.1);
            for (average, colour) in average.iter_mut().zip(colours(pipeline.planes())) {
                *average += weight * (colour.rgb - *average);
                if index >= 72 {
                    sum += (*average - expected).length_squared();
                    terms += 3.0;
                }
            }
        }
    }
    (sum / terms).sqrt()
}

#[test]
fn layers_do_not_mask_one_another_under_a_joint_threshold() {
    for (count, alpha) in [(2, 0.45), (8, 0.2), (20, 0.1)] {
        let [joint, std] = ["joint", "std"].map(|method| averaging_error(method, count, alpha));
        assert!(joint <= 0.55 * std, "{count} layers of {alpha}: joint {joint}, std {std}");
    }
}

#[test]
fn a_joint_threshold_shows_each_layer_by_its_share() {
    // 64 by 64 pixels hold the blue noise once: over a cycle of nine frames their thresholds are 36,864 equal
    // steps of [0, 1), so that the mean over picture and cycle is off by less than a step or two for each
    // layer.
    for (count, alpha) in [(2, 0.45), (8, 0.2), (20, 0.1)] {
        let scene = format!("layers:count={count},alpha={alpha},colours=rainbow,background=0.25");
        let expected = layers_closed_form(count, alpha, LayerColours::Rainbow, 0.25);
        let error = |method: &str| {
            let (planes, _) = play(&scene, method, Antialiasing::ACCUMULATE, 9, small(64, 64), 2);
            let mean = colours(&planes).map(|colour| colour.rgb).sum::<Vec3>() / 4096.0;
            (mean - expected).abs().max_element()
        };
        for method in ["joint", "joint:cycle=still"] {
            assert!(error(method) < 1e-4 * count as f32, "{method}, {count} layers: {}", error(method));
        }
        assert!(error("std") > 2e-3, "STD's layers mask one another: the check is blind");
    }
}

#[test]
fn a_still_pixel_converges_as_the_golden_ratio_moves_its_blue_noise() {
    let scene = "layers:count=8,alpha=0.2,colours=rainbow,background=0.25";
    let expected = layers_closed_form(8, 0.2, LayerColours::Rainbow, 0.25);
    let worst = |method: &str| {
        let (planes, _) = play(scene, method, Antialiasing::ACCUMULATE, 34 * 9, small(24, 16), 2);
        colours(&planes).map(|colour| (colour.rgb - expected).abs().max_element()).fold(0.0, f32::max)
    };
    let (golden, still) = (worst("joint"), worst("joint:cycle=still"));
    assert!(golden < 0.02 && golden < 0.3 * still, "golden {golden}, still {still}");
}

#[test]
fn a_hybrid_of_1_is_the_pure_method_and_one_of_0_the_baseline_to_the_bit() {
    let settings = Settings { start_secs: 6.0, ..small(48, 27) };
    let scene = sheer_gallery::open("smoke-square:particles=400").unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    let mut picture = |method: &str| play_on(&mut stage, method, Antialiasing::NONE, 1, settings);
    let (baseline, exact_cost) = picture("baseline");
    for info in one_fragment_methods() {
        let mut with = |keys: &str| picture(&format!("{}:{keys}", info.id));
        let (pure, pure_cost) = with("");
        assert_eq!(with("hybrid=1"), (pure, pure_cost), "{}", info.id);
        let (exact, cost) = with("hybrid=0");
        assert_eq!(exact, baseline, "{}", info.id);
        let rays_and_fragments = |cost: Counters| (cost.camera_rays, cost.shadow_rays, cost.shaded);
        assert_eq!(rays_and_fragments(cost), rays_and_fragments(exact_cost), "{}", info.id);
        assert_ne!(with("hybrid=0.9").0, baseline, "{}: the check is blind", info.id);
    }
}

#[test]
fn a_correction_of_none_changes_no_bit_and_one_of_eq_5_does() {
    let mut stage = Stage::new(
        sheer_gallery::open("layers:count=1,alpha=0.5,colours=white,background=0").unwrap().scene,
        &CameraChoice::Default,
        Some(2),
    )
    .unwrap();
    for info in one_fragment_methods() {
        let mut picture =
            |method: &str| play_on(&mut stage, method, Antialiasing::ACCUMULATE, 18, small(72, 72)).0;
        let plain = picture(info.id);
        assert_eq!(picture(&format!("{}:correction=none", info.id)), plain, "{}", info.id);
        let corrected = picture(&format!("{}:correction=dlss", info.id));
        assert_ne!(corrected, plain, "{}: the check is blind", info.id);
    }
}

#[test]
fn a_hybrid_comes_nearer_to_the_baseline_with_each_fragment_it_shades() {
    let settings = Settings { start_secs: 6.0, ..small(40, 22) };
    let scene = sheer_gallery::open("smoke-square:particles=400").unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    let mut picture = |method: &str| play_on(&mut stage, method, Antialiasing::ACCUMULATE, 6, settings);
    let (exact, _) = picture("baseline");
    for method in ["roulette", "std", "joint"] {
        let steps = ["1", "0.75", "0.5", "0.25", "0"].map(|share| {
            let (planes, cost) = picture(&format!("{method}:hybrid={share}"));
            let pairs = colours(&planes).zip(colours(&exact));
            let error: f32 = pairs.map(|(colour, exact)| (colour.rgb - exact.rgb).length_squared()).sum();
            (error.sqrt(), cost.shaded)
        });
        // Not strictly at the end: once all smoke is shaded there is nothing left to gain.
        let falls = steps.windows(2).all(|pair| pair[1].0 <= pair[0].0 && pair[1].1 >= pair[0].1);
        assert!(falls && steps[2].0 < 0.5 * steps[0].0, "{method}: {steps:?}");
        assert_eq!(steps[4].0, 0.0, "{method}");
    }
}

#[test]
fn a_hybrid_of_roulette_is_unbiased_in_every_pixel() {
    const FRAMES: u32 = 64;
    let scene = "layers:count=8,alpha=0.2,colours=rainbow,background=0.25";
    let expected = layers_closed_form(8, 0.2, LayerColours::Rainbow, 0.25);
    let scene = sheer_gallery::open(scene).unwrap().scene;
    let stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    // Sum over pixels of the squared z of their means, in standard deviations from its expectation; and the
    // largest z.
    let deviation = |method: &str| {
        let mut pipeline = Pipeline::new(method.parse().unwrap(), Antialiasing::NONE, small(32, 18)).unwrap();
        let (mut sums, mut squares) = (vec![0.0; 32 * 18], 0.0);
        for index in 0..FRAMES {
            pipeline.render(&stage, index).unwrap();
            for (sum, colour) in sums.iter_mut().zip(colours(pipeline.planes())) {
                let difference = f64::from(colour.rgb.x - expected.x);
                *sum += difference;
                squares += difference * difference;
            }
        }
        let pixels = sums.len() as f64;
        let variance = squares / (pixels * f64::from(FRAMES));
        let z = sums.iter().map(|sum| sum / (variance * f64::from(FRAMES)).sqrt());
        let chi_square: f64 = z.clone().map(|z| z * z).sum();
        ((chi_square - pixels) / (2.0 * pixels).sqrt(), z.fold(0.0, |most, z| z.abs().max(most)))
    };
    for method in ["roulette:hybrid=0.5", "roulette:hybrid=0,layers=2"] {
        let (chi, worst) = deviation(method);
        assert!(chi.abs() < 4.0 && worst < 5.0, "{method}: chi {chi}, z {worst}");
    }
    let (chi, _) = deviation("std:hybrid=0.5");
    assert!(chi.abs() > 8.0, "dithered frames are not independent draws, the check is blind: {chi}");
}

#[test]
fn a_limit_of_layers_bounds_what_a_hybrid_shades() {
    let scene = "layers:count=20,alpha=0.1,background=0.25";
    for info in one_fragment_methods() {
        let cost = |keys: &str| {
            let method = format!("{}:{keys}", info.id);
            play(scene, &method, Antialiasing::NONE, 1, small(32, 18), 2).1
        };
        let pixels = 32 * 18;
        assert_eq!(cost("hybrid=0").shaded, 21 * pixels, "{}", info.id);
        let bounded = cost("hybrid=0,layers=4");
        assert_eq!((bounded.shaded, bounded.camera_rays), (5 * pixels, 2 * pixels), "{}", info.id);
        // The first two layers leave 0.81: only a lower share than that runs out of fragments.
        let merged = ["hybrid=0,layers=4", "hybrid=0", "hybrid=0.85,layers=2", "hybrid=0.8,layers=2"];
        assert_eq!(merged.map(|keys| cost(keys).merged), [pixels, 0, 0, pixels], "{}", info.id);
    }
}

#[test]
fn alignment_changes_what_taa_makes_of_motion_and_nothing_else() {
    let scene = sheer_gallery::open("pane").unwrap().scene;
    let camera = CameraChoice::Named("path".to_owned());
    let mut stage = Stage::new(scene, &camera, Some(2)).unwrap();
    let mut picture = |method: &str, aa| play_on(&mut stage, method, aa, 6, small(64, 36)).0;
    for method in METHODS.iter().filter(|info| info.alignment_px > 1).map(|info| info.id) {
        for rule in ["off", "round", "dead"] {
            let other = format!("{method}:align={rule}");
            assert_ne!(picture(method, Antialiasing::TAA), picture(&other, Antialiasing::TAA), "{other}");
            for still in [Antialiasing::NONE, Antialiasing::ACCUMULATE] {
                assert_eq!(picture(method, still), picture(&other, still), "{other}");
            }
        }
    }
}

#[test]
fn both_ends_of_alpha_are_exact_for_every_method() {
    for info in METHODS {
        for (alpha, expected) in [(0.0, Vec3::splat(0.25)), (1.0, Vec3::ONE)] {
            let scene = format!("layers:count=5,alpha={alpha},background=0.25");
            let (planes, _) = play(&scene, info.id, Antialiasing::TAA, 20, small(32, 18), 2);
            let worst = colours(&planes)
                .map(|colour| (colour.rgb - expected).abs().max_element())
                .fold(0.0, f32::max);
            assert!(worst < 1e-5, "{} at alpha {alpha}: off by {worst}", info.id);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let stage = |threads| {
        let scene = sheer_gallery::open("smoke-square:particles=400").unwrap().scene;
        Stage::new(scene, &CameraChoice::Default, Some(threads)).unwrap()
    };
    let mut stages = [1, 2].map(stage);
    for info in METHODS {
        let [(one, cost_of_one), (two, cost_of_two)] =
            stages.each_mut().map(|stage| play_on(stage, info.id, Antialiasing::TAA, 3, small(70, 45)));
        assert_eq!(one, two, "{}", info.id);
        assert_eq!(cost_of_one, cost_of_two, "{}", info.id);
    }
}

#[test]
fn another_seed_draws_other_thresholds() {
    for info in one_fragment_methods() {
        let run = |seed| {
            let settings = Settings { seed, ..small(32, 18) };
            play("layers:count=3,alpha=0.5", info.id, Antialiasing::NONE, 1, settings, 1).0
        };
        assert_ne!(run(0).colour, run(1).colour, "{}", info.id);
    }
}

#[test]
fn a_still_scene_seen_by_a_still_camera_has_no_motion() {
    let (planes, _) = play("layers", "std", Antialiasing::TAA, 3, small(32, 18), 1);
    assert!(planes.motion.as_slice().iter().all(|motion| *motion == [0.0; 2]));
    let (planes, _) = play("smoke-square:particles=100", "std", Antialiasing::TAA, 3, small(32, 18), 1);
    assert!(planes.motion.as_slice().iter().any(|motion| motion[0] != 0.0), "the path camera moves");
}

#[test]
fn without_a_background_the_alpha_is_what_the_scene_covers() {
    let scene = "layers:count=2,alpha=0.5";
    let settings = Settings { background: sheer_render::Background::None, ..small(16, 9) };
    let (planes, _) = play(scene, "baseline", Antialiasing::NONE, 1, settings, 1);
    // The scene brings an opaque background of its own.
    assert!(colours(&planes).all(|colour| colour.alpha > 0.999));
    let (planes, _) = play("plume:particles=200", "baseline", Antialiasing::NONE, 1, settings, 1);
    assert!(colours(&planes).all(|colour| (0.0..=1.0).contains(&colour.alpha)));
}
