//! Both traversals on the device against the CPU's tree.

use glam::{DVec3, Vec3, vec3};
use sheer_accel::{Bvh, Hit, Ray};

use wgpu::{BufferBindingType, BufferUsages};

use super::{
    harness::{self, COMPUTE, GPU},
    shaders::validate,
};
use crate::{
    accel::{Accel, driver::DriverAccel, tree::TreeAccel},
    device::Tracer,
    pipeline::base_linker,
    resource::bind_group::{buffer_entry, read_only_entry, whole},
    shader::{
        binding::{BIND_POSITIONS, BIND_PROBE_IN, BIND_PROBE_OUT},
        constant::{self, Constant},
        linked::Linked,
        numbers::PROBE_GROUP,
    },
};

/// As shaders/probe/traversal.wgsl has it.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Answer {
    count: u32,
    sum: u32,
    t: f32,
    u: f32,
    v: f32,
    triangle: u32,
    front: u32,
    /// `barycentrics` gives other numbers.
    differs: u32,
}

/// The piece probe/traversal over a tracer; hits of the triangle `dropped` do not count.
fn source(tracer: Tracer, dropped: u32) -> Linked {
    let constants = constant::text(&[Constant::new("DROPPED", dropped)]);
    base_linker(tracer).constants(constants).link("probe/traversal").unwrap()
}

fn positions(triangles: &[[Vec3; 3]]) -> wgpu::Buffer {
    harness::buffer(bytemuck::cast_slice(triangles), BufferUsages::STORAGE | BufferUsages::BLAS_INPUT)
}

/// Builds the tracer's structure over the triangles and traces.
fn trace(tracer: Tracer, triangles: &[[Vec3; 3]], rays: &[Ray], dropped: u32) -> Vec<Answer> {
    let positions = positions(triangles);
    let static_count = triangles.len() / 3;
    match tracer {
        Tracer::Query => {
            let mut accel = DriverAccel::new(&GPU.device()).unwrap();
            update(&mut accel, &positions, triangles, static_count);
            probe(tracer, &positions, accel.entries(), rays, dropped)
        }
        Tracer::Bvh => {
            let mut bvh = Bvh::build(&triangles[..static_count]);
            bvh.rebuild_after(static_count, triangles);
            let buffers = TreeAccel::new(&GPU.device(), &GPU.queue(), &bvh).unwrap();
            probe(tracer, &positions, buffers.entries(), rays, dropped)
        }
    }
}

fn update(accel: &mut DriverAccel, positions: &wgpu::Buffer, triangles: &[[Vec3; 3]], static_count: usize) {
    let (device, queue) = (GPU.device(), GPU.queue());
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    accel.update(&device, &queue, &mut encoder, positions, triangles, static_count).unwrap();
    queue.submit([encoder.finish()]);
}

fn probe(
    tracer: Tracer,
    positions: &wgpu::Buffer,
    accel: [wgpu::BindGroupEntry<'_>; 2],
    rays: &[Ray],
    dropped: u32,
) -> Vec<Answer> {
    let packed: Vec<[f32; 8]> = rays
        .iter()
        .map(|ray| {
            let ([x, y, z], [dx, dy, dz]) = (ray.origin.to_array(), ray.direction.to_array());
            [x, y, z, ray.t_min, dx, dy, dz, ray.t_max]
        })
        .collect();
    let packed = harness::buffer(bytemuck::cast_slice(&packed), BufferUsages::STORAGE);
    let answers = harness::results(size_of::<Answer>() * rays.len());
    let [first, second] = Accel::layout_entries(tracer, COMPUTE);
    let scene = [read_only_entry(BIND_POSITIONS, COMPUTE), first, second];
    let written = buffer_entry(BIND_PROBE_OUT, COMPUTE, BufferBindingType::Storage { read_only: false });
    let own = [read_only_entry(BIND_PROBE_IN, COMPUTE), written];
    let pipeline = harness::pipeline(&source(tracer, dropped), &[&scene, &own]);
    let [first, second] = accel;
    let scene = [whole(BIND_POSITIONS, positions), first, second];
    let own = [whole(BIND_PROBE_IN, &packed), whole(BIND_PROBE_OUT, &answers)];
    let workgroups = rays.len() as u32 / PROBE_GROUP;
    bytemuck::pod_collect_to_vec(&harness::run(&pipeline, &[&scene, &own], workgroups, &answers))
}

/// PCG output permutation over a counter.
struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (sheer_core::hash::pcg(self.0) >> 8) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> Vec3 {
        vec3(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// A height field of shared edges and vertices, loose triangles, and two coplanar duplicates.
fn soup(random: &mut Random, count: usize) -> Vec<[Vec3; 3]> {
    let cells = ((count / 4) as f32).sqrt() as usize;
    let heights: Vec<f32> = (0..(cells + 1) * (cells + 1)).map(|_| random.unit() * 0.2).collect();
    let corner = |x: usize, z: usize| {
        let scale = 2.0 / cells as f32;
        vec3(x as f32 * scale - 1.0, heights[x * (cells + 1) + z], z as f32 * scale - 1.0)
    };
    let mut triangles = Vec::new();
    for (x, z) in (0..cells * cells).map(|cell| (cell / cells, cell % cells)) {
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dz)| corner(x + dx, z + dz));
        triangles.extend([[a, c, b], [b, c, d]]);
    }
    let size = 10.0 / (count as f32).sqrt();
    while triangles.len() < count - 2 {
        let centre = random.point();
        triangles.push([0, 1, 2].map(|_| centre + random.point() * size.min(0.3)));
    }
    triangles.extend([triangles[0], triangles[count / 2 + 5]]);
    triangles
}

/// Rays through the scene; every eighth at a vertex or at the middle of an edge if `aimed`.
fn rays(random: &mut Random, triangles: &[[Vec3; 3]], count: usize, aimed: bool) -> Vec<Ray> {
    let vertices = triangles.as_flattened();
    let (lower, upper) = vertices
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lower, upper), &p| (lower.min(p), upper.max(p)));
    let size = (upper - lower).max(Vec3::splat(0.1));
    let middle = (lower + upper) * 0.5;
    (0..count)
        .map(|index| {
            let origin = middle + random.point() * size;
            let target = if aimed && index % 8 == 0 {
                let [a, b, _] = triangles[(random.unit() * triangles.len() as f32) as usize];
                if index % 16 == 0 { a } else { (a + b) * 0.5 }
            } else {
                middle + random.point() * size * 0.5
            };
            let direction = if aimed && index % 32 == 0 { Vec3::NEG_Y } else { target - origin };
            let origin = if direction == Vec3::NEG_Y { vec3(target.x, origin.y, target.z) } else { origin };
            let t_min = if index % 5 == 0 { random.unit() } else { 0.0 };
            let t_max = if index % 3 == 0 { t_min + random.unit() } else { f32::INFINITY };
            Ray { origin, direction, t_min, t_max }
        })
        .collect()
}

