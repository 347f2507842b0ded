//! Rays per second and build times on three seeded scenes (`scenes`), on each SIMD path this processor runs;
//! and on `instances`, 400 turned balls of 1152 triangles each, as instances of one (`shared`) and as they
//! would be with triangles of their own (`copied`).
//!
//! Rays: `closest` takes the first hit, `stochastic` compares a texture's alpha with a hash of pixel and
//! triangle, `all` collects every hit, `shadow` multiplies transmittances towards a light until nothing is
//! left. `tile` in front of a name: the same rays in packets of 8×8 pixels; `pixel`: 16 rays through each of
//! a sixteenth of the pixels, which `pixel-tile` traces as a packet a pixel. Single rays and packets go over
//! the pixels in the same order.
//!
//! `motion`: a frame of 200k quads that all move, for which the tree is built anew (`rebuild`) or follows
//! (`refit`), on all threads and on one.
//!
//! `sun`: as `shadow`, from hits all through the scene towards a light infinitely far away. They are found
//! through the `tree`, as `packet`s of one direction from a tile each, and down the lists of a light
//! `buffer`; `build` makes that. `cargo bench -p sheer-accel -- smoke/stochastic` runs one of them.

mod scenes;

use std::f32::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Affine3A, Quat, Vec3, vec3};
use scenes::{Geometry, Random, camera_ray, pcg, push_ball, push_quad, shadow_ray, texture, unit};
use sheer_accel::{Bvh, Hit, Instance, LightBuffer, MeshTree, Ray, SimdPath};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

/// Direction towards the sun.
const TO_SUN: Vec3 = vec3(0.4, 0.8, 0.45);
/// Around all that the scenes show.
const REGION: [Vec3; 2] = [Vec3::splat(-6.0), Vec3::splat(6.0)];
/// Bytes that a light buffer may take: more than it asks for.
const BUFFER_BYTES: usize = 1 << 30;
/// Less light than this is none.
const LEAST_LIGHT: f32 = 0.001;

/// Rays that are traced together, with a number each that stands for their pixel.
type Tile = (Vec<u32>, Vec<Ray>);

fn even_bits(index: u32) -> u32 {
    index & 1 | index >> 1 & 2 | index >> 2 & 4
}

/// Rays through the centres of tiles of 8×8 pixels; eight consecutive ones lie in a block of 4×2.
fn camera_tiles() -> Vec<Tile> {
    let corners = (0..HEIGHT).step_by(8).flat_map(|top| (0..WIDTH).step_by(8).map(move |left| (left, top)));
    let tile = |(left, top)| {
        (0..64)
            .map(|index| (left + even_bits(index), top + even_bits(index >> 1)))
            .filter(|&(x, y)| x < WIDTH && y < HEIGHT)
            .map(|(x, y)| (y * WIDTH + x, camera_ray([x as f32 + 0.5, y as f32 + 0.5], [WIDTH, HEIGHT])))
            .unzip()
    };
    corners.map(tile).collect()
}

/// 16 rays through every fourth pixel of every fourth row.
fn pixel_tiles() -> Vec<Tile> {
    let pixels = (0..HEIGHT).step_by(4).flat_map(|y| (0..WIDTH).step_by(4).map(move |x| (x, y)));
    let tile = |(x, y): (u32, u32)| {
        let ray = |index: u32| {
            let within = [index, index >> 1].map(|bits| (even_bits(bits) as f32 + 0.5) / 4.0);
            let point_px = [x as f32 + within[0], y as f32 + within[1]];
            (16 * (y * WIDTH + x) + index, camera_ray(point_px, [WIDTH, HEIGHT]))
        };
        (0..16).map(ray).unzip()
    };
    pixels.map(tile).collect()
}

fn ray_count(tiles: &[Tile]) -> u64 {
    tiles.iter().map(|(_, rays)| rays.len() as u64).sum()
}

/// From what the camera sees towards a light.
fn shadow_rays(bvh: &Bvh) -> Vec<Ray> {
    let rays = camera_tiles().into_iter().flat_map(|(_, rays)| rays);
    rays.filter_map(|ray| Some(shadow_ray(&ray, bvh.closest(&ray, |_| true)?.t))).collect()
}

