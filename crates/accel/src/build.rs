//! Top-down construction with the binned surface area heuristic (Wald 2007), straight to eight children a
//! node: the largest child is split until there are eight.
//!
//! Spans above [`SUBTREE`] triangles are binned and partitioned by all threads together, one span after the
//! other; below, each span is one task. Where the two meet depends on the triangles alone, and every
//! reduction is associative, so that one and many threads build the same tree.

use std::ops::Range;

use glam::{Vec3, Vec3A, Vec4};
use rayon::prelude::*;

use crate::limits::{COORDINATE_LIMIT, INDEX_LIMIT};
use crate::node::{Block, Child, Node, WIDTH};

/// Candidate planes are the borders of 16 bins an axis; more cost build time and gain little (Wald 2007).
const BINS: usize = 16;

/// Largest span that one task builds alone: small enough to give many threads work, large enough that the
/// tasks cost nothing.
const SUBTREE: usize = 4096;

/// References that a thread bins or partitions at a time above [`SUBTREE`].
const CHUNK: usize = 4096;

/// Levels that may follow the heuristic. Below, spans are halved, so that no input makes the tree deep:
/// [`INDEX_LIMIT`] triangles then take ten levels more.
const HEURISTIC_LEVELS: u32 = 20;

/// The same for the joint of up to three parts, whose [`JOINT`] references each take three levels more.
/// Together with those of a part they stay below the stack's limit.
const JOINT_HEURISTIC_LEVELS: u32 = 8;

/// Subtrees that each part offers to the joint.
const JOINT: usize = 96;

/// A box as two vectors; their fourth components mean nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    lower: Vec4,
    upper: Vec4,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { lower: Vec4::INFINITY, upper: Vec4::NEG_INFINITY };

    pub(crate) fn new([lower, upper]: [Vec3A; 2]) -> Self {
        Self { lower: lower.extend(0.0), upper: upper.extend(0.0) }
    }

    #[inline(always)]
    pub(crate) fn union(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    #[inline(always)]
    fn with_point(self, point: Vec4) -> Self {
        Self { lower: self.lower.min(point), upper: self.upper.max(point) }
    }

    /// The box that a node gives one of its children.
    pub(crate) fn of_child(node: &Node, lane: usize) -> Self {
        Self { lower: node.lower(lane).extend(0.0), upper: node.upper(lane).extend(0.0) }
    }

    /// Around a triangle.
    pub(crate) fn of_triangle([a, b, c]: &[Vec3; 3]) -> Self {
        Self { lower: a.min(*b).min(*c).extend(0.0), upper: a.max(*b).max(*c).extend(0.0) }
    }

    pub(crate) fn is_empty(self) -> bool {
        self.lower.x > self.upper.x
    }

    /// Half the surface area of the box.
    #[inline(always)]
    pub(crate) fn half_area(self) -> f32 {
        let size = self.upper - self.lower;
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    #[inline(always)]
    pub(crate) fn corners(self) -> (Vec3A, Vec3A) {
        (Vec3A::from_vec4(self.lower), Vec3A::from_vec4(self.upper))
    }
}

/// A triangle, or two consecutive ones (or, in the joint, a subtree), while the tree is built: its box, and
/// in the fourth components its index and how many it is. 32 bytes that are moved, not pointed to.
#[derive(Clone, Copy)]
struct Ref(Bounds);

impl Ref {
    /// Makes a small index a normal float: arithmetic on denormals, though unused, can be slow.
    const TAG: u32 = 1 << 30;

    #[inline(always)]
    fn new(Bounds { lower, upper }: Bounds, index: u32, count: u32) -> Self {
        let tagged = |bits: u32| f32::from_bits(bits | Self::TAG);
        Self(Bounds { lower: lower.with_w(tagged(index)), upper: upper.with_w(tagged(count)) })
    }

    #[inline(always)]
    fn index(&self) -> u32 {
        self.0.lower.w.to_bits() & !Self::TAG
    }

    #[inline(always)]
    fn count(&self) -> u32 {
        self.0.upper.w.to_bits() & !Self::TAG
    }

    /// What it refers to.
    fn indices(&self) -> Range<u32> {
        self.index()..self.index() + self.count()
    }

    /// Twice the middle of the box.
    #[inline(always)]
    fn centroid(&self) -> Vec4 {
        self.0.lower + self.0.upper
    }
}

/// A tree, or a part of one, inside the node and block arrays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) root: Child,
    pub(crate) bounds: Bounds,
}

