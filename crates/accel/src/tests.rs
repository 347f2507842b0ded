//! The tree against brute force, on every path, and on input meant to break it.

use glam::{Affine3A, Mat3, Quat, Vec3, vec3};

use crate::node::Child;
use crate::{AccelError, Bvh, Hit, Instance, LightBuffer, MeshTree, PackedTree, Ray, SimdPath};

mod packets;
mod refits;

type Triangle = [Vec3; 3];

/// PCG output permutation over a counter.
struct Random(u32);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(1);
        let state = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    }

    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    /// In the cube [-1, 1)^3.
    fn point(&mut self) -> Vec3 {
        vec3(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Triangles of a size, every fourth of them there twice, with its vertices turned.
    fn soup(&mut self, count: usize, size: f32) -> Vec<Triangle> {
        let mut triangles: Vec<Triangle> = Vec::new();
        while triangles.len() < count {
            let centre = self.point();
            triangles.push([0, 1, 2].map(|_| centre + self.point() * size));
            if triangles.len().is_multiple_of(4) {
                let [a, b, c] = triangles[self.bits() as usize % triangles.len()];
                triangles.push([b, c, a]);
            }
        }
        triangles
    }

    fn ray(&mut self) -> Ray {
        let origin = self.point() * 2.0;
        let mut direction = self.point() - origin;
        // Some along an axis or in a plane of two.
        for axis in 0..3 {
            if self.bits().is_multiple_of(6) {
                direction[axis] = 0.0;
            }
        }
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }
}

fn paths() -> impl Iterator<Item = SimdPath> {
    SimdPath::ALL.into_iter().filter(|path| path.is_supported())
}

fn on_each_path(bvh: &Bvh) -> impl Iterator<Item = Bvh> {
    paths().map(|path| bvh.clone().with_path(path).unwrap())
}

/// Every triangle alone in its tree: no box can hide it.
fn brute_force(triangles: &[Triangle]) -> Vec<Bvh> {
    triangles.iter().map(|triangle| Bvh::build(&[*triangle])).collect()
}

fn brute_force_hits(alone: &[Bvh], ray: &Ray) -> Vec<Hit> {
    let mut all = Vec::new();
    for (index, bvh) in (0..).zip(alone) {
        bvh.traverse(ray, |hit| {
            all.push(Hit { triangle: index, ..hit });
            ray.t_max
        });
    }
    all
}

/// All hits by triangle, so that two sets compare equal.
fn all_hits(bvh: &Bvh, ray: &Ray) -> Vec<Hit> {
    let mut hits = Vec::new();
    bvh.all(ray, &mut hits);
    hits.sort_by_key(|hit| hit.triangle);
    hits
}

fn nearest(hits: &[Hit], accept: impl Fn(&Hit) -> bool) -> Option<Hit> {
    hits.iter().copied().filter(accept).min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
}

/// A sphere of triangles that share vertices bit for bit.
fn icosphere(subdivisions: u32, centre: Vec3, radius: f32) -> Vec<Triangle> {
    let golden = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let corner = |axis: usize, a: f32, b: f32| {
        let mut p = Vec3::ZERO;
        p[(axis + 1) % 3] = a;
        p[(axis + 2) % 3] = b * golden;
        p.normalize()
    };
    let corners: Vec<Vec3> = (0..3)
        .flat_map(|axis| {
            [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(a, b)| corner(axis, a, b))
        })
        .collect();
    // Faces join three corners at the edge length, turned outwards.
    let edge = corners[0].distance(corners[1]).min(corners[0].distance(corners[2])) * 1.01;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [a, b, c] = [a, b, c].map(|index: usize| corners[index]);
                if a.distance(b) < edge && b.distance(c) < edge && c.distance(a) < edge {
                    let outwards = (b - a).cross(c - a).dot(a) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    assert_eq!(triangles.len(), 20);
    for _ in 0..subdivisions {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    triangles.iter().map(|triangle| triangle.map(|p| centre + p * radius)).collect()
}

/// A terrain with random heights over a random, but shared, grid of points.
fn height_field(random: &mut Random, cells: usize) -> Vec<Triangle> {
    let points: Vec<Vec3> = (0..(cells + 1) * (cells + 1))
        .map(|index| {
            let (i, j) = (index / (cells + 1), index % (cells + 1));
            let border = i == 0 || j == 0 || i == cells || j == cells;
            let shift = if border { Vec3::ZERO } else { random.point() * 0.3 };
            let height = 3.0 * random.unit();
            (vec3(i as f32, 0.0, j as f32) + vec3(shift.x, height, shift.z)) / cells as f32 * 7.3
        })
        .collect();
    let mut triangles = Vec::new();
    for i in 0..cells {
        for j in 0..cells {
            let at = |i: usize, j: usize| points[i * (cells + 1) + j];
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    triangles
}

#[test]
fn hits_equal_brute_force_on_random_soups() {
    for (seed, count, size) in [(1, 7, 0.7), (2, 60, 0.5), (3, 700, 0.15), (4, 700, 1.0)] {
        let mut random = Random(seed << 16);
        let triangles = random.soup(count, size);
        let bvh = Bvh::build(&triangles);
        bvh.validate(&triangles).unwrap();
        let alone = brute_force(&triangles);
        for _ in 0..300 {
            let mut ray = random.ray();
            if random.bits().is_multiple_of(2) {
                ray.t_min = random.unit();
                ray.t_max = ray.t_min + random.unit();
            }
            let expected = brute_force_hits(&alone, &ray);
            let accept = |hit: &Hit| hit.triangle.wrapping_mul(0x9e37_79b9) >> 30 != 0;
            for bvh in on_each_path(&bvh) {
                assert_eq!(all_hits(&bvh, &ray), expected);
                assert_eq!(bvh.closest(&ray, |_| true), nearest(&expected, |_| true));
                assert_eq!(bvh.closest(&ray, accept), nearest(&expected, accept));
                assert_eq!(bvh.any(&ray, |_| true), !expected.is_empty());
                assert_eq!(bvh.any(&ray, |hit| !accept(hit)), expected.iter().any(|hit| !accept(hit)));
            }
        }
    }
}

#[test]
fn hits_lie_where_their_weights_say() {
    let mut random = Random(77);
    let triangles = random.soup(500, 0.4);
    let bvh = Bvh::build(&triangles);
    let mut seen = 0;
    for _ in 0..500 {
        let ray = random.ray();
        for hit in all_hits(&bvh, &ray) {
            let [a, b, c] = triangles[hit.triangle as usize];
            let by_weights = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
            // Grazing triangles amplify the rounding along the ray, but never leave the triangle.
            let by_ray = ray.origin + ray.direction * hit.t;
            let slope = (b - a).cross(c - a).normalize().dot(ray.direction.normalize()).abs();
            assert!(by_weights.distance(by_ray) * slope.max(1e-3) < 1e-5, "{by_weights} {by_ray}");
            assert_eq!(hit.front, (b - a).cross(c - a).dot(ray.direction) < 0.0);
            seen += 1;
        }
    }
    assert!(seen > 500);
}

#[test]
fn both_ends_of_the_interval_belong_to_it() {
    let triangles = [[vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)]];
    let ray = |t_min, t_max| Ray { origin: vec3(0.0, 0.0, 2.0), direction: Vec3::NEG_Z, t_min, t_max };
    for bvh in on_each_path(&Bvh::build(&triangles)) {
        assert!(bvh.any(&ray(2.0, 2.0), |_| true));
        assert!(bvh.any(&ray(-1.0, 2.0), |_| true));
        assert!(!bvh.any(&ray(2.0_f32.next_up(), 3.0), |_| true));
        assert!(!bvh.any(&ray(0.0, 2.0_f32.next_down()), |_| true));
        assert!(!bvh.any(&ray(3.0, 1.0), |_| true));
    }
}

#[test]
fn a_visitor_can_stop_and_can_shorten_the_ray() {
    let layer = |z: f32| [vec3(-1.0, -1.0, z), vec3(1.0, -1.0, z), vec3(0.0, 1.0, z)];
    let triangles: Vec<Triangle> = (0..100).map(|z| layer(z as f32)).collect();
    let ray = Ray { origin: vec3(0.0, 0.0, -1.0), direction: Vec3::Z, t_min: 0.0, t_max: 1000.0 };
    for bvh in on_each_path(&Bvh::build(&triangles)) {
        let mut count = 0;
        bvh.traverse(&ray, |_| {
            count += 1;
            f32::NEG_INFINITY
        });
        assert_eq!(count, 1);
        let mut within = Vec::new();
        bvh.traverse(&ray, |hit| {
            within.push(hit.triangle);
            50.0
        });
        assert!(within[1..].iter().all(|&triangle| triangle < 50));
        assert!((0..50).all(|triangle| within.contains(&triangle)));
        // No hit again for a visitor that asks for a longer ray.
        let mut seen = [0; 100];
        bvh.traverse(&ray, |hit| {
            seen[hit.triangle as usize] += 1;
            f32::INFINITY
        });
        assert_eq!(seen, [1; 100]);
    }
}

#[test]
fn equal_depths_go_to_the_lowest_index_whatever_the_tree() {
    let mut random = Random(5);
    let face = [vec3(-1.0, -0.5, 0.1), vec3(1.0, -1.0, 0.2), vec3(0.0, 1.0, 0.3)];
    let mut triangles: Vec<Triangle> =
        random.soup(300, 0.1).into_iter().map(|triangle| triangle.map(|p| p - Vec3::Z * 2.0)).collect();
    for place in [250, 260, 17, 100, 299] {
        triangles[place] = face;
    }
    for static_count in [0, 50, 200, 255, 300] {
        let mut bvh = Bvh::build(&[]);
        bvh.rebuild_after(static_count, &triangles);
        for bvh in on_each_path(&bvh) {
            for _ in 0..50 {
                let origin = random.point() * 0.2 + Vec3::Z * 3.0;
                let direction = random.point() * 0.2 - origin;
                let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
                for (least, expected) in [(0, 17), (18, 100), (101, 250), (251, 260), (261, 299)] {
                    let hit = bvh.closest(&ray, |hit| hit.triangle >= least);
                    assert_eq!(hit.map(|hit| hit.triangle), Some(expected));
                }
            }
        }
    }
}

#[test]
fn rays_through_edges_and_vertices_cross_a_closed_mesh() {
    let mut random = Random(6);
    for (centre, radius) in [(Vec3::ZERO, 1.0), (vec3(1000.3, -70.7, 3.3), 0.37), (vec3(0.1, 0.2, -0.3), 1e5)]
    {
        let triangles = icosphere(3, centre, radius);
        let bvh = Bvh::build(&triangles);
        for bvh in on_each_path(&bvh) {
            for triangle in &triangles {
                for vertex in 0..3 {
                    let (a, b) = (triangle[vertex], triangle[(vertex + 1) % 3]);
                    let target =
                        if random.bits().is_multiple_of(2) { a } else { a + (b - a) * random.unit() };
                    let inside = centre + random.point() * 0.3 * radius;
                    let ray = |origin: Vec3| Ray {
                        origin,
                        direction: target - origin,
                        t_min: 0.0,
                        t_max: f32::INFINITY,
                    };
                    let hits = all_hits(&bvh, &ray(inside));
                    assert_eq!(hits.len(), 1, "from inside {inside} through {target}: {hits:?}");
                    assert!(!hits[0].front);
                    // From outside: in as often as out, even where the ray only touches the silhouette.
                    let outside = centre + random.point().normalize() * radius * 3.0;
                    let hits = all_hits(&bvh, &ray(outside));
                    let fronts = hits.iter().filter(|hit| hit.front).count();
                    assert_eq!(2 * fronts, hits.len(), "from outside {outside} through {target}: {hits:?}");
                }
            }
        }
    }
}

#[test]
fn rays_along_the_axes_through_a_grid_hit_one_layer() {
    // Integer vertices and rays through them: every edge area is exactly 0 somewhere.
    let mut triangles = Vec::new();
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
        for bvh in on_each_path(&Bvh::build(&triangles)) {
            for step in 0..(2 * 11) * (2 * 11) {
                let target = vec3((step % 22) as f32 * 0.5 + 0.5, (step / 22) as f32 * 0.5 + 0.5, 0.0);
                for direction in [Vec3::Z, Vec3::NEG_Z] {
                    let origin = turned(target - direction * 4.0);
                    let ray = Ray { origin, direction: turned(direction), t_min: 0.0, t_max: 10.0 };
                    let hits = all_hits(&bvh, &ray);
                    assert_eq!(hits.len(), 1, "{target}: {hits:?}");
                    assert_eq!((hits[0].t, hits[0].front), (4.0, direction == Vec3::NEG_Z));
                }
            }
        }
    }
}

#[test]
fn a_height_field_has_no_holes() {
    let mut random = Random(7);
    let triangles = height_field(&mut random, 40);
    let bvh = Bvh::build(&triangles);
    for bvh in on_each_path(&bvh) {
        for triangle in &triangles {
            for vertex in 0..3 {
                let (a, b) = (triangle[vertex], triangle[(vertex + 1) % 3]);
                let target = a + (b - a) * if random.bits().is_multiple_of(2) { 0.0 } else { random.unit() };
                if target.x.min(target.z) < 0.1 || target.x.max(target.z) > 7.2 {
                    continue;
                }
                // Steep: the ray stays over the field all the way down.
                let origin = target + vec3(0.02, 0.0, 0.01) * random.point() + Vec3::Y * 3.0;
                let ray = Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY };
                assert_eq!(all_hits(&bvh, &ray).len() % 2, 1, "leak through {target}");
            }
        }
    }
}

#[test]
fn all_paths_give_the_same_bits() {
    let mut random = Random(8);
    let mut triangles = random.soup(3000, 0.2);
    triangles.extend(icosphere(2, Vec3::ZERO, 0.8));
    let bvh = Bvh::build(&triangles);
    let bits = |hit: &Hit| (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.triangle, hit.front);
    for _ in 0..1000 {
        let mut ray = random.ray();
        if random.bits().is_multiple_of(3) {
            ray.direction = triangles[random.bits() as usize % triangles.len()][0] - ray.origin;
        }
        let mut visits = on_each_path(&bvh).map(|bvh| {
            let mut order = Vec::new();
            bvh.traverse(&ray, |hit| {
                order.push(bits(&hit));
                ray.t_max
            });
            (order, bvh.closest(&ray, |_| true).as_ref().map(bits))
        });
        let first = visits.next().unwrap();
        assert!(visits.all(|other| other == first));
    }
}

#[test]
fn one_and_two_threads_build_the_same_tree() {
    let triangles = Random(9).soup(30_000, 0.05);
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut bvh = Bvh::build(&triangles);
            let first = format!("{:?}", bvh.tree());
            bvh.rebuild_after(10_000, &triangles);
            (first, format!("{:?}", bvh.tree()))
        })
    };
    // Compared as text, in which NaN equals NaN and -0 differs from 0.
    assert!(build(1) == build(2));
}

