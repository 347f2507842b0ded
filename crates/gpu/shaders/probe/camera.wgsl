// 2 words in, the bits of a point in pixels; 8 out, the bits of the origin and the direction of its ray, and
// of the distances between which the camera sees.
#import probe/io
#import shared/camera

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let at = id.x * 2u;
    let ray = camera_ray(bitcast<vec2f>(vec2u(probe_in[at], probe_in[at + 1u])));
    let origin = bitcast<vec3u>(ray.origin);
    let direction = bitcast<vec3u>(ray.direction);
    for (var axis = 0u; axis < 3u; axis++) {
        probe_out[id.x * 8u + axis] = origin[axis];
        probe_out[id.x * 8u + 3u + axis] = direction[axis];
    }
    probe_out[id.x * 8u + 6u] = bitcast<u32>(ray.nearest);
    probe_out[id.x * 8u + 7u] = bitcast<u32>(ray.furthest);
}
