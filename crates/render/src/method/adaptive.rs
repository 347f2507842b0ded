//! Adaptive transparency: visibility over depth as a staircase of N steps, built in one pass, by which a
//! second pass adds up all colours (Salvi, Montgomery and Lefohn 2011).
//!
//! Of one step too many, that one goes whose removal changes the area under the staircase least: it is joined
//! with the step in front, so visibility is never more than it should be. The paper's program spares the
//! steps nearest to the eye; here all are judged alike.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use crate::contract::{
    Fragment, Memory, MethodInfo, NoRaster, PixelSite, Raster, Retrace, UnorderedCompositing, Visitor,
};

/// The most steps that can be asked for.
const MOST_NODES: usize = 32;

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "adaptive",
    title: "visibility over depth in N steps, then the sum of all fragments by it: two passes",
    paper: "Salvi, Montgomery, Lefohn 2011, Adaptive Transparency",
    works: &[&bibliography::SALVI_2011],
    bias: "beyond N fragments some are too dark, as steps of visibility are joined towards the eye; the background is exact",
    parameters: &[
        ParameterInfo {
            key: "nodes",
            default: "8",
            range: ParameterRange::Count(2, MOST_NODES as u32),
            what: "steps of the visibility function",
        },
        Retrace::PARAMETER,
    ],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// Adaptive transparency with a bound on the steps of its visibility function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Adaptive {
    nodes: u32,
    retrace: Retrace,
}

/// A step: what is seen through everything up to it.
#[derive(Clone, Copy, Debug)]
struct Node {
    sort_key: (f32, u32),
    transmittance: f32,
}

/// A pixel's visibility function, and its light.
#[derive(Clone, Debug)]
pub(super) struct Visibility {
    /// Front to back; one more than may stay.
    nodes: [Node; MOST_NODES + 1],
    len: usize,
    rgb_premul: Vec3,
    removed_count: u32,
}

impl Adaptive {
    pub(super) fn new(values: &Values) -> Self {
        Self { nodes: values.count("nodes"), retrace: values.choice(Retrace::PARAMETER.key) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
    }
}

impl Visibility {
    fn nodes(&self) -> &[Node] {
        &self.nodes[..self.len]
    }

    /// What is seen in front of a step.
    fn before(&self, at: usize) -> f32 {
        if at == 0 { 1.0 } else { self.nodes[at - 1].transmittance }
    }

    /// What is seen of a fragment.
    fn at(&self, sort_key: (f32, u32)) -> f32 {
        self.before(self.nodes().partition_point(|node| node.sort_key < sort_key))
    }

    fn insert(&mut self, sort_key: (f32, u32), transmittance: f32) {
        let at = self.nodes().partition_point(|node| node.sort_key <= sort_key);
        self.nodes.copy_within(at..self.len, at + 1);
        self.len += 1;
        self.nodes[at] = Node { sort_key, transmittance: self.before(at) };
        for node in &mut self.nodes[at..self.len] {
            node.transmittance *= transmittance;
        }
    }

    /// Joins the step that matters least with the one in front of it. There are at least two.
    fn remove_least(&mut self) {
        let area = |pair: &[Node]| {
            (pair[1].sort_key.0 - pair[0].sort_key.0) * (pair[0].transmittance - pair[1].transmittance)
        };
        let areas = self.nodes().windows(2).map(area).enumerate();
        let least = areas.min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(at, _)| at);
        self.nodes[least].transmittance = self.nodes[least + 1].transmittance;
        self.nodes.copy_within(least + 2..self.len, least + 1);
        self.len -= 1;
        self.removed_count += 1;
    }
}

impl UnorderedCompositing for Adaptive {
    type Pixel = Visibility;

    fn retrace(&self) -> Retrace {
        self.retrace
    }

    fn pass_count(&self) -> usize {
        2
    }

    fn pass_name(&self, pass: usize) -> &'static str {
        ["visibility", "blend"][pass]
    }

    fn is_order_independent(&self) -> bool {
        false
    }

    fn memory(&self) -> Memory {
        // A step: depth and transmittance.
        Memory::Bounded(8 * self.nodes)
    }

    fn raster(&self) -> Result<Raster, NoRaster> {
        Ok(Raster::Lists)
    }

    fn begin(&self, _: &PixelSite) -> Visibility {
        let unused = Node { sort_key: (f32::INFINITY, u32::MAX), transmittance: 1.0 };
        Visibility { nodes: [unused; MOST_NODES + 1], len: 0, rgb_premul: Vec3::ZERO, removed_count: 0 }
    }

    fn add(
        &self,
        pixel: &mut Visibility,
        pass: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        if pass == 0 {
            pixel.insert(fragment.sort_key(0), 1.0 - fragment.alpha);
            if pixel.len > self.nodes as usize {
                pixel.remove_least();
            }
        } else {
            pixel.rgb_premul += pixel.at(fragment.sort_key(0)) * fragment.alpha * shade();
        }
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Visibility, _: usize) -> f32 {
        pixel.before(pixel.len)
    }

    fn resolve(&self, pixel: &Visibility) -> Vec3 {
        pixel.rgb_premul
    }

    fn merged_count(&self, pixel: &Visibility) -> u32 {
        pixel.removed_count
    }
}
