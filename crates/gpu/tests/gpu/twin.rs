//! The GPU gives the CPU's pictures: every method that goes by rays, on both paths.
//!
//! What decides whether a fragment is shown is integer arithmetic and opacities by the CPU's own operations in the CPU's order, so that two
//! backends differ where they find other hits: at the edges of triangles. A pixel counts as one of those if the CPU meets other triangles a
//! small part of a pixel beside its centre.
#![expect(clippy::unwrap_used, reason = "a test that cannot begin has failed")]

use std::{
    path::Path as FilePath,
    sync::{Arc, LazyLock},
};

use sheer_gpu::{AdapterChoice, Gpu, GpuPathChoice, GpuPipeline, GpuStage, Tracer};
use sheer_image::Planes;
use sheer_metrics::FragmentDifference;
use sheer_render::{Antialiasing, Method, Settings};
use sheer_scene::{CameraChoice, Scene};

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
/// Share of pixels that may show another fragment.
const OTHER_SHARE: f64 = 0.002;
/// Hardware rounds the corners of triangles to 1/256 of a pixel (Vulkan asks for 1/16 at least), and the projection rounds before that.
const EDGE_PX: f32 = 1.0 / 64.0;
/// Colours of the same fragment differ by no more than this, relative to the larger one and to a display's white: half-float accuracy is 2⁻¹¹.
const COLOUR_BOUND: f32 = 1.0 / 1024.0;

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

fn settings(seed: u32) -> Settings {
    Settings { size: SIZE, seed, first_frame: 4, ..Settings::default() }
}

fn cpu_stage(scene: &Arc<Scene>) -> sheer_render::Stage {
    sheer_render::Stage::new(Arc::clone(scene), &CameraChoice::Default, None).unwrap()
}

fn on_cpu(stage: &mut sheer_render::Stage, method: &str) -> Planes {
    let method: Method = method.parse().unwrap();
    let mut pipeline = sheer_render::Pipeline::new(method, Antialiasing::NONE, settings(0)).unwrap();
    stage.advance(pipeline.clock().at(0));
    pipeline.render(stage, 0).unwrap();
    pipeline.planes().clone()
}

fn on_gpu(gpu: &Arc<Gpu>, path: GpuPathChoice, scene: &Arc<Scene>, method: &str, seed: u32) -> Planes {
    let mut stage = GpuStage::new(gpu, Arc::clone(scene), &CameraChoice::Default, None).unwrap();
    let method: Method = method.parse().unwrap();
    let mut pipeline = GpuPipeline::new(gpu, path, method, Antialiasing::NONE, settings(seed)).unwrap();
    stage.advance(pipeline.clock().at(0)).unwrap();
    pipeline.render(&mut stage, 0).unwrap();
    pipeline.planes().unwrap()
}

fn difference(expected: &Planes, found: &Planes) -> FragmentDifference {
    FragmentDifference::measure(expected, found, COLOUR_BOUND).unwrap()
}

/// Whether few pixels differ, and only where the CPU finds other triangles right beside the pixel's centre.
fn is_small(stage: &sheer_render::Stage, difference: &FragmentDifference) -> bool {
    difference.other_share() <= OTHER_SHARE
        && difference.colour_share() <= OTHER_SHARE
        && difference.others.iter().all(|&other| stage.is_near_edge(other, SIZE, EDGE_PX))
}

fn fragment(planes: &Planes, [x, y]: [u32; 2]) -> [u32; 2] {
    [planes.instance[(x, y)], planes.primitive[(x, y)]]
}

fn pixels() -> f64 {
    f64::from(SIZE[0]) * f64::from(SIZE[1])
}

/// Holds a method against the CPU on all scenes.
fn check(gpu: &Arc<Gpu>, path: GpuPathChoice, method: &str) {
    for (name, alpha) in SCENES {
        let scene = scene(name, alpha);
        let mut stage = cpu_stage(&scene);
        let difference = difference(&on_cpu(&mut stage, method), &on_gpu(gpu, path, &scene, method, 0));
        assert!(
            is_small(&stage, &difference),
            "{method} of {name} by {path:?}, {:?}: {difference:?}",
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

#[test]
fn selection_shows_the_cpus_fragments_on_both_paths() {
    for path in [GpuPathChoice::Ray, GpuPathChoice::Raster] {
        check(&GPU, path, "joint");
    }
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
        let difference = difference(&ray, &raster);
        let mut stage = cpu_stage(&scene);
        on_cpu(&mut stage, "std");
        assert!(is_small(&stage, &difference), "{name}: {difference:?}");
    }
}

#[test]
fn motion_depth_and_transparency_are_the_cpus() {
    for (name, alpha) in SCENES {
        let scene = scene(name, alpha);
        let (expected, found) =
            (on_cpu(&mut cpu_stage(&scene), "std"), on_gpu(&GPU, GpuPathChoice::Ray, &scene, "std", 0));
        let all = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
        let same = all.filter(|&at| fragment(&expected, at) == fragment(&found, at));
        let wrong = same.filter(|&[x, y]| {
            let [depth, other_depth] = [&expected, &found].map(|planes| planes.depth[(x, y)]);
            let [motion, other_motion] = [&expected, &found].map(|planes| planes.motion[(x, y)]);
            let moved = motion.into_iter().zip(other_motion).any(|(a, b)| (a - b).abs() > 1e-2);
            let far = depth != other_depth && (depth - other_depth).abs() > 1e-4 * depth.abs();
            moved || far || expected.transparent[(x, y)] != found.transparent[(x, y)]
        });
        // Whether something transparent lies before a fragment is a matter of edges, too.
        assert!(wrong.count() as f64 <= OTHER_SHARE * pixels(), "{name}");
    }
}

#[test]
fn another_seed_or_method_is_noticed() {
    for (name, alpha) in SCENES {
        let scene = scene(name, alpha);
        let mut stage = cpu_stage(&scene);
        let expected = on_cpu(&mut stage, "std");
        let seed = difference(&expected, &on_gpu(&GPU, GpuPathChoice::Ray, &scene, "std", 1));
        let method = difference(&expected, &on_gpu(&GPU, GpuPathChoice::Ray, &scene, "roulette", 0));
        for difference in [seed, method] {
            assert!(!is_small(&stage, &difference), "the check is blind on {name}: {difference:?}");
        }
    }
}