#[test]
fn a_rebuilt_tree_gives_the_hits_of_a_new_one() {
    let mut random = Random(10);
    for (static_count, moving_count) in [(0, 500), (500, 0), (3, 2), (500, 3), (3, 500), (2000, 9000), (0, 0)]
    {
        let mut triangles = random.soup(static_count, 0.3);
        triangles.truncate(static_count);
        triangles.extend(random.soup(moving_count, 0.2));
        let mut bvh = Bvh::build(&triangles[..static_count]);
        for frame in 0..3 {
            for triangle in &mut triangles[static_count..] {
                let shift = random.point() * 0.2;
                *triangle = triangle.map(|p| p + shift);
            }
            bvh.rebuild_after(static_count, &triangles);
            bvh.validate(&triangles).unwrap_or_else(|error| panic!("frame {frame}: {error}"));
            let new = Bvh::build(&triangles);
            for _ in 0..100 {
                let ray = random.ray();
                assert_eq!(all_hits(&bvh, &ray), all_hits(&new, &ray));
                assert_eq!(bvh.closest(&ray, |_| true), new.closest(&ray, |_| true));
            }
        }
    }
}

#[test]
fn a_rebuild_forgets_a_shorter_or_longer_static_part() {
    let mut random = Random(11);
    let triangles = random.soup(900, 0.2);
    let mut bvh = Bvh::build(&triangles[..100]);
    for static_count in [300, 100, 900, 5000, 0] {
        bvh.rebuild_after(static_count, &triangles);
        bvh.validate(&triangles).unwrap();
    }
}