/// From one of the hits of each camera ray that has some, whichever, towards the sun; by tiles.
fn sun_rays(bvh: &Bvh) -> Vec<Vec<Ray>> {
    let mut hits = Vec::new();
    let mut sun_ray = |(&pixel, ray): (&u32, &Ray)| {
        bvh.all(ray, &mut hits);
        let hit = hits.get(pcg(pixel) as usize % hits.len().max(1))?;
        let origin = ray.origin + ray.direction * hit.t;
        Some(Ray { origin, direction: TO_SUN, t_min: 1e-4, t_max: f32::INFINITY })
    };
    camera_tiles()
        .iter()
        .map(|(pixels, rays)| pixels.iter().zip(rays).filter_map(&mut sun_ray).collect())
        .collect()
}

fn rays(criterion: &mut Criterion) {
    let texture = texture();
    for geometry in Geometry::all() {
        let bvh = Bvh::build(&geometry.triangles);
        let (tiles, pixels, shadow) = (camera_tiles(), pixel_tiles(), shadow_rays(&bvh));
        let alpha = |hit: &Hit| geometry.alpha(&texture, hit.triangle, hit.u, hit.v);
        for path in SimdPath::ALL.into_iter().filter(|path| path.is_supported()) {
            let bvh = bvh.clone().with_path(path).expect("the path is supported");
            let mut group = criterion.benchmark_group(geometry.name);
            group
                .sample_size(10)
                .warm_up_time(Duration::from_millis(300))
                .measurement_time(Duration::from_secs(2));

            let is_kept = |pixel: u32, hit: &Hit| alpha(hit) > unit(pcg(pcg(pixel) ^ hit.triangle));
            for (single, packet, tiles) in [
                ("stochastic", "tile-stochastic", &tiles),
                ("pixel-stochastic", "pixel-tile-stochastic", &pixels),
            ] {
                group.throughput(Throughput::Elements(ray_count(tiles)));
                group.bench_function(BenchmarkId::new(single, path), |bencher| {
                    bencher.iter(|| {
                        for (pixels, rays) in tiles {
                            for (&pixel, ray) in pixels.iter().zip(rays) {
                                black_box(bvh.closest(ray, |hit| is_kept(pixel, hit)));
                            }
                        }
                    });
                });
                group.bench_function(BenchmarkId::new(packet, path), |bencher| {
                    let mut closest = Vec::new();
                    bencher.iter(|| {
                        for (pixels, rays) in tiles {
                            let accept = |ray: usize, hit: &Hit| is_kept(pixels[ray], hit);
                            bvh.closest_of_packet(rays, accept, &mut closest);
                            black_box(&closest);
                        }
                    });
                });
            }
            group.throughput(Throughput::Elements(ray_count(&tiles)));
            group.bench_function(BenchmarkId::new("closest", path), |bencher| {
                bencher.iter(|| {
                    for ray in tiles.iter().flat_map(|(_, rays)| rays) {
                        black_box(bvh.closest(ray, |_| true));
                    }
                });
            });
            group.bench_function(BenchmarkId::new("tile-closest", path), |bencher| {
                let mut closest = Vec::new();
                bencher.iter(|| {
                    for (_, rays) in &tiles {
                        bvh.closest_of_packet(rays, |_, _| true, &mut closest);
                        black_box(&closest);
                    }
                });
            });
            group.bench_function(BenchmarkId::new("all", path), |bencher| {
                let mut hits = Vec::new();
                bencher.iter(|| {
                    for ray in tiles.iter().flat_map(|(_, rays)| rays) {
                        bvh.all(ray, &mut hits);
                        black_box(&hits);
                    }
                });
            });
            group.bench_function(BenchmarkId::new("tile-all", path), |bencher| {
                let mut hits: Vec<Vec<Hit>> = vec![Vec::new(); 64];
                bencher.iter(|| {
                    for (_, rays) in &tiles {
                        hits.iter_mut().for_each(Vec::clear);
                        bvh.traverse_packet(rays, |ray, hit| {
                            hits[ray].push(hit);
                            f32::INFINITY
                        });
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
                            transmittance < LEAST_LIGHT
                        }));
                        black_box(transmittance);
                    }
                });
            });
            group.finish();
        }
    }
}