/// Whether a triangle takes part in a tree, see [`crate::Bvh`]. One with two equal vertices has no inside.
/// One with its vertices on a line stays: after the rounding of the triangle test it may be what closes a
/// T-junction.
#[must_use]
pub fn is_kept(triangle: &[Vec3; 3]) -> bool {
    let [a, b, c] = triangle;
    let finite = |p: &Vec3| p.abs().cmple(Vec3::splat(COORDINATE_LIMIT)).all();
    finite(a) && finite(b) && finite(c) && a != b && b != c && c != a
}

/// Appends a tree over `triangles[range]`, numbered `shift` further on. None if no triangle there is kept.
pub(crate) fn build(
    triangles: &[[Vec3; 3]],
    range: Range<usize>,
    shift: u32,
    nodes: &mut Vec<Node>,
    blocks: &mut Vec<Block>,
) -> Option<Part> {
    let limit = INDEX_LIMIT - shift as usize;
    let range = range.start.min(limit)..range.end.min(limit);
    let chunks = range.len().div_ceil(CHUNK);
    let chunk = |chunk: usize| range.clone().skip(chunk * CHUNK).take(CHUNK);
    let refs = (0..chunks).into_par_iter().map(|index| references(triangles, chunk(index)));
    plant(refs.collect::<Vec<_>>().concat(), triangles, shift, nodes, blocks)
}

/// The same over some triangles, all of which are kept.
pub(crate) fn build_of(
    triangles: &[[Vec3; 3]],
    indices: &[usize],
    shift: u32,
    nodes: &mut Vec<Node>,
    blocks: &mut Vec<Block>,
) -> Option<Part> {
    plant(references(triangles, indices.iter().copied()), triangles, shift, nodes, blocks)
}

/// Refers to those of the triangles that are kept.
///
/// Two consecutive ones are one reference where no line is the likelier to meet it for that: the halves of a
/// quad, neighbours in a strip. That halves the work of a build, and parts no quad.
fn references(triangles: &[[Vec3; 3]], indices: impl Iterator<Item = usize>) -> Vec<Ref> {
    let mut refs: Vec<Ref> = Vec::with_capacity(indices.size_hint().0);
    // The last reference, if another triangle may still join it.
    let mut open: Option<Bounds> = None;
    for index in indices.filter(|&index| is_kept(&triangles[index])) {
        let (own, index) = (Bounds::of_triangle(&triangles[index]), index as u32);
        if let (Some(first), Some(last)) = (open, refs.last_mut())
            && last.index() + 1 == index
        {
            let both = first.union(own);
            if both.half_area() <= first.half_area() + own.half_area() {
                *last = Ref::new(both, last.index(), 2);
                open = None;
                continue;
            }
        }
        refs.push(Ref::new(own, index, 1));
        open = Some(own);
    }
    refs
}

