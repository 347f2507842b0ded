//! Panics of other people's code that become errors: young decoders on damaged data, graphics without memory.

use std::{
    any::Any,
    cell::Cell,
    panic::{self, AssertUnwindSafe},
};

thread_local! {
    /// Whether a panic on this thread becomes an error.
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Does something whose panics, on this thread, become errors.
///
/// The panic hook of the program is called all the same, and by default prints a message; a program that
/// wants none calls [`silence`].
///
/// # Errors
/// What the panic said.
pub fn catch<T>(task: impl FnOnce() -> T) -> Result<T, String> {
    let was_caught = IS_CAUGHT.replace(true);
    // Nothing of what the task had in its hands is used again.
    let outcome = panic::catch_unwind(AssertUnwindSafe(task));
    IS_CAUGHT.set(was_caught);
    outcome.map_err(|payload| said(payload.as_ref()))
}

/// Lets panics that [`catch`] catches say nothing by themselves, and leaves all others to the hook that there
/// is. Called once, by a program and no library.
pub fn silence() {
    let say = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        // "panic in a destructor", "panic in a function that cannot unwind": what ends the program at once.
        let ends_all = panic.payload_as_str().is_some_and(|text| text.starts_with("panic in a "));
        if !IS_CAUGHT.get() || ends_all {
            say(panic);
        }
    }));
}

fn said(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("it panicked").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    thread_local! {
        static TOLD: Cell<u32> = const { Cell::new(0) };
    }

    #[test]
    fn what_is_caught_is_told_to_the_caller_and_nobody_else() {
        let before = panic::take_hook();
        panic::set_hook(Box::new(|_| TOLD.set(TOLD.get() + 1)));
        silence();
        assert_eq!(catch(|| 7), Ok(7));
        assert_eq!(
            catch::<()>(|| panic!("no memory for {}", "queue")),
            Err("no memory for queue".to_owned())
        );
        assert_eq!(catch(|| catch::<()>(|| panic!("deep"))), Ok(Err("deep".to_owned())));
        assert_eq!(TOLD.get(), 0);
        // Others are told as ever, also after one that was caught.
        assert!(panic::catch_unwind(|| panic!("elsewhere")).is_err());
        assert_eq!(TOLD.get(), 1);
        panic::set_hook(before);
    }
}
