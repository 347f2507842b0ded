//! The one traversal, written over eight [`Lanes`] and compiled once for each SIMD path.

use glam::{Vec3, Vec3A};

use crate::instance::TopLevel;
use crate::limits::{COORDINATE_LIMIT, LEAST_SPEED, SPEED_LIMIT};
use crate::node::{Block, Node, WIDTH};
use crate::placement::{InWorld, Placement};
use crate::ray::{Hit, Ray};
use crate::simd::lanes::Lanes;
use crate::simd::stack::{Slots, Stack};
use crate::tree::Tree;

/// Visits every hit of `ray` whose `t` lies in `[t_min, t_max]` at that time; `visit` returns the new
/// `t_max`. Sees near boxes first if `IN_ORDER`, which costs a tenth of the time, and stops once
/// `t_max < t_min`.
#[inline(always)]
pub(crate) fn traverse<const IN_ORDER: bool, L: Lanes>(
    lanes: L,
    tree: Tree<'_>,
    ray: &Ray,
    mut visit: impl FnMut(Hit) -> f32,
) {
    let Some(slabs) = Slabs::new(ray, tree.lower, tree.upper) else { return };
    let shear = Shear::new(ray, slabs.inverse);
    walk::<IN_ORDER, _, _>(lanes, tree, &InWorld, &slabs, &shear, ray.t_max, &mut visit);
}

/// The same through a tree and the instances beside it: first all of the tree, then each instance whose box
/// is still in reach, near ones first.
#[inline(always)]
pub(crate) fn traverse_two_levels<L: Lanes>(
    lanes: L,
    tree: Tree<'_>,
    top: &TopLevel,
    ray: &Ray,
    visit: &mut dyn FnMut(Hit) -> f32,
) {
    let mut t_max = ray.t_max;
    if let Some(slabs) = Slabs::new(ray, tree.lower, tree.upper) {
        let shear = Shear::new(ray, slabs.inverse);
        t_max = walk::<true, _, _>(lanes, tree, &InWorld, &slabs, &shear, t_max, &mut *visit);
    }
    let boxes = top.tree();
    let Some(root) = boxes.root else { return };
    let Some(slabs) = Slabs::new(ray, boxes.lower, boxes.upper) else { return };
    let shear = Shear::new(ray, slabs.inverse);
    let mut slots = Slots::new();
    let mut stack = Stack::new(&mut slots);
    stack.push(slabs.t_min, root);
    while let Some((near, child)) = stack.pop() {
        if near > t_max {
            continue;
        }
        if child.is_block() {
            let (mesh, placed) = top.instance(child.index());
            t_max = walk::<true, _, _>(lanes, mesh, placed, &slabs, &shear, t_max, &mut *visit);
            if t_max < slabs.t_min {
                return;
            }
            continue;
        }
        let node = &boxes.nodes[child.index()];
        let (near, entered) = slabs.enter(lanes, &InWorld, node, t_max);
        if entered != 0 {
            lanes.push(&mut stack, near, entered, &node.children);
        }
    }
}

/// Visits the hits in one tree, placed in the world; returns the `t_max` that is left.
#[inline(always)]
fn walk<const IN_ORDER: bool, L: Lanes, P: Placement>(
    lanes: L,
    tree: Tree<'_>,
    place: &P,
    slabs: &Slabs,
    shear: &Shear,
    mut t_max: f32,
    mut visit: impl FnMut(Hit) -> f32,
) -> f32 {
    let Some(root) = tree.root else { return t_max };
    let mut hits = LaneHits::NONE;
    let mut slots = Slots::new();
    let mut stack = Stack::new(&mut slots);
    stack.push(slabs.t_min, root);
    'pop: while let Some((near, mut child)) = stack.pop() {
        if near > t_max {
            continue;
        }
        if let Some(next) = stack.top() {
            tree.prefetch(lanes, next);
        }
        while !child.is_block() {
            let node = &tree.nodes[child.index()];
            let (near, entered) = slabs.enter(lanes, place, node, t_max);
            if entered == 0 {
                continue 'pop;
            }
            let first = entered.trailing_zeros() as usize % WIDTH;
            let rest = entered & (entered - 1);
            child = node.children[first];
            if rest == 0 {
                continue;
            }
            if !IN_ORDER {
                let mut rest = rest;
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize % WIDTH;
                    rest &= rest - 1;
                    stack.push(slabs.t_min, node.children[lane]);
                }
                continue;
            }
            if rest & (rest - 1) != 0 {
                lanes.push(&mut stack, near, entered, &node.children);
                continue 'pop;
            }
            let second = rest.trailing_zeros() as usize % WIDTH;
            let near = lanes.store(near);
            if near[first] <= near[second] {
                stack.push(near[second], node.children[second]);
            } else {
                stack.push(near[first], child);
                child = node.children[second];
            }
        }
        let block = &tree.blocks[child.index()];
        if !shear.hit(lanes, place, block, slabs.t_min, t_max, &mut hits) {
            continue;
        }
        let mut waiting = hits.lanes;
        while waiting != 0 {
            let lane = waiting.trailing_zeros() as usize % WIDTH;
            waiting &= waiting - 1;
            let t = hits.t[lane];
            if t <= t_max && place.keeps(block, lane) {
                t_max = t_max.min(visit(Hit {
                    t,
                    u: hits.u[lane],
                    v: hits.v[lane],
                    triangle: place.number(block.triangles[lane]),
                    front: hits.front >> lane & 1 != 0,
                }));
            }
        }
        if t_max < slabs.t_min {
            break;
        }
    }
    t_max
}

