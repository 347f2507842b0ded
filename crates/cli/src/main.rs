//! Order-independent transparency: render, compare, measure.
fn main() {}
