// Multi-layer alpha blending (Salvi and Vaidyanathan 2014, section 3): twin of
// crates/render/src/method/mlab.rs.
//
// The paper changes a pixel's layers as its fragments are drawn, which takes ordered access to memory from
// fragment shaders. There is none here: fragments go to a list a pixel first, and are taken from it in the
// order of their triangles, which is the order that such access keeps. The picture is the paper's; the list's
// memory comes on top.
#import shared/chunks
#import shared/composited
#import shared/counters
#import shared/order_by_triangle
#import shared/shade
#import shared/stack

fn composited(pixel: vec2u, ray: CameraRay) -> Composited {
    var result = Composited(vec3f(0.0), 1.0, false, false, Hit());
    stack_count = 0u;
    begin_chunks();
    while next_chunk(pixel, ray) {
        for (var at = 0u; at < chunk_count; at += 1u) {
            let fragment = chunk[at];
            let hit = fragment.hit;
            counted.hits += 1u;
            counted.shaded += 1u;
            let rgb_premul = fragment.alpha * shade(ray, hit, pixel);
            insert_into_stack(StackLayer(rgb_premul, 1.0 - fragment.alpha, fragment.depth, hit.triangle));
            if stack_count > P_K {
                counted.merged += 1u;
                merge_furthest();
            }
            if !result.has_furthest || is_behind(hit, result.furthest) {
                result.furthest = hit;
                result.has_furthest = true;
            }
        }
    }
    for (var at = 0u; at < stack_count; at += 1u) {
        result.rgb_premul += result.transmittance * stack[at].rgb_premul;
        result.transmittance *= stack[at].transmittance;
    }
    let rest = tail(pixel);
    result.rgb_premul += result.transmittance * rest.xyz;
    result.transmittance *= 1.0 - rest.w;
    result.transparent = result.has_furthest || rest.w > 0.0;
    return result;
}
