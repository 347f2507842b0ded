//! Coloured glass: what shines through a surface in its colour.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4};
use sheer_core::colour::mean_channel;
use sheer_gallery::{LayerColours, glass_layers_closed_form};
use sheer_image::Planes;
use sheer_render::{
    Background, Method, Pipeline, Settings, Stage,
    method::{Family, METHODS},
};
use sheer_scene::{
    CameraChoice, ClipPlanes, Scene,
    camera::{Camera, CameraKey, CameraMotion, Lens},
    model::{AlphaMode, Instance, Material, Mesh, Node, SceneParts, ShadingModel, Transform},
};

const ALPHA: f32 = 0.125;
const TRANSMISSION: f32 = 0.75;

fn play_on(stage: &mut Stage, method: &str, aa: &str, frames: u32, settings: Settings) -> Planes {
    let mut pipeline = Pipeline::new(method.parse().unwrap(), aa.parse().unwrap(), settings).unwrap();
    for index in 0..frames {
        stage.advance(pipeline.clock().at(index));
        pipeline.render(stage, index).unwrap();
    }
    pipeline.planes().clone()
}

fn layers(count: u32, background: f32) -> Stage {
    let text = format!(
        "layers:count={count},alpha={ALPHA},transmission={TRANSMISSION},colours=stained,background={background}"
    );
    let scene = sheer_gallery::open(&text).unwrap().scene;
    Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap()
}

fn small(width: u32, height: u32) -> Settings {
    Settings { size: [width, height], ..Settings::default() }
}

fn mean(planes: &Planes) -> Vec3 {
    let pixels = planes.colour.as_slice();
    pixels.iter().map(|&[red, green, blue, _]| Vec3::new(red, green, blue)).sum::<Vec3>()
        / pixels.len() as f32
}

/// Of three layers before grey.
fn closed_form(background: f32) -> Vec3 {
    glass_layers_closed_form(3, ALPHA, TRANSMISSION, LayerColours::Stained, background)
}

#[test]
fn what_composites_lets_the_background_through_in_exact_colours() {
    let [mut dark, mut bright] = [layers(3, 0.0), layers(3, 1.0)];
    let expected = closed_form(1.0) - closed_form(0.0);
    assert!(expected.x < 0.75 * expected.y, "the test is blind: {expected}");
    for info in METHODS {
        if info.id.parse::<Method>().unwrap().family().shades_one_fragment() {
            continue;
        }
        let [without, with] =
            [&mut dark, &mut bright].map(|stage| mean(&play_on(stage, info.id, "none", 1, small(8, 8))));
        assert!(
            (with - without).abs_diff_eq(expected, 1e-5),
            "{}: {with} - {without}, not {expected}",
            info.id
        );
    }
}

#[test]
fn what_composites_in_order_is_exact() {
    let mut stage = layers(3, 0.75);
    for method in ["baseline", "list", "list:samples=3", "peel", "kbuffer", "mlab", "adaptive"] {
        let found = mean(&play_on(&mut stage, method, "none", 1, small(8, 8)));
        assert!(found.abs_diff_eq(closed_form(0.75), 1e-5), "{method}: {found}, not {}", closed_form(0.75));
    }
}

#[test]
fn no_sample_of_a_single_fragment_is_brighter_than_what_it_samples() {
    // Weights are at most 1, however many layers chance lets pass.
    let mut stage = layers(8, 1.0);
    for info in METHODS {
        let family = info.id.parse::<Method>().unwrap().family();
        if !matches!(family, Family::Threshold | Family::Selection) {
            continue;
        }
        let planes = play_on(&mut stage, info.id, "none", 1, small(64, 36));
        let brightest =
            planes.colour.as_slice().iter().flatten().fold(0.0, |most: f32, &value| most.max(value));
        assert!(brightest <= 1.0 + 1e-6, "{}: {brightest}", info.id);
    }
}

