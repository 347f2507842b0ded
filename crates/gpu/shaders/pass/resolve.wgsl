// Adds a frame up by the anti-aliasing technique: twin of `History::add` in
// crates/render/src/temporal/mod.rs.
#import shared/temporal
#import technique

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_resolve(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= temporal.size) {
        return;
    }
    let at = index_of(id.xy);
    if temporal.count == 0u {
        next_history[at] = pixels[at].colour;
        return;
    }
    next_history[at] = resolved(id.xy, pixels[at]);
}
