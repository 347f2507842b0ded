// 4 words in, 14 out: every hash of them, the bits of a unit number, a high half of a product, a rotation and
// a McGuire hash.
#import probe/io
#import shared/hash

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let at = id.x * 4u;
    let v = vec4u(probe_in[at], probe_in[at + 1u], probe_in[at + 2u], probe_in[at + 3u]);
    let two = pcg2d(v.xy);
    let three = pcg3d(v.xyz);
    let four = pcg4d(v);
    let out = id.x * 14u;
    probe_out[out] = pcg(v.x);
    probe_out[out + 1u] = two.x;
    probe_out[out + 2u] = two.y;
    probe_out[out + 3u] = three.x;
    probe_out[out + 4u] = three.y;
    probe_out[out + 5u] = three.z;
    probe_out[out + 6u] = four.x;
    probe_out[out + 7u] = four.y;
    probe_out[out + 8u] = four.z;
    probe_out[out + 9u] = four.w;
    probe_out[out + 10u] = bitcast<u32>(unit_from_bits(v.x));
    probe_out[out + 11u] = mul_high(v.x, v.y);
    probe_out[out + 12u] = rotate_left(v.x, 16u);
    probe_out[out + 13u] = bitcast<u32>(mcguire3(vec3f(vec3u(v.xyz % 1000u))));
}
