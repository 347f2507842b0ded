//! glTF files: what they mean, and what is said about bad ones.

// Test builds alone see these modules anyway; saying so lets their helpers unwrap like the tests do.
#[cfg(test)]
mod assets;
#[cfg(test)]
mod builder;
#[cfg(test)]
mod choices;
#[cfg(test)]
mod faults;
#[cfg(test)]
mod features;
#[cfg(test)]
mod salvage;