/// Appends a tree over the triangles that are referred to.
fn plant(
    mut refs: Vec<Ref>,
    triangles: &[[Vec3; 3]],
    shift: u32,
    nodes: &mut Vec<Node>,
    blocks: &mut Vec<Block>,
) -> Option<Part> {
    let rules = Rules { leaf_bits: WIDTH.ilog2(), heuristic_levels: HEURISTIC_LEVELS };
    let built = rules.grow(&mut refs)?;

    let (first_node, first_block) = (nodes.len(), blocks.len());
    nodes.par_extend(built.nodes.into_par_iter().with_min_len(CHUNK).map(|mut node| {
        node.children = node.children.map(|child| child.shifted(first_node, first_block));
        node
    }));
    blocks.par_extend(built.leaves.par_iter().with_min_len(CHUNK / WIDTH).map(|leaf| {
        let mut block = Block::EMPTY;
        for (lane, index) in refs[leaf.clone()].iter().flat_map(Ref::indices).enumerate() {
            block.set(lane, &triangles[index as usize], index + shift);
        }
        block
    }));
    Some(Part { root: built.root.shifted(first_node, first_block), bounds: built.bounds })
}

/// Appends the nodes that make one tree of several parts, three at most. These are opened down to their
/// larger subtrees, and the heuristic arranges them anew; the opened nodes stay behind unused. None without
/// parts.
pub(crate) fn join(parts: &[Part], nodes: &mut Vec<Node>) -> Option<Part> {
    if let [_, _, ..] = parts {
        let subtrees: Vec<Part> = parts.iter().flat_map(|&part| open(part, nodes)).collect();
        let boxes: Vec<Bounds> = subtrees.iter().map(|subtree| subtree.bounds).collect();
        let roots: Vec<Child> = subtrees.iter().map(|subtree| subtree.root).collect();
        arrange(&boxes, &roots, JOINT_HEURISTIC_LEVELS, nodes)
    } else {
        parts.first().copied()
    }
}

/// Appends a tree whose leaves are no blocks but `owners`, each in its box. None without any.
pub(crate) fn build_over(boxes: &[Bounds], owners: &[usize], nodes: &mut Vec<Node>) -> Option<Part> {
    let leaves: Vec<Child> = owners.iter().map(|&owner| Child::block(owner)).collect();
    arrange(boxes, &leaves, HEURISTIC_LEVELS, nodes)
}

/// Appends the nodes that make one tree of what lies in boxes.
fn arrange(boxes: &[Bounds], owners: &[Child], heuristic_levels: u32, nodes: &mut Vec<Node>) -> Option<Part> {
    let mut refs: Vec<Ref> = (0..).zip(boxes).map(|(index, &bounds)| Ref::new(bounds, index, 1)).collect();
    let built = Rules { leaf_bits: 0, heuristic_levels }.grow(&mut refs)?;
    let first_node = nodes.len();
    let owner = |child: Child| {
        if child != Child::NONE && child.is_block() {
            owners[refs[built.leaves[child.index()].start].index() as usize]
        } else {
            child.shifted(first_node, 0)
        }
    };
    nodes.extend(built.nodes.into_iter().map(|mut node| {
        node.children = node.children.map(owner);
        node
    }));
    Some(Part { root: owner(built.root), bounds: built.bounds })
}

/// Up to [`JOINT`] subtrees that make up a part: the largest is opened again and again.
fn open(part: Part, nodes: &[Node]) -> Vec<Part> {
    let mut subtrees = vec![part];
    while subtrees.len() + WIDTH <= JOINT {
        let largest = subtrees
            .iter()
            .enumerate()
            .filter(|(_, subtree)| !subtree.root.is_block())
            .max_by(|(_, a), (_, b)| a.bounds.half_area().total_cmp(&b.bounds.half_area()));
        let Some((place, opened)) = largest.map(|(place, subtree)| (place, *subtree)) else { break };
        subtrees.swap_remove(place);
        let node = &nodes[opened.root.index()];
        for (lane, &root) in node.children.iter().enumerate().filter(|(_, child)| **child != Child::NONE) {
            subtrees.push(Part { root, bounds: Bounds::of_child(node, lane) });
        }
    }
    subtrees
}

/// What differs between a tree over triangles and a joint over subtrees.
#[derive(Clone, Copy)]
struct Rules {
    /// What a leaf holds at most, as a power of two, and no less than one reference is; a leaf costs the
    /// heuristic the same however full.
    leaf_bits: u32,
    heuristic_levels: u32,
}

