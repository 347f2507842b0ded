//! Lanes without intrinsics; compilers turn most of it into vector code by themselves.

use std::array::from_fn;

use super::lanes::{Lanes, key};
use super::stack::Stack;
use crate::node::{Child, WIDTH};

#[derive(Clone, Copy)]
pub(super) struct Portable;

#[inline(always)]
fn mask(test: impl Fn(usize) -> bool) -> u32 {
    (0..WIDTH).fold(0, |mask, lane| mask | u32::from(test(lane)) << lane)
}

impl Lanes for Portable {
    type F = [f32; WIDTH];

    #[inline(always)]
    fn load(self, values: &[f32; WIDTH]) -> Self::F {
        *values
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::F {
        [value; WIDTH]
    }

    #[inline(always)]
    fn store(self, values: Self::F) -> [f32; WIDTH] {
        values
    }

    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|lane| a[lane] + b[lane])
    }

    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|lane| a[lane] - b[lane])
    }

    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|lane| a[lane] * b[lane])
    }

    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|lane| a[lane] / b[lane])
    }

    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|lane| if a[lane] < b[lane] { a[lane] } else { b[lane] })
    }

    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|lane| if a[lane] > b[lane] { a[lane] } else { b[lane] })
    }

    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> u32 {
        mask(|lane| a[lane] <= b[lane])
    }

    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> u32 {
        mask(|lane| a[lane] < b[lane])
    }

    #[inline(always)]
    fn transpose(self, rows: [Self::F; WIDTH]) -> [Self::F; WIDTH] {
        from_fn(|row| from_fn(|lane| rows[lane][row]))
    }

    #[inline(always)]
    fn prefetch<T>(self, _: &T) {}

    /// Insertion sort: most nodes have one to three children on a ray.
    #[inline(always)]
    fn push(self, stack: &mut Stack<'_>, near: Self::F, mut hits: u32, children: &[Child; WIDTH]) {
        let mut keys = [0; WIDTH];
        let mut count = 0;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize % WIDTH;
            hits &= hits - 1;
            let new = key(near[lane], lane);
            let mut slot = count;
            while slot > 0 && keys[slot - 1] > new {
                keys[slot] = keys[slot - 1];
                slot -= 1;
            }
            keys[slot] = new;
            count += 1;
        }
        for key in &keys[..count] {
            stack.push(f32::from_bits(!key & !7), children[(!key & 7) as usize]);
        }
    }
}
