//! How far a measurement is, for whoever waits for it.

use crate::Result;

/// Hears how far a measurement is and what its user should know.
pub trait Progress {
    /// So many more steps are to come.
    fn expect(&self, steps: u64);
    /// What the next steps are about.
    fn name(&self, what: &str);
    /// A step is done.
    fn step(&self);
    /// Asked after each step of a clip: whether anybody still waits for it.
    ///
    /// # Errors
    /// Ends the measurement with this error; [`LabError::Output`](crate::LabError::Output) takes any.
    fn go_on(&self) -> Result<()> {
        Ok(())
    }
    /// What the user may like to know.
    fn note(&self, text: &str);
    /// What is not as the user may think.
    fn warn(&self, text: &str);
}

/// Tells no one.
#[derive(Clone, Copy, Debug)]
pub struct Silent;

impl Progress for Silent {
    fn expect(&self, _: u64) {}
    fn name(&self, _: &str) {}
    fn step(&self) {}
    fn note(&self, _: &str) {}
    fn warn(&self, _: &str) {}
}