#[test]
fn layers_are_put_together_with_the_exact_colours_of_each_frame() {
    let mut stage = layers(3, 0.75);
    for method in ["joint", "roulette"] {
        let found = mean(&play_on(&mut stage, method, "layered", 64, small(48, 27)));
        assert!(found.abs_diff_eq(closed_form(0.75), 0.01), "{method}: {found}, not {}", closed_form(0.75));
    }
    // What glass absorbs is known from the first frame on, whichever layer a pixel has sampled.
    let settings = Settings { raw: true, ..small(16, 9) };
    let planes = play_on(&mut stage, "joint", "layered", 1, settings);
    let layers = planes.layers.unwrap();
    let expected = closed_form(1.0) - closed_form(0.0);
    for layers in layers.as_slice() {
        let passes = Vec3::splat(1.0 - layers.coverage) - Vec3::from(layers.absorbed);
        assert!(passes.abs_diff_eq(expected, 1e-5), "{layers:?}, not {expected}");
    }
    assert!(layers.as_slice().iter().any(|layers| layers.is_front));
    assert!(layers.as_slice().iter().any(|layers| !layers.is_front));
}

/// Unlit squares of side 2, facing the eye, each with a material and a place.
fn squares(squares: &[(Material, Vec3)]) -> Scene {
    let positions =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
    let indices = vec![[0, 1, 2], [0, 2, 3]];
    let mesh = |material| Mesh {
        positions: positions.clone(),
        indices: indices.clone(),
        material,
        ..Mesh::default()
    };
    let instance = |(index, (_, place)): (u32, &(Material, Vec3))| Instance {
        node: 0,
        node_from_object: Affine3A::from_translation(*place),
        mesh: index,
        id: index,
        geometry: 0,
        skin: None,
        morph_weights: Vec::new(),
    };
    Scene::new(SceneParts {
        name: "squares".to_owned(),
        nodes: vec![Node { name: String::new(), parent: None, transform: Transform::IDENTITY }],
        instances: (0..).zip(squares).map(instance).collect(),
        meshes: (0..squares.len() as u32).map(mesh).collect(),
        materials: squares.iter().map(|(material, _)| material.clone()).collect(),
        cameras: vec![Camera {
            name: "front".to_owned(),
            lens: Lens::Orthographic { half_height: 1.6 },
            clip: ClipPlanes::NONE,
            motion: CameraMotion::Path {
                keys: vec![CameraKey { time_secs: 0.0, eye: Vec3::Z, target: Vec3::ZERO }],
            },
        }],
        exposure: 1.0,
        ..SceneParts::default()
    })
    .unwrap()
}

fn glass(colour: Vec3) -> Material {
    Material {
        base_colour: Vec4::from((colour, 0.2)),
        alpha_mode: AlphaMode::Blend,
        transmission: 0.8,
        model: ShadingModel::Unlit,
        ..Material::default()
    }
}

/// The middle of a picture of a scene before nothing.
fn middle(scene: &Scene, method: &str, frames: u32) -> [f32; 4] {
    let mut stage = Stage::new(Arc::new(scene.clone()), &CameraChoice::Default, Some(1)).unwrap();
    let settings = Settings { background: Background::None, ..small(33, 33) };
    play_on(&mut stage, method, "accumulate", frames, settings).colour[(16, 16)]
}

#[test]
fn before_nothing_glass_covers_what_it_absorbs() {
    let red = squares(&[(glass(Vec3::X), Vec3::ZERO)]);
    // The surface itself is 0.2 red; of the rest, 0.8, red passes and a third is all that is left of it.
    let expected = [0.2, 0.0, 0.0, 1.0 - 0.8 / 3.0];
    let near = |found: [f32; 4], tolerance: f32| {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= tolerance)
    };
    for method in ["baseline", "list", "weighted", "stochastic"] {
        let found = middle(&red, method, 1);
        assert!(near(found, 1e-5), "{method}: {found:?}");
    }
    // The standard error of 900 frames of red, the noisiest channel, is 0.4/30.
    for method in ["roulette", "joint"] {
        let found = middle(&red, method, 900);
        assert!(near(found, 0.05), "{method}: {found:?}");
    }
    // Red before blue lets nothing pass.
    let both = squares(&[(glass(Vec3::X), Vec3::ZERO), (glass(Vec3::Z), Vec3::NEG_Z)]);
    for method in ["baseline", "list", "peel", "kbuffer"] {
        let [red, green, blue, alpha] = middle(&both, method, 1);
        assert!(alpha > 0.999_99 && (red - 0.2).abs() < 1e-5 && green == 0.0 && blue < 1e-5, "{method}");
    }
}

