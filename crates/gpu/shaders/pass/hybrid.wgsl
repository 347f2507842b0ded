// The nearest fragments exactly as far as the method wants them, then what its stochastic ray finds (STD
// section 3.4). Twin of `Tracer::hybrid` and, where nothing is left to chance, of
// `Tracer::composite_in_order`.
#import find
#import shared/gather
#import shared/resolve_pixel
#import tail

// Light of the fragments so far, premultiplied, and what is seen behind them.
var<private> rgb_premul: vec3f;
var<private> visibility_left: f32;
// The last of them, and whether any was transparent.
var<private> last: Hit;
var<private> any_transparent: bool;

// The fragment that stands for all that the exact ones leave, as the only layer; none if there is nothing to
// stand for.
fn gather_rest(pixel: vec2u, ray: CameraRay) -> Found {
    layer_count = 0u;
    let rest = find(pixel, ray, true, last);
    any_transparent = any_transparent || rest.transparent;
    // Of the hit alone: what the search itself may have gathered is done with.
    layers[0] = Layer(rest.hit.t, rest.hit.triangle, 1.0, 0.0);
    layer_count = select(0u, 1u, rest.found);
    return rest;
}

// Adds the layers that were gathered to the light.
fn shade_layers(pixel: vec2u, ray: CameraRay) {
    for (var at = 0u; at < layer_count; at += 1u) {
        let layer = layers[at];
        let hit = whole_hit(ray, layer);
        counted.shaded += 1u;
        rgb_premul += visibility_left * layer.alpha * shade(ray, hit, pixel);
        visibility_left = layer.visibility;
        last = hit;
        any_transparent = any_transparent || layer.alpha < 1.0;
    }
}

fn trace_hybrid(pixel: vec2u, ray: CameraRay) {
    // Not below the baseline's end, so that a share of 0 is the baseline.
    let share = max(frame.hybrid_visibility, MIN_VISIBILITY);
    rgb_premul = vec3f(0.0);
    visibility_left = 1.0;
    any_transparent = false;
    begin_gathering(false, Hit());
    gather_share = share;
    gather_most = frame.hybrid_layers;
    // Rounds of exact fragments, then one for what stands for the rest: in one loop, so that there is one
    // place that shades.
    var is_exact = true;
    var shows_surface = false;
    var behind = vec4f(0.0);
    loop {
        if is_exact {
            gather_front(ray);
            shows_surface = gather_ended;
        } else {
            let rest = gather_rest(pixel, ray);
            shows_surface = rest.found;
            behind = select(background_through_glass(ray), vec4f(rest.tail_rgb, 1.0), rest.is_tail);
        }
        let goes_on = is_exact && gather_goes_on();
        shade_layers(pixel, ray);
        if goes_on {
            continue;
        }
        if !is_exact || !gather_ended || visibility_left <= MIN_VISIBILITY {
            break;
        }
        if visibility_left > share {
            counted.merged += 1u;
        }
        is_exact = false;
    }
    if is_exact && !shows_surface {
        behind = over(tail(pixel), background_through_glass(ray));
    }
    let colour = over(vec4f(rgb_premul, 1.0 - visibility_left), select(behind, vec4f(0.0), shows_surface));
    write_pixel(pixel, colour, ray, shows_surface, last, any_transparent);
}

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_trace(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    pixel_at = id.xy;
    trace_hybrid(pixel_at, camera_ray(sample_of(pixel_at)));
    hand_in_counts();
}
