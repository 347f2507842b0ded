//! The papers' numbers and the methods' promises, from theory, as printed, and as measured; and whether a GPU
//! keeps them.

use crate::{Progress, Result};

mod check;
mod correction;
mod ends;
mod estimate;
mod glass;
mod layers;
mod maps;
mod model;
mod picture;
mod reprojection;
mod shadows;
mod stacked;
mod still;
mod stochastic;
mod threads;
mod thresholds;
mod twins;
mod unbiased;

pub use self::{
    check::{Check, Value, judge},
    twins::{Twins, twins},
};

/// What papers and methods promise, kept by the CPU; not judged yet.
///
/// # Errors
/// A check could not be made.
pub fn promises(threads: Option<usize>, progress: &dyn Progress) -> Result<Vec<Check>> {
    type Group = fn(Option<usize>) -> Result<Vec<Check>>;
    let groups: [(&str, Group); 13] = [
        ("threshold maps", |_| Ok(maps::checks())),
        ("layers", layers::checks),
        ("coloured glass", glass::checks),
        ("alpha 0 and 1", ends::checks),
        ("threads", |_| threads::checks()),
        ("unbiased methods", unbiased::checks),
        ("stacked layers", stacked::checks),
        ("still pictures", still::checks),
        ("thresholds", |_| thresholds::checks()),
        ("motion vectors", |_| Ok(reprojection::checks())),
        ("correction", correction::checks),
        ("shadows", shadows::checks),
        ("stochastic", |_| stochastic::checks()),
    ];
    progress.expect(groups.len() as u64);
    let mut checks = Vec::new();
    for (name, group) in groups {
        progress.name(name);
        checks.extend(group(threads)?);
        progress.step();
    }
    Ok(checks)
}
