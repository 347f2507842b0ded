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

use crate::instance::TopLevel;
use crate::node::{Block, Node, WIDTH};
use crate::placement::{InWorld, Placement};
use crate::ray::{Hit, Ray};
use crate::simd::lanes::Lanes;
use crate::simd::stack::{Slots, Stack};
use crate::traverse::{Areas, LaneHits, Shear, is_in_range};
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
        let mut waiting = Waiting::new(rays);
        while waiting.fill(first, rays, &mut packet) {
            packet.walk(lanes, tree, &InWorld, &mut visit);
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
        let mut waiting = Waiting::new(rays);
        while waiting.fill(first, rays, &mut packet) {
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

/// Rays that have not been traced yet.
struct Waiting {
    /// One bit a ray; those out of range never wait.
    rays: u64,
    /// Which axis dominates, in which direction.
    axes: [[usize; 3]; RAYS],
}

impl Waiting {
    fn new(rays: &[Ray]) -> Self {
        let mut waiting = Self { rays: 0, axes: [[0; 3]; RAYS] };
        for (index, ray) in rays.iter().enumerate() {
            waiting.rays |= u64::from(is_in_range(ray)) << index;
            waiting.axes[index] = Shear::axes(ray.direction);
        }
        waiting
    }

    /// Fills a packet with the next rays that have their axes in common; false if there are none. `rays` are
    /// those of the caller from `first` on.
    fn fill(&mut self, first: usize, rays: &[Ray], packet: &mut Packet) -> bool {
        if self.rays == 0 {
            return false;
        }
        packet.begin(rays[self.rays.trailing_zeros() as usize % RAYS], self.next_axes());
        let mut left = self.rays;
        while left != 0 {
            let index = left.trailing_zeros() as usize % RAYS;
            left &= left - 1;
            if self.axes[index] == packet.axes {
                packet.add(first + index, &rays[index]);
                self.rays &= !(1 << index);
            }
        }
        packet.finish();
        true
    }

    fn next_axes(&self) -> [usize; 3] {
        self.axes[self.rays.trailing_zeros() as usize % RAYS]
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

    #[inline(always)]
    fn include(&mut self, lane: usize, value: f32) {
        self.low[lane] = self.low[lane].min(value);
        self.high[lane] = self.high[lane].max(value);
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

    /// Makes it a packet without rays. `first` will be its first one.
    #[inline(always)]
    fn begin(&mut self, first: Ray, axes: [usize; 3]) {
        self.len = 0;
        self.axes = axes;
        self.is_forward = first.direction[axes[2]] > 0.0;
        self.shares_origin = true;
        self.groups = Frusta::EMPTY;
    }

    /// Adds a ray with the axes of the packet.
    #[inline(always)]
    fn add(&mut self, index: usize, ray: &Ray) {
        let [x, y, z] = self.axes;
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        let inverse = 1.0 / direction[z];
        let (origin, slope) =
            ([origin[x], origin[y], origin[z]], [direction[x] * inverse, direction[y] * inverse, inverse]);
        let (group, lane) = (self.len / WIDTH % GROUPS, self.len % WIDTH);
        self.index[self.len % RAYS] = index;
        self.len += 1;
        for axis in 0..3 {
            self.shares_origin &=
                self.len == 1 || origin[axis].to_bits() == self.origin[axis][0][0].to_bits();
            self.origin[axis][group][lane] = origin[axis];
            self.slope[axis][group][lane] = slope[axis];
            self.groups.origin[axis].include(group, origin[axis]);
        }
        self.groups.slope[0].include(group, slope[0]);
        self.groups.slope[1].include(group, slope[1]);
        // The addition turns -0 into +0, as for single rays.
        let (t_min, speed) = (ray.t_min.max(0.0) + 0.0, direction[z].abs());
        self.t_min[group][lane] = t_min;
        self.t_max[group][lane] = ray.t_max;
        self.speed[group][lane] = speed * (1.0 + SLACK);
        // What is subtracted is for products that leave the range of normal numbers.
        let begin = t_min * speed * (1.0 - SLACK) - f32::MIN_POSITIVE;
        let depth = &mut self.groups.depth;
        if self.is_forward {
            depth.low[group] = depth.low[group].min(begin);
        } else {
            depth.high[group] = depth.high[group].max(-begin);
        }
    }

    /// Fills the last group with rays that hit nothing, and makes the frusta.
    #[inline(always)]
    fn finish(&mut self) {
        for place in self.len..self.group_count() * WIDTH {
            let (group, lane) = (place / WIDTH % GROUPS, place % WIDTH);
            for axis in 0..3 {
                self.origin[axis][group][lane] = self.origin[axis][group][0];
                self.slope[axis][group][lane] = self.slope[axis][group][0];
            }
            self.t_min[group][lane] = 0.0;
            self.t_max[group][lane] = f32::NEG_INFINITY;
            self.speed[group][lane] = 1.0;
        }
        for axis in 0..3 {
            self.whole.origin[axis] = self.groups.origin[axis].union();
        }
        self.whole.slope = [self.groups.slope[0].union(), self.groups.slope[1].union()];
        for group in 0..self.group_count() {
            self.shorten_group(group);
        }
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