/// References that will be one child, as a range of the array.
#[derive(Clone, Copy)]
struct Span {
    start: usize,
    len: usize,
    /// How much they refer to.
    count: u32,
    bounds: Bounds,
}

impl Span {
    fn range(&self) -> Range<usize> {
        self.start..self.start + self.len
    }
}

/// A tree whose blocks are still ranges of the references.
struct Built {
    nodes: Vec<Node>,
    leaves: Vec<Range<usize>>,
    root: Child,
    bounds: Bounds,
}

/// A child left to its own task.
struct Job {
    parent: usize,
    lane: usize,
    span: Span,
    level: u32,
}

/// The state of one task.
struct Grower<'a> {
    rules: Rules,
    refs: &'a mut [Ref],
    /// Scratch memory for partitioning, as long as `refs`.
    spare: &'a mut [Ref],
    nodes: Vec<Node>,
    leaves: Vec<Range<usize>>,
    /// Where spans of up to [`SUBTREE`] go; None in a task that builds them itself.
    jobs: Option<Vec<Job>>,
}

impl Rules {
    fn leaf_size(self) -> u32 {
        1 << self.leaf_bits
    }

    /// Builds the tree and puts the references into its order. None without references.
    fn grow(self, refs: &mut [Ref]) -> Option<Built> {
        if refs.is_empty() {
            return None;
        }
        let bounds = union(refs);
        let span = Span { start: 0, len: refs.len(), count: count(refs), bounds };
        let mut spare = vec![Ref(Bounds::EMPTY); refs.len()];
        let jobs = (refs.len() > SUBTREE).then(Vec::new);
        let mut top =
            Grower { rules: self, refs, spare: &mut spare, nodes: Vec::new(), leaves: Vec::new(), jobs };
        let root = top.child(span, 0);
        let Grower { mut nodes, mut leaves, jobs, refs, spare, .. } = top;

        let mut jobs = jobs.unwrap_or_default();
        jobs.sort_unstable_by_key(|job| job.span.start);
        let subtrees: Vec<Grower<'_>> = with_slices(&jobs, refs, spare)
            .into_par_iter()
            .map(|(job, refs, spare)| {
                let mut task =
                    Grower { rules: self, refs, spare, nodes: Vec::new(), leaves: Vec::new(), jobs: None };
                task.node(Span { start: 0, ..job.span }, job.level);
                task
            })
            .collect();
        for (job, subtree) in jobs.iter().zip(subtrees) {
            let (first_node, first_leaf) = (nodes.len(), leaves.len());
            nodes[job.parent].children[job.lane] = Child::node(first_node);
            nodes.extend(subtree.nodes.into_iter().map(|mut node| {
                node.children = node.children.map(|child| child.shifted(first_node, first_leaf));
                node
            }));
            let start = job.span.start;
            leaves.extend(subtree.leaves.into_iter().map(|leaf| leaf.start + start..leaf.end + start));
        }
        Some(Built { nodes, leaves, root, bounds })
    }
}

/// Each job with its part of the two arrays; jobs are in the order of their spans.
fn with_slices<'a, 'j>(
    jobs: &'j [Job],
    mut refs: &'a mut [Ref],
    mut spare: &'a mut [Ref],
) -> Vec<(&'j Job, &'a mut [Ref], &'a mut [Ref])> {
    let mut taken = 0;
    jobs.iter()
        .map(|job| {
            let skipped = job.span.start - taken;
            taken = job.span.start + job.span.len;
            let cut = |slice: &mut &'a mut [Ref]| {
                let (_, rest) = std::mem::take(slice).split_at_mut(skipped);
                let (own, rest) = rest.split_at_mut(job.span.len);
                *slice = rest;
                own
            };
            (job, cut(&mut refs), cut(&mut spare))
        })
        .collect()
}

