//! Coherent rays together: those of a tile of pixels, the samples of a pixel, rays towards one light.
//!
//! A packet descends the tree once, as in Wald et al., *Interactive Rendering with Coherent Ray Tracing*
//! (Eurographics 2001). A node's eight boxes are held against the frustum around all of its rays (Reshetov et
//! al., *Multi-Level Ray Tracing Algorithm*, SIGGRAPH 2005), a leaf's eight triangles likewise, then each of
//! those left against the frusta of eight groups of eight rays, and only then rays against the triangle,
//! eight at a time. What grows with the number of rays is the last step alone.
//!
//! A frustum is intervals: of origins, of the slopes by which [`Shear`] tilts vertices, and of depths along
//! the dominant axis (Boulos, Wald and Shirley, *Geometric and Arithmetic Culling Methods for Entire Ray
//! Packets*, 2006). Each bound is found by the very operations of the triangle test, and rounding is
//! monotonic: where the interval of a sheared coordinate does not hold 0, no ray of the packet has a vertex
//! on the other side, to the last bit. So culling needs no slack, and hits are those of single rays. Depths
//! alone have one, for a hit's `t` is a weighted sum. Rays with one origin, one direction, or neither differ
//! in the width of intervals only.
//!
//! The alternative, to test each box with the first ray that is still alive (Overbeck, Ramamoorthi and Mark,
//! *Large Ray Packets for Real-time Whitted Ray Tracing*, 2008), bears less coherent rays, and costs
//! each node some rays.

use glam::Vec3;

use crate::instance::TopLevel;
use crate::limits::{COORDINATE_LIMIT, LEAST_SPEED, SPEED_LIMIT};
use crate::node::{Block, Node, WIDTH};
use crate::placement::{InWorld, Placement};
use crate::ray::{Hit, Ray};
use crate::simd::lanes::Lanes;
use crate::simd::stack::{Slots, Stack};
use crate::traverse::{Areas, LaneHits, Shear};
use crate::tree::Tree;

/// Rays that descend together.
pub(crate) const RAYS: usize = 64;
/// Groups of as many rays as there are lanes; as many groups as lanes, so that all are one register.
const GROUPS: usize = RAYS / WIDTH;
/// Up to so many groups a triangle is held against their rays at once.
const FEW_GROUPS: usize = 2;

/// Relative slack of depths: 32 roundings, where a hit's `t` takes eight.
const SLACK: f32 = 1.0 / (1 << 19) as f32;

/// Numbers of eight rays, eight groups or eight triangles.
type Row = [f32; WIDTH];

/// Visits every hit of each ray whose `t` lies in `[t_min, t_max]` at that time; `visit` gets the ray's index
/// and returns its new `t_max`.
#[inline(always)]
pub(crate) fn traverse<L: Lanes>(
    lanes: L,
    tree: Tree<'_>,
    rays: &[Ray],
    mut visit: impl FnMut(usize, Hit) -> f32,
) {
    let mut packet = Packet::EMPTY;
    let mut first = 0;
    for rays in rays.chunks(RAYS) {
        let rows = Rows::new(rays);
        for class in rows.classes(lanes) {
            if packet.fill(lanes, &rows, class, first) {
                packet.walk(lanes, tree, &InWorld, &mut visit);
            }
        }
        first += RAYS;
    }
}

/// The same through a tree and the instances beside it, near ones first.
#[inline(always)]
pub(crate) fn traverse_two_levels<L: Lanes>(
    lanes: L,
    tree: Tree<'_>,
    top: &TopLevel,
    rays: &[Ray],
    visit: &mut dyn FnMut(usize, Hit) -> f32,
) {
    let boxes = top.tree();
    let mut packet = Packet::EMPTY;
    let mut first = 0;
    for rays in rays.chunks(RAYS) {
        let rows = Rows::new(rays);
        for class in rows.classes(lanes) {
            if !packet.fill(lanes, &rows, class, first) {
                continue;
            }
            packet.walk(lanes, tree, &InWorld, visit);
            let Some(root) = boxes.root else { continue };
            let mut slots = Slots::new();
            let mut stack = Stack::new(&mut slots);
            stack.push(0.0, root);
            while let Some((near, child)) = stack.pop() {
                if near > packet.end {
                    continue;
                }
                if child.is_block() {
                    let (mesh, placed) = top.instance(child.index());
                    packet.walk(lanes, mesh, placed, visit);
                    continue;
                }
                let node = &boxes.nodes[child.index()];
                let (near, entered) = packet.enter(lanes, &InWorld, node);
                if entered != 0 {
                    lanes.push(&mut stack, near, entered, &node.children);
                }
            }
        }
        first += RAYS;
    }
}

