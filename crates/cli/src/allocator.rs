//! The last line of the memory limit: what is alive is counted, and at the limit, or where the system has
//! nothing left, the program ends with a message and exit code 1.
//!
//! Loaders count before they take and say which part of a file is too large; what they miss ends here, where
//! otherwise the system would end the program, or others for its sake. Nothing can be undone at that point:
//! an allocation has no caller who expects an error. Only Rust's allocations are counted, not those of
//! graphics drivers.
#![expect(unsafe_code, reason = "an allocator is an unsafe trait")]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
    sync::{
        OnceLock,
        atomic::{AtomicBool, AtomicIsize, Ordering},
    },
};

#[global_allocator]
static ALLOCATOR: Counted = Counted;

/// The system's allocator, with a count.
struct Counted;

/// Bytes that are alive, less what threads have not reported yet.
static ALIVE: AtomicIsize = AtomicIsize::new(0);
/// Bytes that may be.
static LIMIT: AtomicIsize = AtomicIsize::new(isize::MAX);
/// Whether the end has begun, in which memory is needed for the last words.
static IS_ENDING: AtomicBool = AtomicBool::new(false);
/// What ends the program.
static END: OnceLock<End> = OnceLock::new();

thread_local! {
    /// Bytes that this thread has taken or given back and not reported.
    static UNREPORTED: Cell<isize> = const { Cell::new(0) };
}

/// How much a thread keeps to itself, so that threads do not wait for one another at each allocation.
const REPORTED: isize = 1 << 16;

/// What code, stacks and libraries take beside what is counted, roughly.
pub(crate) const UNCOUNTED_BYTES: u64 = 32 << 20;

/// Ends the program: who is short of memory, and how many bytes were asked for.
pub(crate) type End = fn(Shortage, usize) -> !;

/// Who has no memory to give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shortage {
    /// The limit that was set.
    Limit,
    /// The system.
    System,
}

/// Says what ends the program where an allocation fails. Only the first call counts.
pub(crate) fn end_with(end: End) {
    let _ = END.set(end);
}

/// Sets how many bytes the program may take in all.
pub(crate) fn set_limit(bytes: u64) {
    let counted = bytes.saturating_sub(UNCOUNTED_BYTES);
    LIMIT.store(isize::try_from(counted).unwrap_or(isize::MAX), Ordering::Relaxed);
}

/// Bytes that an allocation takes with what the system's allocator keeps beside it: a word, rounded up.
fn cost(size: usize) -> isize {
    ((size.saturating_add(8 + 15) & !15).max(32)).try_into().unwrap_or(isize::MAX)
}

/// Counts bytes that are about to be taken, or, below zero, were given back.
#[inline]
fn count(bytes: isize, asked_for: usize) {
    let unreported = UNREPORTED.get().saturating_add(bytes);
    if unreported.abs() < REPORTED {
        UNREPORTED.set(unreported);
        return;
    }
    UNREPORTED.set(0);
    let alive = ALIVE.fetch_add(unreported, Ordering::Relaxed).saturating_add(unreported);
    if unreported > 0 && alive > LIMIT.load(Ordering::Relaxed) {
        end(Shortage::Limit, asked_for);
    }
}

#[cold]
fn end(shortage: Shortage, asked_for: usize) {
    if let Some(end) = END.get()
        && !IS_ENDING.swap(true, Ordering::Relaxed)
    {
        end(shortage, asked_for);
    }
}

/// What the system gave, or the end.
#[inline]
fn given(memory: *mut u8, asked_for: usize) -> *mut u8 {
    if memory.is_null() {
        end(Shortage::System, asked_for);
    }
    memory
}

// SAFETY: every call is the system allocator's with the same arguments; beside it there is only arithmetic.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(cost(layout.size()), layout.size());
        // SAFETY: what holds of the arguments here holds there.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(cost(layout.size()), layout.size());
        // SAFETY: what holds of the arguments here holds there.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: what holds of the arguments here holds there.
        unsafe { System.dealloc(memory, layout) };
        count(-cost(layout.size()), 0);
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        count(cost(new_size) - cost(layout.size()), new_size);
        // SAFETY: what holds of the arguments here holds there.
        given(unsafe { System.realloc(memory, layout, new_size) }, new_size)
    }
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn what_is_taken_is_counted_and_what_is_given_back_is_not() {
        let alive = || ALIVE.load(Ordering::Relaxed);
        // Other tests run beside this one: the amount has to stand out.
        let before = alive();
        let mut taken: Vec<u8> = black_box(Vec::with_capacity(1 << 30));
        assert!(alive() - before > 1 << 29);
        taken.reserve_exact(3 << 30);
        let taken = black_box(taken);
        assert!(alive() - before > 5 << 29);
        drop(taken);
        assert!(alive() - before < 1 << 29);
    }

    #[test]
    fn small_allocations_cost_what_the_system_takes_for_them() {
        assert_eq!([0, 1, 24, 25, 40, 1000].map(cost), [32, 32, 32, 48, 48, 1008]);
        assert_eq!(cost(usize::MAX), isize::MAX);
    }
}