#[test]
fn degenerate_triangles_are_ignored() {
    let good = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)];
    let point = [Vec3::ZERO; 3];
    let line = [Vec3::ZERO, Vec3::X, Vec3::X];
    let nan = [Vec3::NAN, Vec3::X, Vec3::Y];
    let infinite = [Vec3::INFINITY, Vec3::X, Vec3::Y];
    let huge = [Vec3::MAX, Vec3::X, Vec3::Y];
    let triangles = [point, line, nan, good, infinite, huge, point];
    let ray = Ray { origin: vec3(0.0, 0.0, 2.0), direction: Vec3::NEG_Z, t_min: 0.0, t_max: f32::INFINITY };
    for bvh in on_each_path(&Bvh::build(&triangles)) {
        assert_eq!(bvh.validate(&triangles).unwrap().triangle_count, 1);
        assert_eq!(all_hits(&bvh, &ray).iter().map(|hit| hit.triangle).collect::<Vec<_>>(), [3]);
    }
    for none in [&[][..], &[nan], &[point, line]] {
        for bvh in on_each_path(&Bvh::build(none)) {
            assert_eq!(bvh.validate(none).unwrap().node_count, 0);
            assert_eq!(bvh.closest(&ray, |_| true), None);
        }
    }
}

#[test]
fn rays_out_of_range_hit_nothing() {
    let triangles = icosphere(2, Vec3::ZERO, 1.0);
    let ray = |origin: Vec3, direction: Vec3| Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
    for bvh in on_each_path(&Bvh::build(&triangles)) {
        for bad in [Vec3::ZERO, Vec3::NAN, vec3(1.0, f32::NAN, 0.0), Vec3::INFINITY] {
            assert_eq!(bvh.closest(&ray(Vec3::ZERO, bad), |_| true), None);
        }
        for bad in [Vec3::NAN, vec3(0.0, f32::NEG_INFINITY, 0.0), Vec3::MAX] {
            assert_eq!(bvh.closest(&ray(bad, Vec3::X), |_| true), None);
        }
        let unlimited = Ray { t_max: f32::NAN, ..ray(Vec3::ZERO, Vec3::X) };
        assert_eq!(bvh.closest(&unlimited, |_| true), None);
        for length in [1e-18, 1e-9, 1.0, 1e9, 1e18] {
            let hit = bvh.closest(&ray(vec3(0.1, 0.2, 0.3), Vec3::ONE * length), |_| true).unwrap();
            assert!((0.3..0.6).contains(&(hit.t * length)), "{length} {hit:?}");
        }
    }
}

