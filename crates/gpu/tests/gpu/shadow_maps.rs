//! Stochastic shadow maps against the CPU's.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use sheer_gpu::{AdapterChoice, Gpu, GpuError, GpuPathChoice, GpuPipeline, GpuStage, Tracer};
use sheer_image::Planes;
use sheer_render::{Antialiasing, Counters, Settings};
use sheer_scene::{
    Camera, CameraChoice, Scene,
    model::{AlphaMode, Instance, Light, LightKind, Material, Mesh, Node, SceneParts, Transform},
};

const SIZE: [u32; 2] = [64, 48];
/// Pixels at the edges of triangles, where a rasteriser may see another one than a ray: up to 8 of 3072 in
/// these scenes.
const EDGES: f64 = 0.01;

fn built_in(name: &str) -> Arc<Scene> {
    Arc::new(sheer_gallery::open(name).unwrap().scene)
}

/// A horizontal square of so much half a side, at a height; turned a little, so that no row of texels lies
/// along its edges or diagonal, where rounding decides which of two triangles a ray meets.
fn add_sheet(parts: &mut SceneParts, material: Material, half: f32, height: f32) {
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let turned = Quat::from_rotation_y(0.3);
    let index = parts.meshes.len() as u32;
    parts.materials.push(Material { double_sided: true, ..material });
    parts.meshes.push(Mesh {
        positions: corners.map(|(x, z)| turned * Vec3::new(x, height, z)).into(),
        indices: vec![[0, 2, 1], [0, 3, 2]],
        material: index,
        ..Mesh::default()
    });
    let node = add_node(parts, Vec3::ZERO);
    parts.instances.push(Instance {
        node,
        node_from_object: Affine3A::IDENTITY,
        mesh: index,
        id: index,
        geometry: 0,
        skin: None,
        morph_weights: Vec::new(),
    });
}

fn add_node(parts: &mut SceneParts, place: Vec3) -> u32 {
    let transform = Transform::from_translation(place);
    parts.nodes.push(Node { name: String::new(), parent: None, transform });
    parts.nodes.len() as u32 - 1
}

/// A floor in the shadow of coloured glass and of something opaque, under lamps: one around which a map has
/// six sides, and two spots whose cone is wide and has six sides, too, or narrow.
fn lamps() -> Arc<Scene> {
    let mut parts = SceneParts { name: "lamps".into(), exposure: 1.0, ..SceneParts::default() };
    add_sheet(&mut parts, Material::default(), 5.0, 0.0);
    for (layer, colour) in [[0.9, 0.3, 0.2], [0.2, 0.8, 0.4], [0.9, 0.8, 0.1]].into_iter().enumerate() {
        let base_colour = Vec3::from(colour).extend(0.35);
        let glass =
            Material { base_colour, alpha_mode: AlphaMode::Blend, transmission: 0.5, ..Material::default() };
        add_sheet(&mut parts, glass, 1.2, 1.0 + 0.1 * layer as f32);
    }
    add_sheet(&mut parts, Material::default(), 0.3, 1.5);
    let range = f32::INFINITY;
    for (place, kind) in [
        (Vec3::new(2.0, 3.0, 0.5), LightKind::Point { range }),
        (Vec3::new(-1.5, 4.0, 1.0), LightKind::Point { range: 20.0 }),
    ] {
        let node = add_node(&mut parts, place);
        parts.lights.push(Light { name: String::new(), node, intensity: Vec3::splat(10.0), kind });
    }
    // Spots look along -Z: down, once turned by a right angle.
    for outer_cone_rad in [0.7, 1.3] {
        let node = add_node(&mut parts, Vec3::new(0.4, 4.0, -0.3));
        parts.nodes[node as usize].transform = Transform::Trs {
            translation: Vec3::new(0.4, 4.0, -0.3),
            rotation: Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
            scale: Vec3::ONE,
        };
        let kind = LightKind::Spot { range, inner_cone_rad: 0.3, outer_cone_rad };
        parts.lights.push(Light { name: String::new(), node, intensity: Vec3::splat(10.0), kind });
    }
    parts.cameras.push(Camera::fixed("above", 0.9, Vec3::new(0.5, 4.5, 6.0), Vec3::ZERO));
    Arc::new(Scene::new(parts).unwrap())
}

fn settings(shadow: &str, seed: u32) -> Settings {
    Settings { size: SIZE, shadow: shadow.parse().unwrap(), seed, ..Settings::default() }
}