/// The ray as the box test needs it: widened, so that no box is missed that holds a triangle the
/// triangle test would hit.
///
/// The triangle test moves each vertex by rounding: at most `2 u X + 5 u Z`, with `u` = 2^-24 and X, Z the
/// distances to the vertex along the axis and along the dominant axis. The planes move outwards by
/// `8 u (X + Z)`, taken once a ray from the root's box as Woop et al. do, and by the rounding of the moved
/// origin. The rounding of the distances themselves, three operations, and that of a hit's `t` is covered by
/// [`Slabs::SLACK`] (Ize's factor of 1 + 4 u is for the former alone). None of it costs measurable time.
pub(crate) struct Slabs {
    origin_near: [f32; 3],
    origin_far: [f32; 3],
    /// 1 per unit of direction; exact to rounding for the fastest axis.
    inverse: [f32; 3],
    inverse_near: [f32; 3],
    inverse_far: [f32; 3],
    /// Rows of [`Node::bounds`] that the ray enters and leaves by.
    near: [usize; 3],
    far: [usize; 3],
    t_min: f32,
}

impl Slabs {
    /// Relative slack of box distances: eight roundings.
    pub(crate) const SLACK: f32 = 1.0 / (1 << 21) as f32;
    /// Slowest axis relative to the fastest: it moves the ray by less than the planes are moved, and keeps
    /// its inverse finite.
    pub(crate) const SLOWEST: f32 = 1e-12;
    /// `8 u`, for the vertices that the triangle test moves.
    pub(crate) const PADDING: f32 = 1.0 / (1 << 21) as f32;
    /// `2 u`, for the rounding of the moved origin.
    pub(crate) const ORIGIN_PADDING: f32 = 1.0 / (1 << 23) as f32;

    /// None for a ray out of the ranges that [`Ray`] names, NaN included.
    #[inline(always)]
    fn new(ray: &Ray, lower: Vec3A, upper: Vec3A) -> Option<Self> {
        if !is_in_range(ray) {
            return None;
        }
        let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
        let speed = direction.abs();
        let fastest = speed.max_element();
        let reach = (lower - origin).abs().max((upper - origin).abs());
        let pad = (reach + reach.max_element()) * Self::PADDING + origin.abs() * Self::ORIGIN_PADDING;
        let pad = pad.copysign(direction);
        let inverse = speed.max(Vec3A::splat(fastest * Self::SLOWEST)).copysign(direction).recip();
        let backwards = direction.is_negative_bitmask();
        let entry = |axis: usize| axis + if backwards >> axis & 1 != 0 { 3 } else { 0 };
        let exit = |axis: usize| axis + if backwards >> axis & 1 != 0 { 0 } else { 3 };
        Some(Self {
            origin_near: (origin + pad).to_array(),
            origin_far: (origin - pad).to_array(),
            inverse: inverse.to_array(),
            inverse_near: (inverse * (1.0 - Self::SLACK)).to_array(),
            inverse_far: (inverse * (1.0 + Self::SLACK)).to_array(),
            near: [entry(0), entry(1), entry(2)],
            far: [exit(0), exit(1), exit(2)],
            // The addition turns -0 into +0, whose bits sort below all other distances.
            t_min: ray.t_min.max(0.0) + 0.0,
        })
    }