struct Expected {
    all: Vec<Hit>,
    closest: Option<Hit>,
}

fn on_cpu(triangles: &[[Vec3; 3]], rays: &[Ray]) -> Vec<Expected> {
    let bvh = Bvh::build(triangles);
    rays.iter()
        .map(|ray| {
            let mut all = Vec::new();
            bvh.all(ray, &mut all);
            Expected { all, closest: bvh.closest(ray, |_| true) }
        })
        .collect()
}

/// Same triangles, whatever their numbers.
fn same_triangles(answer: &Answer, expected: &Expected) -> bool {
    let sum = expected.all.iter().fold(0u32, |sum, hit| sum.wrapping_add(hit.triangle));
    answer.count as usize == expected.all.len()
        && answer.sum == sum
        && answer.triangle == expected.closest.map_or(u32::MAX, |hit| hit.triangle)
        && expected.closest.is_none_or(|hit| (answer.front != 0) == hit.front)
}

/// Largest difference of t (relative), u and v of the nearest hit; 0 if all bits are equal.
fn distance(answer: &Answer, expected: &Expected) -> f32 {
    expected.closest.map_or(0.0, |hit| {
        let t = (answer.t - hit.t).abs() / hit.t.max(f32::MIN_POSITIVE);
        t.max((answer.u - hit.u).abs()).max((answer.v - hit.v).abs())
    })
}

/// Whether the ray passes an edge of some triangle within 1e-5 of the triangle's height over it, or an end of
/// its interval within a relative 1e-5.
fn is_near_edge(ray: &Ray, triangles: &[[Vec3; 3]]) -> bool {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    triangles.iter().any(|triangle| {
        let [a, b, c] = triangle.map(|p| p.as_dvec3() - origin);
        let areas = [(c, b), (a, c), (b, a)].map(|(p, q): (DVec3, DVec3)| direction.dot(p.cross(q)));
        let sum: f64 = areas.iter().sum();
        let weights = areas.map(|area| area / sum);
        let t = (a * weights[0] + b * weights[1] + c * weights[2]).length() / direction.length();
        let least = weights.into_iter().fold(f64::INFINITY, f64::min);
        let ends = [ray.t_min, ray.t_max].map(f64::from).map(|end| (t - end).abs() <= 1e-5 * end);
        least.abs() <= 1e-5 || least > 0.0 && ends.contains(&true)
    })
}

fn scenes() -> Vec<(&'static str, Vec<[Vec3; 3]>)> {
    let loaded = sheer_gallery::open("pane").unwrap();
    let scene = std::sync::Arc::new(loaded.scene);
    let camera = scene.parts().cameras[0].clone();
    let animator = sheer_scene::Animator::new(scene, camera);
    let pane = animator.frame().triangles().to_vec();
    vec![("soup", soup(&mut Random(7 << 16), 2000)), ("pane", pane)]
}

#[test]
fn both_traversals_are_valid_wgsl() {
    for tracer in [Tracer::Query, Tracer::Bvh] {
        validate(&source(tracer, u32::MAX)).unwrap_or_else(|error| panic!("{tracer:?}: {error}"));
    }
}

