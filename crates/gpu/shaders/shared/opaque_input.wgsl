// What the caller has drawn: how its depths and motions are to be read.
#import struct/OpaqueUniform

@group(GROUP_PASS) @binding(BIND_INPUT) var<uniform> opaque_input: OpaqueUniform;

// Along the viewing axis, world units; FAR_AWAY where nothing is: twin of `DepthRow::distance`.
fn distance_of_depth(ndc: f32) -> f32 {
    let row = opaque_input.depth_row;
    let divisor = row.x - ndc * row.z;
    if ndc == opaque_input.nothing || divisor == 0.0 {
        return FAR_AWAY;
    }
    let distance = (row.y - ndc * row.w) / divisor;
    return select(FAR_AWAY, distance, distance >= 0.0 && distance < FAR_AWAY);
}
