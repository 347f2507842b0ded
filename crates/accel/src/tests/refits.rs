//! Trees that follow their triangles, against trees that are built anew each frame.

use glam::{Quat, Vec3};

use super::{Random, Triangle, all_hits, on_each_path};
use crate::{Bvh, Hit};

/// A cloud of small triangles, each with a velocity of its own, that live and die; now and then one shrinks
/// to a point, or leaves the range of coordinates, and comes back.
struct Cloud {
    random: Random,
    still: Vec<Triangle>,
    moving: Vec<Mover>,
    next_name: u32,
}

#[derive(Clone, Copy)]
struct Mover {
    name: u32,
    triangle: Triangle,
    velocity: Vec3,
    is_lost: bool,
}

/// What becomes of a cloud from one frame to the next.
#[derive(Clone, Copy)]
struct Pace {
    /// How far a triangle moves.
    step: f32,
    /// One in so many dies, and as many are born.
    turnover: usize,
    /// One in so many is degenerate or out of range.
    lost: u32,
}

impl Cloud {
    fn new(seed: u32, still: usize, moving: usize) -> Self {
        let mut random = Random(seed << 16);
        let still = random.soup(still, 0.1).into_iter().take(still).collect();
        let mut cloud = Self { random, still, moving: Vec::new(), next_name: 0 };
        (0..moving).for_each(|_| cloud.bear());
        cloud
    }

    fn bear(&mut self) {
        let random = &mut self.random;
        let centre = random.point();
        let triangle = [0, 1, 2].map(|_| centre + random.point() * 0.1);
        self.moving.push(Mover { name: self.next_name, triangle, velocity: random.point(), is_lost: false });
        self.next_name += 1;
    }

    /// Moves on; says of each triangle that moved before which place it has now.
    fn advance(&mut self, pace: Pace) -> Vec<u32> {
        let before: Vec<u32> = self.moving.iter().map(|mover| mover.name).collect();
        let deaths = self.moving.len().div_ceil(pace.turnover);
        for _ in 0..deaths.min(self.moving.len()) {
            let place = self.random.bits() as usize % self.moving.len();
            self.moving.remove(place);
        }
        (0..deaths).for_each(|_| self.bear());
        for mover in &mut self.moving {
            let shift = mover.velocity * pace.step;
            mover.triangle = mover.triangle.map(|p| p + shift);
            mover.is_lost = self.random.bits().is_multiple_of(pace.lost);
        }
        let place = |name: u32| self.moving.binary_search_by_key(&name, |mover| mover.name);
        before.into_iter().map(|name| place(name).map_or(u32::MAX, |place| place as u32)).collect()
    }

    fn triangles(&self) -> Vec<Triangle> {
        let lose = |[a, b, c]: Triangle, name: u32| match name % 3 {
            0 => [a, a, c],
            1 => [a, b * 1e30, c],
            _ => [b, b, b],
        };
        let seen =
            |mover: &Mover| if mover.is_lost { lose(mover.triangle, mover.name) } else { mover.triangle };
        self.still.iter().copied().chain(self.moving.iter().map(seen)).collect()
    }
}

/// Whether two trees give the same hits to the same questions, on each path, asked by rays alone and
/// together.
fn answer_alike(a: &Bvh, b: &Bvh, random: &mut Random) -> bool {
    let accept = |hit: &Hit| hit.triangle.wrapping_mul(0x9e37_79b9) >> 30 != 0;
    let rays: Vec<_> = (0..16).map(|_| random.ray()).collect();
    on_each_path(a).zip(on_each_path(b)).all(|(a, b)| {
        let (mut of_a, mut of_b) = (Vec::new(), Vec::new());
        a.closest_of_packet(&rays, |_, hit| accept(hit), &mut of_a);
        b.closest_of_packet(&rays, |_, hit| accept(hit), &mut of_b);
        of_a == of_b
            && rays.iter().all(|ray| {
                all_hits(&a, ray) == all_hits(&b, ray)
                    && a.closest(ray, |_| true) == b.closest(ray, |_| true)
                    && a.closest(ray, accept) == b.closest(ray, accept)
                    && a.any(ray, |hit| !accept(hit)) == b.any(ray, |hit| !accept(hit))
            })
    })
}

