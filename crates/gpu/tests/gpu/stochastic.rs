//! Stochastic transparency on targets of several samples a pixel, against the CPU.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use glam::{UVec2, Vec2};
use sheer_gallery::{LayerColours, layers_closed_form};
use sheer_gpu::{AdapterChoice, Gpu, GpuError, GpuPathChoice, GpuPipeline, GpuStage};
use sheer_image::Planes;
use sheer_render::{Antialiasing, Counters, Settings, StepTime};
use sheer_scene::CameraChoice;

const SIZE: [u32; 2] = [120, 80];

fn gpu() -> Arc<Gpu> {
    Gpu::new(&AdapterChoice::Best).unwrap()
}

fn scene(name: &str) -> sheer_scene::Scene {
    let scene = sheer_gallery::open(name).unwrap().scene;
    if name.ends_with(".gltf") { scene.with_alpha(0.4) } else { scene }
}

fn cpu_stage(name: &str) -> sheer_render::Stage {
    sheer_render::Stage::new(scene(name), &CameraChoice::Default, Some(2)).unwrap()
}

fn gpu_stage(gpu: &Arc<Gpu>, name: &str) -> GpuStage {
    GpuStage::new(gpu, scene(name), &CameraChoice::Default, Some(2)).unwrap()
}

fn settings(seed: u32) -> Settings {
    Settings { size: SIZE, seed, ..Settings::default() }
}

fn on_cpu(stage: &mut sheer_render::Stage, method: &str, settings: Settings) -> (Planes, Counters) {
    let method = method.parse().unwrap();
    let mut pipeline = sheer_render::Pipeline::new(method, Antialiasing::NONE, settings).unwrap();
    stage.advance(pipeline.clock().at(0));
    let (counters, _) = pipeline.render(stage, 0).unwrap();
    (pipeline.planes().clone(), counters)
}

struct Drawn {
    planes: Planes,
    counters: Counters,
    steps: Vec<StepTime>,
}

fn on_gpu(gpu: &Arc<Gpu>, stage: &mut GpuStage, method: &str, settings: Settings) -> Result<Drawn, GpuError> {
    let method = method.parse().unwrap();
    let mut pipeline = GpuPipeline::new(gpu, GpuPathChoice::Automatic, method, Antialiasing::NONE, settings)?;
    stage.advance(pipeline.clock().at(0))?;
    let (counters, _) = pipeline.render(stage, 0)?;
    Ok(Drawn { planes: pipeline.planes()?, counters, steps: pipeline.steps().to_vec() })
}

/// Pixels in which rays near all four corners and through the centre meet the same triangles: hardware
/// samples lie within.
fn interior(stage: &sheer_render::Stage) -> Vec<bool> {
    let [width, height] = SIZE;
    // Close enough to one another that a triangle between them has hardly a sample.
    let sides = [0.02, 0.26, 0.5, 0.74, 0.98];
    let offsets: Vec<Vec2> = sides.iter().flat_map(|&y| sides.map(|x| Vec2::new(x, y))).collect();
    let met = |at: Vec2| stage.triangles_through(at, SIZE);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| UVec2::new(x, y).as_vec2()));
    pixels
        .map(|corner| {
            let first = met(corner + offsets[0]);
            offsets[1..].iter().all(|offset| met(corner + *offset) == first)
        })
        .collect()
}

/// Of each pixel the largest difference of a channel, as a share of the brighter of both where that is more
/// than 1.
fn differences(one: &Planes, two: &Planes) -> Vec<f32> {
    let pairs = one.colour.as_slice().iter().zip(two.colour.as_slice());
    let difference = |(a, b): (&[f32; 4], &[f32; 4])| {
        let each = a.iter().zip(b).map(|(a, b)| (a - b).abs() / a.abs().max(b.abs()).max(1.0));
        each.fold(0.0, f32::max)
    };
    pairs.map(difference).collect()
}

