//! Eight lanes of `f32` on three paths, and the traversal compiled once for each.
//!
//! The arithmetic of a hit is written once, in `traverse::Areas`, over [`lanes::Lanes`]; no path fuses a
//! multiplication with an addition, so all paths give the same bits.
#![expect(
    unsafe_code,
    reason = "intrinsics and an uninitialised stack; nothing else in the crate needs them"
)]

pub(crate) mod lanes;
mod portable;
pub(crate) mod stack;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::fmt;

use crate::column::{self, Column};
use crate::instance::TopLevel;
use crate::packet;
use crate::ray::{Hit, Ray};
use crate::traverse;
use crate::tree::Tree;

/// The instructions a tree is traversed with. Hits are bit-equal on all paths; only the speed differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SimdPath {
    /// AVX-512 F, VL, BW and DQ on x86-64.
    Avx512,
    /// AVX2 with BMI1 and BMI2 on x86-64.
    Avx2,
    /// No intrinsics: any processor.
    Portable,
}

impl SimdPath {
    /// All paths, fastest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// The fastest path that this processor runs.
    pub fn detect() -> Self {
        Self::ALL.into_iter().find(|path| path.is_supported()).unwrap_or(Self::Portable)
    }

    /// Whether this processor runs the path.
    pub fn is_supported(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => x86::has_avx512(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => x86::has_avx2(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx512 | Self::Avx2 => false,
            Self::Portable => true,
        }
    }
}

impl fmt::Display for SimdPath {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        })
    }
}

/// A path that this processor was found to run: the only way to it is [`SupportedPath::new`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct SupportedPath(SimdPath);

impl SupportedPath {
    pub(crate) fn new(path: SimdPath) -> Option<Self> {
        path.is_supported().then_some(Self(path))
    }

    pub(crate) fn detect() -> Self {
        Self(SimdPath::detect())
    }

    pub(crate) fn get(self) -> SimdPath {
        self.0
    }

    /// Runs the traversal compiled for the path. `visit` is inlined into it.
    #[inline]
    pub(crate) fn traverse<const IN_ORDER: bool>(
        self,
        tree: Tree<'_>,
        ray: &Ray,
        visit: impl FnMut(Hit) -> f32,
    ) {
        match self.0 {
            // SAFETY: `new` and `detect` make a `SupportedPath` only after `is_supported`.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx512 => unsafe { x86::traverse_avx512::<IN_ORDER>(tree, ray, visit) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx2 => unsafe { x86::traverse_avx2::<IN_ORDER>(tree, ray, visit) },
            _ => traverse::traverse::<IN_ORDER, _>(portable::Portable, tree, ray, visit),
        }
    }

    /// Runs the walk down a light buffer's list compiled for the path. `visit` is inlined into it.
    #[inline]
    pub(crate) fn scan(self, column: &Column<'_>, t_max: f32, visit: impl FnMut(Hit) -> f32) {
        match self.0 {
            // SAFETY: `new` and `detect` make a `SupportedPath` only after `is_supported`.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx512 => unsafe { x86::scan_avx512(column, t_max, visit) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx2 => unsafe { x86::scan_avx2(column, t_max, visit) },
            _ => column::scan(portable::Portable, column, t_max, visit),
        }
    }

    /// The same as [`Self::traverse`] through a tree and the instances beside it. Here `visit` is called:
    /// what an instance costs more than a triangle in the world outweighs that, and nothing is compiled
    /// twice.
    pub(crate) fn traverse_two_levels(
        self,
        tree: Tree<'_>,
        top: &TopLevel,
        ray: &Ray,
        visit: &mut dyn FnMut(Hit) -> f32,
    ) {
        match self.0 {
            // SAFETY: `new` and `detect` make a `SupportedPath` only after `is_supported`.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx512 => unsafe { x86::traverse_two_levels_avx512(tree, top, ray, visit) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx2 => unsafe { x86::traverse_two_levels_avx2(tree, top, ray, visit) },
            _ => traverse::traverse_two_levels(portable::Portable, tree, top, ray, visit),
        }
    }

    /// Runs the traversal of packets compiled for the path. `visit` is inlined into it.
    #[inline]
    pub(crate) fn traverse_packet(self, tree: Tree<'_>, rays: &[Ray], visit: impl FnMut(usize, Hit) -> f32) {
        match self.0 {
            // SAFETY: `new` and `detect` make a `SupportedPath` only after `is_supported`.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx512 => unsafe { x86::traverse_packet_avx512(tree, rays, visit) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx2 => unsafe { x86::traverse_packet_avx2(tree, rays, visit) },
            _ => packet::traverse(portable::Portable, tree, rays, visit),
        }
    }

    /// The same through a tree and the instances beside it, where `visit` is called.
    pub(crate) fn traverse_packet_two_levels(
        self,
        tree: Tree<'_>,
        top: &TopLevel,
        rays: &[Ray],
        visit: &mut dyn FnMut(usize, Hit) -> f32,
    ) {
        match self.0 {
            // SAFETY: `new` and `detect` make a `SupportedPath` only after `is_supported`.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx512 => unsafe { x86::traverse_packet_two_levels_avx512(tree, top, rays, visit) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx2 => unsafe { x86::traverse_packet_two_levels_avx2(tree, top, rays, visit) },
            _ => packet::traverse_two_levels(portable::Portable, tree, top, rays, visit),
        }
    }
}
