//! Rays per second and build times on three seeded scenes, on each SIMD path this processor runs.
//!
//! * `smoke`: 50k textured camera-facing quads in a cloud, many layers a ray.
//! * `hair`: a ball under one million thin triangles.
//! * `mixed`: terrain and balls, 70 % of 500k triangles, among textured cards.
//! * `instances`: 400 turned balls of 1152 triangles each, as instances of one (`shared`) and as they would
//!   be with triangles of their own (`copied`).
//!
//! Rays: `closest` takes the first hit, `stochastic` compares a texture's alpha with a hash of pixel and
//! triangle, `all` collects every hit, `shadow` multiplies transmittances towards a light until nothing is
//! left. `cargo bench -p sheer-accel -- smoke/stochastic` runs one of them.

use std::f32::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Affine3A, Quat, Vec3, vec3};
use sheer_accel::{Bvh, Hit, Instance, MeshTree, Ray, SimdPath};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

/// Triangles from this on are halves of textured cards, those before are opaque (or hair).
struct Geometry {
    name: &'static str,
    triangles: Vec<[Vec3; 3]>,
    first_card: u32,
    /// Opacity of what is not a card.
    solid_alpha: f32,
}

/// PCG output permutation over a counter: a small generator whose sequence is ours.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        unit(pcg(self.0))
    }

    fn in_ball(&mut self) -> Vec3 {
        loop {
            let p = vec3(self.next(), self.next(), self.next()) * 2.0 - 1.0;
            if p.length_squared() <= 1.0 {
                return p;
            }
        }
    }
}

fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// Two triangles whose texture runs from corner 0 to corner 2.
fn push_quad(triangles: &mut Vec<[Vec3; 3]>, centre: Vec3, x: Vec3, y: Vec3) {
    let corners = [centre - x - y, centre + x - y, centre + x + y, centre - x + y];
    triangles.push([corners[0], corners[1], corners[2]]);
    triangles.push([corners[0], corners[2], corners[3]]);
}

/// The camera is at +5 z and looks at the origin.
fn smoke() -> Geometry {
    let mut random = Random(1);
    let mut triangles = Vec::new();
    for _ in 0..50_000 {
        let centre = random.in_ball() * vec3(2.4, 1.2, 1.2);
        let (sin, cos) = (random.next() * TAU).sin_cos();
        let size = 0.02 + 0.03 * random.next();
        push_quad(&mut triangles, centre, vec3(cos, sin, 0.0) * size, vec3(-sin, cos, 0.0) * size);
    }
    Geometry { name: "smoke", triangles, first_card: 0, solid_alpha: 1.0 }
}

fn hair() -> Geometry {
    let mut random = Random(2);
    let mut triangles = Vec::new();
    for _ in 0..31_250 {
        let mut direction = random.in_ball().normalize();
        let mut point = direction * 1.2;
        let side = direction.cross(random.in_ball()).normalize() * 0.0008;
        for segment in 0..16 {
            let next = point + direction * 0.035;
            let (near, far) =
                (side * (1.0 - segment as f32 / 17.0), side * (1.0 - (segment + 1) as f32 / 17.0));
            triangles.push([point - near, point + near, next + far]);
            triangles.push([point - near, next + far, next - far]);
            point = next;
            direction = (direction + random.in_ball() * 0.2 - vec3(0.0, 0.1, 0.0)).normalize();
        }
    }
    Geometry { name: "hair", triangles, first_card: u32::MAX, solid_alpha: 0.4 }
}