impl Grower<'_> {
    /// A leaf or a node for `span`.
    fn child(&mut self, span: Span, level: u32) -> Child {
        if span.count <= self.rules.leaf_size() {
            self.leaves.push(span.range());
            Child::block(self.leaves.len() - 1)
        } else {
            self.node(span, level)
        }
    }

    /// A node for `span`, which is longer than a leaf, and all below it.
    fn node(&mut self, span: Span, level: u32) -> Child {
        let (spans, count) = self.split_to_eight(span, level);
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        for (lane, span) in spans[..count].iter().enumerate() {
            let child = match &mut self.jobs {
                Some(jobs) if span.count > self.rules.leaf_size() && span.len <= SUBTREE => {
                    jobs.push(Job { parent: index, lane, span: *span, level: level + 1 });
                    Child::NONE
                }
                _ => self.child(*span, level + 1),
            };
            let (lower, upper) = span.bounds.corners();
            self.nodes[index].set(lane, lower.into(), upper.into(), child);
        }
        Child::node(index)
    }

    /// Two to eight spans that make up `span`.
    fn split_to_eight(&mut self, span: Span, level: u32) -> ([Span; WIDTH], usize) {
        let balanced = level >= self.rules.heuristic_levels;
        let mut spans = [span; WIDTH];
        let mut count = 1;
        while count < WIDTH {
            // Of coincident boxes the fullest is split, which keeps the tree shallow.
            let weight = |span: &Span| (if balanced { 0.0 } else { span.bounds.half_area() }, span.count);
            let heaviest = (0..count)
                .filter(|&place| spans[place].count > self.rules.leaf_size())
                .map(|place| (place, weight(&spans[place])))
                .max_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let Some((place, _)) = heaviest else { break };
            [spans[place], spans[count]] = self.split(spans[place], balanced);
            count += 1;
        }
        (spans, count)
    }

    /// Splits at the cheapest border of bins or, if there is none, in the middle.
    fn split(&mut self, span: Span, balanced: bool) -> [Span; 2] {
        let refs = &mut self.refs[span.range()];
        let spare = &mut self.spare[span.range()];
        let grid = Grid::new(middles(refs));
        let best = if balanced { None } else { Bins::fill(&grid, refs).best_border(self.rules.leaf_bits) };
        let (left_len, left_count, bounds) = match best {
            Some(best) => {
                let left_len = partition(refs, spare, |reference| grid.bins(reference)[best.axis] < best.bin);
                (left_len, best.left_count, best.bounds)
            }
            None => {
                let (left, right) = refs.split_at(refs.len() / 2);
                (left.len(), count(left), [union(left), union(right)])
            }
        };
        [
            Span { start: span.start, len: left_len, count: left_count, bounds: bounds[0] },
            Span {
                start: span.start + left_len,
                len: span.len - left_len,
                count: span.count - left_count,
                bounds: bounds[1],
            },
        ]
    }
}

/// Folds `refs`, above [`SUBTREE`] with all threads. `merge` is associative.
fn fold<T: Send>(refs: &[Ref], of_slice: impl Fn(&[Ref]) -> T + Sync, merge: impl Fn(T, T) -> T + Sync) -> T {
    if refs.len() <= SUBTREE {
        return of_slice(refs);
    }
    refs.par_chunks(CHUNK).map(&of_slice).reduce_with(&merge).expect("more references than none")
}

/// How much all refer to.
fn count(refs: &[Ref]) -> u32 {
    fold(refs, |refs: &[Ref]| refs.iter().map(Ref::count).sum(), |a: u32, b| a + b)
}

/// The box around all.
fn union(refs: &[Ref]) -> Bounds {
    let of_slice =
        |refs: &[Ref]| refs.iter().fold(Bounds::EMPTY, |bounds, reference| bounds.union(reference.0));
    fold(refs, of_slice, Bounds::union)
}

/// The box around all centroids.
fn middles(refs: &[Ref]) -> Bounds {
    let of_slice = |refs: &[Ref]| {
        refs.iter().fold(Bounds::EMPTY, |bounds, reference| bounds.with_point(reference.centroid()))
    };
    fold(refs, of_slice, Bounds::union)
}