#[test]
fn a_tree_that_follows_its_triangles_gives_the_hits_of_a_new_one() {
    let calm = Pace { step: 0.005, turnover: 400, lost: 400 };
    let lively = Pace { step: 0.05, turnover: 20, lost: 5 };
    // How often the tree was kept; once it is kept however bad it becomes.
    let mut kept = [0; 3];
    let mut frame_count = 0;
    for (seed, still, moving, frames) in
        [(1, 0, 900, 20), (2, 700, 900, 20), (3, 40, 9, 12), (4, 3, 1, 8), (5, 0, 6000, 5), (6, 5000, 40, 5)]
    {
        frame_count += frames;
        for (which, pace) in [calm, lively, lively].into_iter().enumerate() {
            let mut cloud = Cloud::new(seed + 100, still, moving);
            let mut bvh = Bvh::build(&cloud.still);
            bvh.rebuild_after(still, &cloud.triangles());
            for frame in 0..frames {
                if which == 2 {
                    bvh.stop_watching();
                }
                let successors = cloud.advance(pace);
                let triangles = cloud.triangles();
                kept[which] += u32::from(bvh.refit_after(still, &triangles, &successors));
                bvh.validate(&triangles)
                    .unwrap_or_else(|error| panic!("seed {seed}, frame {frame}: {error}"));
                let new = Bvh::build(&triangles);
                assert!(answer_alike(&bvh, &new, &mut cloud.random), "seed {seed}, frame {frame}");
            }
        }
    }
    // Both ways were gone. A tree of which nothing is left at times has to be built anew, watched or not.
    assert!(kept[0] > 30 && kept[1] < 10 && kept[2] > frame_count - 20, "{kept:?} of {frame_count}");
}

/// The negative control of the test above: hits that are a frame old are told from those of a new tree.
#[test]
fn a_tree_that_has_not_followed_is_found_out() {
    let mut cloud = Cloud::new(120, 300, 900);
    let stale = Bvh::build(&cloud.triangles());
    cloud.advance(Pace { step: 0.005, turnover: 900, lost: 900 });
    let triangles = cloud.triangles();
    assert!(stale.validate(&triangles).is_err());
    assert!(!answer_alike(&stale, &Bvh::build(&triangles), &mut cloud.random));
}

#[test]
fn what_is_said_of_successors_does_not_change_a_hit() {
    let mut cloud = Cloud::new(130, 100, 800);
    let mut random = Random(9);
    for trial in 0..8 {
        let mut bvh = Bvh::build(&cloud.still);
        bvh.rebuild_after(cloud.still.len(), &cloud.triangles());
        cloud.advance(Pace { step: 0.02, turnover: 100, lost: 20 });
        // Any places, some of nothing, as long as they ascend.
        let mut successors: Vec<u32> =
            (0..1000).filter(|_| !random.bits().is_multiple_of(5)).take(800).collect();
        successors.resize(800, u32::MAX);
        successors.swap(7, 700);
        assert!(!bvh.refit_after(cloud.still.len(), &cloud.triangles(), &successors), "they do not ascend");
        successors.swap(7, 700);
        bvh.stop_watching();
        let triangles = cloud.triangles();
        assert!(bvh.refit_after(cloud.still.len(), &triangles, &successors));
        bvh.validate(&triangles).unwrap();
        assert!(answer_alike(&bvh, &Bvh::build(&triangles), &mut random), "trial {trial}");
        // Lists that do not fit: of another length, or for another static part.
        assert!(!bvh.refit_after(cloud.still.len(), &triangles, &successors[1..]));
        assert!(!bvh.refit_after(50, &triangles, &successors));
        bvh.validate(&triangles).unwrap();
        assert!(!bvh.refit_after(5000, &triangles, &successors));
        bvh.validate(&triangles).unwrap();
    }
}