#[test]
fn clear_glass_is_grey_to_the_bit() {
    let clear = squares(&[(glass(Vec3::ONE), Vec3::ZERO), (glass(Vec3::ONE), Vec3::NEG_Z)]);
    let ordinary = Material { transmission: 0.0, ..glass(Vec3::ONE) };
    let grey = squares(&[(ordinary.clone(), Vec3::ZERO), (ordinary, Vec3::NEG_Z)]);
    for info in METHODS {
        assert_eq!(middle(&clear, info.id, 3), middle(&grey, info.id, 3), "{}", info.id);
    }
}

#[test]
fn a_body_absorbs_by_its_thickness_where_its_front_is_met() {
    let body = |thickness: f32, absorption: Vec3| Material {
        thickness,
        absorption,
        double_sided: true,
        ..glass(Vec3::ONE)
    };
    let passes = |material: Material| {
        let [wall, none] = [1.0, 0.0].map(|grey| {
            let wall = Material {
                base_colour: Vec4::new(grey, grey, grey, 1.0),
                model: ShadingModel::Unlit,
                ..Material::default()
            };
            middle(&squares(&[(material.clone(), Vec3::ZERO), (wall, Vec3::NEG_Z)]), "baseline", 1)
        });
        Vec3::from_array([0, 1, 2].map(|at| wall[at] - none[at]))
    };
    let absorption = Vec3::new(0.0, 1.0, 3.0);
    let expected = 0.8 * (-0.5 * absorption).exp();
    assert!(passes(body(0.5, absorption)).abs_diff_eq(expected, 1e-5), "{}", passes(body(0.5, absorption)));
    assert!(passes(body(0.0, absorption)).abs_diff_eq(Vec3::splat(0.8), 1e-5));
    assert!(passes(body(0.5, Vec3::ZERO)).abs_diff_eq(Vec3::splat(0.8), 1e-5));
}

#[test]
fn edges_of_glass_are_every_samples_own() {
    // A red square in front of a white wall; its edges lie within pixels.
    let wall = Material { model: ShadingModel::Unlit, ..Material::default() };
    let mut big = Vec::new();
    for x in -2..=2 {
        for y in -2..=2 {
            big.push((wall.clone(), Vec3::new(2.0 * x as f32, 2.0 * y as f32, -1.0)));
        }
    }
    big.push((glass(Vec3::X), Vec3::new(0.37, 0.21, 0.0)));
    let mut stage = Stage::new(Arc::new(squares(&big)), &CameraChoice::Default, Some(2)).unwrap();
    let [spread, many, one] =
        [("list:samples=64", "none", 1), ("list", "accumulate", 256), ("list", "none", 1)]
            .map(|(method, aa, frames)| play_on(&mut stage, method, aa, frames, small(47, 27)));
    let rms = |planes: &Planes| {
        let pairs = planes.colour.as_slice().iter().zip(many.colour.as_slice());
        let squares = pairs.map(|(a, b)| (Vec4::from(*a) - Vec4::from(*b)).length_squared());
        (squares.sum::<f32>() / (3.0 * 47.0 * 27.0)).sqrt()
    };
    assert!(rms(&spread) < 0.15 * rms(&one), "{} of {}", rms(&spread), rms(&one));
}

#[test]
fn the_mean_of_three_equal_channels_is_that() {
    for value in [0.0, 0.1, 1.0 / 3.0, 0.7, 1.0] {
        assert_eq!(mean_channel(Vec3::splat(value)), value);
    }
}
