//! Eight lanes of `f32` on three paths, and the traversal compiled once for each.
//!
//! The arithmetic of a hit is written once, in [`crate::traverse`], over [`Lanes`]; no path fuses a
//! multiplication with an addition, so all paths give the same bits.
#![expect(
    unsafe_code,
    reason = "intrinsics and an uninitialised stack; nothing else in the crate needs them"
)]

mod portable;
mod stack;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::fmt;

use crate::bvh::Tree;
use crate::node::{Child, WIDTH};
use crate::{Hit, Ray, traverse};

pub(crate) use stack::{LEVEL_LIMIT, Slots, Stack};

/// The instructions a tree is traversed with. Hits are bit-equal on all paths; only the speed differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SimdPath {
    /// AVX-512 F, VL, BW and DQ on x86-64.
    Avx512,
    /// AVX2 on x86-64.
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
    pub(crate) fn traverse(self, tree: Tree<'_>, ray: &Ray, visit: impl FnMut(Hit) -> f32) {
        match self.0 {
            // SAFETY: `new` and `detect` make a `SupportedPath` only after `is_supported`.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx512 => unsafe { x86::traverse_avx512(tree, ray, visit) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            SimdPath::Avx2 => unsafe { x86::traverse_avx2(tree, ray, visit) },
            _ => traverse::traverse(portable::Portable, tree, ray, visit),
        }
    }
}

/// Eight lanes of `f32`. Masks have one bit a lane, lane 0 lowest. `min` and `max` return their second
/// operand when the first is NaN or the two are equal, as the x86 instructions do.
pub(crate) trait Lanes: Copy {
    /// Eight numbers.
    type F: Copy;

    fn load(self, values: &[f32; WIDTH]) -> Self::F;
    fn splat(self, value: f32) -> Self::F;
    fn store(self, values: Self::F) -> [f32; WIDTH];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// Lanes with `a <= b`.
    fn le(self, a: Self::F, b: Self::F) -> u32;
    /// Lanes with `a < b`.
    fn lt(self, a: Self::F, b: Self::F) -> u32;

    /// Pushes the children named by `hits`, nearest last. `near` is not negative there; it is rounded down
    /// to the stack's keys (see [`key`]), which keeps culling conservative.
    fn push(self, stack: &mut Stack<'_>, near: Self::F, hits: u32, children: &[Child; WIDTH]);
}

/// Sort key of a child: the bits of a non-negative `f32` are ordered like the number, the lowest three
/// carry the lane, and the complement turns "nearest first" into the order of a stack.
#[inline(always)]
fn key(near: f32, lane: usize) -> u32 {
    !((near.to_bits() & !7) | lane as u32)
}
