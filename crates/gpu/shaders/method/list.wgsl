// The A-buffer (Carpenter 1984): twin of crates/render/src/method/list.rs for one sample a pixel. Fragments
// that the pool has no node for are one more fragment behind all others.
#import shared/chunks
#import shared/composited
#import shared/counters
#import shared/order_by_depth
#import shared/shade

fn composited(pixel: vec2u, ray: CameraRay) -> Composited {
    var result = Composited(vec3f(0.0), 1.0, false, false, Hit());
    begin_chunks();
    while next_chunk(pixel, ray) {
        for (var at = 0u; at < chunk_count; at += 1u) {
            let fragment = chunk[at];
            counted.hits += 1u;
            counted.shaded += 1u;
            result.rgb_premul += result.transmittance * fragment.alpha * shade(ray, fragment.hit, pixel);
            result.transmittance *= 1.0 - fragment.alpha;
            result.transparent = true;
            result.has_furthest = true;
            result.furthest = fragment.hit;
        }
    }
    let rest = tail(pixel);
    result.rgb_premul += result.transmittance * rest.xyz;
    result.transmittance *= 1.0 - rest.w;
    result.transparent = result.transparent || rest.w > 0.0;
    return result;
}