#[test]
fn tiny_and_large_scenes_are_hit_alike() {
    let mut random = Random(12);
    for scale in [1e-15, 1e-6, 1.0, 1e6, 1e11] {
        let triangles = icosphere(2, Vec3::ZERO, scale);
        for bvh in on_each_path(&Bvh::build(&triangles)) {
            for _ in 0..200 {
                let ray = Ray {
                    origin: random.point() * 0.4 * scale,
                    direction: random.point(),
                    t_min: 0.0,
                    t_max: f32::INFINITY,
                };
                assert_eq!(all_hits(&bvh, &ray).len(), 1, "scale {scale}");
            }
        }
    }
}

#[test]
fn coincident_triangles_and_shrinking_ones_make_no_deep_tree() {
    let face = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)];
    let triangles = vec![face; 1000];
    let ray = Ray { origin: vec3(0.0, 0.0, 2.0), direction: Vec3::NEG_Z, t_min: 0.0, t_max: f32::INFINITY };
    for bvh in on_each_path(&Bvh::build(&triangles)) {
        assert!(bvh.validate(&triangles).unwrap().depth <= 4);
        assert_eq!(all_hits(&bvh, &ray).len(), 1000);
        assert_eq!(bvh.closest(&ray, |_| true).unwrap().triangle, 0);
    }
    // Each is half the last: the heuristic alone would peel them off one by one.
    let triangles: Vec<Triangle> = (0..20_000)
        .map(|index| face.map(|p| (p + Vec3::X) * 0.5_f32.powi(index % 60) + Vec3::Z * (index as f32 * 1e-5)))
        .collect();
    let mut bvh = Bvh::build(&triangles);
    bvh.validate(&triangles).unwrap();
    bvh.rebuild_after(10_000, &triangles);
    bvh.validate(&triangles).unwrap();
}

#[test]
fn statistics_add_up() {
    let triangles = icosphere(4, Vec3::ZERO, 1.0);
    let stats = Bvh::build(&triangles).validate(&triangles).unwrap();
    assert_eq!(stats.triangle_count, 5120);
    assert!(stats.leaf_count >= 640 && stats.leaf_count < 2000, "{stats:?}");
    assert_eq!(stats.bytes, stats.node_count as usize * 224 + stats.leaf_count as usize * 320);
    assert!(stats.depth >= 4 && stats.depth < 8, "{stats:?}");
    assert!(stats.sah_cost > 1.0 && stats.sah_cost < 50.0, "{stats:?}");
}

/// The negative control of `validate`: each fault it looks for is found.
#[test]
fn validate_finds_what_is_broken() {
    let triangles = Random(13).soup(2000, 0.1);
    let intact = Bvh::build(&triangles);
    intact.validate(&triangles).unwrap();

    type Damage = fn(&mut Bvh);
    type Expected = fn(&AccelError) -> bool;
    let faults: [(&str, Damage, Expected); 8] = [
        (
            "box too small",
            |bvh| bvh.nodes_mut()[1].bounds[3][0] -= 0.05,
            |error| matches!(error, AccelError::BrokenBox { .. }),
        ),
        (
            "NaN in a box",
            |bvh| bvh.nodes_mut()[0].bounds[2][1] = f32::NAN,
            |error| matches!(error, AccelError::BrokenBox { .. }),
        ),
        ("shared child", share_first_child, |error| matches!(error, AccelError::BrokenLink { .. })),
        (
            "cycle",
            |bvh| bvh.nodes_mut()[2].children[0] = Child::node(0),
            |error| matches!(error, AccelError::BrokenLink { .. }),
        ),
        (
            "index out of range",
            |bvh| bvh.nodes_mut()[0].children[0] = Child::block(1 << 20),
            |error| matches!(error, AccelError::BrokenLink { .. }),
        ),
        (
            "lost triangle",
            |bvh| bvh.blocks_mut()[3].triangles[0] = u32::MAX,
            |error| matches!(error, AccelError::LostTriangle { leaves: 0, .. }),
        ),
        (
            "doubled triangle",
            |bvh| bvh.blocks_mut()[3] = bvh.blocks_mut()[4],
            |error| matches!(error, AccelError::LostTriangle { .. } | AccelError::BrokenBox { .. }),
        ),
        (
            "moved triangle",
            |bvh| bvh.blocks_mut()[5].vertices[1][2][0] += 1.0,
            |error| matches!(error, AccelError::StaleTriangle { .. }),
        ),
    ];
    fn share_first_child(bvh: &mut Bvh) {
        let root = &mut bvh.nodes_mut()[0];
        root.set(1, root.lower(0), root.upper(0), root.children[0]);
    }
    for (name, damage, expected) in faults {
        let mut bvh = intact.clone();
        damage(&mut bvh);
        let error = bvh.validate(&triangles).expect_err(name);
        assert!(expected(&error), "{name}: {error}");
    }
    assert!(intact.validate(&triangles[1..]).is_err());
}