/// Puts the references that go left before the others, both in their old order; returns how many go left.
/// `spare` is as long as `refs` and loses its content.
fn partition(refs: &mut [Ref], spare: &mut [Ref], goes_left: impl Fn(&Ref) -> bool + Sync) -> usize {
    if refs.len() <= SUBTREE {
        // Each reference is written to both sides, and the side's length tells which write stays: no branch.
        let (mut left, mut right) = (0, 0);
        for index in 0..refs.len() {
            let reference = refs[index];
            let to_left = usize::from(goes_left(&reference));
            refs[left] = reference;
            spare[right] = reference;
            left += to_left;
            right += 1 - to_left;
        }
        refs[left..].copy_from_slice(&spare[..right]);
        return left;
    }
    let counts: Vec<usize> = refs
        .par_chunks(CHUNK)
        .map(|chunk| chunk.iter().filter(|reference| goes_left(reference)).count())
        .collect();
    let left_len = counts.iter().sum();
    let (mut left, mut right) = spare.split_at_mut(left_len);
    let moves: Vec<_> = refs
        .chunks(CHUNK)
        .zip(&counts)
        .map(|(chunk, &count)| {
            let (to_left, rest) = std::mem::take(&mut left).split_at_mut(count);
            left = rest;
            let (to_right, rest) = std::mem::take(&mut right).split_at_mut(chunk.len() - count);
            right = rest;
            (chunk, to_left, to_right)
        })
        .collect();
    moves.into_par_iter().for_each(|(chunk, to_left, to_right)| {
        let (mut left, mut right) = (to_left.iter_mut(), to_right.iter_mut());
        for reference in chunk {
            let place = if goes_left(reference) { left.next() } else { right.next() };
            *place.expect("the first pass counted with the same test") = *reference;
        }
    });
    refs.par_chunks_mut(CHUNK).zip(spare.par_chunks(CHUNK)).for_each(|(to, from)| to.copy_from_slice(from));
    left_len
}

/// Maps centroids to bins.
struct Grid {
    origin: Vec4,
    /// Bins per unit; 0 along an axis in which all centroids are equal.
    scale: Vec4,
}

impl Grid {
    /// 1.5 * 2^23: a number of up to 2^22 added to it is rounded to an integer in the low bits.
    const MAGIC: f32 = 12_582_912.0;

    fn new(middles: Bounds) -> Self {
        let size = middles.upper - middles.lower;
        // A little below 16, so that the last centroid falls into the last bin.
        let scale = Vec4::splat(BINS as f32 * (1.0 - 1e-5)) / size;
        let usable = size.cmpgt(Vec4::splat(1e-30)) & Vec4::splat(f32::INFINITY).cmpgt(scale);
        Self { origin: middles.lower, scale: Vec4::select(usable, scale, Vec4::ZERO) }
    }

    /// The reference's bin along each axis. Rounds `x - 0.5` where the heuristic says floor: all that
    /// matters is that it is monotonic.
    #[inline(always)]
    fn bins(&self, reference: &Ref) -> [usize; 3] {
        let place = (reference.centroid() - self.origin) * self.scale - Vec4::splat(0.5);
        let [x, y, z, _] = (place + Vec4::splat(Self::MAGIC)).to_array();
        [x, y, z].map(|bin| bin.to_bits() as usize % BINS)
    }
}

