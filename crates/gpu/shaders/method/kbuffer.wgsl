// The k-buffer: the k nearest fragments of a pixel in order, and all others merged behind them.
//
// Bavoil et al. 2007 insert a fragment into sorted slots as it is drawn and blend the nearest into the
// picture where all are taken: twin of that is crates/render/src/method/kbuffer.rs. It takes ordered access
// to memory from fragment shaders, which there is not here, and a lock may hang. So a first pass makes a
// chain of atomic maxima over depths (Liu et al. 2010, FreePipe, section 4.2): each slot keeps the nearer of
// two and hands the further one on. Which fragments stay does not depend on the order: those that are
// nearest. A second pass lets each fragment find the slot that its depth has won. Up to k fragments the
// picture is the CPU's. Of more, the k nearest are exact and the others come behind them as a mean by alpha;
// there, what arrives too late is blended behind what it should hide.
#import shared/composited
#import shared/counters
#import shared/drawn
#import shared/shade
#import shared/tail_targets

// P_K slots a pixel, nearest first: complements of the bits of depths. Those of positive numbers are ordered
// as the numbers are, and 0, what a cleared buffer holds, is further than all of them.
@group(GROUP_OWN) @binding(BIND_KEPT_DEPTHS) var<storage, read_write> kept_depths: array<atomic<u32>>;
// Complements of the triangles in these slots.
@group(GROUP_OWN) @binding(BIND_KEPT_TRIANGLES) var<storage, read_write> kept_triangles: array<atomic<u32>>;

fn first_slot(pixel: vec2u) -> u32 {
    return P_K * (pixel.y * frame.size.x + pixel.x);
}

// Draws nothing: a pass has to have a target.
@fragment
fn fs_keep(vertex: TriangleVertex) -> Tail {
    pixel_at = vec2u(vertex.position.xy);
    let fragment = drawn(vertex, camera_ray(sample_of(pixel_at)));
    if fragment.alpha > 0.0 {
        let first = first_slot(pixel_at);
        var key = ~bitcast<u32>(fragment.depth);
        // Equal ones take a slot each.
        for (var slot = 0u; slot < P_K && key != 0u; slot += 1u) {
            key = min(key, atomicMax(&kept_depths[first + slot], key));
        }
    }
    discard;
    return Tail(vec4f(0.0), 1.0);
}

// Puts a triangle into the slot of its depth. Fragments of one depth have neighbouring slots, which are a
// chain of their own, by triangle. Gives the complement of the triangle that has no slot, which may be
// another one than this; 0 if all have one.
fn claim(pixel: vec2u, fragment: Fragment) -> u32 {
    let first = first_slot(pixel);
    let key = ~bitcast<u32>(fragment.depth);
    var triangle = ~fragment.hit.triangle;
    for (var slot = 0u; slot < P_K && triangle != 0u; slot += 1u) {
        if atomicLoad(&kept_depths[first + slot]) == key {
            triangle = min(triangle, atomicMax(&kept_triangles[first + slot], triangle));
        }
    }
    return triangle;
}

@fragment
fn fs_claim(vertex: TriangleVertex) -> Tail {
    pixel_at = vec2u(vertex.position.xy);
    let ray = camera_ray(sample_of(pixel_at));
    let fragment = drawn(vertex, ray);
    if fragment.alpha <= 0.0 {
        discard;
    }
    let without_slot = claim(pixel_at, fragment);
    if without_slot == 0u {
        discard;
    }
    let hit = fragment_hit(pixel_at, ~without_slot);
    counted.hits += 1u;
    counted.shaded += 1u;
    counted.merged += 1u;
    let rgb = shade(ray, hit, pixel_at);
    hand_in_counts();
    return tail_of(rgb, alpha_of(hit));
}

fn composited(pixel: vec2u, ray: CameraRay) -> Composited {
    var result = Composited(vec3f(0.0), 1.0, false, false, Hit());
    let first = first_slot(pixel);
    for (var slot = 0u; slot < P_K; slot += 1u) {
        let triangle = atomicLoad(&kept_triangles[first + slot]);
        if triangle == 0u {
            continue;
        }
        let fragment = fragment_of(ray, fragment_hit(pixel, ~triangle));
        counted.hits += 1u;
        counted.shaded += 1u;
        result.rgb_premul += result.transmittance * fragment.alpha * shade(ray, fragment.hit, pixel);
        result.transmittance *= 1.0 - fragment.alpha;
        result.transparent = true;
        result.furthest = fragment.hit;
    }
    let rest = tail(pixel);
    result.rgb_premul += result.transmittance * rest.xyz;
    result.transmittance *= 1.0 - rest.w;
    // Of those without a slot, which is the furthest is not known.
    result.has_furthest = result.transparent && rest.w <= 0.0;
    return result;
}
