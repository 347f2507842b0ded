//! glTF files: what they mean, what is said about bad ones, and that no damage makes the loader panic.

// Test builds alone see these modules anyway; saying so lets their helpers unwrap like the tests do.
#[cfg(test)]
mod assets;
#[cfg(test)]
mod builder;
#[cfg(test)]
mod faults;
#[cfg(test)]
mod features;
#[cfg(test)]
mod mutation;
#[cfg(test)]
mod salvage;
