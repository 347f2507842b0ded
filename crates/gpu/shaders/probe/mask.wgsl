// 4 words in, 6 out: opacity and size of a subset, masks, a position along the curve and a threshold.
#import probe/io
#import shared/mask

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let at = id.x * 4u;
    let v = vec4u(probe_in[at], probe_in[at + 1u], probe_in[at + 2u], probe_in[at + 3u]);
    let alpha = quantised_alpha(unit_from_bits(v.x), v.y);
    let size = set_size(alpha, MASK_SAMPLES, v.z >> (32u - ALPHA_BITS));
    let out = id.x * 6u;
    probe_out[out] = alpha;
    probe_out[out + 1u] = size;
    probe_out[out + 2u] = coin_mask(alpha, v.zw);
    probe_out[out + 3u] = mask_pick(size, v.w);
    probe_out[out + 4u] = along_curve(v.xy);
    probe_out[out + 5u] = stratified_threshold(v.x, v.y);
}
