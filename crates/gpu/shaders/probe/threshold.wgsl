// 15 words in, a site; 1 out, the bits of the method's threshold.
#import method
#import probe/io
#import shared/site

fn probe_float(at: u32) -> f32 {
    return bitcast<f32>(probe_in[at]);
}

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let at = id.x * 15u;
    var site: Site;
    site.pixel = vec2u(probe_in[at], probe_in[at + 1u]);
    site.frame = probe_in[at + 2u];
    site.seed = probe_in[at + 3u];
    site.instance = probe_in[at + 4u];
    site.geometry = probe_in[at + 5u];
    site.primitive = probe_in[at + 6u];
    site.back = probe_in[at + 7u];
    site.position = vec3f(probe_float(at + 8u), probe_float(at + 9u), probe_float(at + 10u));
    if USES_OBJECT_SPACE {
        site.position_in_object = vec3f(probe_float(at + 11u), probe_float(at + 12u), probe_float(at + 13u));
        site.footprint_in_object = probe_float(at + 14u);
    }
    probe_out[id.x] = bitcast<u32>(threshold(site));
}
