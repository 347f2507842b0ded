// The plain mean of frames of one moment: twin of `add_to_mean` in crates/render/src/temporal/mod.rs.
#import shared/temporal

@compute @workgroup_size(8, 8)
fn cs_accumulate(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= temporal.size) {
        return;
    }
    let at = index_of(id.xy);
    let current = pixels[at].colour;
    if temporal.count == 0u {
        next_history[at] = current;
        return;
    }
    let weight = 1.0 / (f32(temporal.count) + 1.0);
    let mean = history[at];
    next_history[at] = mean + (current - mean) * weight;
}