/// Up to 64 rays, one in each lane of eight rows; lanes without one repeat the first, and hit nothing.
struct Rows {
    len: usize,
    origin: [[Row; GROUPS]; 3],
    direction: [[Row; GROUPS]; 3],
    t_min: [Row; GROUPS],
    t_max: [Row; GROUPS],
}

impl Rows {
    /// The rays of a chunk, of which there is one at least.
    #[inline(always)]
    fn new(rays: &[Ray]) -> Self {
        let mut rows = Self {
            len: rays.len(),
            origin: [[[0.0; WIDTH]; GROUPS]; 3],
            direction: [[[0.0; WIDTH]; GROUPS]; 3],
            t_min: [[0.0; WIDTH]; GROUPS],
            t_max: [[0.0; WIDTH]; GROUPS],
        };
        for (place, ray) in rays.iter().enumerate() {
            rows.set(place, ray);
        }
        let filler = Ray { t_max: f32::NEG_INFINITY, ..rays[0] };
        for place in rays.len()..RAYS {
            rows.set(place, &filler);
        }
        rows
    }

    #[inline(always)]
    fn set(&mut self, place: usize, ray: &Ray) {
        let (group, lane) = (place / WIDTH % GROUPS, place % WIDTH);
        for axis in 0..3 {
            self.origin[axis][group][lane] = ray.origin[axis];
            self.direction[axis][group][lane] = ray.direction[axis];
        }
        self.t_min[group][lane] = ray.t_min;
        self.t_max[group][lane] = ray.t_max;
    }

    #[inline(always)]
    fn ray(&self, place: usize) -> Ray {
        let (group, lane) = (place / WIDTH % GROUPS, place % WIDTH);
        let vector = |rows: &[[Row; GROUPS]; 3]| {
            Vec3::new(rows[0][group][lane], rows[1][group][lane], rows[2][group][lane])
        };
        Ray {
            origin: vector(&self.origin),
            direction: vector(&self.direction),
            t_min: self.t_min[group][lane],
            t_max: self.t_max[group][lane],
        }
    }

    /// The rays that are within the ranges that [`Ray`] names, one bit each, by what [`Shear::axes`] gives
    /// them: the dominant axis and, of each, the two directions.
    #[inline(always)]
    fn classes<L: Lanes>(&self, lanes: L) -> [u64; 6] {
        let (origin_limit, speed_limit) = (lanes.splat(COORDINATE_LIMIT), lanes.splat(SPEED_LIMIT));
        let (least_speed, zero) = (lanes.splat(LEAST_SPEED), lanes.splat(0.0));
        let mut classes = [0; 6];
        for group in 0..self.len.div_ceil(WIDTH) {
            let [x, y, z] = load_group(lanes, &self.direction, group);
            let speed = [abs(lanes, x), abs(lanes, y), abs(lanes, z)];
            let [a, b, c] = load_group(lanes, &self.origin, group);
            let near = lanes.le(abs(lanes, a), origin_limit)
                & lanes.le(abs(lanes, b), origin_limit)
                & lanes.le(abs(lanes, c), origin_limit);
            let slow = lanes.le(speed[0], speed_limit)
                & lanes.le(speed[1], speed_limit)
                & lanes.le(speed[2], speed_limit);
            let fastest = lanes.max(lanes.max(speed[0], speed[1]), speed[2]);
            let in_range = near & slow & lanes.le(least_speed, fastest);
            let x_dominates = lanes.le(speed[1], speed[0]) & lanes.le(speed[2], speed[0]);
            let y_dominates = lanes.le(speed[2], speed[1]) & !x_dominates;
            let dominates = [x_dominates, y_dominates, !(x_dominates | y_dominates)];
            let backwards = [lanes.lt(x, zero), lanes.lt(y, zero), lanes.lt(z, zero)];
            for axis in 0..3 {
                let rays = in_range & dominates[axis];
                classes[2 * axis] |= u64::from(rays & !backwards[axis]) << (group * WIDTH);
                classes[2 * axis + 1] |= u64::from(rays & backwards[axis]) << (group * WIDTH);
            }
        }
        // Beyond the last ray there are only repetitions.
        let used = u64::MAX >> (RAYS - self.len);
        for class in &mut classes {
            *class &= used;
        }
        classes
    }
}