#[test]
fn an_unsupported_path_is_refused_with_a_way_out() {
    for path in SimdPath::ALL {
        let result = Bvh::build(&[]).with_path(path);
        assert_eq!(result.is_ok(), path.is_supported());
        if let Err(error) = result {
            assert!(error.to_string().contains("SimdPath::Portable"));
        } else {
            assert_eq!(result.unwrap().path(), path);
        }
    }
}

#[test]
fn a_packed_tree_names_the_part_that_stays() {
    let mut triangles = Random(24).soup(500, 0.3);
    let mut bvh = Bvh::build(&triangles[..300]);
    bvh.rebuild_after(300, &triangles);
    let before = bvh.clone();
    for vertex in triangles[300..].as_flattened_mut() {
        *vertex += Vec3::X;
    }
    bvh.rebuild_after(300, &triangles);

    let (old, new) = (before.packed(), bvh.packed());
    assert_eq!(old.kept_id, new.kept_id);
    assert_eq!(old.nodes[..old.kept_nodes], new.nodes[..new.kept_nodes]);
    assert_eq!(old.blocks[..old.kept_blocks], new.blocks[..new.kept_blocks]);
    assert!(old.kept_nodes > 0 && old.blocks[old.kept_blocks..] != new.blocks[new.kept_blocks..]);
    bvh.rebuild_after(299, &triangles);
    assert_ne!(kept_id(&bvh), kept_id(&before), "another part stays");
    assert_eq!(Bvh::build(&[]).packed().root, PackedTree::NONE);
}

fn kept_id(bvh: &Bvh) -> u64 {
    bvh.packed().kept_id
}

/// Triangles beside instances, as they are and with all triangles of the instances in world.
struct TwoLevels {
    static_triangles: Vec<Triangle>,
    meshes: Vec<Vec<Triangle>>,
    instances: Vec<Instance>,
    moving: Vec<Triangle>,
}

impl TwoLevels {
    fn number_count(&self) -> u32 {
        self.instances.iter().map(|instance| self.meshes[instance.mesh].len() as u32).sum()
    }

    fn instanced(&self) -> Bvh {
        let meshes = self.meshes.iter().map(|mesh| MeshTree::build(mesh)).collect();
        let mut bvh = Bvh::build_with_meshes(&self.static_triangles, meshes, self.number_count());
        bvh.place_instances(0, &self.instances);
        let stored = [&self.static_triangles[..], &self.moving].concat();
        bvh.rebuild_after(self.static_triangles.len(), &stored);
        bvh.validate(&stored).unwrap();
        bvh
    }

    fn flattened(&self) -> Bvh {
        let mut triangles = self.static_triangles.clone();
        for instance in &self.instances {
            assert_eq!(triangles.len(), instance.first_triangle as usize);
            let to_world =
                |triangle: &Triangle| triangle.map(|p| instance.world_from_object.transform_point3(p));
            triangles.extend(self.meshes[instance.mesh].iter().map(to_world));
        }
        triangles.extend(&self.moving);
        Bvh::build(&triangles)
    }

    /// Adds an instance of a mesh.
    fn place(&mut self, mesh: usize, world_from_object: Affine3A) {
        let first_triangle = self.static_triangles.len() as u32 + self.number_count();
        self.instances.push(Instance { mesh, world_from_object, first_triangle });
    }
}

impl Random {
    /// Turned, scaled alike or not along its axes, mirrored, sheared, flat, or small and far from its origin.
    fn map(&mut self) -> Affine3A {
        let rotation = Quat::from_axis_angle(self.point().normalize(), 7.0 * self.unit());
        let scale = match self.bits() % 6 {
            0 => Vec3::ONE,
            1 => Vec3::splat(0.1 + self.unit()),
            2 => self.point(),
            3 => self.point() * vec3(1.0, 0.0, 1.0),
            4 => vec3(-1.0, 1.0, 1.0),
            _ => vec3(1e-6, 0.5, 30.0 * self.unit()),
        };
        let placed = Affine3A::from_scale_rotation_translation(scale, rotation, self.point());
        match self.bits() % 4 {
            0 => placed * Affine3A::from_mat3(Mat3::from_cols(Vec3::X, vec3(0.7, 1.0, -0.2), Vec3::Z)),
            // Far from its origin: what is near to the rays is what is left of large numbers.
            1 => {
                placed
                    * Affine3A::from_translation(vec3(-200.0, 30.0, 0.1))
                    * Affine3A::from_translation(vec3(200.0, -30.0, 0.0))
            }
            2 => Affine3A::from_scale_rotation_translation(
                Vec3::splat(0.6),
                Quat::IDENTITY,
                self.point() * 0.5,
            ),
            _ => placed,
        }
    }
}

