//! Packets against single rays, bit for bit.

use glam::{Affine3A, Quat, Vec3, vec3};

use super::{Random, Triangle, TwoLevels, height_field, icosphere, on_each_path};
use crate::{Bvh, Hit, Ray};

/// A hit of a ray as bits, so that 0 differs from -0.
type Bits = (usize, u32, u32, u32, u32, bool);

fn bits(ray: usize, hit: &Hit) -> Bits {
    (ray, hit.triangle, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.front)
}

/// All hits, in the order in which a packet visits them.
fn visits(bvh: &Bvh, rays: &[Ray]) -> Vec<Bits> {
    let mut visits = Vec::new();
    bvh.traverse_packet(rays, |ray, hit| {
        visits.push(bits(ray, &hit));
        f32::INFINITY
    });
    visits
}

fn hits_of_packet(bvh: &Bvh, rays: &[Ray]) -> Vec<Bits> {
    let mut hits = visits(bvh, rays);
    hits.sort_unstable();
    hits
}

fn hits_of_single_rays(bvh: &Bvh, rays: &[Ray]) -> Vec<Bits> {
    let mut hits = Vec::new();
    for (index, ray) in rays.iter().enumerate() {
        bvh.traverse(ray, |hit| {
            hits.push(bits(index, &hit));
            f32::INFINITY
        });
    }
    hits.sort_unstable();
    hits
}

/// Asserts that a packet finds what its rays find alone: all hits, the nearest, and what a visitor is left
/// with that stops. Returns how many hits there are.
fn assert_finds_what_single_rays_find(bvh: &Bvh, rays: &[Ray]) -> usize {
    let expected = hits_of_single_rays(bvh, rays);
    let accepts: [fn(usize, &Hit) -> bool; 2] =
        [|_, _| true, |ray, hit| (hit.triangle ^ ray as u32).wrapping_mul(0x9e37_79b9) >> 30 == 0];
    for bvh in on_each_path(bvh) {
        let path = bvh.path();
        assert!(hits_of_packet(&bvh, rays) == expected, "{path}, {rays:?}");
        for accept in accepts {
            let mut closest = Vec::new();
            bvh.closest_of_packet(rays, accept, &mut closest);
            let alone =
                rays.iter().enumerate().map(|(index, ray)| bvh.closest(ray, |hit| accept(index, hit)));
            assert!(alone.eq(closest), "{path}, {rays:?}");
        }
        let mut counts = vec![0; rays.len()];
        bvh.traverse_packet(rays, |ray, _| {
            counts[ray] += 1;
            f32::NEG_INFINITY
        });
        for (index, &count) in counts.iter().enumerate() {
            assert_eq!(count, usize::from(expected.iter().any(|&(ray, ..)| ray == index)), "{path}");
        }
    }
    expected.len()
}

impl Random {
    /// Rays of a picture, of a tile of it or a part of one, of the samples of a pixel, or towards one light;
    /// some with ends, and some that are no rays.
    fn packet(&mut self) -> Vec<Ray> {
        let count = match self.bits() % 4 {
            0 => 64,
            1 => 16,
            2 => 1 + self.bits() as usize % 63,
            _ => 65 + self.bits() as usize % 80,
        };
        let eye = self.point() * 2.0;
        let mut forward = self.point() - eye;
        if self.bits().is_multiple_of(4) {
            // Along an axis: slopes of 0, and of both signs.
            forward *= [Vec3::X, Vec3::Y, Vec3::Z][self.bits() as usize % 3];
        }
        let side = forward.cross(self.point()).normalize_or_zero();
        let up = side.cross(forward).normalize_or_zero();
        let (shares_origin, shares_direction) = match self.bits() % 8 {
            0 | 1 => (false, true),
            2 => (false, false),
            3 => (true, true),
            _ => (true, false),
        };
        let spread = [1e-6, 0.01, 0.1, 0.5, 4.0][self.bits() as usize % 5];
        let has_ends = self.bits().is_multiple_of(2);
        let mut rays: Vec<Ray> = (0..count)
            .map(|index| {
                let (column, row) = (index % 8, index / 8);
                let across = (side * (column as f32 - 3.5) + up * (row as f32 - 3.5)) * spread;
                let mut ray = Ray { origin: eye, direction: forward, t_min: 0.0, t_max: f32::INFINITY };
                if !shares_origin {
                    ray.origin += across * 0.3;
                }
                if !shares_direction {
                    ray.direction += across;
                }
                if has_ends {
                    ray.t_min = self.unit();
                    ray.t_max = ray.t_min + self.unit();
                }
                ray
            })
            .collect();
        if self.bits().is_multiple_of(3) {
            for bad in [
                |ray: &mut Ray| ray.direction = Vec3::ZERO,
                |ray: &mut Ray| ray.direction.x = f32::NAN,
                |ray: &mut Ray| ray.origin.y = 1e13,
                |ray: &mut Ray| ray.t_max = f32::NAN,
                |ray: &mut Ray| ray.t_max = -1.0,
                |ray: &mut Ray| ray.t_min = f32::NAN,
                |ray: &mut Ray| ray.direction *= 1e17,
                |ray: &mut Ray| ray.direction *= 1e-17,
            ] {
                bad(&mut rays[self.bits() as usize % count]);
            }
        }
        rays
    }
}