/// Intervals of eight lanes.
#[derive(Clone, Copy)]
struct Intervals {
    low: Row,
    high: Row,
}

impl Intervals {
    const EMPTY: Self = Self { low: [f32::INFINITY; WIDTH], high: [f32::NEG_INFINITY; WIDTH] };

    /// The intervals of eight groups of eight numbers.
    #[inline(always)]
    fn of_groups<L: Lanes>(lanes: L, rows: &[Row; GROUPS]) -> Self {
        let [first, rest @ ..] = transposed(lanes, rows);
        let (mut low, mut high) = (first, first);
        for column in rest {
            low = lanes.min(low, column);
            high = lanes.max(high, column);
        }
        Self { low: lanes.store(low), high: lanes.store(high) }
    }

    /// The interval around all lanes, in each lane.
    #[inline(always)]
    fn union(&self) -> Self {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for lane in 0..WIDTH {
            low = low.min(self.low[lane]);
            high = high.max(self.high[lane]);
        }
        Self { low: [low; WIDTH], high: [high; WIDTH] }
    }

    #[inline(always)]
    fn load<L: Lanes>(&self, lanes: L) -> Span<L::F> {
        Span { low: lanes.load(&self.low), high: lanes.load(&self.high) }
    }
}

/// Eight intervals in registers.
#[derive(Clone, Copy)]
struct Span<F> {
    low: F,
    high: F,
}

impl<F: Copy> Span<F> {
    /// A coordinate relative to any of the origins.
    #[inline(always)]
    fn from_origin<L: Lanes<F = F>>(lanes: L, low: F, high: F, origin: Self) -> Self {
        Self { low: lanes.sub(low, origin.high), high: lanes.sub(high, origin.low) }
    }

    /// A coordinate in the sheared plane, of points between these along an axis and along the dominant one.
    #[inline(always)]
    fn sheared<L: Lanes<F = F>>(self, lanes: L, z: Self, slope: Self) -> Self {
        let shifts = [
            lanes.mul(z.low, slope.low),
            lanes.mul(z.low, slope.high),
            lanes.mul(z.high, slope.low),
            lanes.mul(z.high, slope.high),
        ];
        let most = lanes.max(lanes.max(shifts[0], shifts[1]), lanes.max(shifts[2], shifts[3]));
        let least = lanes.min(lanes.min(shifts[0], shifts[1]), lanes.min(shifts[2], shifts[3]));
        Self { low: lanes.sub(self.low, most), high: lanes.sub(self.high, least) }
    }

    /// The same of one point.
    #[inline(always)]
    fn sheared_point<L: Lanes<F = F>>(lanes: L, x: F, z: F, slope: Self) -> Self {
        let shifts = [lanes.mul(z, slope.low), lanes.mul(z, slope.high)];
        Self {
            low: lanes.sub(x, lanes.max(shifts[0], shifts[1])),
            high: lanes.sub(x, lanes.min(shifts[0], shifts[1])),
        }
    }

    /// Around three intervals.
    #[inline(always)]
    fn around<L: Lanes<F = F>>(lanes: L, [a, b, c]: [Self; 3]) -> Self {
        Self {
            low: lanes.min(lanes.min(a.low, b.low), c.low),
            high: lanes.max(lanes.max(a.high, b.high), c.high),
        }
    }
}

/// Eight frusta: what eight sets of rays may meet. Axes are those of the packet.
struct Frusta {
    origin: [Intervals; 3],
    slope: [Intervals; 2],
    /// From the nearest beginning to the furthest end of a ray, along the dominant axis, relative to its
    /// origin.
    depth: Intervals,
}