/// Half floats have 11 bits: each of the few dozen sums and products of a pixel rounds by half a unit of the
/// last, 2^-12 of what it is at most; that of 16 in a row of one sign is 2^-8, and less than that in these
/// scenes.
const HALF_BOUND: f32 = 1.0 / 256.0;

/// Shares of interior pixels, and of all, that differ by more than half floats explain.
fn shares(interior: &[bool], differences: &[f32]) -> [f64; 2] {
    let share = |wanted: &dyn Fn(usize) -> bool| {
        let chosen: Vec<usize> = (0..differences.len()).filter(|&at| wanted(at)).collect();
        let off = chosen.iter().filter(|&&at| differences[at] > HALF_BOUND).count();
        off as f64 / chosen.len().max(1) as f64
    };
    [share(&|at| interior[at]), share(&|_| true)]
}

/// Of the GPU's picture and the CPU's.
fn compare(gpu: &Arc<Gpu>, name: &str, [method, twin]: [&str; 2], seeds: [u32; 2]) -> [f64; 2] {
    let mut stage = cpu_stage(name);
    let (expected, _) = on_cpu(&mut stage, twin, settings(seeds[1]));
    let drawn = on_gpu(gpu, &mut gpu_stage(gpu, name), method, settings(seeds[0])).unwrap();
    let inside = interior(&stage);
    assert!(inside.iter().filter(|is| **is).count() > 1000, "{name} has hardly a pixel of one triangle");
    shares(&inside, &differences(&drawn.planes, &expected))
}

const FOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/gltf/Fox/Fox.gltf");
const TILES: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/gltf/VertexColorTest/VertexColorTest.gltf");

#[test]
fn pixels_that_triangles_cover_whole_are_the_cpus() {
    let gpu = gpu();
    for name in ["layers:count=6,alpha=0.3", "pane", "smoke-square", FOX, TILES] {
        for method in ["stochastic:samples=4", "stochastic:samples=4,estimator=basic"] {
            let [inside, all] = compare(&gpu, name, [method; 2], [5; 2]);
            assert!(inside == 0.0, "{name}, {method}: {inside} of the inner pixels");
            // Edges: of small triangles there are many, and one sample in four may see another set of
            // triangles than the centre.
            assert!(all < 0.1, "{name}, {method}: {all} of all pixels");
        }
    }
}

#[test]
fn every_parameter_draws_the_cpus_masks() {
    let gpu = gpu();
    for settings in [
        "masks=naive,seed-by=object",
        "masks=a2c,dither=tile",
        "dither=tile,reseed=off,correct=off",
        "seed-by=depth,estimator=basic,correct=off",
        "passes=3,correct=off",
    ] {
        let method = format!("stochastic:samples=4,{settings}");
        let [inside, _] = compare(&gpu, "layers:count=6,alpha=0.3", [&method; 2], [9; 2]);
        assert!(inside == 0.0, "{method}: {inside}");
    }
}

#[test]
fn more_samples_than_the_hardware_has_are_the_cpus_passes() {
    let gpu = gpu();
    if gpu.report().msaa.contains(&8) {
        let eight = ["stochastic:samples=8"; 2];
        assert_eq!(compare(&gpu, "layers:count=6,alpha=0.3", eight, [5; 2])[0], 0.0);
    } else {
        let eight = ["stochastic:samples=8", "stochastic:samples=4,passes=2"];
        assert_eq!(compare(&gpu, "layers:count=6,alpha=0.3", eight, [5; 2])[0], 0.0);
    }
    let sixteen = ["stochastic:samples=16,correct=off", "stochastic:samples=4,passes=4,correct=off"];
    if gpu.report().msaa == [4] {
        assert_eq!(compare(&gpu, "layers:count=6,alpha=0.3", sixteen, [5; 2])[0], 0.0);
    }
}