/// Rays from a point through points that lie close together.
fn towards(origin: Vec3, targets: impl IntoIterator<Item = Vec3>) -> Vec<Ray> {
    let ray = |target| Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY };
    targets.into_iter().map(ray).collect()
}

#[test]
fn packets_find_the_hits_of_single_rays() {
    let mut hit_count = 0;
    for (seed, count, size) in [(1, 7, 0.7), (2, 60, 0.5), (3, 700, 0.15), (4, 3000, 0.02), (5, 700, 1.0)] {
        let mut random = Random(seed << 16 | 40);
        let mut triangles = random.soup(count, size);
        // Not kept: equal vertices, no numbers.
        triangles.extend([[Vec3::X; 3], [Vec3::ZERO, Vec3::X, Vec3::X], [Vec3::NAN, Vec3::X, Vec3::Y]]);
        let bvh = Bvh::build(&triangles);
        for _ in 0..120 {
            let rays = random.packet();
            hit_count += assert_finds_what_single_rays_find(&bvh, &rays);
        }
    }
    assert!(hit_count > 1_000, "{hit_count}");
}

#[test]
fn packets_through_edges_and_vertices_leak_nowhere() {
    let mut random = Random(41);
    for (centre, radius) in [(Vec3::ZERO, 1.0), (vec3(1000.3, -70.7, 3.3), 0.37), (vec3(0.1, 0.2, -0.3), 1e5)]
    {
        let triangles = icosphere(3, centre, radius);
        let bvh = Bvh::build(&triangles);
        // The triangles of a mesh that is subdivided lie side by side in fours.
        for near in triangles.chunks(8) {
            let origin = centre + random.point() * 0.3 * radius;
            let targets = near.iter().flat_map(|&[a, b, c]| [a, b, c, a.midpoint(b), a.lerp(c, 0.3)]);
            let rays = towards(origin, targets);
            assert_eq!(assert_finds_what_single_rays_find(&bvh, &rays), rays.len());
        }
    }
}