/// Boxes and counts of the references by bin, for each axis.
struct Bins {
    bounds: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

/// Where to split: references in bins below `bin` go left.
struct Border {
    axis: usize,
    bin: usize,
    /// How much the references that go left refer to.
    left_count: u32,
    bounds: [Bounds; 2],
}

impl Bins {
    fn fill(grid: &Grid, refs: &[Ref]) -> Self {
        let of_slice = |refs: &[Ref]| {
            let mut bins = Self { bounds: [[Bounds::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };
            for reference in refs {
                let count = reference.count();
                for (axis, bin) in grid.bins(reference).into_iter().enumerate() {
                    bins.bounds[axis][bin] = bins.bounds[axis][bin].union(reference.0);
                    bins.counts[axis][bin] += count;
                }
            }
            bins
        };
        fold(refs, of_slice, |mut a, b| {
            for axis in 0..3 {
                for bin in 0..BINS {
                    a.bounds[axis][bin] = a.bounds[axis][bin].union(b.bounds[axis][bin]);
                    a.counts[axis][bin] += b.counts[axis][bin];
                }
            }
            a
        })
    }

    /// The border with the least `area * cost` summed over both sides. None if all are in one bin.
    ///
    /// The cost of a side lies between its leaves if none were split again and its references; of the
    /// weights tried, this one traced fastest on all benchmark scenes, by about 5 %.
    fn best_border(&self, leaf_bits: u32) -> Option<Border> {
        let leaves = |count: u32| (count + (1 << leaf_bits) - 1) >> leaf_bits;
        let cost = |count: u32| count as f32 + 3.0 * leaves(count) as f32;
        let mut best: Option<Border> = None;
        let mut least = f32::INFINITY;
        for axis in 0..3 {
            // Right of each border, summed from the right; then left of it, from the left.
            let mut right = [(Bounds::EMPTY, 0); BINS];
            let mut sum = (Bounds::EMPTY, 0);
            for bin in (1..BINS).rev() {
                sum = (sum.0.union(self.bounds[axis][bin]), sum.1 + self.counts[axis][bin]);
                right[bin] = sum;
            }
            let mut left = (Bounds::EMPTY, 0);
            for (bin, right) in right.into_iter().enumerate().skip(1) {
                left = (left.0.union(self.bounds[axis][bin - 1]), left.1 + self.counts[axis][bin - 1]);
                if left.1 == 0 || right.1 == 0 {
                    continue;
                }
                let sum = left.0.half_area() * cost(left.1) + right.0.half_area() * cost(right.1);
                if sum < least {
                    least = sum;
                    best = Some(Border { axis, bin, left_count: left.1, bounds: [left.0, right.0] });
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_rise_with_the_centroid_and_share_the_extent_evenly() {
        let refs: Vec<Ref> = (0..=1600)
            .map(|index| {
                let p = Vec3::new(index as f32 * 0.01 - 3.0, 1e6 + index as f32, -7.0);
                Ref::new(Bounds::of_triangle(&[p; 3]), index, 1)
            })
            .collect();
        let grid = Grid::new(middles(&refs));
        let mut counts = [[0; BINS]; 3];
        let mut last = [0; 3];
        for reference in &refs {
            let bins = grid.bins(reference);
            assert!(bins.iter().zip(last).all(|(&bin, last)| bin >= last), "{bins:?} after {last:?}");
            last = bins;
            (0..3).for_each(|axis| counts[axis][bins[axis]] += 1);
        }
        assert_eq!(last, [BINS - 1, BINS - 1, 0]);
        let even = |counts: &[i32; BINS]| counts.iter().all(|count| (95..=105).contains(count));
        assert!(even(&counts[0]) && even(&counts[1]) && !even(&counts[2]), "{counts:?}");
    }

    #[test]
    fn two_far_groups_are_told_apart_first() {
        let triangles: Vec<[Vec3; 3]> = (0..2000)
            .map(|index| {
                let corner = Vec3::new((index % 2) as f32 * 50.0, (index / 2) as f32 * 0.01, 0.0);
                [corner, corner + Vec3::X, corner + Vec3::Y]
            })
            .collect();
        let (mut nodes, mut blocks) = (Vec::new(), Vec::new());
        build(&triangles, 0..triangles.len(), 0, &mut nodes, &mut blocks).expect("there are triangles");
        for lane in 0..WIDTH {
            assert!(nodes[0].upper(lane).x - nodes[0].lower(lane).x <= 1.0);
        }
    }
}
