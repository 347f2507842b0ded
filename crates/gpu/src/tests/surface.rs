//! A scene on a device gives the opacities and surfaces that it gives on the CPU.

use std::{
    path::Path,
    sync::{Arc, LazyLock},
};

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use sheer_core::hash::{pcg3d, unit_from_bits};
use sheer_scene::{Animator, Beam, CameraChoice, FaceSide, Frame};

use wgpu::{BufferBindingType, BufferUsages};

use super::harness::{self, ANSWER_LENGTH, COMPUTE, GPU};
use crate::{
    resource::bind_group::{buffer_entry, read_only_entry, whole},
    scene::SceneBuffers,
    shader::{
        binding::{BIND_FRAME, BIND_PROBE_IN, BIND_PROBE_OUT, BIND_TABLES},
        numbers::PROBE_GROUP,
        record::frame::FrameUniform,
    },
    tables::Tables,
};

const QUERIES: usize = 4096;

/// A point of a triangle, as the probe reads it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Query {
    triangle: u32,
    u: f32,
    v: f32,
    counter_clockwise: u32,
    /// Unit direction of the beam that sees it.
    direction: Vec3,
    /// Its width.
    width: f32,
}

/// One for all tests: software drivers take seconds to compile the probe.
static PROBE: LazyLock<wgpu::ComputePipeline> = LazyLock::new(|| {
    let uniform = buffer_entry(BIND_FRAME, COMPUTE, BufferBindingType::Uniform);
    let scene: Vec<_> = [uniform, read_only_entry(BIND_TABLES, COMPUTE)]
        .into_iter()
        .chain(SceneBuffers::layout_entries())
        .collect();
    let written = buffer_entry(BIND_PROBE_OUT, COMPUTE, BufferBindingType::Storage { read_only: false });
    harness::pipeline(
        &harness::link("probe/surface"),
        &[&scene, &[read_only_entry(BIND_PROBE_IN, COMPUTE), written]],
    )
});

type Answer = [f32; ANSWER_LENGTH];

fn send(frame: &Frame) -> SceneBuffers {
    SceneBuffers::new(&GPU.device(), &GPU.queue(), frame).unwrap()
}

fn ask(scene: &SceneBuffers, frame: &Frame, queries: &[Query]) -> Vec<Answer> {
    let uniform = FrameUniform { static_count: frame.static_count() as u32, ..FrameUniform::zeroed() };
    let uniform = harness::buffer(bytemuck::bytes_of(&uniform), BufferUsages::UNIFORM);
    let tables = Tables::new(&[], [0, 0]);
    let tables = harness::buffer(bytemuck::cast_slice(&tables.words), BufferUsages::STORAGE);
    let asked = harness::buffer(bytemuck::cast_slice(queries), BufferUsages::STORAGE);
    let answers = harness::results(size_of::<Answer>() * queries.len());
    let group_0: Vec<_> = [whole(BIND_FRAME, &uniform), whole(BIND_TABLES, &tables)]
        .into_iter()
        .chain(scene.entries())
        .collect();
    let group_1 = [whole(BIND_PROBE_IN, &asked), whole(BIND_PROBE_OUT, &answers)];
    let workgroups = queries.len().div_ceil(PROBE_GROUP as usize) as u32;
    bytemuck::pod_collect_to_vec(&harness::run(&PROBE, &[&group_0, &group_1], workgroups, &answers))
}

/// Random points of random triangles, a fraction of them at the end of the list, where the moving ones are.
fn queries(frame: &Frame) -> Vec<Query> {
    let count = frame.triangles().len() as u32;
    (0..QUERIES as u32)
        .map(|index| {
            let [a, b, c] = pcg3d([index, 17, 4]);
            let [u, v] = [b, c].map(|bits| (bits >> 8) as f32 / (1 << 24) as f32);
            let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            let triangle = if index % 4 == 0 { count - 1 - a % count.min(64) } else { a % count };
            // From next to nothing to more than most triangles, and not so flat against them that rounding
            // decides how far along it sees.
            let [d, e, f] = pcg3d([index, 18, 4]).map(unit_from_bits);
            let [a_corner, b_corner, c_corner] = frame.triangles()[triangle as usize];
            let normal = (b_corner - a_corner).cross(c_corner - a_corner).normalize_or(Vec3::Z);
            let direction = (normal + 0.5 * (2.0 * Vec3::new(d, e, f) - 1.0)).normalize_or(normal);
            let width =
                f32::exp2(-16.0 * unit_from_bits(pcg3d([index, 19, 4])[0])) * (b_corner - a_corner).length();
            Query { triangle, u, v, counter_clockwise: a >> 31, direction, width }
        })
        .collect()
}

/// What the CPU answers.
fn expected(frame: &Frame, query: &Query) -> Answer {
    let Query { triangle, u, v, .. } = *query;
    let counter_clockwise = query.counter_clockwise != 0;
    let beam = Beam { direction: query.direction, width: query.width };
    let surface = frame.surface(triangle, u, v, counter_clockwise, beam);
    let alpha = frame.opacity(triangle, u, v, query.width);
    let scalars = [
        alpha,
        frame.opacity_for_camera(triangle, u, v, counter_clockwise, query.width),
        f32::from(u8::from(surface.side == FaceSide::Front)),
        surface.metallic,
        surface.roughness,
        surface.occlusion,
    ];
    let [a, b, c] = frame.corners_in_object(triangle);
    let vectors = [
        surface.base_colour,
        surface.normal,
        surface.geometric_normal,
        surface.position,
        surface.previous_position,
        surface.emissive,
        frame.light_through(triangle, u, v, counter_clockwise, alpha, query.width),
        a,
        b,
        c,
    ];
    let values: Vec<f32> = scalars.into_iter().chain(vectors.iter().flat_map(Vec3::to_array)).collect();
    values.try_into().unwrap()
}