fn push_ball(triangles: &mut Vec<[Vec3; 3]>, centre: Vec3, radius: f32, rings: u32) {
    let point = |ring: u32, step: u32| {
        let (polar, turn) = (0.5 * TAU * ring as f32 / rings as f32, TAU * step as f32 / (2 * rings) as f32);
        centre + vec3(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()) * radius
    };
    for ring in 0..rings {
        for step in 0..2 * rings {
            let (a, b) = (point(ring, step), point(ring, step + 1));
            let (c, d) = (point(ring + 1, step + 1), point(ring + 1, step));
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
}

fn mixed() -> Geometry {
    let mut random = Random(3);
    let mut triangles = Vec::new();
    let cells = 250;
    let height = |i: u32, j: u32| {
        let (x, z) = (i as f32 / cells as f32 * 8.0 - 4.0, j as f32 / cells as f32 * 8.0 - 4.0);
        vec3(x, -1.0 + 0.2 * (3.0 * x).sin() * (2.0 * z).cos() + 0.01 * unit(pcg(i * 4096 + j)), z)
    };
    for i in 0..cells {
        for j in 0..cells {
            let (a, b, c, d) = (height(i, j), height(i, j + 1), height(i + 1, j + 1), height(i + 1, j));
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    while triangles.len() < 350_000 {
        let centre = random.in_ball() * vec3(3.0, 0.8, 3.0);
        push_ball(&mut triangles, centre, 0.05 + 0.15 * random.next(), 24);
    }
    let first_card = triangles.len() as u32;
    while triangles.len() < 500_000 {
        let centre = random.in_ball() * vec3(3.0, 1.0, 3.0);
        let x = random.in_ball().normalize();
        let y = x.cross(random.in_ball()).normalize();
        push_quad(&mut triangles, centre, x * 0.03, y * 0.03);
    }
    Geometry { name: "mixed", triangles, first_card, solid_alpha: 1.0 }
}

/// Alpha of a round puff, 32 x 32.
fn texture() -> Vec<f32> {
    (0..32 * 32)
        .map(|texel| {
            let (x, y) = ((texel % 32) as f32 / 15.5 - 1.0, (texel / 32) as f32 / 15.5 - 1.0);
            (1.0 - x * x - y * y).max(0.0) * (0.3 + 0.4 * unit(pcg(texel)))
        })
        .collect()
}

impl Geometry {
    #[inline(always)]
    fn alpha(&self, texture: &[f32], hit: &Hit) -> f32 {
        if hit.triangle < self.first_card {
            return self.solid_alpha;
        }
        let (x, y) = if (hit.triangle - self.first_card).is_multiple_of(2) {
            (hit.u + hit.v, hit.v)
        } else {
            (hit.u, hit.u + hit.v)
        };
        let texel = |x: f32| ((x * 32.0) as usize).min(31);
        texture[texel(y) * 32 + texel(x)]
    }
}

fn camera_rays() -> Vec<Ray> {
    (0..WIDTH * HEIGHT)
        .map(|pixel| {
            let x = (pixel % WIDTH) as f32 + 0.5 - WIDTH as f32 / 2.0;
            let y = HEIGHT as f32 / 2.0 - (pixel / WIDTH) as f32 - 0.5;
            let direction = vec3(x, y, -(HEIGHT as f32)) / HEIGHT as f32;
            Ray { origin: vec3(0.0, 0.2, 4.0), direction, t_min: 0.0, t_max: f32::INFINITY }
        })
        .collect()
}

/// From what the camera sees towards a light.
fn shadow_rays(bvh: &Bvh) -> Vec<Ray> {
    let light = vec3(3.0, 6.0, 3.0);
    camera_rays()
        .iter()
        .filter_map(|ray| {
            let hit = bvh.closest(ray, |_| true)?;
            let origin = ray.origin + ray.direction * hit.t;
            Some(Ray { origin, direction: light - origin, t_min: 1e-4, t_max: 1.0 })
        })
        .collect()
}

fn rays(criterion: &mut Criterion) {
    let texture = texture();
    for geometry in [smoke(), hair(), mixed()] {
        let bvh = Bvh::build(&geometry.triangles);
        let (camera, shadow) = (camera_rays(), shadow_rays(&bvh));
        let alpha = |hit: &Hit| geometry.alpha(&texture, hit);
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
    for geometry in [smoke(), hair(), mixed()] {
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