#[test]
fn our_tree_gives_the_hits_of_the_cpu() {
    for (name, triangles) in scenes() {
        let rays = rays(&mut Random(8 << 16), &triangles, 1 << 14, true);
        let expected = on_cpu(&triangles, &rays);
        let answers = trace(Tracer::Bvh, &triangles, &rays, u32::MAX);
        let mut inexact = 0;
        for (index, (answer, expected)) in answers.iter().zip(&expected).enumerate() {
            assert!(
                same_triangles(answer, expected),
                "{name}, ray {index}: {answer:?}, {:?}",
                expected.closest
            );
            assert_eq!(answer.differs, 0, "{name}, ray {index}");
            // Where an area rounds to 0 the CPU takes f64, the shader pairs of f32: the last places differ.
            // Only a ray that was aimed at an edge gets there.
            let distance = distance(answer, expected);
            assert!(distance == 0.0 || index % 8 == 0 && distance <= 1e-6, "{name}, ray {index}: {distance}");
            inexact += usize::from(distance != 0.0);
        }
        println!("{name}: {inexact} of {} differ in the last places", rays.len());
        let hits = expected.iter().filter(|expected| expected.closest.is_some()).count();
        assert!(hits > rays.len() / 4, "{name}: {hits} rays hit anything");
    }
}

#[test]
fn the_driver_gives_the_hits_of_the_cpu_away_from_edges() {
    for (name, triangles) in scenes() {
        let rays = rays(&mut Random(9 << 16), &triangles, 1 << 14, false);
        let expected = on_cpu(&triangles, &rays);
        let answers = trace(Tracer::Query, &triangles, &rays, u32::MAX);
        let mut different = 0;
        for ((ray, answer), expected) in rays.iter().zip(&answers).zip(&expected) {
            // The numbers are those of `barycentrics`, so all bits are equal.
            if same_triangles(answer, expected) && distance(answer, expected) == 0.0 {
                continue;
            }
            different += 1;
            assert!(is_near_edge(ray, &triangles), "{name}: {ray:?}, {answer:?}, {:?}", expected.closest);
        }
        println!("{name}: {different} of {} differ at edges", rays.len());
        assert!(different <= rays.len() / 500, "{name}: {different} differ");
    }
}

#[test]
fn a_lost_triangle_is_noticed() {
    let triangles = soup(&mut Random(7 << 16), 2000);
    let rays = rays(&mut Random(8 << 16), &triangles, 1 << 12, false);
    let expected = on_cpu(&triangles, &rays);
    let lost = expected.iter().find_map(|expected| expected.all.first()).unwrap().triangle;
    for tracer in [Tracer::Query, Tracer::Bvh] {
        let answers = trace(tracer, &triangles, &rays, lost);
        let differs = |(answer, (ray, expected)): (&Answer, (&Ray, &Expected))| {
            !same_triangles(answer, expected) && !is_near_edge(ray, &triangles)
        };
        assert!(answers.iter().zip(rays.iter().zip(&expected)).any(differs), "{tracer:?}");
    }
}

/// Traces with both structures after each change of one scene, so that what was kept is used.
#[test]
fn a_scene_that_moves_grows_and_empties_is_traced_right() {
    let mut random = Random(10 << 16);
    let mut accel = DriverAccel::new(&GPU.device()).unwrap();
    let mut bvh = Bvh::build(&[]);
    let mut buffers = TreeAccel::new(&GPU.device(), &GPU.queue(), &bvh).unwrap();
    let mut fixed = soup(&mut random, 300);
    // A triangle that no tracer knows.
    fixed[17][1] = fixed[17][0];
    let steps = [(300, 100), (300, 100), (300, 0), (300, 900), (300, 50), (0, 200), (0, 0), (300, 0), (1, 1)];
    for (static_count, moving_count) in steps {
        let mut triangles = fixed[..static_count].to_vec();
        triangles.extend(soup(&mut random, 1000)[1000 - moving_count..].iter().copied());
        let rays = rays(&mut random, &fixed, 512, false);
        let expected = on_cpu(&triangles, &rays);
        let on_device = positions(&triangles);
        bvh.rebuild_after(static_count, &triangles);
        buffers.update(&GPU.device(), &GPU.queue(), &bvh).unwrap();
        update(&mut accel, &on_device, &triangles, static_count);
        for (tracer, entries) in [(Tracer::Query, accel.entries()), (Tracer::Bvh, buffers.entries())] {
            let answers = probe(tracer, &on_device, entries, &rays, u32::MAX);
            for (ray, (answer, expected)) in rays.iter().zip(answers.iter().zip(&expected)) {
                let is_edge = tracer == Tracer::Query && is_near_edge(ray, &triangles);
                let case = (tracer, static_count, moving_count);
                assert!(is_edge || same_triangles(answer, expected), "{case:?}: {answer:?}");
            }
        }
    }
}