/// Queries that are answered otherwise than by the CPU: by more than 1e-5 of a value, or of 1 where it is
/// smaller. That is a hundred roundings: as many as a lookup has operations.
fn wrong(frame: &Frame, queries: &[Query], answers: &[Answer]) -> Vec<String> {
    assert_eq!(queries.len(), answers.len());
    let pairs = queries.iter().zip(answers);
    pairs
        .filter_map(|(query, answer)| {
            let expected = expected(frame, query);
            let far = |index: &usize| {
                let (found, wanted) = (answer[*index], expected[*index]);
                let near = (found - wanted).abs() <= 1e-5 * wanted.abs().max(1.0);
                // False for a NaN, too.
                !near
            };
            let index = (0..ANSWER_LENGTH).find(far)?;
            Some(format!("{query:?}: value {index} is {} instead of {}", answer[index], expected[index]))
        })
        .collect()
}

fn animator(scene: &str) -> Animator {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/gltf").join(scene);
    let text = if scene.contains('/') { path.to_str().unwrap() } else { scene };
    let scene = Arc::new(sheer_gallery::open(text).unwrap().scene);
    let camera = scene.camera(&CameraChoice::Default).unwrap();
    Animator::new(scene, camera)
}

#[test]
fn a_device_gives_the_surfaces_that_the_cpu_gives() {
    let scenes = [
        "pane",
        "plume",
        "windy-hill",
        "layers:count=2",
        "layers:count=3,colours=stained,transmission=0.8",
        "Fox/Fox.gltf",
        "MultiUVTest/MultiUVTest.gltf",
        "NegativeScaleTest/NegativeScaleTest.gltf",
        "VertexColorTest/VertexColorTest.gltf",
        "MorphPrimitivesTest-Draco/MorphPrimitivesTest.gltf",
    ];
    for scene in scenes {
        let mut animator = animator(scene);
        let mut buffers = send(animator.frame());
        for [time_secs, previous_secs] in [[0.0, 0.0], [0.7, 0.65]] {
            animator.advance(time_secs, previous_secs);
            buffers.update(&GPU.device(), &GPU.queue(), animator.frame()).unwrap();
            let queries = queries(animator.frame());
            let answers = ask(&buffers, animator.frame(), &queries);
            let wrong = wrong(animator.frame(), &queries, &answers);
            assert!(wrong.is_empty(), "{scene} at {time_secs} s: {} wrong, {}", wrong.len(), wrong[0]);
        }
    }
}

#[test]
fn a_swapped_weight_or_a_frame_that_was_not_sent_is_noticed() {
    let mut animator = animator("Fox/Fox.gltf");
    let buffers = send(animator.frame());
    let asked = queries(animator.frame());
    let swapped: Vec<_> = asked.iter().map(|query| Query { u: query.v, v: query.u, ..*query }).collect();
    let answers = ask(&buffers, animator.frame(), &swapped);
    assert!(wrong(animator.frame(), &asked, &answers).len() > QUERIES / 2);
    animator.advance(0.7, 0.65);
    let answers = ask(&buffers, animator.frame(), &asked);
    assert!(wrong(animator.frame(), &asked, &answers).len() > QUERIES / 2);
}

#[test]
fn a_frame_of_other_times_is_sent_without_new_buffers_once_there_is_room() {
    let mut animator = animator("plume");
    let mut buffers = send(animator.frame());
    let bytes = buffers.bytes();
    let mut grown = 0;
    for index in 1..=100_u8 {
        let time_secs = f32::from(index) * 0.1;
        let frame = animator.advance(time_secs, time_secs - 0.1);
        grown += u32::from(buffers.update(&GPU.device(), &GPU.queue(), frame).unwrap());
    }
    assert!(grown <= 3, "{grown} times");
    assert!(buffers.bytes() >= bytes);
}

#[test]
fn too_many_lights_are_told_with_what_to_do_and_the_device_lives() {
    const LIMIT: u64 = 1 << 17;
    let (device, queue) = harness::small_device(LIMIT);
    let parts = sheer_gallery::open("layers").unwrap().scene.parts().clone();
    let with_lights = |count| {
        let mut parts = parts.clone();
        parts.nodes.push(sheer_scene::model::Node {
            name: String::new(),
            parent: None,
            transform: sheer_scene::model::Transform::IDENTITY,
        });
        let light = sheer_scene::model::Light {
            name: String::new(),
            node: parts.nodes.len() as u32 - 1,
            intensity: Vec3::ONE,
            kind: sheer_scene::model::LightKind::Directional,
        };
        parts.lights = vec![light; count];
        let scene = Arc::new(sheer_scene::Scene::new(parts).unwrap());
        let camera = scene.camera(&CameraChoice::Default).unwrap();
        SceneBuffers::new(&device, &queue, Animator::new(scene, camera).frame())
    };
    let error = with_lights(10_000).unwrap_err().to_string();
    assert!(error.contains("lights") && error.contains("--backend cpu"), "{error}");
    with_lights(10).unwrap();
}
