// 4 words in: pixel, frame and seed; 1 out, the bits of the method's threshold.
#import method
#import probe/io

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let at = id.x * 4u;
    let pixel = vec2u(probe_in[at], probe_in[at + 1u]);
    probe_out[id.x] = bitcast<u32>(selection_threshold(pixel, probe_in[at + 2u], probe_in[at + 3u]));
}