    /// Distances at which the ray enters the children's boxes, and the lanes of the boxes that it passes
    /// within `[t_min, t_max]`. A NaN, from a ray in the plane of a side, can only loosen the bounds: it
    /// loses against the second operand of `max` and `min`, and so does a pair of axes that gives one.
    #[inline(always)]
    fn enter<L: Lanes, P: Placement>(&self, lanes: L, place: &P, node: &Node, t_max: f32) -> (L::F, u32) {
        let near = [
            self.enter_slab(lanes, place, node, 0),
            self.enter_slab(lanes, place, node, 1),
            self.enter_slab(lanes, place, node, 2),
        ];
        let far = [
            self.leave_slab(lanes, place, node, 0),
            self.leave_slab(lanes, place, node, 1),
            self.leave_slab(lanes, place, node, 2),
        ];
        // In pairs: the next node waits for this chain.
        let near = lanes.max(lanes.max(near[2], near[1]), lanes.max(near[0], lanes.splat(self.t_min)));
        let far = lanes.min(lanes.min(far[2], far[1]), lanes.min(far[0], lanes.splat(t_max)));
        (near, lanes.le(near, far) & place.used(lanes, node))
    }

    #[inline(always)]
    fn enter_slab<L: Lanes, P: Placement>(&self, lanes: L, place: &P, node: &Node, axis: usize) -> L::F {
        let from_origin = translate(lanes, place.plane(lanes, node, self.near[axis]), self.origin_near[axis]);
        lanes.mul(from_origin, lanes.splat(self.inverse_near[axis]))
    }

    #[inline(always)]
    fn leave_slab<L: Lanes, P: Placement>(&self, lanes: L, place: &P, node: &Node, axis: usize) -> L::F {
        let from_origin = translate(lanes, place.plane(lanes, node, self.far[axis]), self.origin_far[axis]);
        lanes.mul(from_origin, lanes.splat(self.inverse_far[axis]))
    }
}

/// Whether a ray keeps the ranges that [`Ray`] names; a NaN does not.
#[inline(always)]
pub(crate) fn is_in_range(ray: &Ray) -> bool {
    let speed = Vec3A::from(ray.direction).abs();
    let in_range = Vec3A::from(ray.origin).abs().cmple(Vec3A::splat(COORDINATE_LIMIT))
        & speed.cmple(Vec3A::splat(SPEED_LIMIT));
    in_range.all() && speed.max_element() >= LEAST_SPEED
}

/// The ray as the watertight triangle test needs it (Woop et al.): translation to its origin,
/// axes permuted so that z is the fastest, and the shear that turns it into the z axis.
#[derive(Clone, Copy)]
pub(crate) struct Shear {
    /// Original axes that become x, y and z.
    pub(crate) axes: [usize; 3],
    /// The ray's origin with its axes permuted.
    pub(crate) origin: [f32; 3],
    /// Direction's x and y per z, and 1 per z.
    pub(crate) slope: [f32; 3],
}

/// Hits of one ray with a block, or of eight rays with a triangle. Lanes outside `lanes` hold anything.
pub(crate) struct LaneHits {
    pub(crate) lanes: u32,
    /// Lanes whose triangle turns its front to the ray's origin.
    pub(crate) front: u32,
    pub(crate) t: [f32; WIDTH],
    pub(crate) u: [f32; WIDTH],
    pub(crate) v: [f32; WIDTH],
}

impl LaneHits {
    pub(crate) const NONE: Self =
        Self { lanes: 0, front: 0, t: [0.0; WIDTH], u: [0.0; WIDTH], v: [0.0; WIDTH] };

    /// The hit of a lane of a block in the world.
    #[inline(always)]
    pub(crate) fn hit(&self, block: &Block, lane: usize) -> Hit {
        Hit {
            t: self.t[lane],
            u: self.u[lane],
            v: self.v[lane],
            triangle: block.triangles[lane],
            front: self.front >> lane & 1 != 0,
        }
    }

    /// Adds what [`Shear::exact`] found in a lane, if it lies within `[t_min, t_max]`.
    pub(crate) fn add(&mut self, lane: usize, hit: &Hit, t_min: f32, t_max: f32) {
        if t_min <= hit.t && hit.t <= t_max {
            self.lanes |= 1 << lane;
            self.front |= u32::from(hit.front) << lane;
            (self.t[lane], self.u[lane], self.v[lane]) = (hit.t, hit.u, hit.v);
        }
    }
}

impl Shear {
    /// Of a ray by itself; none if it is out of the ranges that [`Ray`] names.
    pub(crate) fn of(ray: &Ray) -> Option<Self> {
        let slabs = Slabs::new(ray, Vec3A::ZERO, Vec3A::ZERO)?;
        Some(Self::new(ray, slabs.inverse))
    }