impl Frusta {
    const EMPTY: Self =
        Self { origin: [Intervals::EMPTY; 3], slope: [Intervals::EMPTY; 2], depth: Intervals::EMPTY };

    /// Lanes where something is in reach, from where it is seen in the sheared plane and how deep it lies. A
    /// lane of NaN is not.
    #[inline(always)]
    fn reach<L: Lanes>(&self, lanes: L, x: Span<L::F>, y: Span<L::F>, z: Span<L::F>) -> u32 {
        let depth = self.depth.load(lanes);
        let (before, behind) = (lanes.sub(z.low, depth.high), lanes.sub(z.high, depth.low));
        let low = lanes.max(lanes.max(x.low, y.low), before);
        let high = lanes.min(lanes.min(x.high, y.high), behind);
        let zero = lanes.splat(0.0);
        lanes.le(low, zero) & lanes.le(zero, high)
    }

    /// Lanes where a triangle is in reach: eight triangles and one frustum, or one triangle and eight frusta.
    /// Vertices that share their origin with all rays are relative to it.
    #[inline(always)]
    fn reach_triangles<L: Lanes>(&self, lanes: L, shares_origin: bool, [x, y, z]: [[L::F; 3]; 3]) -> u32 {
        let slopes = [self.slope[0].load(lanes), self.slope[1].load(lanes)];
        let spans = if shares_origin {
            [
                [
                    Span::sheared_point(lanes, x[0], z[0], slopes[0]),
                    Span::sheared_point(lanes, x[1], z[1], slopes[0]),
                    Span::sheared_point(lanes, x[2], z[2], slopes[0]),
                ],
                [
                    Span::sheared_point(lanes, y[0], z[0], slopes[1]),
                    Span::sheared_point(lanes, y[1], z[1], slopes[1]),
                    Span::sheared_point(lanes, y[2], z[2], slopes[1]),
                ],
                [
                    Span { low: z[0], high: z[0] },
                    Span { low: z[1], high: z[1] },
                    Span { low: z[2], high: z[2] },
                ],
            ]
        } else {
            let z = self.seen_from_origins(lanes, 2, z);
            let (x, y) = (self.seen_from_origins(lanes, 0, x), self.seen_from_origins(lanes, 1, y));
            [
                [
                    x[0].sheared(lanes, z[0], slopes[0]),
                    x[1].sheared(lanes, z[1], slopes[0]),
                    x[2].sheared(lanes, z[2], slopes[0]),
                ],
                [
                    y[0].sheared(lanes, z[0], slopes[1]),
                    y[1].sheared(lanes, z[1], slopes[1]),
                    y[2].sheared(lanes, z[2], slopes[1]),
                ],
                z,
            ]
        };
        let [x, y, z] = spans;
        self.reach(lanes, Span::around(lanes, x), Span::around(lanes, y), Span::around(lanes, z))
    }

    #[inline(always)]
    fn seen_from_origins<L: Lanes>(&self, lanes: L, axis: usize, [a, b, c]: [L::F; 3]) -> [Span<L::F>; 3] {
        let origin = self.origin[axis].load(lanes);
        [
            Span::from_origin(lanes, a, a, origin),
            Span::from_origin(lanes, b, b, origin),
            Span::from_origin(lanes, c, c, origin),
        ]
    }
}

/// Up to 64 rays with one dominant axis, which they follow in one direction; eight consecutive ones are a
/// group.
struct Packet {
    len: usize,
    /// Original axes that become x, y and z.
    axes: [usize; 3],
    /// Whether depths grow along the dominant axis.
    is_forward: bool,
    shares_origin: bool,
    /// The caller's index of each ray.
    index: [usize; RAYS],
    origin: [[Row; GROUPS]; 3],
    /// As [`Shear::slope`].
    slope: [[Row; GROUPS]; 3],
    t_min: [Row; GROUPS],
    t_max: [Row; GROUPS],
    /// Depth for each `t`, rounded up by the slack.
    speed: [Row; GROUPS],
    /// The frustum of each group.
    groups: Frusta,
    /// The frustum of all rays, in each lane.
    whole: Frusta,
    /// Distance along the dominant axis behind which no ray looks for anything any more.
    end: f32,
}