#[test]
fn instances_are_hit_as_their_triangles_would_be() {
    let mut hit_count = 0;
    for seed in 0..12 {
        let mut random = Random(seed << 16 | 9);
        let mut scene = TwoLevels {
            static_triangles: random.soup(seed as usize % 3 * 40, 0.4),
            meshes: vec![
                random.soup(90, 0.5),
                icosphere(2, Vec3::ZERO, 0.8),
                random.soup(3, 1.0),
                Vec::new(),
            ],
            instances: Vec::new(),
            moving: random.soup(seed as usize % 4 * 20, 0.4),
        };
        for _ in 0..[1, 2, 9, 40][seed as usize % 4] {
            let (mesh, map) = (random.bits() as usize % 4, random.map());
            scene.place(mesh, map);
            // Every third is there twice: equal depths go to the first.
            if random.bits().is_multiple_of(3) {
                scene.place(mesh, map);
            }
        }
        let (instanced, flattened) = (scene.instanced(), scene.flattened());
        assert_eq!(instanced.bounds(), flattened.bounds());
        for _ in 0..200 {
            let mut ray = random.ray();
            if random.bits().is_multiple_of(2) {
                ray.t_min = random.unit();
                ray.t_max = ray.t_min + random.unit();
            }
            let expected = all_hits(&flattened, &ray);
            hit_count += expected.len();
            let accept = |hit: &Hit| hit.triangle.wrapping_mul(0x9e37_79b9) >> 30 != 0;
            for bvh in on_each_path(&instanced) {
                assert_eq!(all_hits(&bvh, &ray), expected);
                assert_eq!(bvh.closest(&ray, |_| true), flattened.closest(&ray, |_| true));
                assert_eq!(bvh.closest(&ray, accept), flattened.closest(&ray, accept));
                assert_eq!(bvh.any(&ray, |hit| !accept(hit)), flattened.any(&ray, |hit| !accept(hit)));
            }
        }
    }
    assert!(hit_count > 5_000, "{hit_count}");
}

#[test]
fn an_instance_that_is_elsewhere_by_a_rounding_is_hit_elsewhere() {
    let mut random = Random(31);
    let mut scene = TwoLevels {
        static_triangles: Vec::new(),
        meshes: vec![icosphere(3, Vec3::ZERO, 0.8)],
        instances: Vec::new(),
        moving: Vec::new(),
    };
    scene.place(0, Affine3A::from_rotation_y(0.3));
    let flattened = scene.flattened();
    let differ = |scene: &TwoLevels, random: &mut Random| {
        let instanced = scene.instanced();
        (0..200)
            .filter(|_| {
                let ray = random.ray();
                all_hits(&instanced, &ray) != all_hits(&flattened, &ray)
            })
            .count()
    };
    assert_eq!(differ(&scene, &mut random), 0);
    scene.instances[0].world_from_object.matrix3.x_axis.x = 0.3_f32.cos().next_down();
    assert!(differ(&scene, &mut random) > 50);
}

#[test]
fn rays_through_edges_and_vertices_cross_a_closed_instance() {
    let mut random = Random(32);
    for map in [
        Affine3A::from_rotation_x(0.4),
        Affine3A::from_scale_rotation_translation(
            vec3(-2.0, 0.3, 1.7),
            Quat::from_rotation_z(1.0),
            vec3(900.0, 2.0, -7.0),
        ),
    ] {
        let mut scene = TwoLevels {
            static_triangles: Vec::new(),
            meshes: vec![icosphere(3, Vec3::ZERO, 1.0)],
            instances: Vec::new(),
            moving: Vec::new(),
        };
        scene.place(0, map);
        for bvh in on_each_path(&scene.instanced()) {
            for triangle in &scene.meshes[0] {
                let [a, b, _] = triangle.map(|p| map.transform_point3(p));
                let target = if random.bits().is_multiple_of(2) { a } else { a + (b - a) * random.unit() };
                let origin = map.transform_point3(random.point() * 0.3);
                let ray = Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY };
                assert_eq!(all_hits(&bvh, &ray).len(), 1, "from inside {origin} through {target}");
            }
        }
    }
}

#[test]
fn instances_out_of_range_lose_the_triangles_that_are() {
    let mut scene = TwoLevels {
        static_triangles: Vec::new(),
        meshes: vec![icosphere(2, Vec3::ZERO, 1.0)],
        instances: Vec::new(),
        moving: Vec::new(),
    };
    // Some of it beyond 1e12; all of it; a point; a point by rounding; not a number.
    scene.place(0, Affine3A::from_scale_rotation_translation(Vec3::splat(1.1e12), Quat::IDENTITY, Vec3::X));
    scene.place(0, Affine3A::from_translation(vec3(1e13, 0.0, 0.0)));
    scene.place(0, Affine3A::from_scale(Vec3::ZERO));
    scene.place(
        0,
        Affine3A::from_scale_rotation_translation(Vec3::splat(1e-7), Quat::IDENTITY, Vec3::splat(7.0)),
    );
    scene.place(0, Affine3A::from_scale(Vec3::splat(f32::NAN)));
    scene.place(0, Affine3A::from_scale(vec3(f32::INFINITY, 1.0, 1.0)));
    let (instanced, flattened) = (scene.instanced(), scene.flattened());
    assert_eq!(instanced.bounds(), flattened.bounds());
    let mut random = Random(33);
    let mut hit_count = 0;
    for _ in 0..500 {
        let origin = random.point() * 1e11;
        let ray = Ray { origin, direction: random.point() * 1e11, t_min: 0.0, t_max: f32::INFINITY };
        let expected = all_hits(&flattened, &ray);
        hit_count += expected.len();
        on_each_path(&instanced).for_each(|bvh| assert_eq!(all_hits(&bvh, &ray), expected));
    }
    assert!(hit_count > 50, "{hit_count}");
}

#[test]
fn instances_that_move_are_found_where_they_are() {
    let mut random = Random(34);
    let mut scene = TwoLevels {
        static_triangles: random.soup(50, 0.3),
        meshes: vec![random.soup(60, 0.5)],
        instances: Vec::new(),
        moving: random.soup(10, 0.4),
    };
    for _ in 0..20 {
        let map = random.map();
        scene.place(0, map);
    }
    let mut bvh = scene.instanced();
    let still_count = 12;
    for step in 0..4 {
        for instance in &mut scene.instances[still_count..] {
            instance.world_from_object = random.map();
        }
        scene.moving = random.soup(10 * step, 0.4);
        bvh.place_instances(still_count, &scene.instances);
        bvh.rebuild_after(50, &[&scene.static_triangles[..], &scene.moving].concat());
        let flattened = scene.flattened();
        assert_eq!(bvh.bounds(), flattened.bounds());
        for _ in 0..100 {
            let ray = random.ray();
            assert_eq!(all_hits(&bvh, &ray), all_hits(&flattened, &ray));
        }
    }
    // None at all are none.
    bvh.place_instances(0, &[]);
    let ray = random.ray();
    let own = |hits: Vec<Hit>| hits.into_iter().map(|hit| hit.t).collect::<Vec<_>>();
    let stored = [&scene.static_triangles[..], &scene.moving].concat();
    assert_eq!(own(all_hits(&bvh, &ray)), own(all_hits(&Bvh::build(&stored), &ray)));
}