    /// Of a ray in the same direction from elsewhere.
    #[inline(always)]
    pub(crate) fn at(&self, origin: Vec3) -> Self {
        Self { origin: self.axes.map(|axis| origin[axis]), ..*self }
    }

    /// `inverse` is 1 per unit of direction, of which the fastest axis counts.
    #[inline(always)]
    fn new(ray: &Ray, inverse: [f32; 3]) -> Self {
        let axes @ [x, y, z] = Self::axes(ray.direction);
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        Self {
            axes,
            origin: [origin[x], origin[y], origin[z]],
            slope: [direction[x] * inverse[z], direction[y] * inverse[z], inverse[z]],
        }
    }

    /// Original axes that become x, y and z for a ray of a direction.
    #[inline(always)]
    pub(crate) fn axes(direction: Vec3) -> [usize; 3] {
        let speed = direction.abs();
        let (next, last, z) = if speed.x >= speed.y && speed.x >= speed.z {
            (1, 2, 0)
        } else if speed.y >= speed.z {
            (2, 0, 1)
        } else {
            (0, 1, 2)
        };
        // Swapped for a ray against the axis: keeps the winding.
        if direction[z] < 0.0 { [last, next, z] } else { [next, last, z] }
    }

    /// Writes the hits of a block within `[t_min, t_max]`; false if there are none.
    ///
    /// [`Shear::exact`] settles lanes where the sign of an area is lost.
    #[inline(always)]
    pub(crate) fn hit<L: Lanes, P: Placement>(
        &self,
        lanes: L,
        place: &P,
        block: &Block,
        t_min: f32,
        t_max: f32,
        hits: &mut LaneHits,
    ) -> bool {
        // No closures, no `map`: what is not `inline(always)` is compiled without the path's instructions.
        let [x_axis, y_axis, z_axis] = self.axes;
        let [a, b, c] = place.coordinates(lanes, block, z_axis);
        let z = [
            translate(lanes, a, self.origin[2]),
            translate(lanes, b, self.origin[2]),
            translate(lanes, c, self.origin[2]),
        ];
        let x = shear(lanes, place.coordinates(lanes, block, x_axis), self.origin[0], self.slope[0], z);
        let y = shear(lanes, place.coordinates(lanes, block, y_axis), self.origin[1], self.slope[1], z);
        let areas = Areas::new(lanes, x, y);
        let touched = areas.touched(lanes);
        if touched == 0 {
            return false;
        }
        let (front, inside) = areas.sides(lanes);
        let [t, u, v] = areas.solve(lanes, z, lanes.splat(self.slope[2]));
        let within = lanes.le(lanes.splat(t_min), t) & lanes.le(t, lanes.splat(t_max));
        hits.lanes = inside & within;
        hits.front = front;
        hits.t = lanes.store(t);
        hits.u = lanes.store(u);
        hits.v = lanes.store(v);
        if touched != inside {
            self.settle(place, block, touched & !inside, t_min, t_max, hits);
        }
        hits.lanes != 0
    }

    /// Adds those of the `unsettled` lanes to the hits that are.
    #[cold]
    #[inline(never)]
    fn settle<P: Placement>(
        &self,
        place: &P,
        block: &Block,
        mut unsettled: u32,
        t_min: f32,
        t_max: f32,
        hits: &mut LaneHits,
    ) {
        while unsettled != 0 {
            let lane = unsettled.trailing_zeros() as usize % WIDTH;
            unsettled &= unsettled - 1;
            if let Some(hit) = self.exact(place, block, lane) {
                hits.add(lane, &hit, t_min, t_max);
            }
        }
    }

    /// The test for one triangle with an area that rounds to 0, in `f64`: products of two `f32` are exact
    /// there, so that the signs of their differences are right.
    ///
    /// Where an area is exactly 0 the ray passes through an edge. Then it counts as moved by an
    /// infinitesimal (-e, e^2) in the sheared plane, which is the fill rule of rasterisers: of all triangles
    /// around the edge or vertex, as many are hit as if the ray had passed beside it.
    pub(crate) fn exact<P: Placement>(&self, place: &P, block: &Block, lane: usize) -> Option<Hit> {
        let [a, b, c] = [0, 1, 2].map(|vertex: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| {
                place.coordinate(block, lane, vertex, self.axes[axis]) - self.origin[axis]
            });
            [x - z * self.slope[0], y - z * self.slope[1], z].map(f64::from)
        });
        let area = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let areas = [area(c, b), area(a, c), area(b, a)];
        let sum = areas[0] + areas[1] + areas[2];
        let front = sum > 0.0;
        let edges = [[c, b], [a, c], [b, a]];
        let inside = areas.iter().zip(edges).all(|(&area, [from, to])| {
            let [from, to] = if front { [from, to] } else { [to, from] };
            let facing = if front { area } else { -area };
            facing > 0.0 || facing == 0.0 && (to[1] > from[1] || to[1] == from[1] && to[0] > from[0])
        });
        if !inside || sum == 0.0 {
            return None;
        }
        let depth = (areas[0] * a[2] + areas[1] * b[2] + areas[2] * c[2]) / sum;
        Some(Hit {
            t: depth as f32 * self.slope[2],
            u: (areas[1] / sum) as f32,
            v: (areas[2] / sum) as f32,
            triangle: block.triangles[lane],
            front,
        })
    }
}

