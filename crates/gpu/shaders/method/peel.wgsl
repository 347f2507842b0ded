// Depth peeling (Mammen 1989, Everitt 2001): twin of crates/render/src/method/peel.rs. A pass finds the
// triangle of each pixel's next layer, as a visibility buffer does; then that layer alone is shaded, where
// the CPU shades, as Everitt's, whatever passes both depth tests.
#import shared/composited
#import shared/counters
#import shared/drawn
#import shared/resolve_pixel
#import shared/shade

// The layer of the pass before, or of this one: bits of its depth, and its triangle; NONE if there was none.
@group(GROUP_OWN) @binding(BIND_LAYER_KEYS) var layer_keys: texture_2d<u32>;
// Light of all layers so far and their alpha, four floats a pixel.
@group(GROUP_OWN) @binding(BIND_PEELED_LAYERS) var<storage, read_write> peeled: array<vec4f>;

struct Peeled {
    @location(0) key: vec2u,
    @builtin(frag_depth) depth: f32,
}

fn peel(vertex: TriangleVertex) -> Peeled {
    let fragment = drawn(vertex, camera_ray(sample_of(pixel_at)));
    let key = vec2u(bitcast<u32>(fragment.depth), fragment.hit.triangle);
    // Of equal depths the depth test keeps what is drawn first: the triangle with the lower number.
    return Peeled(select(vec2u(NONE), key, fragment.alpha > 0.0), clamp(fragment.depth / frame.reach, 0.0, 1.0));
}

@fragment
fn fs_first(vertex: TriangleVertex) -> Peeled {
    pixel_at = vec2u(vertex.position.xy);
    let next = peel(vertex);
    if next.key.y == NONE {
        discard;
    }
    counted.hits += 1u;
    hand_in_counts();
    return next;
}

@fragment
fn fs_next(vertex: TriangleVertex) -> Peeled {
    pixel_at = vec2u(vertex.position.xy);
    let next = peel(vertex);
    let last = textureLoad(layer_keys, pixel_at, 0).xy;
    // Nothing lies behind a layer that was not there.
    if next.key.y == NONE || last.y == NONE
        || !is_in_front(bitcast<f32>(last.x), last.y, bitcast<f32>(next.key.x), next.key.y) {
        discard;
    }
    return next;
}

// Blends a layer behind those before.
@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_blend(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    pixel_at = id.xy;
    let triangle = textureLoad(layer_keys, pixel_at, 0).y;
    if triangle == NONE {
        return;
    }
    let ray = camera_ray(sample_of(pixel_at));
    let hit = fragment_hit(pixel_at, triangle);
    let alpha = alpha_of(hit);
    counted.shaded += 1u;
    let at = pixel_at.y * frame.size.x + pixel_at.x;
    peeled[at] = over(peeled[at], vec4f(alpha * shade(ray, hit, pixel_at), alpha));
    hand_in_counts();
}

fn composited(pixel: vec2u, ray: CameraRay) -> Composited {
    let front = peeled[pixel.y * frame.size.x + pixel.x];
    return Composited(front.xyz, 1.0 - front.w, front.w > 0.0, false, Hit());
}