#[test]
fn all_that_moves_may_vanish_and_come_back() {
    let mut cloud = Cloud::new(140, 200, 300);
    let all = cloud.triangles();
    let mut bvh = Bvh::build(&cloud.still);
    let mut before = 0;
    for count in [300, 0, 0, 300, 1, 0, 7] {
        let triangles = &all[..200 + count];
        let successors: Vec<u32> = (0..before).collect();
        bvh.refit_after(200, triangles, &successors);
        bvh.validate(triangles).unwrap();
        assert!(answer_alike(&bvh, &Bvh::build(triangles), &mut cloud.random), "{count}");
        before = count as u32;
    }
    // None is left that is no point and within range.
    cloud.moving.truncate(7);
    cloud.moving.iter_mut().for_each(|mover| mover.is_lost = true);
    for _ in 0..2 {
        bvh.refit_after(200, &cloud.triangles(), &[0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(bvh.validate(&cloud.triangles()).unwrap().triangle_count, 200);
    }
    cloud.moving.iter_mut().for_each(|mover| mover.is_lost = false);
    bvh.refit_after(200, &cloud.triangles(), &[0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(bvh.validate(&cloud.triangles()).unwrap().triangle_count, 207);
}

/// Cost of a tree through which a vortex has stirred its triangles, relative to a new one, by frame.
fn cost_in_a_vortex(is_watched: bool) -> Vec<f64> {
    let mut cloud = Cloud::new(150, 0, 4000);
    let mut bvh = Bvh::build(&[]);
    bvh.rebuild_after(0, &cloud.triangles());
    let names: Vec<u32> = (0..4000).collect();
    (0..60)
        .map(|_| {
            for mover in &mut cloud.moving {
                let [a, b, c] = mover.triangle;
                let centre = (a + b + c) / 3.0;
                let turn = Quat::from_rotation_y(0.1 / (0.2 + centre.length_squared()));
                mover.triangle = mover.triangle.map(|p| p + turn * centre - centre);
            }
            let triangles = cloud.triangles();
            if !is_watched {
                bvh.stop_watching();
            }
            bvh.refit_after(0, &triangles, &names);
            let new = Bvh::build(&triangles).validate(&triangles).unwrap();
            bvh.validate(&triangles).unwrap().sah_cost / new.sah_cost
        })
        .collect()
}

#[test]
fn a_tree_is_built_anew_before_it_costs_much_to_trace_through() {
    let most = |cost: &[f64]| cost.iter().copied().fold(0.0, f64::max);
    // The bound, and what the joint of the parts may add to it.
    let watched = cost_in_a_vortex(true);
    assert!(most(&watched) < 1.15, "{watched:?}");
    // It does go down again, and is not held there by building each frame.
    let rebuilt = watched.windows(2).filter(|pair| pair[1] < pair[0] - 0.02).count();
    assert!((1..30).contains(&rebuilt), "{rebuilt}: {watched:?}");
    // The negative control: without the watch it costs much.
    let unwatched = cost_in_a_vortex(false);
    assert!(most(&unwatched) > 1.5, "{unwatched:?}");
}

#[test]
fn one_and_two_threads_refit_the_same_tree() {
    let refitted = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut cloud = Cloud::new(160, 500, 9000);
            let mut bvh = Bvh::build(&cloud.still);
            bvh.rebuild_after(500, &cloud.triangles());
            let successors = cloud.advance(Pace { step: 0.005, turnover: 300, lost: 100 });
            assert!(bvh.refit_after(500, &cloud.triangles(), &successors));
            format!("{:?}", bvh.tree())
        })
    };
    assert!(refitted(1) == refitted(2));
}