/// Twice the signed areas that the point of a ray spans with the edges of a triangle, both seen along the
/// ray. The triangle is hit if they have one sign. In `f32` a sign is never wrong, as rounding is monotonic,
/// but it may be lost.
///
/// This is the arithmetic of all hits, of one ray with eight triangles as of eight rays with one: so hits are
/// the same bits.
pub(crate) struct Areas<F> {
    areas: [F; 3],
    least: F,
    most: F,
}

impl<F: Copy> Areas<F> {
    /// `x` and `y` of the three vertices in the sheared plane, where the ray is the origin.
    #[inline(always)]
    pub(crate) fn new<L: Lanes<F = F>>(lanes: L, x: [F; 3], y: [F; 3]) -> Self {
        let areas = [
            cross(lanes, x[2], y[2], x[1], y[1]),
            cross(lanes, x[0], y[0], x[2], y[2]),
            cross(lanes, x[1], y[1], x[0], y[0]),
        ];
        let least = lanes.min(lanes.min(areas[0], areas[1]), areas[2]);
        let most = lanes.max(lanes.max(areas[0], areas[1]), areas[2]);
        Self { areas, least, most }
    }

    /// Lanes that are hit, and those where a lost sign leaves it open.
    #[inline(always)]
    pub(crate) fn touched<L: Lanes<F = F>>(&self, lanes: L) -> u32 {
        let zero = lanes.splat(0.0);
        lanes.le(zero, self.least) | lanes.le(self.most, zero)
    }

    /// Lanes whose triangle is hit from the front, and those where it is hit at all, as far as no sign is
    /// lost.
    #[inline(always)]
    pub(crate) fn sides<L: Lanes<F = F>>(&self, lanes: L) -> (u32, u32) {
        let zero = lanes.splat(0.0);
        let front = lanes.lt(zero, self.least);
        (front, front | lanes.lt(self.most, zero))
    }

    /// Distance and weights of the second and third vertex, from the vertices' depths and 1 per unit of the
    /// ray's direction along the dominant axis.
    #[inline(always)]
    pub(crate) fn solve<L: Lanes<F = F>>(&self, lanes: L, z: [F; 3], inverse_speed: F) -> [F; 3] {
        let [a, b, c] = self.areas;
        let inverse = lanes.div(lanes.splat(1.0), lanes.add(lanes.add(a, b), c));
        // The weights before the depth: areas times depths could leave the range of f32.
        let weights = [lanes.mul(a, inverse), lanes.mul(b, inverse), lanes.mul(c, inverse)];
        let depth = lanes.add(lanes.mul(weights[0], z[0]), lanes.mul(weights[1], z[1]));
        let depth = lanes.add(depth, lanes.mul(weights[2], z[2]));
        [lanes.mul(depth, inverse_speed), weights[1], weights[2]]
    }
}

#[inline(always)]
fn translate<L: Lanes>(lanes: L, row: L::F, origin: f32) -> L::F {
    lanes.sub(row, lanes.splat(origin))
}

/// One coordinate of three vertices, seen along the ray.
#[inline(always)]
fn shear<L: Lanes>(lanes: L, rows: [L::F; 3], origin: f32, slope: f32, z: [L::F; 3]) -> [L::F; 3] {
    let slope = lanes.splat(slope);
    [
        lanes.sub(translate(lanes, rows[0], origin), lanes.mul(z[0], slope)),
        lanes.sub(translate(lanes, rows[1], origin), lanes.mul(z[1], slope)),
        lanes.sub(translate(lanes, rows[2], origin), lanes.mul(z[2], slope)),
    ]
}

/// Twice the area of the triangle that the origin of the plane makes with `a` and `b`.
#[inline(always)]
fn cross<L: Lanes>(lanes: L, ax: L::F, ay: L::F, bx: L::F, by: L::F) -> L::F {
    lanes.sub(lanes.mul(ax, by), lanes.mul(ay, bx))
}