fn on_cpu(scene: &Arc<Scene>, settings: Settings) -> (Planes, Counters) {
    let mut stage = sheer_render::Stage::new(Arc::clone(scene), &CameraChoice::Default, Some(2)).unwrap();
    let mut pipeline =
        sheer_render::Pipeline::new("std".parse().unwrap(), Antialiasing::NONE, settings).unwrap();
    stage.advance(pipeline.clock().at(0));
    let (counters, _) = pipeline.render(&stage, 0).unwrap();
    (pipeline.planes().clone(), counters)
}

fn on_gpu(
    gpu: &Arc<Gpu>,
    path: GpuPathChoice,
    scene: &Arc<Scene>,
    settings: Settings,
) -> Result<(Planes, Counters), GpuError> {
    let mut stage = GpuStage::new(gpu, Arc::clone(scene), &CameraChoice::Default, Some(2))?;
    let mut pipeline = GpuPipeline::new(gpu, path, "std".parse().unwrap(), Antialiasing::NONE, settings)?;
    stage.advance(pipeline.clock().at(0))?;
    let (counters, timings) = pipeline.render(&mut stage, 0)?;
    assert!(!gpu.report().timestamps || timings.shadow_ms > 0.0, "{timings:?}");
    Ok((pipeline.planes()?, counters))
}

/// Share of pixels whose colours differ by more than a thousandth.
fn share_off(one: &Planes, two: &Planes) -> f64 {
    let pairs = one.colour.as_slice().iter().zip(two.colour.as_slice());
    let off = pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-3 * a.abs().max(1.0)));
    off.count() as f64 / one.colour.as_slice().len() as f64
}

#[test]
fn light_through_maps_is_the_cpus_on_both_paths() {
    let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
    for (name, scene) in [("smoke-square", built_in("smoke-square")), ("lamps", lamps())] {
        for shadow in [
            "stochastic-map:resolution=128",
            "stochastic-map:resolution=64,samples=16,sampling=naive,correct=on,filter=3",
            "stochastic-map:resolution=64,taps=4,filter=0",
        ] {
            let (expected, cpu) = on_cpu(&scene, settings(shadow, 3));
            for (path, bound) in [(GpuPathChoice::Ray, 0.002), (GpuPathChoice::Raster, EDGES)] {
                // By raster what is seen through coloured glass is grey.
                if name == "lamps" && path == GpuPathChoice::Raster {
                    continue;
                }
                let (picture, counters) = on_gpu(&gpu, path, &scene, settings(shadow, 3)).unwrap();
                let off = share_off(&picture, &expected);
                assert!(off <= bound, "{name}, {shadow}, {path:?}: {off}");
                assert_eq!(counters.shadow_rays, cpu.shadow_rays, "a ray a texel");
            }
        }
    }
}

#[test]
fn maps_are_made_without_ray_query_as_well() {
    let gpu = Gpu::with_tracer(&AdapterChoice::Best, Some(Tracer::Bvh)).unwrap();
    let (scene, shadow) = (lamps(), "stochastic-map:resolution=64,correct=on");
    let (expected, _) = on_cpu(&scene, settings(shadow, 3));
    let (picture, _) = on_gpu(&gpu, GpuPathChoice::Ray, &scene, settings(shadow, 3)).unwrap();
    let off = share_off(&picture, &expected);
    assert!(off <= 0.002, "{off}");
}

#[test]
fn other_maps_are_other_pictures() {
    let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
    let scene = lamps();
    let (picture, _) =
        on_gpu(&gpu, GpuPathChoice::Ray, &scene, settings("stochastic-map:resolution=64", 3)).unwrap();
    for shadow in ["stochastic-map:resolution=48", "stochastic-map:resolution=64,sampling=naive", "deep"] {
        let (expected, _) = on_cpu(&scene, settings(shadow, 3));
        let off = share_off(&picture, &expected);
        assert!(off > 0.05, "the comparison is blind to {shadow}: {off}");
    }
}

#[test]
fn maps_too_large_for_a_device_are_refused_with_advice() {
    let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
    let shadow = "stochastic-map:resolution=8192,samples=64";
    let error = on_gpu(&gpu, GpuPathChoice::Ray, &lamps(), settings(shadow, 0)).unwrap_err();
    assert!(matches!(&error, GpuError::Limit { .. }), "{error}");
    assert!(error.to_string().contains("resolution="), "{error}");
}
