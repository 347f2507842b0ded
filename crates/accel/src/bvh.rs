//! The tree as callers see it: build, rebuild what moves, and the four questions a ray can ask.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::Vec3;

use crate::build::{self, Bounds, Part};
use crate::error::AccelError;
use crate::instance::{Instance, MeshTree, TopLevel};
use crate::limits::INDEX_LIMIT;
use crate::node::{Block, Child, Node};
use crate::packed::PackedTree;
use crate::ray::{Hit, Ray};
use crate::refit::{self, TreeCost, Watch};
use crate::simd::{SimdPath, SupportedPath};
use crate::tree::Tree;
use crate::validate::{self, Stats};

/// The last [`PackedTree::kept_id`] given.
static LAST_KEPT_ID: AtomicU64 = AtomicU64::new(0);

/// A tree over triangles. Queries take `&self` and may run on any number of threads.
///
/// Ignored, and so never hit: triangles with a coordinate that is not finite or above 1e12 in magnitude,
/// triangles with two equal vertices, and those from index 2^30 on.
/// Triangles with sides below about 1e-18 may be missed, as their area is no normal `f32`.
#[derive(Clone)]
pub struct Bvh {
    /// Static part, then the part that moves, then the part over what has come since that was built, then
    /// the nodes that join the three.
    nodes: Vec<Node>,
    /// Those of the same three parts.
    blocks: Vec<Block>,
    whole: Option<Part>,
    kept: Kept,
    moving: Moving,
    /// What is drawn as instances; boxed, for most trees have none.
    instanced: Option<Box<Instanced>>,
    path: SupportedPath,
}

/// Instances beside a tree.
#[derive(Clone)]
struct Instanced {
    top: TopLevel,
    /// How many numbers are theirs, between those of the static part and those of the part that moves.
    number_count: u32,
}

/// The part of a tree that [`Bvh::rebuild_after`] keeps.
#[derive(Clone)]
struct Kept {
    triangle_count: usize,
    node_count: usize,
    block_count: usize,
    part: Option<Part>,
    /// Changes with the part: [`PackedTree::kept_id`].
    id: u64,
}

/// The part of a tree that [`Bvh::refit_after`] fits to where its triangles are.
#[derive(Clone, Default)]
struct Moving {
    /// Triangles that moved in the last call, in this part or not.
    triangle_count: usize,
    /// Where the nodes and blocks of the part end; they follow on those of the part that is kept.
    node_end: usize,
    block_end: usize,
    part: Option<Part>,
    watch: Watch,
}

