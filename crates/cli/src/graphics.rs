//! What the graphics library does where it has no error to give: it panics, above all without memory; and
//! what drivers do there: they end the program, so that they are not asked.

use sheer_core::{caught_panic, text::MemorySize};

use crate::memory;

/// Why there are no graphics.
#[derive(Debug, thiserror::Error)]
enum GraphicsFailure {
    /// What the library said as it failed.
    #[error("the graphics library has failed ({0}); free memory, update the driver, or take --backend cpu")]
    Panic(String),
    /// Drivers are known to crash.
    #[error(
        "a graphics driver may take {needed} of memory, and {free} are free; free some, or take --backend cpu"
    )]
    Memory { needed: MemorySize, free: MemorySize },
}

/// What a driver may take to tell what there is, and to open a device: below, Mesa's software driver crashes.
pub(crate) const LISTING: MemorySize = MemorySize(350_000_000);
pub(crate) const RENDERING: MemorySize = MemorySize(900_000_000);

/// Does something with the graphics library, whose panics become errors, where a driver finds the memory that
/// it may take.
pub(crate) fn guarded<T>(needed: MemorySize, task: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    if let Some(free) = memory::free().filter(|free| *free < needed) {
        return Err(GraphicsFailure::Memory { needed, free }.into());
    }
    caught_panic::catch(task).unwrap_or_else(|said| Err(GraphicsFailure::Panic(said).into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_that_says_what_to_do() {
        let message =
            guarded::<()>(MemorySize(0), || panic!("no memory for {}", "queue")).unwrap_err().to_string();
        assert!(message.contains("(no memory for queue); free memory"), "{message}");
        assert_eq!(guarded(MemorySize(0), || Ok(7)).unwrap(), 7);
        // Where the system says what is free, no driver is asked in vain.
        if memory::free().is_some() {
            let message = guarded(MemorySize(u64::MAX), || Ok(())).unwrap_err().to_string();
            assert!(message.contains("are free; free some"), "{message}");
        }
    }
}
