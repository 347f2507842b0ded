//! OBJ, PLY, STL and hair files: what they mean, and what is said about odd ones.

// Test builds alone see these modules anyway; saying so lets their helpers unwrap like the tests do.
#[cfg(test)]
mod content;
#[cfg(test)]
mod hair;
#[cfg(test)]
mod limits;
#[cfg(test)]
mod obj;
#[cfg(test)]
mod ply;
#[cfg(test)]
mod reading;
#[cfg(test)]
mod stl;