#[test]
fn packets_along_the_axes_through_a_grid_hit_one_layer() {
    // Integer vertices and rays through them: every edge area is exactly 0 somewhere.
    let mut triangles: Vec<Triangle> = Vec::new();
    for i in 0..12 {
        for j in 0..12 {
            let at = |i: i32, j: i32| vec3(i as f32, j as f32, 0.0);
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    for turn in 0..3 {
        let turned = |p: Vec3| Vec3::from_array([0, 1, 2].map(|axis| p[(axis + turn) % 3]));
        let triangles: Vec<Triangle> = triangles.iter().map(|triangle| triangle.map(turned)).collect();
        let bvh = Bvh::build(&triangles);
        let targets = |left: i32, top: i32| {
            (0..64).map(move |index| {
                turned(vec3((left + index % 8 + 1) as f32, (top + index / 8 + 1) as f32, 0.0) * 0.5)
            })
        };
        for (left, top) in [(0, 0), (5, 9), (13, 13)] {
            for side in [4.0, -4.0] {
                let eye = turned(vec3(5.5, 6.0, side));
                let from_eye = towards(eye, targets(left, top));
                let along = turned(vec3(0.0, 0.0, -side));
                let parallel: Vec<Ray> = targets(left, top)
                    .map(|target| Ray { origin: target - along, direction: along, ..from_eye[0] })
                    .collect();
                for rays in [from_eye, parallel] {
                    assert_eq!(assert_finds_what_single_rays_find(&bvh, &rays), 64);
                }
            }
        }
    }
}

#[test]
fn packets_see_tiny_and_large_scenes_alike() {
    let mut random = Random(42);
    for scale in [1e-15, 1e-6, 1.0, 1e6, 1e11] {
        let bvh = Bvh::build(&icosphere(3, Vec3::ZERO, scale));
        for _ in 0..20 {
            let mut rays = random.packet();
            for ray in &mut rays {
                ray.origin *= scale;
                ray.direction *= scale;
            }
            assert_finds_what_single_rays_find(&bvh, &rays);
            // From within, over all around: all six axes.
            let around = (0..64).map(|_| random.point() * scale).collect::<Vec<_>>();
            let rays = towards(random.point() * 0.4 * scale, around);
            assert_eq!(assert_finds_what_single_rays_find(&bvh, &rays), 64, "scale {scale}");
        }
    }
}

#[test]
fn a_camera_above_a_terrain_and_within_it() {
    let mut random = Random(43);
    let bvh = Bvh::build(&height_field(&mut random, 40));
    for eye in [vec3(3.0, 4.0, 3.0), vec3(3.0, 0.2, 3.0), vec3(-2.0, 0.3, 3.3)] {
        for (column, row) in (0..8).flat_map(|column| (0..8).map(move |row| (column, row))) {
            let target = |index: u32| {
                let (x, y) = (column * 8 + index % 8, row * 8 + index / 8);
                eye + vec3(x as f32 / 32.0 - 1.0, 0.4 - y as f32 / 32.0, -1.0)
            };
            assert_finds_what_single_rays_find(&bvh, &towards(eye, (0..64).map(target)));
        }
    }
}

#[test]
fn nothing_is_found_where_nothing_is() {
    let mut random = Random(44);
    let rays = random.packet();
    assert_eq!(assert_finds_what_single_rays_find(&Bvh::build(&[]), &rays), 0);
    assert_eq!(assert_finds_what_single_rays_find(&Bvh::build_with_meshes(&[], Vec::new(), 0), &rays), 0);
    assert_eq!(assert_finds_what_single_rays_find(&Bvh::build(&icosphere(1, Vec3::ZERO, 1.0)), &[]), 0);
}

#[test]
fn packets_find_instances() {
    let mut hit_count = 0;
    for seed in 0..8 {
        let mut random = Random(seed << 16 | 45);
        let mut scene = TwoLevels {
            static_triangles: random.soup(seed as usize % 3 * 40, 0.4),
            meshes: vec![random.soup(90, 0.5), icosphere(2, Vec3::ZERO, 0.8), Vec::new()],
            instances: Vec::new(),
            moving: random.soup(seed as usize % 4 * 20, 0.4),
        };
        for _ in 0..[1, 2, 9, 40][seed as usize % 4] {
            let (mesh, map) = (random.bits() as usize % 3, random.map());
            scene.place(mesh, map);
        }
        let (instanced, flattened) = (scene.instanced(), scene.flattened());
        for _ in 0..40 {
            let rays = random.packet();
            hit_count += assert_finds_what_single_rays_find(&instanced, &rays);
            // Of a tree over copies, too: the order of hits differs, hits do not.
            assert!(hits_of_packet(&instanced, &rays) == hits_of_single_rays(&flattened, &rays));
        }
    }
    assert!(hit_count > 5_000, "{hit_count}");
}

#[test]
fn packets_find_instances_out_of_range_without_what_they_lose() {
    let mut scene = TwoLevels {
        static_triangles: Vec::new(),
        meshes: vec![icosphere(2, Vec3::ZERO, 1.0)],
        instances: Vec::new(),
        moving: Vec::new(),
    };
    // Some of it beyond 1e12, some beyond all numbers.
    scene.place(0, Affine3A::from_scale_rotation_translation(Vec3::splat(1.1e12), Quat::IDENTITY, Vec3::X));
    scene.place(0, Affine3A::from_scale(vec3(1.0, f32::MAX, 1.0) * 4.0));
    scene.place(0, Affine3A::from_scale(vec3(f32::INFINITY, 1.0, 1.0)));
    let bvh = scene.instanced();
    let mut random = Random(46);
    let mut hit_count = 0;
    for _ in 0..60 {
        let origin = random.point() * 1e11;
        let direction = random.point() * 1e11;
        let near: Vec<_> = (0..64).map(|_| origin + direction + random.point() * 1e10).collect();
        hit_count += assert_finds_what_single_rays_find(&bvh, &towards(origin, near));
    }
    assert!(hit_count > 500, "{hit_count}");
}

#[test]
fn packets_visit_in_one_order_on_all_paths() {
    let mut random = Random(47);
    let bvh = Bvh::build(&random.soup(2000, 0.2));
    for _ in 0..100 {
        let rays = random.packet();
        let mut orders = on_each_path(&bvh).map(|bvh| visits(&bvh, &rays));
        let first = orders.next().unwrap();
        assert!(orders.all(|order| order == first));
    }
}

/// The negative control: a difference of one rounding is seen.
#[test]
fn a_vertex_moved_by_a_rounding_shows() {
    let mut random = Random(48);
    let mut triangles = icosphere(3, Vec3::ZERO, 1.0);
    let intact = Bvh::build(&triangles);
    for [a, ..] in &mut triangles {
        a.x = a.x.next_up();
    }
    let moved = Bvh::build(&triangles);
    let differing = (0..50)
        .filter(|_| {
            let rays = towards(Vec3::ZERO, (0..64).map(|_| random.point()));
            hits_of_packet(&intact, &rays) != hits_of_single_rays(&moved, &rays)
        })
        .count();
    assert!(differing > 40, "{differing}");
}
