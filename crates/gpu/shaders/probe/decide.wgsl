// 2 words in, 2 out: the coverage of an opacity, and whether it is kept against a threshold.
#import probe/io
#import shared/decide

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let alpha = bitcast<f32>(probe_in[id.x * 2u]);
    let threshold = bitcast<f32>(probe_in[id.x * 2u + 1u]);
    probe_out[id.x * 2u] = bitcast<u32>(coverage(alpha));
    probe_out[id.x * 2u + 1u] = u32(keeps(alpha, threshold));
}