impl Packet {
    const EMPTY: Self = Self {
        len: 0,
        axes: [0; 3],
        is_forward: true,
        shares_origin: true,
        index: [0; RAYS],
        origin: [[[0.0; WIDTH]; GROUPS]; 3],
        slope: [[[0.0; WIDTH]; GROUPS]; 3],
        t_min: [[0.0; WIDTH]; GROUPS],
        t_max: [[0.0; WIDTH]; GROUPS],
        speed: [[0.0; WIDTH]; GROUPS],
        groups: Frusta::EMPTY,
        whole: Frusta::EMPTY,
        end: f32::NEG_INFINITY,
    };

    /// Makes it the packet of those rays that have a bit in `class`, which have their axes in common; false
    /// if there are none. The caller counts the first ray of `rows` as `first`.
    #[inline(always)]
    fn fill<L: Lanes>(&mut self, lanes: L, rows: &Rows, class: u64, first: usize) -> bool {
        if class == 0 {
            return false;
        }
        if class == u64::MAX >> (RAYS - rows.len) {
            for (place, index) in self.index.iter_mut().enumerate() {
                *index = first + place;
            }
            self.fill_rows(lanes, rows);
            return true;
        }
        let mut rays = [rows.ray(class.trailing_zeros() as usize); RAYS];
        let (mut count, mut left) = (0, class);
        while left != 0 {
            let place = left.trailing_zeros() as usize;
            left &= left - 1;
            rays[count % RAYS] = rows.ray(place);
            self.index[count % RAYS] = first + place;
            count += 1;
        }
        self.fill_rows(lanes, &Rows::new(&rays[..count]));
        true
    }

    /// Fills all but the indices.
    #[inline(always)]
    fn fill_rows<L: Lanes>(&mut self, lanes: L, rows: &Rows) {
        let first = rows.ray(0);
        self.len = rows.len;
        self.axes = Shear::axes(first.direction);
        let [x, y, z] = self.axes;
        self.is_forward = first.direction[z] > 0.0;
        self.origin = [rows.origin[x], rows.origin[y], rows.origin[z]];
        self.t_max = rows.t_max;

        // Each ray by itself. The addition turns -0 into +0, as for single rays; what is subtracted from
        // where a ray begins is for products that leave the range of normal numbers.
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let mut begin = [[0.0; WIDTH]; GROUPS];
        for (group, begin) in begin.iter_mut().enumerate() {
            let along = lanes.load(&rows.direction[z][group]);
            let inverse = lanes.div(one, along);
            let slope = [
                lanes.mul(lanes.load(&rows.direction[x][group]), inverse),
                lanes.mul(lanes.load(&rows.direction[y][group]), inverse),
            ];
            self.slope[0][group] = lanes.store(slope[0]);
            self.slope[1][group] = lanes.store(slope[1]);
            self.slope[2][group] = lanes.store(inverse);
            let speed = abs(lanes, along);
            self.speed[group] = lanes.store(lanes.mul(speed, lanes.splat(1.0 + SLACK)));
            let t_min = lanes.add(lanes.max(lanes.load(&rows.t_min[group]), zero), zero);
            self.t_min[group] = lanes.store(t_min);
            let least = lanes.mul(lanes.mul(t_min, speed), lanes.splat(1.0 - SLACK));
            *begin = lanes.store(lanes.sub(least, lanes.splat(f32::MIN_POSITIVE)));
        }

        // The frusta of the groups.
        self.shares_origin = true;
        for axis in 0..3 {
            self.shares_origin &= is_same(&self.origin[axis]);
        }
        for axis in 0..3 {
            self.groups.origin[axis] = if self.shares_origin {
                let origin = [self.origin[axis][0][0]; WIDTH];
                Intervals { low: origin, high: origin }
            } else {
                Intervals::of_groups(lanes, &self.origin[axis])
            };
        }
        self.groups.slope =
            [Intervals::of_groups(lanes, &self.slope[0]), Intervals::of_groups(lanes, &self.slope[1])];
        let begin = Intervals::of_groups(lanes, &begin).low;
        self.groups.depth = Intervals::EMPTY;
        for (group, begin) in begin.into_iter().enumerate().take(self.group_count()) {
            if self.is_forward {
                self.groups.depth.low[group] = begin;
            } else {
                self.groups.depth.high[group] = -begin;
            }
            self.shorten_group(group);
        }

        // The frustum of all.
        for axis in 0..3 {
            self.whole.origin[axis] = self.groups.origin[axis].union();
        }
        self.whole.slope = [self.groups.slope[0].union(), self.groups.slope[1].union()];
        self.shorten();
    }