#[test]
fn another_seed_is_another_picture() {
    let [inside, _] =
        compare(&gpu(), "layers:count=6,alpha=0.3", ["stochastic:samples=4,correct=off"; 2], [5, 6]);
    assert!(inside > 0.5, "the comparison is blind: {inside}");
}

/// Standard errors between the mean picture of 64 frames, each with masks of its own, and the closed form;
/// the largest of three channels.
fn z_of_layers(gpu: &Arc<Gpu>, method: &str) -> f64 {
    const FRAMES: u32 = 64;
    let mut stage = gpu_stage(gpu, "layers:count=6,alpha=0.3,colours=rainbow,background=0.5");
    let small = Settings { size: [32, 24], ..settings(1) };
    let method = method.parse().unwrap();
    let mut pipeline =
        GpuPipeline::new(gpu, GpuPathChoice::Automatic, method, Antialiasing::NONE, small).unwrap();
    let mut mean_of = |frame: u32| {
        stage.advance(pipeline.clock().at(frame)).unwrap();
        pipeline.render(&mut stage, frame).unwrap();
        let planes = pipeline.planes().unwrap();
        let colours = planes.colour.as_slice();
        [0, 1, 2].map(|channel| {
            colours.iter().map(|colour| f64::from(colour[channel])).sum::<f64>() / colours.len() as f64
        })
    };
    let means: Vec<[f64; 3]> = (0..FRAMES).map(&mut mean_of).collect();
    let exact = layers_closed_form(6, 0.3, LayerColours::Rainbow, 0.5).to_array();
    let channels = (0..3).map(|channel| {
        let count = f64::from(FRAMES);
        let mean = means.iter().map(|mean| mean[channel]).sum::<f64>() / count;
        let squares = means.iter().map(|other| (other[channel] - mean).powi(2)).sum::<f64>();
        let error = (squares / (count - 1.0) / count).sqrt();
        // Sums of half floats may round towards zero: half a unit of 2^-11 for each of up to six.
        let rounding = 3.0 * mean / 2048.0;
        ((mean - f64::from(exact[channel])).abs() - rounding).max(0.0) / error
    });
    channels.fold(0.0, f64::max)
}

#[test]
fn the_mean_of_uncorrected_pictures_is_exact_and_that_of_correlated_masks_is_not() {
    let gpu = gpu();
    // Three channels at a level of 0.001: 3.6 by Šidák, of Student's 63 degrees of freedom.
    let z = z_of_layers(&gpu, "stochastic:samples=4,correct=off");
    assert!(z < 3.6, "{z}");
    let z = z_of_layers(&gpu, "stochastic:samples=8,correct=off");
    assert!(z < 3.6, "{z}");
    let z = z_of_layers(&gpu, "stochastic:samples=4,correct=off,masks=a2c");
    assert!(z > 20.0, "the check is blind: {z}");
}

#[test]
fn steps_and_counters_tell_what_was_drawn() {
    let gpu = gpu();
    let mut stage = gpu_stage(&gpu, "pane");
    let drawn = on_gpu(&gpu, &mut stage, "stochastic:samples=4", settings(1)).unwrap();
    let (_, cpu) = on_cpu(&mut cpu_stage("pane"), "stochastic:samples=4", settings(1));
    if gpu.report().timestamps {
        let names: Vec<_> = drawn.steps.iter().map(|step| step.name).collect();
        let expected = ["opaque", "total alpha", "stochastic depth", "accumulate", "composite", "behind"];
        assert_eq!(names[..6], expected);
    }
    // Triangles that cover a part of a pixel are fragments of it, too.
    let more = |ours: u64, theirs: u64| (theirs..theirs + theirs / 10).contains(&ours);
    assert!(more(drawn.counters.hits, cpu.hits), "{:?}, {cpu:?}", drawn.counters);
    assert!(more(drawn.counters.shaded, cpu.shaded), "{:?}, {cpu:?}", drawn.counters);
}
