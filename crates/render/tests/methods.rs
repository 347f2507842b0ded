//! Every method on scenes whose answer is known, and the promises of the CPU backend.

use glam::Vec3;
use sheer_core::colour::Premul;
use sheer_image::Planes;
use sheer_render::{Antialiasing, Counters, Pipeline, Settings, Stage, method::METHODS};
use sheer_scene::{
    CameraChoice,
    builtin::{LayerColours, layers_closed_form},
};

/// Renders `frames` frames and returns the last picture and the sum of the counters.
fn play(
    scene: &str,
    method: &str,
    aa: Antialiasing,
    frames: u32,
    settings: Settings,
    threads: usize,
) -> (Planes, Counters) {
    let scene = sheer_scene::open(scene).unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(threads)).unwrap();
    let mut pipeline = Pipeline::new(method.parse().unwrap(), aa, settings).unwrap();
    let mut total = Counters::default();
    for index in 0..frames {
        stage.advance(pipeline.clock().at(index));
        total = total + pipeline.render(&stage, index).unwrap().0;
    }
    (pipeline.planes().clone(), total)
}

fn small(width: u32, height: u32) -> Settings {
    Settings { size: [width, height], ..Settings::default() }
}

fn colours(planes: &Planes) -> impl Iterator<Item = Premul> {
    planes.colour.as_slice().iter().copied().map(Premul::from_array)
}

#[test]
fn the_baseline_gives_the_closed_form_of_stacked_layers() {
    for (count, alpha) in [(1, 0.3), (2, 0.45), (8, 0.2), (20, 0.1), (64, 0.05)] {
        let scene = format!("layers:count={count},alpha={alpha},colours=rainbow,background=0.25");
        let (planes, _) = play(&scene, "baseline", Antialiasing::None, 1, small(16, 9), 2);
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
        let (sorted, _) = play(scene, "baseline", Antialiasing::None, 1, settings, 2);
        let (continued, counters) =
            play(scene, "baseline:trace=continuation", Antialiasing::None, 1, settings, 2);
        assert_eq!(sorted, continued, "{scene}");
        assert!(counters.camera_rays > 64 * 36, "it did continue");
    }
}

#[test]
fn stochastic_methods_shade_one_fragment_a_pixel_at_most() {
    for info in METHODS.iter().filter(|info| info.id != "baseline") {
        let (_, counters) =
            play("smoke-square:particles=400", info.id, Antialiasing::None, 1, small(64, 36), 2);
        assert_eq!(counters.camera_rays, 64 * 36, "{}", info.id);
        assert!(counters.shaded <= 64 * 36 && counters.shaded > 0, "{}", info.id);
    }
}

#[test]
fn both_ends_of_alpha_are_exact_for_every_method() {
    for info in METHODS {
        for (alpha, expected) in [(0.0, Vec3::splat(0.25)), (1.0, Vec3::ONE)] {
            let scene = format!("layers:count=5,alpha={alpha},background=0.25");
            let (planes, _) = play(&scene, info.id, Antialiasing::Taa, 20, small(32, 18), 2);
            let worst = colours(&planes)
                .map(|colour| (colour.rgb - expected).abs().max_element())
                .fold(0.0, f32::max);
            assert!(worst < 1e-5, "{} at alpha {alpha}: off by {worst}", info.id);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for info in METHODS {
        let run = |threads| {
            play("smoke-square:particles=400", info.id, Antialiasing::Taa, 3, small(70, 45), threads)
        };
        let ((one, cost_of_one), (two, cost_of_two)) = (run(1), run(2));
        assert_eq!(one, two, "{}", info.id);
        assert_eq!(cost_of_one, cost_of_two, "{}", info.id);
    }
}

#[test]
fn another_seed_draws_other_thresholds() {
    for info in METHODS.iter().filter(|info| info.id != "baseline") {
        let run = |seed| {
            let settings = Settings { seed, ..small(32, 18) };
            play("layers:count=3,alpha=0.5", info.id, Antialiasing::None, 1, settings, 1).0
        };
        assert_ne!(run(0).colour, run(1).colour, "{}", info.id);
    }
}

#[test]
fn a_still_scene_seen_by_a_still_camera_has_no_motion() {
    let (planes, _) = play("layers", "std", Antialiasing::Taa, 3, small(32, 18), 1);
    assert!(planes.motion.as_slice().iter().all(|motion| *motion == [0.0; 2]));
    let (planes, _) = play("smoke-square:particles=100", "std", Antialiasing::Taa, 3, small(32, 18), 1);
    assert!(planes.motion.as_slice().iter().any(|motion| motion[0] != 0.0), "the path camera moves");
}

#[test]
fn without_a_background_the_alpha_is_what_the_scene_covers() {
    let scene = "layers:count=2,alpha=0.5";
    let settings = Settings { background: sheer_render::Background::None, ..small(16, 9) };
    let (planes, _) = play(scene, "baseline", Antialiasing::None, 1, settings, 1);
    // The scene brings an opaque background of its own.
    assert!(colours(&planes).all(|colour| colour.alpha > 0.999));
    let (planes, _) = play("plume:particles=200", "baseline", Antialiasing::None, 1, settings, 1);
    assert!(colours(&planes).all(|colour| (0.0..=1.0).contains(&colour.alpha)));
}