    #[inline(always)]
    fn group_count(&self) -> usize {
        self.len.div_ceil(WIDTH)
    }

    /// Finds where the furthest ray of a group ends.
    #[inline(always)]
    fn shorten_group(&mut self, group: usize) {
        let mut end = f32::NEG_INFINITY;
        for lane in 0..WIDTH {
            end = end.max(self.t_max[group][lane] * self.speed[group][lane]);
        }
        end += f32::MIN_POSITIVE;
        let depth = &mut self.groups.depth;
        if self.is_forward {
            depth.high[group] = end;
        } else {
            depth.low[group] = -end;
        }
    }

    /// Finds where the furthest ray of all ends.
    #[inline(always)]
    fn shorten(&mut self) {
        self.whole.depth = self.groups.depth.union();
        self.end = if self.is_forward { self.whole.depth.high[0] } else { -self.whole.depth.low[0] };
    }

    /// Visits the hits in one tree, placed in the world.
    #[inline(always)]
    fn walk<L: Lanes, P: Placement>(
        &mut self,
        lanes: L,
        tree: Tree<'_>,
        place: &P,
        visit: &mut (impl FnMut(usize, Hit) -> f32 + ?Sized),
    ) {
        let Some(root) = tree.root else { return };
        let mut hits = LaneHits::NONE;
        let mut slots = Slots::new();
        let mut stack = Stack::new(&mut slots);
        stack.push(0.0, root);
        while let Some((near, child)) = stack.pop() {
            if near > self.end {
                continue;
            }
            if let Some(next) = stack.top() {
                tree.prefetch(lanes, next);
            }
            if !child.is_block() {
                let node = &tree.nodes[child.index()];
                let (near, entered) = self.enter(lanes, place, node);
                if entered != 0 {
                    lanes.push(&mut stack, near, entered, &node.children);
                }
                continue;
            }

            let block = &tree.blocks[child.index()];
            let (vertices, mut in_reach) = self.reach_block(lanes, place, block);
            let mut shortened = 0_u32;
            while in_reach != 0 {
                let triangle = in_reach.trailing_zeros() as usize % WIDTH;
                in_reach &= in_reach - 1;
                let mut groups = self.groups_in_reach(lanes, &vertices, triangle);
                while groups != 0 {
                    let group = groups.trailing_zeros() as usize % GROUPS;
                    groups &= groups - 1;
                    if !self.hit(lanes, place, block, &vertices, triangle, group, &mut hits)
                        || !place.keeps(block, triangle)
                    {
                        continue;
                    }
                    let mut waiting = hits.lanes;
                    while waiting != 0 {
                        let lane = waiting.trailing_zeros() as usize % WIDTH;
                        waiting &= waiting - 1;
                        let hit = Hit {
                            t: hits.t[lane],
                            u: hits.u[lane],
                            v: hits.v[lane],
                            triangle: place.number(block.triangles[triangle]),
                            front: hits.front >> lane & 1 != 0,
                        };
                        let t_max = visit(self.index[group * WIDTH + lane], hit);
                        if t_max < self.t_max[group][lane] {
                            self.t_max[group][lane] = t_max;
                            shortened |= 1 << group;
                        }
                    }
                }
            }
            if shortened != 0 {
                while shortened != 0 {
                    self.shorten_group(shortened.trailing_zeros() as usize % GROUPS);
                    shortened &= shortened - 1;
                }
                self.shorten();
            }
        }
    }