/// Where the rays of the tests begin.
const REGION: [Vec3; 2] = [Vec3::splat(-8.0), Vec3::splat(8.0)];
/// Bytes that never keep a list of the tests from being divided.
const PLENTY: usize = 1 << 28;

/// Hits of a buffer in the order in which they are visited.
fn buffer_hits(buffer: &LightBuffer, ray: &Ray) -> Vec<Hit> {
    let mut hits = Vec::new();
    let is_served = buffer.traverse(ray, |hit| {
        hits.push(hit);
        ray.t_max
    });
    assert!(is_served, "{ray:?}");
    hits
}

/// The same by triangle.
fn sorted_buffer_hits(buffer: &LightBuffer, ray: &Ray) -> Vec<Hit> {
    let mut hits = buffer_hits(buffer, ray);
    hits.sort_by_key(|hit| hit.triangle);
    hits
}

/// Directions of all kinds: along axes, in planes of two, and any.
fn directions(random: &mut Random) -> Vec<Vec3> {
    let mut directions = vec![Vec3::X, Vec3::NEG_Y, vec3(1.0, 0.0, 1.0), vec3(0.0, -1.0, 1e-7)];
    directions.extend((0..4).map(|_| random.point() * random.unit().exp2()));
    directions
}

/// A point of a triangle: a corner, on an edge, or inside.
fn point_of(random: &mut Random, [a, b, c]: Triangle) -> Vec3 {
    let along = (random.unit() * 3.0 - 1.0).clamp(0.0, 1.0);
    let inwards = (random.unit() * 2.0 - 1.0).max(0.0);
    a.lerp(b, along).lerp(c, inwards)
}

#[test]
fn a_light_buffer_gives_the_hits_of_a_tree() {
    let mut random = Random(30 << 16);
    let mut large_and_small = random.soup(600, 0.01);
    large_and_small.extend(random.soup(60, 2.0));
    // Far beyond where rays begin.
    large_and_small.extend(random.soup(20, 3000.0));
    let soups = [
        random.soup(5, 1.0),
        random.soup(700, 0.15),
        random.soup(2500, 0.3),
        large_and_small,
        icosphere(3, Vec3::ZERO, 0.8),
        height_field(&mut random, 20),
        Vec::new(),
    ];
    let mut found = 0;
    for (soup, direction) in
        soups.iter().flat_map(|soup| directions(&mut Random(31)).into_iter().map(move |d| (soup, d)))
    {
        // Elsewhere and in another unit, too: what is rounded there, bounds have to cover.
        for (unit, offset) in [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (100.0, vec3(1e5, -3e5, 2e5))] {
            let to_world = |p: Vec3| p * unit + offset;
            let triangles: Vec<Triangle> = soup.iter().map(|triangle| triangle.map(to_world)).collect();
            let bvh = Bvh::build(&triangles);
            let is_opaque = |triangle: u32| triangle.is_multiple_of(3);
            let region = REGION.map(to_world);
            let build = |bytes| LightBuffer::build(&triangles, 0, is_opaque, direction, region, bytes);
            let buffer = build(PLENTY).unwrap();
            for _ in 0..40 {
                let mut origin = to_world(random.point() * 1.5);
                // Most go through corners, edges, or points of triangles, where they begin there.
                if !triangles.is_empty() && !random.bits().is_multiple_of(4) {
                    let triangle = triangles[random.bits() as usize % triangles.len()];
                    let back = direction * (unit * random.unit());
                    let through = point_of(&mut random, triangle) - back;
                    if (region[0].cmple(through) & through.cmple(region[1])).all() {
                        origin = through;
                    }
                }
                let t_min = [0.0, -1.0, 0.1 * unit][random.bits() as usize % 3];
                let t_max = [unit * (1.0 + random.unit()), f32::INFINITY][random.bits() as usize % 2];
                let ray = Ray { origin, direction, t_min, t_max };
                let expected = all_hits(&bvh, &ray);
                found += expected.len();
                for buffer in paths().map(|path| buffer.clone().with_path(path)) {
                    // Opaque ones first; whatever that is, nothing twice.
                    assert!(buffer_hits(&buffer, &ray).is_sorted_by_key(|hit| !is_opaque(hit.triangle)));
                    assert_eq!(sorted_buffer_hits(&buffer, &ray), expected, "{ray:?}");
                }
            }
        }
    }
    assert!(found > 15_000, "{found} hits");
}

#[test]
fn a_light_buffer_misses_no_triangle_that_is_seen_from_its_edge() {
    let mut random = Random(34 << 16);
    let directions = [Vec3::Z, vec3(0.3, -0.2, 1.0), vec3(1.0, 0.7, -0.9)];
    let mut found = 0;
    for direction in directions {
        // Needles and slivers along the rays, about as thin as rounding: which way their corners turn in the
        // plane across is chance.
        let triangles: Vec<Triangle> = (0..1500)
            .map(|_| {
                let (a, b) = (random.point(), random.point());
                let c = a.lerp(b, (2.0 * random.unit()).min(1.0)) + direction * (random.unit() - 0.5);
                [a, b, c + random.point() * (1e-7 * (16.0 * random.unit()).exp2())]
            })
            .collect();
        let bvh = Bvh::build(&triangles);
        let buffer = LightBuffer::build(&triangles, 0, |_| false, direction, REGION, PLENTY).unwrap();
        for &triangle in &triangles {
            let origin = point_of(&mut random, triangle) - direction * (3.0 * random.unit());
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
            let expected = all_hits(&bvh, &ray);
            found += expected.len();
            assert_eq!(sorted_buffer_hits(&buffer, &ray), expected, "{ray:?}");
        }
    }
    assert!(found > 100, "{found} hits");
}

