//! What a traversal asks of eight lanes of `f32`, whatever the instructions.

use super::stack::Stack;
use crate::node::{Child, WIDTH};

/// Eight lanes of `f32`. Masks have one bit a lane, lane 0 lowest. `min` and `max` return their second
/// operand when the first is NaN or the two are equal, as the x86 instructions do.
pub(crate) trait Lanes: Copy {
    /// A register of eight numbers.
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

    /// Eight registers whose lane `i` becomes lanes of register `i`.
    fn transpose(self, rows: [Self::F; WIDTH]) -> [Self::F; WIDTH];
    /// Asks for the memory of a value that is read soon; nothing else happens.
    fn prefetch<T>(self, value: &T);

    /// Pushes the children named by `hits`, nearest last. `near` is not negative there; it is rounded down
    /// to the stack's keys (see [`key`]), which keeps culling conservative.
    fn push(self, stack: &mut Stack<'_>, near: Self::F, hits: u32, children: &[Child; WIDTH]);
}

/// Sort key of a child: the bits of a non-negative `f32` are ordered like the number, the lowest three
/// carry the lane, and the complement turns "nearest first" into the order of a stack.
#[inline(always)]
pub(super) fn key(near: f32, lane: usize) -> u32 {
    !((near.to_bits() & !7) | lane as u32)
}
