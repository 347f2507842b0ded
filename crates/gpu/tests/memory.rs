//! Memory over a long run. Alone in its process, since it looks at the memory of all of it.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test that cannot begin has failed")]

use std::{path::Path as FilePath, sync::Arc};

use sheer_gpu::{AdapterChoice, Gpu, GpuPathChoice, GpuPipeline, GpuStage};
use sheer_render::{Antialiasing, Settings};
use sheer_scene::CameraChoice;

/// Skinned triangles that are new in each frame, and their acceleration structure with them.
const MOVING: &str = "../../assets/gltf/Fox/Fox.gltf";

/// Bytes of the process that lie in memory.
fn resident_bytes() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 4096
}

#[test]
fn five_hundred_frames_of_moving_geometry_take_no_more_memory_than_a_hundred() {
    // Pages that the allocator touches late; a buffer that stays behind in each frame would be more.
    const SLACK_BYTES: u64 = 2 << 20;
    let gpu = Gpu::new(&AdapterChoice::Best)
        .expect("the tests need a Vulkan driver: `cargo xtask setup` installs one");
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join(MOVING);
    let scene = Arc::new(sheer_gallery::open(file.to_str().unwrap()).unwrap().scene);
    let mut stage = GpuStage::new(&gpu, scene, &CameraChoice::Default, None).unwrap();
    let settings = Settings { size: [64, 36], ..Settings::default() };
    let mut pipeline =
        GpuPipeline::new(&gpu, GpuPathChoice::Automatic, "std".parse().unwrap(), Antialiasing::TAA, settings)
            .unwrap();
    let mut after_hundred = (0, 0);
    for index in 0..500 {
        stage.advance(pipeline.clock().at(index)).unwrap();
        // Errors of validation come out here.
        pipeline.render(&mut stage, index).unwrap();
        if index == 100 {
            after_hundred = (resident_bytes(), stage.bytes());
        }
    }
    let (resident, on_device) = after_hundred;
    assert_eq!(stage.bytes(), on_device, "the scene's buffers have grown");
    let now = resident_bytes();
    assert!(now < resident + SLACK_BYTES, "{resident} bytes after 100 frames, {now} after 500");
}
