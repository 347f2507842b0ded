//! The GPU gives the CPU's pictures: every method that goes by rays, on both paths.
//!
//! What decides whether a fragment is shown is integer arithmetic and opacities by the CPU's own operations
//! in the CPU's order, so that two backends differ where they find other hits: at the edges of triangles. A
//! pixel counts as one of those if the CPU meets other triangles a small part of a pixel beside its centre.
#![expect(clippy::unwrap_used, reason = "a test that cannot begin has failed")]

use std::{
    f32::consts::TAU,
    path::Path as FilePath,
    sync::{Arc, LazyLock},
};

use glam::{Vec2, Vec3, Vec4};
use sheer_gpu::{AdapterChoice, Gpu, GpuBackend, GpuPathChoice, GpuPipeline, GpuStage, Tracer};
use sheer_image::{Image, Planes};
use sheer_lab::{
    agreement::{Disagreement, Tolerance},
    picture,
};
use sheer_render::{Antialiasing, Backend, Background, Method, Moment, Settings, Stage, backend::Cpu};
use sheer_scene::{
    CameraChoice, ClipPlanes, Environment, Scene, SceneParts,
    model::{Animation, Interpolation, Keys, MorphTarget, Property},
};

/// Three built-in scenes, two files, some with an opacity for everything.
const SCENES: [(&str, Option<f32>); 5] = [
    ("layers:count=6,alpha=0.3", None),
    ("pane", None),
    ("smoke-square", None),
    ("gltf/Fox/Fox.gltf", Some(0.4)),
    ("gltf/NegativeScaleTest/NegativeScaleTest.gltf", Some(0.6)),
];
/// Large enough that few pixels are edges.
const SIZE: [u32; 2] = [256, 144];
/// Of the scene with tens of layers everywhere, which takes most of the time.
const DEEP: (&str, [u32; 2]) = ("smoke-square", [128, 72]);
/// Colours of the same fragment differ by no more than half floats do, 2⁻¹¹, twice; few pixels are edges.
const TOLERANCE: Tolerance = Tolerance {
    colour: 1.0 / 1024.0,
    colour_share: 0.002,
    other_share: 0.002,
    inside_share: Some(0.0),
    surface_share: 0.002,
};

static GPU: LazyLock<Arc<Gpu>> = LazyLock::new(|| {
    Gpu::new(&AdapterChoice::Best).expect("the tests need a Vulkan driver: `cargo xtask setup` installs one")
});
static OWN_TREE: LazyLock<Arc<Gpu>> = LazyLock::new(|| {
    Gpu::with_tracer(&AdapterChoice::Best, Some(Tracer::Bvh)).expect("the tests need a Vulkan driver")
});

fn scene(text: &str, alpha: Option<f32>) -> Arc<Scene> {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(text);
    let text = if text.contains('/') { file.to_str().unwrap() } else { text };
    let scene = sheer_gallery::open(text).unwrap().scene;
    Arc::new(match alpha {
        Some(alpha) => scene.with_alpha(alpha),
        None => scene,
    })
}

fn settings(scene: &Scene, seed: u32) -> Settings {
    let size = if scene.parts().name == DEEP.0 { DEEP.1 } else { SIZE };
    Settings { size, seed, first_frame: 4, ..Settings::default() }
}

fn cpu_stage(scene: &Arc<Scene>) -> Stage {
    Stage::new(Arc::clone(scene), &CameraChoice::Default, None).unwrap()
}

fn on_cpu(stage: &mut Stage, method: &str) -> Planes {
    let settings = settings(stage.frame().scene(), 0);
    picture(&Cpu, stage, &method.parse().unwrap(), Antialiasing::NONE, settings, 1).unwrap().0
}

fn on_gpu(gpu: &Arc<Gpu>, path: GpuPathChoice, scene: &Arc<Scene>, method: &str, seed: u32) -> Planes {
    let backend = GpuBackend::new(Arc::clone(gpu), path);
    let mut stage = backend.stage(Arc::clone(scene), &CameraChoice::Default, None).unwrap();
    let method = method.parse().unwrap();
    picture(&backend, &mut stage, &method, Antialiasing::NONE, settings(scene, seed), 1).unwrap().0
}

fn difference(stage: &Stage, expected: &Planes, found: &Planes) -> Disagreement {
    Disagreement::measure(stage, expected, found, TOLERANCE).unwrap()
}

/// Holds a method against the CPU on all scenes.
fn check(gpu: &Arc<Gpu>, path: GpuPathChoice, method: &str) {
    for (name, alpha) in SCENES {
        let scene = scene(name, alpha);
        let mut stage = cpu_stage(&scene);
        let expected = on_cpu(&mut stage, method);
        let difference = difference(&stage, &expected, &on_gpu(gpu, path, &scene, method, 0));
        assert!(
            difference.shows_same(TOLERANCE),
            "{method} of {name} by {path:?}, {:?}: {difference}",
            gpu.tracer()
        );
    }
}

#[test]
fn threshold_methods_show_the_cpus_fragments_by_rays() {
    for method in
        ["std", "roulette", "dtaa", "dtaa-unique", "hashed", "stbn", "std:rehash=9,identity=primitive"]
    {
        check(&GPU, GpuPathChoice::Ray, method);
    }
}