/// Shadow rays of one direction, on the fastest path.
fn sun(criterion: &mut Criterion) {
    let texture = texture();
    for geometry in Geometry::all() {
        let bvh = Bvh::build(&geometry.triangles);
        let build = || LightBuffer::build(&geometry.triangles, 0, |_| false, TO_SUN, REGION, BUFFER_BYTES);
        let buffer = build().expect("direction and region are in range, and there is room");
        let tiles = sun_rays(&bvh);
        let dim = |light: &mut f32, hit: &Hit| {
            *light *= 1.0 - geometry.alpha(&texture, hit.triangle, hit.u, hit.v);
            if *light < LEAST_LIGHT { f32::NEG_INFINITY } else { f32::INFINITY }
        };
        let mut group = criterion.benchmark_group(geometry.name);
        group.sample_size(10).measurement_time(Duration::from_secs(2));
        group.throughput(Throughput::Elements(tiles.iter().map(|rays| rays.len() as u64).sum()));
        group.bench_function("sun/tree", |bencher| {
            bencher.iter(|| {
                for ray in tiles.iter().flatten() {
                    let mut light = 1.0;
                    bvh.traverse(ray, |hit| dim(&mut light, &hit));
                    black_box(light);
                }
            });
        });
        group.bench_function("sun/packet", |bencher| {
            bencher.iter(|| {
                for rays in &tiles {
                    let mut lights = [1.0; 64];
                    bvh.traverse_packet(rays, |ray, hit| dim(&mut lights[ray], &hit));
                    black_box(lights);
                }
            });
        });
        group.bench_function("sun/buffer", |bencher| {
            bencher.iter(|| {
                for ray in tiles.iter().flatten() {
                    let mut light = 1.0;
                    assert!(buffer.traverse(ray, |hit| dim(&mut light, &hit)), "the buffer serves all rays");
                    black_box(light);
                }
            });
        });
        group.throughput(Throughput::Elements(geometry.triangles.len() as u64));
        group.bench_function("sun/build", |bencher| bencher.iter(build));
        group.finish();
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

/// Quads of a cloud in which each goes its own way.
const QUADS: u32 = 200_000;

/// The triangles of a cloud at a time: quads that drift and turn, a step of 1 moves one by about its own
/// size.
fn cloud(step: f32) -> Vec<[Vec3; 3]> {
    let mut random = Random(5);
    let mut triangles = Vec::with_capacity(2 * QUADS as usize);
    for _ in 0..QUADS {
        let size = 0.01 + 0.02 * random.next();
        let centre = random.in_ball() * vec3(2.4, 1.2, 1.2) + random.in_ball() * (0.03 * step);
        let (sin, cos) = (TAU * random.next() + 0.1 * step).sin_cos();
        push_quad(&mut triangles, centre, vec3(cos, sin, 0.0) * size, vec3(-sin, cos, 0.0) * size);
    }
    triangles
}

/// An animated frame in which everything moves: a tree built anew, and one that follows.
fn motion(criterion: &mut Criterion) {
    // There and back again, in small steps.
    let frames: Vec<_> = [0.0, 0.1, 0.2, 0.3, 0.2, 0.1].map(cloud).into();
    let successors: Vec<u32> = (0..2 * QUADS).collect();
    let mut group = criterion.benchmark_group("motion");
    group.sample_size(20).measurement_time(Duration::from_secs(5));
    group.throughput(Throughput::Elements(u64::from(2 * QUADS)));
    for (name, threads) in [("", 0), ("-1-thread", 1)] {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started");
        let mut bvh = Bvh::build(&[]);
        let mut frame = 0;
        group.bench_function(format!("rebuild{name}"), |bencher| {
            bencher.iter(|| {
                frame = (frame + 1) % frames.len();
                pool.install(|| bvh.rebuild_after(0, &frames[frame]));
            });
        });
        group.bench_function(format!("refit{name}"), |bencher| {
            bencher.iter(|| {
                frame = (frame + 1) % frames.len();
                pool.install(|| bvh.refit_after(0, &frames[frame], &successors))
            });
        });
    }
    group.finish();
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
    let tiles = camera_tiles();
    let mut group = criterion.benchmark_group("instances");
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    group.throughput(Throughput::Elements(ray_count(&tiles)));
    for (name, bvh) in [("shared", &shared), ("copied", &copied)] {
        group.bench_function(BenchmarkId::new("closest", name), |bencher| {
            bencher.iter(|| {
                for ray in tiles.iter().flat_map(|(_, rays)| rays) {
                    black_box(bvh.closest(ray, |_| true));
                }
            });
        });
        group.bench_function(BenchmarkId::new("tile-closest", name), |bencher| {
            let mut closest = Vec::new();
            bencher.iter(|| {
                for (_, rays) in &tiles {
                    bvh.closest_of_packet(rays, |_, _| true, &mut closest);
                    black_box(&closest);
                }
            });
        });
        group.bench_function(BenchmarkId::new("all", name), |bencher| {
            let mut hits = Vec::new();
            bencher.iter(|| {
                for ray in tiles.iter().flat_map(|(_, rays)| rays) {
                    bvh.all(ray, &mut hits);
                    black_box(&hits);
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, build, motion, rays, sun, instances);
criterion_main!(benches);
