//! The project's own tasks: test, assets, docs.
fn main() {}
