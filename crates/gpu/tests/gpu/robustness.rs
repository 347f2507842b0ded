//! Long runs, switches, and what goes wrong on purpose: the process lives and says what happened.
#![expect(clippy::unwrap_used, reason = "a test that cannot begin has failed")]

use std::{path::Path as FilePath, sync::Arc};

use sheer_gpu::{AdapterChoice, Gpu, GpuError, GpuPathChoice, GpuPipeline, GpuStage, Tracer};
use sheer_render::{Antialiasing, Method, Settings};
use sheer_scene::{CameraChoice, Scene};

fn gpu() -> Arc<Gpu> {
    Gpu::new(&AdapterChoice::Best).expect("the tests need a Vulkan driver: `cargo xtask setup` installs one")
}

fn scene(text: &str) -> Arc<Scene> {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(text);
    let text = if text.contains('/') { file.to_str().unwrap() } else { text };
    Arc::new(sheer_gallery::open(text).unwrap().scene)
}

fn settings(size: [u32; 2]) -> Settings {
    Settings { size, ..Settings::default() }
}

fn method(text: &str) -> Method {
    text.parse().unwrap()
}

fn std_pipeline(gpu: &Arc<Gpu>, size: [u32; 2]) -> GpuPipeline {
    GpuPipeline::new(gpu, GpuPathChoice::Automatic, method("std"), Antialiasing::TAA, settings(size)).unwrap()
}

fn stage(gpu: &Arc<Gpu>, text: &str) -> GpuStage {
    GpuStage::new(gpu, scene(text), &CameraChoice::Default, None).unwrap()
}

/// Skinned triangles that are new in each frame, and their acceleration structure with them.
const MOVING: &str = "gltf/Fox/Fox.gltf";

#[test]
fn fifty_scenes_one_after_the_other_share_a_device() {
    let gpu = gpu();
    let mut pipeline = std_pipeline(&gpu, [64, 36]);
    let texts = ["layers:count=3", MOVING, "gltf/VertexColorTest/VertexColorTest.gltf"];
    for index in 0..50 {
        let mut stage = stage(&gpu, texts[index as usize % texts.len()]);
        stage.advance(pipeline.clock().at(index)).unwrap();
        pipeline.render(&mut stage, index).unwrap();
    }
    assert!(pipeline.planes().unwrap().colour.as_slice().iter().flatten().all(|value| value.is_finite()));
}

#[test]
fn pictures_of_every_size_come_from_one_stage() {
    let gpu = gpu();
    let mut stage = stage(&gpu, "layers:count=2");
    for size in [[1, 1], [7, 5], [64, 36], [33, 200], [8, 8]] {
        for choice in [GpuPathChoice::Ray, GpuPathChoice::Raster] {
            let mut pipeline =
                GpuPipeline::new(&gpu, choice, method("std"), Antialiasing::TAA, settings(size)).unwrap();
            stage.advance(pipeline.clock().at(0)).unwrap();
            pipeline.render(&mut stage, 0).unwrap();
            assert_eq!(pipeline.planes().unwrap().colour.size(), (size[0], size[1]));
        }
    }
}

#[test]
fn a_lost_device_is_replaced_and_the_frame_is_rendered_again() {
    let gpu = gpu();
    let mut stage = stage(&gpu, MOVING);
    let mut pipeline =
        GpuPipeline::new(&gpu, GpuPathChoice::Ray, method("std"), Antialiasing::NONE, settings([64, 36]))
            .unwrap();
    let moment = pipeline.clock().at(3);
    stage.advance(moment).unwrap();
    pipeline.render(&mut stage, 3).unwrap();
    let before = pipeline.planes().unwrap();

    gpu.lose_device();
    stage.advance(moment).unwrap();
    pipeline.render(&mut stage, 3).unwrap();
    assert_eq!(gpu.generation(), 1);
    assert_eq!(pipeline.planes().unwrap(), before);
}

#[test]
fn two_pipelines_of_a_stage_both_go_on_after_a_loss() {
    let gpu = gpu();
    let mut stage = stage(&gpu, "layers:count=2");
    let mut pipelines = ["std", "roulette"].map(|text| {
        GpuPipeline::new(&gpu, GpuPathChoice::Ray, method(text), Antialiasing::NONE, settings([16, 9]))
            .unwrap()
    });
    for round in 0..2 {
        for pipeline in &mut pipelines {
            pipeline.render(&mut stage, round).unwrap();
            assert!(pipeline.planes().unwrap().colour.as_slice().iter().any(|colour| colour[3] > 0.0));
        }
        gpu.lose_device();
    }
}

#[test]
fn a_picture_too_large_says_so_and_leaves_the_device_usable() {
    let gpu = gpu();
    let too_large = settings([60_000, 60_000]);
    let error =
        GpuPipeline::new(&gpu, GpuPathChoice::Ray, method("std"), Antialiasing::NONE, too_large).unwrap_err();
    assert!(matches!(error, GpuError::Limit { .. }), "{error}");
    assert!(error.to_string().contains("60000x60000"), "{error}");
    assert_eq!(gpu.generation(), 0);
    std_pipeline(&gpu, [16, 9]).render(&mut stage(&gpu, "layers:count=2"), 0).unwrap();
}

#[test]
fn what_a_path_does_not_run_is_told_with_what_does() {
    let gpu = gpu();
    let refused = |choice, text: &str| {
        let pipeline = GpuPipeline::new(&gpu, choice, method(text), Antialiasing::NONE, settings([16, 9]));
        pipeline.unwrap_err().to_string()
    };
    let error = refused(GpuPathChoice::Ray, "weighted");
    assert!(error.contains("weighted") && error.contains("gpu:raster"), "{error}");
}

#[test]
fn adapters_that_are_not_there_are_told_with_those_that_are() {
    let error = Gpu::new(&AdapterChoice::Named("Voodoo 2".to_owned())).unwrap_err().to_string();
    let name = gpu().report().name.clone();
    assert!(error.contains("Voodoo 2") && error.contains(&name), "{error}");
}

#[test]
fn without_ray_query_raster_is_taken_and_said_so() {
    let gpu = Gpu::with_tracer(&AdapterChoice::Best, Some(Tracer::Bvh)).unwrap();
    let pipeline = std_pipeline(&gpu, [16, 9]);
    assert_eq!(pipeline.path(), sheer_gpu::GpuPath::Raster);
    assert!(pipeline.notes()[0].contains("no ray query"), "{:?}", pipeline.notes());
}

#[test]
fn frames_that_nobody_waits_for_add_up_to_the_same_picture() {
    let gpu = gpu();
    let mut stage = stage(&gpu, MOVING);
    let pictures = [true, false].map(|waits| {
        let mut pipeline = std_pipeline(&gpu, [64, 36]);
        for index in 0..6 {
            stage.advance(pipeline.clock().at(index)).unwrap();
            if waits || index == 5 {
                pipeline.render(&mut stage, index).unwrap();
            } else {
                pipeline.submit(&mut stage, index).unwrap();
            }
        }
        assert!(pipeline.steps().iter().all(|step| step.ms >= 0.0));
        pipeline.planes().unwrap()
    });
    assert_eq!(pictures[0], pictures[1]);

    let mut pipeline = std_pipeline(&gpu, [64, 36]);
    gpu.lose_device();
    // Nobody has asked the device yet: the next call sees the loss.
    pipeline.submit(&mut stage, 0).unwrap();
    pipeline.submit(&mut stage, 1).unwrap();
    assert_eq!(gpu.generation(), 1);
    assert!(pipeline.planes().unwrap().colour.as_slice().iter().any(|colour| colour[3] > 0.0));
}
