//! The GPU shows the CPU's coloured glass by rays, and says that it does not by raster.
#![expect(clippy::unwrap_used, reason = "a test that cannot begin has failed")]

use std::sync::{Arc, LazyLock};

use sheer_gpu::{AdapterChoice, Gpu, GpuBackend, GpuPathChoice, GpuPipeline, GpuStage};
use sheer_image::Planes;
use sheer_lab::picture;
use sheer_render::{Antialiasing, Backend, Settings, Stage, backend::Cpu};
use sheer_scene::{CameraChoice, Scene};

/// No edges in sight: all pixels have the CPU's fragments.
const SIZE: [u32; 2] = [48, 27];
/// Colours of the same fragments: as far apart as the twins of grey scenes may be.
const TOLERANCE: f32 = 1.0 / 1024.0;

static GPU: LazyLock<Arc<Gpu>> = LazyLock::new(|| {
    Gpu::new(&AdapterChoice::Best).expect("the tests need a Vulkan driver: `cargo xtask setup` installs one")
});

fn settings() -> Settings {
    Settings { size: SIZE, ..Settings::default() }
}

fn scene(transmission: f32) -> Arc<Scene> {
    let text =
        format!("layers:count=3,alpha=0.125,transmission={transmission},colours=stained,background=0.75");
    Arc::new(sheer_gallery::open(&text).unwrap().scene)
}

fn on_cpu(scene: &Arc<Scene>, method: &str, aa: Antialiasing, frames: u32) -> Planes {
    let mut stage = Stage::new(Arc::clone(scene), &CameraChoice::Default, None).unwrap();
    picture(&Cpu, &mut stage, &method.parse().unwrap(), aa, settings(), frames).unwrap().0
}

fn on_gpu(scene: &Arc<Scene>, method: &str, aa: Antialiasing, frames: u32) -> Planes {
    let backend = GpuBackend::new(Arc::clone(&GPU), GpuPathChoice::Ray);
    let mut stage = backend.stage(Arc::clone(scene), &CameraChoice::Default, None).unwrap();
    picture(&backend, &mut stage, &method.parse().unwrap(), aa, settings(), frames).unwrap().0
}

/// The greatest difference of a channel.
fn difference(a: &Planes, b: &Planes) -> f32 {
    let pairs = a.colour.as_slice().iter().flatten().zip(b.colour.as_slice().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn the_cpus_glass_is_seen_by_rays() {
    let (glass, grey) = (scene(0.75), scene(0.0));
    for method in ["std", "baseline"] {
        let expected = on_cpu(&glass, method, Antialiasing::NONE, 1);
        let found = difference(&on_gpu(&glass, method, Antialiasing::NONE, 1), &expected);
        assert!(found < TOLERANCE, "{method}: {found}");
        let control = difference(&on_cpu(&grey, method, Antialiasing::NONE, 1), &expected);
        assert!(control > 10.0 * TOLERANCE, "{method}: the check is blind, {control}");
    }
}

#[test]
fn that_raster_shows_glass_in_grey_is_said() {
    let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
    for (transmission, notes) in [(0.75, 1), (0.0, 0)] {
        let _stage = GpuStage::new(&gpu, scene(transmission), &CameraChoice::Default, None).unwrap();
        let method = "std".parse().unwrap();
        let pipeline =
            GpuPipeline::new(&gpu, GpuPathChoice::Raster, method, Antialiasing::NONE, settings()).unwrap();
        let found = pipeline.notes();
        assert!(found.len() == notes && found.iter().all(|note| note.contains("glass")), "{found:?}");
    }
}

#[test]
fn layers_know_what_glass_absorbs() {
    let glass = scene(0.75);
    let layered: Antialiasing = "layered".parse().unwrap();
    let [expected, found] = [on_cpu(&glass, "joint", layered, 2), on_gpu(&glass, "joint", layered, 2)];
    let of_layers = |planes: &Planes| planes.layers.as_ref().unwrap().as_slice().to_vec();
    for (expected, found) in of_layers(&expected).iter().zip(of_layers(&found)) {
        let differ = expected.absorbed.iter().zip(found.absorbed).any(|(a, b)| (a - b).abs() > 1e-5);
        assert!(!differ && expected.absorbed[0] > 0.1, "{expected:?}, {found:?}");
    }
    assert!(difference(&expected, &found) < TOLERANCE, "{}", difference(&expected, &found));
}