#[test]
fn a_light_buffer_serves_one_direction_and_one_region() {
    let mut random = Random(32 << 16);
    let triangles = random.soup(700, 0.15);
    let build = |direction, region| LightBuffer::build(&triangles, 0, |_| false, direction, region, PLENTY);
    let buffer = build(Vec3::Z, REGION).unwrap();
    let ray = |origin, direction| Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
    let serves = |ray| buffer.traverse(&ray, |_| f32::INFINITY);
    assert!(serves(ray(Vec3::ZERO, Vec3::Z)) && serves(ray(Vec3::splat(8.0), Vec3::Z)));
    assert!(!serves(ray(Vec3::ZERO, vec3(1e-6, 0.0, 1.0))) && !serves(ray(Vec3::ZERO, 2.0 * Vec3::Z)));
    assert!(!serves(ray(Vec3::splat(8.1), Vec3::Z)) && !serves(ray(Vec3::NAN, Vec3::Z)));
    assert!(!serves(ray(Vec3::ZERO, Vec3::NAN)));
    assert!(build(Vec3::ZERO, REGION).is_none() && build(Vec3::NAN, REGION).is_none());
    assert!(build(Vec3::Z, [Vec3::NEG_INFINITY, Vec3::INFINITY]).is_none());
    let nowhere = LightBuffer::build(&[], 0, |_| false, Vec3::Z, [Vec3::ZERO; 2], PLENTY);
    assert!(nowhere.is_none());

    // The comparison of hits is not blind: those of another direction differ wherever there are some.
    let bvh = Bvh::build(&triangles);
    let (mut met, mut differ) = (0, 0);
    for origin in (0..200).map(|_| random.point()) {
        let expected = all_hits(&bvh, &ray(origin, vec3(0.02, 0.0, 1.0)));
        met += usize::from(!expected.is_empty());
        let other = sorted_buffer_hits(&buffer, &ray(origin, Vec3::Z));
        differ += usize::from(!expected.is_empty() && other != expected);
    }
    assert!(met > 50 && differ == met, "{differ} of {met}");
}

#[test]
fn a_light_buffer_goes_from_the_light_to_the_point_and_stops_when_told() {
    // Sheets across the rays, in no order.
    let sheet = |height: f32| [vec3(-1.0, height, -1.0), vec3(1.0, height, -1.0), vec3(0.0, height, 1.0)];
    let heights = [0.5, -0.2, 0.9, 0.1, 0.7, 0.3, -0.5, 0.8, 0.2, 0.6, 0.4];
    let triangles = heights.map(sheet);
    let is_opaque = |triangle: u32| triangle == 104 || triangle == 109;
    let buffer = LightBuffer::build(&triangles, 100, is_opaque, Vec3::Y, REGION, PLENTY).unwrap();
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Y, t_min: 0.0, t_max: f32::INFINITY };
    let visited = |most: usize| {
        let mut numbers = Vec::new();
        buffer.traverse(&ray, |hit| {
            numbers.push(hit.triangle);
            if numbers.len() == most { f32::NEG_INFINITY } else { f32::INFINITY }
        });
        numbers
    };
    let order = [104, 109, 102, 107, 100, 110, 105, 108, 103];
    assert_eq!(visited(usize::MAX), order);
    assert_eq!(visited(4), order[..4]);
}

#[test]
fn a_light_buffer_keeps_to_its_memory_and_does_not_depend_on_threads() {
    let mut random = Random(33 << 16);
    // Thin ones across everything are in the most cells.
    let mut triangles = random.soup(12_000, 0.2);
    for triangle in &mut triangles[..4000] {
        triangle[2] = triangle[1] + Vec3::splat(1e-4);
        triangle[1] = random.point();
    }
    let direction = vec3(0.3, -1.0, 0.2);
    let build = |threads: usize, bytes: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| LightBuffer::build(&triangles, 0, |_| false, direction, REGION, bytes))
    };
    let bvh = Bvh::build(&triangles);
    let rays: Vec<Ray> = (0..100)
        .map(|_| Ray { origin: random.point(), direction, t_min: 0.0, t_max: f32::INFINITY })
        .collect();
    let mut least = usize::MAX;
    for bytes in [64 << 20, 8 << 20, 2 << 20] {
        let (one, two) = (build(1, bytes).unwrap(), build(2, bytes).unwrap());
        // With less memory lists are longer, and hits are the same.
        assert!(one.bytes() <= bytes && one.bytes() < least, "{} of {bytes}", one.bytes());
        assert_eq!(one.bytes(), two.bytes());
        least = one.bytes();
        for ray in &rays {
            assert_eq!(buffer_hits(&one, ray), buffer_hits(&two, ray));
            assert_eq!(sorted_buffer_hits(&one, ray), all_hits(&bvh, ray));
        }
    }
    assert!(build(1, 1 << 19).is_none(), "not even a single list has room");
}

#[test]
fn what_is_kept_is_found_by_itself() {
    let mut random = Random(35 << 16);
    let mut triangles = random.soup(900, 0.2);
    let mut bvh = Bvh::build(&triangles[..400]);
    bvh.rebuild_after(400, &triangles);
    triangles.truncate(400);
    let kept = Bvh::build(&triangles);
    let mut differ = 0;
    for ray in (0..200).map(|_| random.ray()) {
        let mut hits = Vec::new();
        bvh.traverse_kept(&ray, |hit| {
            hits.push(hit);
            ray.t_max
        });
        hits.sort_by_key(|hit| hit.triangle);
        assert_eq!(hits, all_hits(&kept, &ray));
        differ += usize::from(hits != all_hits(&bvh, &ray));
    }
    assert!(differ > 50, "{differ}: all of the tree has more");
}
