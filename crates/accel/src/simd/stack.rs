//! The traversal stack: what is still to be visited, with the distance at which the ray enters it.

use std::mem::MaybeUninit;

use crate::limits::LEVEL_LIMIT;
use crate::node::{Child, WIDTH};

/// Each level leaves at most seven siblings behind; a push writes eight lanes whatever it keeps.
const CAPACITY: usize = LEVEL_LIMIT as usize * (WIDTH - 1) + 1 + WIDTH;

/// Distances and children in two arrays, so that a sorted node is two vector stores.
pub(crate) struct Slots {
    near: MaybeUninit<[f32; CAPACITY]>,
    children: MaybeUninit<[Child; CAPACITY]>,
}

impl Slots {
    /// Leaves the arrays as they are: clearing 2.6 kB would cost a tenth of a short ray.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { near: MaybeUninit::uninit(), children: MaybeUninit::uninit() }
    }
}

/// Apart from its slots, so that the length can stay in a register.
pub(crate) struct Stack<'a> {
    slots: &'a mut Slots,
    /// Slots below it are written; never above `CAPACITY`.
    len: usize,
}

impl<'a> Stack<'a> {
    #[inline(always)]
    pub(crate) fn new(slots: &'a mut Slots) -> Self {
        Self { slots, len: 0 }
    }

    /// Where the next eight entries go.
    ///
    /// # Panics
    /// When more than [`LEVEL_LIMIT`] levels are open.
    #[inline(always)]
    pub(crate) fn reserve(&mut self) -> (*mut f32, *mut Child) {
        assert!(self.len + WIDTH <= CAPACITY, "the builder bounds the depth of the tree");
        // SAFETY: `len` is below the length of both arrays.
        unsafe {
            (
                self.slots.near.as_mut_ptr().cast::<f32>().add(self.len),
                self.slots.children.as_mut_ptr().cast::<Child>().add(self.len),
            )
        }
    }

    /// Takes over `count` entries written to the reserved slots.
    ///
    /// # Safety
    /// The first `count` slots behind both pointers, eight at most, are written since [`Stack::reserve`].
    #[inline(always)]
    pub(crate) unsafe fn grow(&mut self, count: usize) {
        self.len += count;
    }

    /// # Panics
    /// When more than [`LEVEL_LIMIT`] levels are open.
    #[inline(always)]
    pub(crate) fn push(&mut self, near: f32, child: Child) {
        let (near_slot, child_slot) = self.reserve();
        // SAFETY: both point at a free slot, which is written before it counts.
        unsafe {
            near_slot.write(near);
            child_slot.write(child);
            self.grow(1);
        }
    }

    /// What will be popped next.
    #[inline(always)]
    pub(crate) fn top(&self) -> Option<Child> {
        let index = self.len.checked_sub(1)?;
        // SAFETY: `len` is above this index, and entries below `len` are written.
        Some(unsafe { self.slots.children.as_ptr().cast::<Child>().add(index).read() })
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<(f32, Child)> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: `len` was above this index, and entries below `len` are written.
        unsafe {
            Some((
                self.slots.near.as_ptr().cast::<f32>().add(self.len).read(),
                self.slots.children.as_ptr().cast::<Child>().add(self.len).read(),
            ))
        }
    }
}