    /// Depths at which the packet enters the children's boxes, 0 or more, and the lanes of the boxes that are
    /// in reach.
    #[inline(always)]
    fn enter<L: Lanes, P: Placement>(&self, lanes: L, place: &P, node: &Node) -> (L::F, u32) {
        let x = self.box_from_origins(lanes, place, node, 0);
        let y = self.box_from_origins(lanes, place, node, 1);
        let z = self.box_from_origins(lanes, place, node, 2);
        let seen_x = x.sheared(lanes, z, self.whole.slope[0].load(lanes));
        let seen_y = y.sheared(lanes, z, self.whole.slope[1].load(lanes));
        let zero = lanes.splat(0.0);
        let near = if self.is_forward { z.low } else { lanes.sub(zero, z.high) };
        // The infinite boxes of unused lanes may have become anything.
        let used = lanes.lt(lanes.load(&node.bounds[0]), lanes.splat(f32::INFINITY));
        (lanes.max(near, zero), self.whole.reach(lanes, seen_x, seen_y, z) & used)
    }

    /// The children's boxes along an axis, relative to any of the origins.
    #[inline(always)]
    fn box_from_origins<L: Lanes, P: Placement>(
        &self,
        lanes: L,
        place: &P,
        node: &Node,
        axis: usize,
    ) -> Span<L::F> {
        let row = self.axes[axis];
        let [low, high] = place.slab(lanes, node, row);
        Span::from_origin(lanes, low, high, self.whole.origin[axis].load(lanes))
    }

    /// The vertices of a block's triangles in the axes of the packet, relative to the origin if all rays
    /// share it, and the lanes of the triangles that are in reach.
    #[inline(always)]
    fn reach_block<L: Lanes, P: Placement>(
        &self,
        lanes: L,
        place: &P,
        block: &Block,
    ) -> ([[Row; 3]; 3], u32) {
        let x = self.relative_to_shared_origin(lanes, 0, place.coordinates(lanes, block, self.axes[0]));
        let y = self.relative_to_shared_origin(lanes, 1, place.coordinates(lanes, block, self.axes[1]));
        let z = self.relative_to_shared_origin(lanes, 2, place.coordinates(lanes, block, self.axes[2]));
        let in_reach = self.whole.reach_triangles(lanes, self.shares_origin, [x, y, z]);
        ([store(lanes, x), store(lanes, y), store(lanes, z)], in_reach)
    }

    #[inline(always)]
    fn relative_to_shared_origin<L: Lanes>(&self, lanes: L, axis: usize, [a, b, c]: [L::F; 3]) -> [L::F; 3] {
        if !self.shares_origin {
            return [a, b, c];
        }
        let origin = lanes.splat(self.origin[axis][0][0]);
        [lanes.sub(a, origin), lanes.sub(b, origin), lanes.sub(c, origin)]
    }

    /// Groups that a triangle is in reach of, one bit each.
    #[inline(always)]
    fn groups_in_reach<L: Lanes>(&self, lanes: L, vertices: &[[Row; 3]; 3], triangle: usize) -> u32 {
        if self.group_count() <= FEW_GROUPS {
            return (1 << self.group_count()) - 1;
        }
        let [x, y, z] = vertices;
        let vertices = [splat(lanes, x, triangle), splat(lanes, y, triangle), splat(lanes, z, triangle)];
        self.groups.reach_triangles(lanes, self.shares_origin, vertices)
    }

    /// Writes which rays of a group hit a triangle within their `[t_min, t_max]`; false if none does.
    #[expect(clippy::too_many_arguments, reason = "inlined into the one loop that calls it")]
    #[inline(always)]
    fn hit<L: Lanes, P: Placement>(
        &self,
        lanes: L,
        place: &P,
        block: &Block,
        [x, y, z]: &[[Row; 3]; 3],
        triangle: usize,
        group: usize,
        hits: &mut LaneHits,
    ) -> bool {
        let z = self.relative_to_origins(lanes, 2, group, splat(lanes, z, triangle));
        let x = self.relative_to_origins(lanes, 0, group, splat(lanes, x, triangle));
        let y = self.relative_to_origins(lanes, 1, group, splat(lanes, y, triangle));
        let x = shear(lanes, x, z, lanes.load(&self.slope[0][group]));
        let y = shear(lanes, y, z, lanes.load(&self.slope[1][group]));
        let areas = Areas::new(lanes, x, y);
        let touched = areas.touched(lanes);
        if touched == 0 {
            return false;
        }
        let (front, inside) = areas.sides(lanes);
        let [t, u, v] = areas.solve(lanes, z, lanes.load(&self.slope[2][group]));
        let within =
            lanes.le(lanes.load(&self.t_min[group]), t) & lanes.le(t, lanes.load(&self.t_max[group]));
        hits.lanes = inside & within;
        hits.front = front;
        hits.t = lanes.store(t);
        hits.u = lanes.store(u);
        hits.v = lanes.store(v);
        if touched != inside {
            self.settle(place, block, triangle, group, touched & !inside, hits);
        }
        hits.lanes != 0
    }