#[test]
fn threshold_methods_show_the_cpus_fragments_by_raster() {
    for method in ["std", "roulette", "dtaa", "dtaa-unique", "hashed", "stbn", "std:correction=dlss"] {
        check(&GPU, GpuPathChoice::Raster, method);
    }
}

/// Surroundings that no closed form has: a smooth sky of many colours, and a sun in it.
fn panorama() -> Environment {
    let towards_sun = Vec2::new(200.0, 30.0);
    let texels = Image::from_fn(256, 128, |x, y| {
        let wave = |step: f32| 0.5 + 0.5 * (step * x as f32 * TAU / 256.0 + 0.02 * y as f32).sin();
        let sun = if Vec2::new(x as f32, y as f32).distance(towards_sun) < 2.5 { 800.0 } else { 0.0 };
        [wave(1.0) + sun, 0.8 * wave(2.0) + sun, wave(3.0) + 0.8 * sun]
    });
    Environment::from_panorama(&texels.unwrap()).unwrap()
}

#[test]
fn a_panorama_lights_and_is_seen_as_on_the_cpu() {
    let plain = scene("gltf/Fox/Fox.gltf", Some(0.4));
    let scene = Arc::new(Scene::clone(&plain).with_environment(panorama()));
    assert!(scene.parts().environment.light.is_some(), "the sun casts shadows");
    let mut stage = cpu_stage(&scene);
    let expected = on_cpu(&mut stage, "std");
    let found = on_gpu(&GPU, GpuPathChoice::Ray, &scene, "std", 0);
    let seen = difference(&stage, &expected, &found);
    assert!(seen.shows_same(TOLERANCE), "{seen}");
    // Negative control: in other surroundings it is another picture.
    let other = on_cpu(&mut cpu_stage(&plain), "std");
    assert!(!difference(&stage, &other, &found).shows_same(TOLERANCE));
}

#[test]
fn what_is_display_referred_is_the_same_on_both() {
    let scene = scene("gltf/Fox/Fox.gltf", Some(0.4));
    let settings = Settings { background: Background::Colour(Vec3::ONE), ..settings(&scene, 0) };
    let backend = GpuBackend::new(Arc::clone(&GPU), GpuPathChoice::Ray);
    let moment = Moment { time_secs: 0.3, previous_secs: 0.2 };
    let (mut ours, mut theirs) = (cpu_stage(&scene), cpu_stage(&scene));
    let mut gpu_stage = backend.stage(Arc::clone(&scene), &CameraChoice::Default, None).unwrap();
    ours.advance(moment);
    backend.advance(&mut gpu_stage, moment).unwrap();
    let share = |stage: &Stage| Cpu.display_share(stage, &settings, Antialiasing::TAA).unwrap();
    let found = backend.display_share(&gpu_stage, &settings, Antialiasing::TAA).unwrap();
    assert_eq!(found, share(&ours));
    // Negative control: at another moment the fox stands elsewhere.
    theirs.advance(Moment { time_secs: 0.6, previous_secs: 0.5 });
    assert_ne!(found, share(&theirs));
}

#[test]
fn selection_shows_the_cpus_fragments_on_both_paths() {
    for path in [GpuPathChoice::Ray, GpuPathChoice::Raster] {
        check(&GPU, path, "joint");
    }
}

/// More layers than one traversal gathers: a second one goes on behind them, and neither drops nor merges
/// anything.
#[test]
fn a_further_traversal_of_selection_merges_nothing() {
    let scene = scene("layers:count=20,alpha=0.05", None);
    let settings = settings(&scene, 0);
    let mut stage = GpuStage::new(&GPU, scene, &CameraChoice::Default, None).unwrap();
    let method: Method = "joint".parse().unwrap();
    let mut pipeline =
        GpuPipeline::new(&GPU, GpuPathChoice::Ray, method, Antialiasing::NONE, settings).unwrap();
    stage.advance(pipeline.clock().at(0)).unwrap();
    let (counters, _) = pipeline.render(&mut stage, 0).unwrap();
    let pixels = u64::from(SIZE[0]) * u64::from(SIZE[1]);
    assert!(counters.camera_rays > pixels + pixels / 5, "few pixels need a further traversal: {counters:?}");
    assert_eq!(counters.merged, 0, "{counters:?}");
}

#[test]
fn the_exact_answer_is_the_cpus_on_both_paths() {
    for path in [GpuPathChoice::Ray, GpuPathChoice::Raster] {
        check(&GPU, path, "baseline");
    }
    check(&GPU, GpuPathChoice::Ray, "baseline:trace=continuation");
}

#[test]
fn hybrids_are_the_cpus_on_both_paths() {
    for path in [GpuPathChoice::Ray, GpuPathChoice::Raster] {
        check(&GPU, path, "std:hybrid=0.5,layers=3");
    }
}

#[test]
fn our_own_tree_leads_to_the_same_fragments() {
    for method in ["std", "joint"] {
        check(&OWN_TREE, GpuPathChoice::Ray, method);
    }
}

