//! Rays per second and build times on three seeded scenes (`scenes`), on each SIMD path this processor runs;
//! and on `instances`, 400 turned balls of 1152 triangles each, as instances of one (`shared`) and as they
//! would be with triangles of their own (`copied`).
//!
//! Rays: `closest` takes the first hit, `stochastic` compares a texture's alpha with a hash of pixel and
//! triangle, `all` collects every hit, `shadow` multiplies transmittances towards a light until nothing is
//! left. `cargo bench -p sheer-accel -- smoke/stochastic` runs one of them.

mod scenes;

use std::f32::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Affine3A, Quat, Vec3, vec3};
use scenes::{Geometry, Random, camera_ray, pcg, push_ball, shadow_ray, texture, unit};
use sheer_accel::{Bvh, Hit, Instance, MeshTree, Ray, SimdPath};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

/// One through each pixel's centre, row by row.
fn camera_rays() -> Vec<Ray> {
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| [x as f32 + 0.5, y as f32 + 0.5]));
    pixels.map(|point_px| camera_ray(point_px, [WIDTH, HEIGHT])).collect()
}

/// From what the camera sees towards a light.
fn shadow_rays(bvh: &Bvh) -> Vec<Ray> {
    camera_rays().iter().filter_map(|ray| Some(shadow_ray(ray, bvh.closest(ray, |_| true)?.t))).collect()
}

fn rays(criterion: &mut Criterion) {
    let texture = texture();
    for geometry in Geometry::all() {
        let bvh = Bvh::build(&geometry.triangles);
        let (camera, shadow) = (camera_rays(), shadow_rays(&bvh));
        let alpha = |hit: &Hit| geometry.alpha(&texture, hit.triangle, hit.u, hit.v);
        for path in SimdPath::ALL.into_iter().filter(|path| path.is_supported()) {
            let bvh = bvh.clone().with_path(path).expect("the path is supported");
            let mut group = criterion.benchmark_group(geometry.name);
            group
                .sample_size(10)
                .warm_up_time(Duration::from_millis(300))
                .measurement_time(Duration::from_secs(2));

            group.throughput(Throughput::Elements(camera.len() as u64));
            group.bench_function(BenchmarkId::new("closest", path), |bencher| {
                bencher.iter(|| {
                    for ray in &camera {
                        black_box(bvh.closest(ray, |_| true));
                    }
                });
            });
            group.bench_function(BenchmarkId::new("stochastic", path), |bencher| {
                bencher.iter(|| {
                    for (pixel, ray) in (0..).zip(&camera) {
                        let seed = pcg(pixel);
                        black_box(bvh.closest(ray, |hit| alpha(hit) > unit(pcg(seed ^ hit.triangle))));
                    }
                });
            });
            group.bench_function(BenchmarkId::new("all", path), |bencher| {
                let mut hits = Vec::new();
                bencher.iter(|| {
                    for ray in &camera {
                        bvh.all(ray, &mut hits);
                        black_box(&hits);
                    }
                });
            });
            group.throughput(Throughput::Elements(shadow.len() as u64));
            group.bench_function(BenchmarkId::new("shadow", path), |bencher| {
                bencher.iter(|| {
                    for ray in &shadow {
                        let mut transmittance = 1.0;
                        black_box(bvh.any(ray, |hit| {
                            transmittance *= 1.0 - alpha(hit);
                            transmittance < 0.001
                        }));
                        black_box(transmittance);
                    }
                });
            });
            group.finish();
        }
    }
}

fn build(criterion: &mut Criterion) {
    for geometry in Geometry::all() {
        let mut group = criterion.benchmark_group(geometry.name);
        group.sample_size(10).measurement_time(Duration::from_secs(3));
        group.throughput(Throughput::Elements(geometry.triangles.len() as u64));
        group.bench_function("build", |bencher| bencher.iter(|| Bvh::build(&geometry.triangles)));
        // What an animated frame costs when all but the first tenth moves.
        let static_count = geometry.triangles.len() / 10;
        let mut bvh = Bvh::build(&geometry.triangles);
        group.bench_function("rebuild", |bencher| {
            bencher.iter(|| bvh.rebuild_after(static_count, &geometry.triangles));
        });
        group.finish();
    }
}

/// What it costs to share the triangles of a mesh.
fn instances(criterion: &mut Criterion) {
    let mut ball = Vec::new();
    push_ball(&mut ball, Vec3::ZERO, 1.0, 24);
    let mut random = Random(4);
    let instances: Vec<Instance> = (0..400)
        .map(|index| {
            let rotation = Quat::from_axis_angle(random.in_ball().normalize(), TAU * random.next());
            let scale = Vec3::splat(0.05 + 0.15 * random.next());
            let centre = random.in_ball() * vec3(2.4, 1.2, 1.2);
            let world_from_object = Affine3A::from_scale_rotation_translation(scale, rotation, centre);
            Instance { mesh: 0, world_from_object, first_triangle: index * ball.len() as u32 }
        })
        .collect();
    let mut shared =
        Bvh::build_with_meshes(&[], vec![MeshTree::build(&ball)], (instances.len() * ball.len()) as u32);
    shared.place_instances(0, &instances);
    let to_world = |instance: &Instance| {
        let map = instance.world_from_object;
        ball.iter().map(move |triangle| triangle.map(|p| map.transform_point3(p)))
    };
    let copied = Bvh::build(&instances.iter().flat_map(to_world).collect::<Vec<_>>());
    let camera = camera_rays();
    let mut group = criterion.benchmark_group("instances");
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    group.throughput(Throughput::Elements(camera.len() as u64));
    for (name, bvh) in [("shared", &shared), ("copied", &copied)] {
        group.bench_function(BenchmarkId::new("closest", name), |bencher| {
            bencher.iter(|| {
                for ray in &camera {
                    black_box(bvh.closest(ray, |_| true));
                }
            });
        });
        group.bench_function(BenchmarkId::new("all", name), |bencher| {
            let mut hits = Vec::new();
            bencher.iter(|| {
                for ray in &camera {
                    bvh.all(ray, &mut hits);
                    black_box(&hits);
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, build, rays, instances);
criterion_main!(benches);