    #[inline(always)]
    fn relative_to_origins<L: Lanes>(
        &self,
        lanes: L,
        axis: usize,
        group: usize,
        [a, b, c]: [L::F; 3],
    ) -> [L::F; 3] {
        if self.shares_origin {
            return [a, b, c];
        }
        let origin = lanes.load(&self.origin[axis][group]);
        [lanes.sub(a, origin), lanes.sub(b, origin), lanes.sub(c, origin)]
    }

    /// Adds those of the `unsettled` rays of a group to the hits that do hit the triangle.
    #[cold]
    #[inline(never)]
    fn settle<P: Placement>(
        &self,
        place: &P,
        block: &Block,
        triangle: usize,
        group: usize,
        mut unsettled: u32,
        hits: &mut LaneHits,
    ) {
        while unsettled != 0 {
            let lane = unsettled.trailing_zeros() as usize % WIDTH;
            unsettled &= unsettled - 1;
            let shear = Shear {
                axes: self.axes,
                origin: [0, 1, 2].map(|axis: usize| self.origin[axis][group][lane]),
                slope: [0, 1, 2].map(|axis: usize| self.slope[axis][group][lane]),
            };
            if let Some(hit) = shear.exact(place, block, triangle) {
                hits.add(lane, &hit, self.t_min[group][lane], self.t_max[group][lane]);
            }
        }
    }
}

#[inline(always)]
fn store<L: Lanes>(lanes: L, [a, b, c]: [L::F; 3]) -> [Row; 3] {
    [lanes.store(a), lanes.store(b), lanes.store(c)]
}

/// One coordinate of the three vertices of one triangle, for eight rays.
#[inline(always)]
fn splat<L: Lanes>(lanes: L, [a, b, c]: &[Row; 3], triangle: usize) -> [L::F; 3] {
    [lanes.splat(a[triangle]), lanes.splat(b[triangle]), lanes.splat(c[triangle])]
}

/// One coordinate of three vertices, seen along eight rays.
#[inline(always)]
fn shear<L: Lanes>(lanes: L, x: [L::F; 3], z: [L::F; 3], slope: L::F) -> [L::F; 3] {
    [
        lanes.sub(x[0], lanes.mul(z[0], slope)),
        lanes.sub(x[1], lanes.mul(z[1], slope)),
        lanes.sub(x[2], lanes.mul(z[2], slope)),
    ]
}

#[inline(always)]
fn load_group<L: Lanes>(lanes: L, [x, y, z]: &[[Row; GROUPS]; 3], group: usize) -> [L::F; 3] {
    [lanes.load(&x[group]), lanes.load(&y[group]), lanes.load(&z[group])]
}

#[inline(always)]
fn abs<L: Lanes>(lanes: L, values: L::F) -> L::F {
    lanes.max(values, lanes.sub(lanes.splat(0.0), values))
}

/// Whether all numbers are the same, to the bit.
#[inline(always)]
fn is_same(rows: &[Row; GROUPS]) -> bool {
    let first = rows[0][0].to_bits();
    let mut differing = 0;
    for row in rows {
        for value in row {
            differing |= value.to_bits() ^ first;
        }
    }
    differing == 0
}

/// Row `i` has what lane `i` of each row had.
#[inline(always)]
fn transposed<L: Lanes>(lanes: L, rows: &[Row; GROUPS]) -> [L::F; GROUPS] {
    let [a, b, c, d, e, f, g, h] = rows;
    lanes.transpose([
        lanes.load(a),
        lanes.load(b),
        lanes.load(c),
        lanes.load(d),
        lanes.load(e),
        lanes.load(f),
        lanes.load(g),
        lanes.load(h),
    ])
}