impl Bvh {
    /// Builds a tree on the threads of the current rayon pool; their number does not change it.
    /// [`Hit::triangle`] indexes `triangles`.
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        Self::build_beside(triangles, None)
    }

    /// Builds a tree over triangles that never move, with room for instances of meshes beside it:
    /// [`Bvh::place_instances`] says where they are. The `number_count` numbers behind those of `triangles`
    /// are kept for their triangles; what [`Bvh::rebuild_after`] adds is numbered from there on.
    #[must_use]
    pub fn build_with_meshes(triangles: &[[Vec3; 3]], meshes: Vec<MeshTree>, number_count: u32) -> Self {
        Self::build_beside(triangles, Some(Box::new(Instanced { top: TopLevel::new(meshes), number_count })))
    }

    fn build_beside(triangles: &[[Vec3; 3]], instanced: Option<Box<Instanced>>) -> Self {
        let mut bvh = Self {
            nodes: Vec::new(),
            blocks: Vec::new(),
            whole: None,
            kept: Kept { triangle_count: 0, node_count: 0, block_count: 0, part: None, id: 0 },
            moving: Moving::default(),
            instanced,
            path: SupportedPath::detect(),
        };
        bvh.rebuild_after(triangles.len(), triangles);
        bvh
    }

    /// Builds the tree again over `triangles`, of which the first `static_count` have not changed since the
    /// last call with the same `static_count` (or since [`Bvh::build`] with that many): their part of the
    /// tree is kept, the rest is new. An animated scene pays for what moves.
    ///
    /// The two parts are joined near their roots by the same heuristic that built them, so that a ray
    /// still visits near geometry first, whichever part it is in.
    pub fn rebuild_after(&mut self, static_count: usize, triangles: &[[Vec3; 3]]) {
        let static_count = static_count.min(triangles.len());
        if static_count != self.kept.triangle_count {
            self.nodes.clear();
            self.blocks.clear();
            let part = build::build(triangles, 0..static_count, 0, &mut self.nodes, &mut self.blocks);
            self.kept = Kept {
                triangle_count: static_count,
                node_count: self.nodes.len(),
                block_count: self.blocks.len(),
                part,
                id: LAST_KEPT_ID.fetch_add(1, Ordering::Relaxed) + 1,
            };
        }
        self.nodes.truncate(self.kept.node_count);
        self.blocks.truncate(self.kept.block_count);
        let (moving, shift) = (static_count..triangles.len(), self.shift());
        let part = build::build(triangles, moving.clone(), shift, &mut self.nodes, &mut self.blocks);
        let built = TreeCost::of(&self.nodes[self.kept.node_count..], &self.blocks[self.kept.block_count..]);
        self.moving = Moving {
            triangle_count: moving.len(),
            node_end: self.nodes.len(),
            block_end: self.blocks.len(),
            part,
            watch: Watch::new(built),
        };
        self.join(None);
    }

    /// [`Bvh::rebuild_after`] for a caller that knows what has become of the triangles that moved in the last
    /// call: the tree over them keeps its shape where that is still good, which takes a third of the time.
    /// The hits are the same, whatever is said here. Returns whether the shape was kept.
    ///
    /// `successors` has an entry for each triangle behind the static ones of the last call: its place among
    /// those of `triangles`, or a number that is none, such as `u32::MAX`, if it is gone. Places ascend: who
    /// changes the order gets a new tree. What is the successor of none has come since. Triangles may begin
    /// and cease to be ignored (see [`Bvh`]).
    ///
    /// The tree is built anew when it costs 10 % more to trace through than it did (by the surface area
    /// heuristic), when one triangle in 16 has come or gone, and after 60 refits.
    pub fn refit_after(&mut self, static_count: usize, triangles: &[[Vec3; 3]], successors: &[u32]) -> bool {
        let moving_count = triangles.len().saturating_sub(static_count);
        let fits = static_count == self.kept.triangle_count
            && successors.len() == self.moving.triangle_count
            && ascend(successors.iter().copied().filter(|&place| (place as usize) < moving_count));
        let is_kept = fits && self.refit(triangles, successors);
        if !is_kept {
            self.rebuild_after(static_count, triangles);
        }
        is_kept
    }

    /// Fits the tree to the triangles; false if it is to be built anew, and of no use until then.
    fn refit(&mut self, triangles: &[[Vec3; 3]], successors: &[u32]) -> bool {
        let (first, shift) = (self.kept.triangle_count, self.shift());
        let Some(part) = self.moving.part else { return false };
        self.nodes.truncate(self.moving.node_end);
        self.blocks.truncate(self.moving.block_end);

        // What is left of the part. Marks are set by whichever thread has the triangle's block.
        let moving = &triangles[first..triangles.len().min(INDEX_LIMIT - shift as usize)];
        let placed: Vec<AtomicBool> = moving.iter().map(|_| AtomicBool::new(false)).collect();
        let renew = |block: &mut Block| {
            let old = std::mem::replace(block, Block::EMPTY);
            let numbers = old.triangles.iter().take_while(|&&number| number != PackedTree::NONE);
            let places = numbers.map(|&number| successors[(number - shift) as usize - first] as usize);
            let mut bounds = Bounds::EMPTY;
            let mut lane = 0;
            for place in places {
                let Some(triangle) = moving.get(place).filter(|triangle| build::is_kept(triangle)) else {
                    continue;
                };
                placed[place].store(true, Ordering::Relaxed);
                block.set(lane, triangle, (first + place) as u32 + shift);
                bounds = bounds.union(Bounds::of_triangle(triangle));
                lane += 1;
            }
            bounds
        };
        let starts = [self.kept.node_count, self.kept.block_count];
        let (nodes, blocks) = (&mut self.nodes[starts[0]..], &mut self.blocks[starts[1]..]);
        let Some((part, cost)) = refit::refit(part, nodes, blocks, starts, renew) else { return false };

        // Whether that is still a good tree, and what is in none.
        let has_arrived =
            |&place: &usize| !placed[place].load(Ordering::Relaxed) && build::is_kept(&moving[place]);
        let arrivals: Vec<usize> = (0..moving.len()).filter(has_arrived).map(|place| first + place).collect();
        if !self.moving.watch.keeps(cost, arrivals.len()) {
            return false;
        }
        self.moving.part = Some(part);
        self.moving.triangle_count = triangles.len() - first;
        let arrivals = build::build_of(triangles, &arrivals, shift, &mut self.nodes, &mut self.blocks);
        self.join(arrivals);
        true
    }

    /// Makes one tree of what is kept, what moves, and what has come since that was built.
    fn join(&mut self, arrivals: Option<Part>) {
        let parts: Vec<Part> = [self.kept.part, self.moving.part, arrivals].into_iter().flatten().collect();
        self.whole = build::join(&parts, &mut self.nodes);
    }

    /// How many numbers lie between those of the static part and those of the part that moves.
    fn shift(&self) -> u32 {
        self.instanced.as_ref().map_or(0, |instanced| instanced.number_count)
    }

    /// Places the instances of the meshes that [`Bvh::build_with_meshes`] was given, in place of those of the
    /// last call, of which the first `still_count` have not changed. Nothing happens to a tree without
    /// meshes.
    pub fn place_instances(&mut self, still_count: usize, instances: &[Instance]) {
        if let Some(instanced) = &mut self.instanced {
            instanced.top.place(still_count, instances);
        }
    }

    /// Lowest and highest corner of all triangles; none without any.
    #[must_use]
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let own = self.whole.map(|part| part.bounds);
        let placed = self.instanced.as_ref().and_then(|instanced| instanced.top.bounds());
        let (lower, upper) = own.into_iter().chain(placed).reduce(Bounds::union)?.corners();
        Some([lower.into(), upper.into()])
    }

    /// Visits every hit inside `[t_min, t_max]`, in no promised order except that near boxes come first.
    /// `visit` returns the new `t_max`; one above the current has no effect, `f32::NEG_INFINITY` stops.
    /// No triangle is visited twice.
    ///
    /// The closure is compiled into the traversal, once for each SIMD path; where there are instances it is
    /// called.
    #[inline]
    pub fn traverse(&self, ray: &Ray, mut visit: impl FnMut(Hit) -> f32) {
        match &self.instanced {
            None => self.path.traverse::<true>(self.tree(), ray, visit),
            Some(instanced) => self.path.traverse_two_levels(self.tree(), &instanced.top, ray, &mut visit),
        }
    }

    /// [`Self::traverse`] through that part of the tree alone which [`Bvh::rebuild_after`] keeps, without
    /// instances.
    #[inline]
    pub fn traverse_kept(&self, ray: &Ray, visit: impl FnMut(Hit) -> f32) {
        self.path.traverse::<true>(Tree::new(&self.nodes, &self.blocks, self.kept.part), ray, visit);
    }

    /// [`Self::traverse`] for rays that run close to one another: `visit` gets the index of a ray with its
    /// hit, and returns the new `t_max` of that ray. Each ray has the hits
    /// that it has alone, to the bit, but hits of several rays alternate.
    ///
    /// Rays are taken 64 at a time, in their order, those of one dominant direction together. Eight
    /// consecutive ones should be neighbours among these again: blocks of 4×2 pixels, of tiles of 8×8. It is
    /// best if all have the same origin, or else one direction. Rays without any coherence are found the same
    /// hits, slowly.
    #[inline]
    pub fn traverse_packet(&self, rays: &[Ray], mut visit: impl FnMut(usize, Hit) -> f32) {
        match &self.instanced {
            None => self.path.traverse_packet(self.tree(), rays, visit),
            Some(instanced) => {
                self.path.traverse_packet_two_levels(self.tree(), &instanced.top, rays, &mut visit);
            }
        }
    }

    /// [`Self::closest`] for rays that run close to one another, see [`Self::traverse_packet`]. Replaces the
    /// content of `closest` by the nearest hit of each ray that `accept` takes; `accept` gets the index of
    /// the ray with its hit.
    #[inline]
    pub fn closest_of_packet(
        &self,
        rays: &[Ray],
        mut accept: impl FnMut(usize, &Hit) -> bool,
        closest: &mut Vec<Option<Hit>>,
    ) {
        closest.clear();
        closest.resize(rays.len(), None);
        self.traverse_packet(rays, |ray, hit| {
            let closest = &mut closest[ray];
            let first = closest.is_none_or(|best| hit.t < best.t || hit.triangle < best.triangle);
            if first && accept(ray, &hit) {
                *closest = Some(hit);
                return hit.t;
            }
            f32::INFINITY
        });
    }

    /// The nearest hit that `accept` takes. Of hits at equal `t` the lowest triangle index wins, whatever
    /// the shape of the tree. `accept` sees each triangle at most once, and not all that the ray meets.
    #[inline]
    pub fn closest(&self, ray: &Ray, mut accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let mut t_max = ray.t_max;
        self.traverse(ray, |hit| {
            let first = closest.is_none_or(|best| hit.t < best.t || hit.triangle < best.triangle);
            if first && accept(&hit) {
                closest = Some(hit);
                t_max = hit.t;
            }
            t_max
        });
        closest
    }

    /// Whether `accept` takes a hit. It sees each triangle at most once, near or far ones first, until it
    /// takes one.
    #[inline]
    pub fn any(&self, ray: &Ray, mut accept: impl FnMut(&Hit) -> bool) -> bool {
        let mut found = false;
        let mut visit = |hit| {
            found = accept(&hit);
            if found { f32::NEG_INFINITY } else { ray.t_max }
        };
        match &self.instanced {
            None => self.path.traverse::<false>(self.tree(), ray, visit),
            Some(instanced) => self.path.traverse_two_levels(self.tree(), &instanced.top, ray, &mut visit),
        }
        found
    }

    /// Replaces the content of `hits` by every hit, unsorted; hits at equal depths are all there.
    #[inline]
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        self.traverse(ray, |hit| {
            hits.push(hit);
            ray.t_max
        });
    }

    /// Checks the tree against the triangles it was built from: each one that is not ignored in exactly one
    /// leaf, each box around what lies below it, no NaN, no broken link. Of a tree that has instances beside
    /// it, those are no part.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate(&self, triangles: &[[Vec3; 3]]) -> Result<Stats, AccelError> {
        validate::validate(self.tree(), triangles, self.kept.triangle_count, self.shift())
    }

    /// The tree as bytes, for a processor that traverses it by itself; nothing is copied, and instances
    /// beside the tree are no part of it.
    #[must_use]
    pub fn packed(&self) -> PackedTree<'_> {
        let tree = self.tree();
        PackedTree {
            nodes: bytemuck::cast_slice(&self.nodes),
            blocks: bytemuck::cast_slice(&self.blocks),
            root: tree.root.unwrap_or(Child::NONE).0,
            lower: tree.lower.into(),
            upper: tree.upper.into(),
            kept_id: self.kept.id,
            kept_nodes: self.kept.node_count * PackedTree::NODE_BYTES,
            kept_blocks: self.kept.block_count * PackedTree::BLOCK_BYTES,
        }
    }

    /// The instructions that queries use.
    pub fn path(&self) -> SimdPath {
        self.path.get()
    }

    /// The same tree on another path, for tests and benchmarks; `build` has chosen the fastest.
    ///
    /// # Errors
    /// [`AccelError::UnsupportedPath`] when this processor lacks it.
    pub fn with_path(self, path: SimdPath) -> Result<Self, AccelError> {
        let path = SupportedPath::new(path).ok_or(AccelError::UnsupportedPath(path))?;
        Ok(Self { path, ..self })
    }

    pub(crate) fn tree(&self) -> Tree<'_> {
        Tree::new(&self.nodes, &self.blocks, self.whole)
    }
}

/// Whether each number is larger than the last, so that none is there twice.
fn ascend(mut numbers: impl Iterator<Item = u32>) -> bool {
    let mut last = None;
    numbers.all(|number| last.replace(number).is_none_or(|last| last < number))
}

/// Access for tests that damage a tree and look whether validation finds it.
#[cfg(test)]
impl Bvh {
    pub(crate) fn nodes_mut(&mut self) -> &mut [Node] {
        &mut self.nodes
    }

    pub(crate) fn blocks_mut(&mut self) -> &mut [Block] {
        &mut self.blocks
    }

    /// Lets refits go on, however bad the tree becomes.
    pub(crate) fn stop_watching(&mut self) {
        self.moving.watch = Watch::BLIND;
    }
}

impl fmt::Debug for Bvh {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Bvh")
            .field("nodes", &self.nodes.len())
            .field("blocks", &self.blocks.len())
            .field("path", &self.path())
            .finish_non_exhaustive()
    }
}