/// STD section 3.5 asks for "identical hit points" of both paths.
#[test]
fn rays_and_raster_pick_the_same_fragments() {
    for (name, alpha) in SCENES {
        let scene = scene(name, alpha);
        let [ray, raster] =
            [GpuPathChoice::Ray, GpuPathChoice::Raster].map(|path| on_gpu(&GPU, path, &scene, "std", 0));
        let mut stage = cpu_stage(&scene);
        on_cpu(&mut stage, "std");
        let difference = difference(&stage, &ray, &raster);
        assert!(difference.shows_same(TOLERANCE), "{name}: {difference}");
    }
}

#[test]
fn motion_depth_and_transparency_are_the_cpus() {
    for (name, alpha) in SCENES {
        let scene = scene(name, alpha);
        let mut stage = cpu_stage(&scene);
        let expected = on_cpu(&mut stage, "std");
        let difference = difference(&stage, &expected, &on_gpu(&GPU, GpuPathChoice::Ray, &scene, "std", 0));
        assert!(difference.has_same_surfaces(TOLERANCE), "{name}: {difference}");
    }
}

#[test]
fn another_seed_or_method_is_noticed() {
    for (name, alpha) in SCENES {
        let scene = scene(name, alpha);
        let mut stage = cpu_stage(&scene);
        let expected = on_cpu(&mut stage, "std");
        let seed = difference(&stage, &expected, &on_gpu(&GPU, GpuPathChoice::Ray, &scene, "std", 1));
        let method = difference(&stage, &expected, &on_gpu(&GPU, GpuPathChoice::Ray, &scene, "roulette", 0));
        for difference in [seed, method] {
            assert!(!difference.shows_same(TOLERANCE), "the check is blind on {name}: {difference}");
        }
    }
}

/// Layers of which the nearest and the background are beyond the camera's clip planes; one fades, one glows,
/// and one has the colours of a morph.
fn layers_that_change() -> Arc<Scene> {
    let mut parts = sheer_gallery::open("layers:count=6,alpha=0.3").unwrap().scene.parts().clone();
    let keys = |from: Vec4, to: Vec4| Keys {
        times_secs: vec![0.0, 1.0],
        values: vec![from, to],
        interpolation: Interpolation::Linear,
    };
    let fading = keys(Vec4::ONE, Vec4::new(0.2, 0.4, 0.6, 0.1));
    let glow =
        Keys { times_secs: vec![0.0, 1.0], values: vec![0.0, 4.0], interpolation: Interpolation::Linear };
    parts.animations.push(Animation {
        properties: vec![
            Property::BaseColour { material: 0, factor: fading },
            Property::Emissive { material: 1, factor: Keys::constant(Vec3::ONE), strength: glow },
        ],
        ..Animation::default()
    });
    let morphed = &mut parts.meshes[2];
    morphed.colours = vec![Vec4::ONE; morphed.positions.len()];
    let deltas = (0..morphed.positions.len()).map(|vertex| Vec4::new(-0.2, 0.0, -0.1, -0.25 * vertex as f32));
    morphed.morph_targets = vec![MorphTarget { colours: deltas.collect(), ..MorphTarget::default() }];
    for instance in parts.instances.iter_mut().filter(|instance| instance.mesh == 2) {
        instance.morph_weights = vec![0.5];
    }

    let stage = cpu_stage(&Arc::new(Scene::new(parts.clone()).unwrap()));
    let frame = stage.frame();
    let mut depths: Vec<f32> =
        frame.triangles().iter().map(|corners| frame.camera().view_depth(corners[0])).collect();
    depths.sort_by(f32::total_cmp);
    depths.dedup();
    let [nearest, next, .., last, background] = depths[..] else { panic!("{depths:?}") };
    parts.cameras[0].clip = ClipPlanes { near: 0.5 * (nearest + next), far: 0.5 * (last + background) };
    Arc::new(Scene::new(parts).unwrap())
}

#[test]
fn clip_planes_and_what_changes_its_look_are_the_cpus_on_both_paths() {
    let scene = layers_that_change();
    let mut stage = cpu_stage(&scene);
    let expected = on_cpu(&mut stage, "baseline");
    for path in [GpuPathChoice::Ray, GpuPathChoice::Raster] {
        let difference = difference(&stage, &expected, &on_gpu(&GPU, path, &scene, "baseline", 0));
        assert!(difference.shows_same(TOLERANCE), "{path:?}: {difference}");
    }
    // Each of them is seen.
    let without: [fn(&mut SceneParts); 3] = [
        |parts| parts.animations.clear(),
        |parts| parts.instances.iter_mut().for_each(|instance| instance.morph_weights.fill(0.0)),
        |parts| parts.cameras[0].clip = ClipPlanes::NONE,
    ];
    for change in without {
        let mut parts = scene.parts().clone();
        change(&mut parts);
        let other = on_cpu(&mut cpu_stage(&Arc::new(Scene::new(parts).unwrap())), "baseline");
        let difference = difference(&stage, &expected, &other);
        assert!(!difference.shows_same(TOLERANCE), "the check is blind: {difference}");
    }
}
