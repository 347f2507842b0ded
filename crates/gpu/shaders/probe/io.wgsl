// What probes read and write: words, so many an input and an output.
@group(GROUP_PASS) @binding(BIND_PROBE_IN) var<storage, read> probe_in: array<u32>;
@group(GROUP_PASS) @binding(BIND_PROBE_OUT) var<storage, read_write> probe_out: array<u32>;
