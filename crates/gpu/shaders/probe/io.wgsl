// What probes read and write: words, so many an input and an output.
@group(1) @binding(0) var<storage, read> probe_in: array<u32>;
@group(1) @binding(1) var<storage, read_write> probe_out: array<u32>;
