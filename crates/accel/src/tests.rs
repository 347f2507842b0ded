//! The tree against brute force, on every path, and on input meant to break it.

use glam::{Vec3, vec3};

use crate::node::Child;
use crate::{AccelError, Bvh, Hit, PackedTree, Ray, SimdPath};

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
