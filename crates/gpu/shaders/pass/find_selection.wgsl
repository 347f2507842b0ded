// The hit with which the accumulated coverage first exceeds the pixel's threshold: twin of
// `Tracer::first_exceeding`.
#import method
#import shared/found
#import shared/gather
#import tail

fn find(pixel: vec2u, ray: CameraRay, has_after: bool, after: Hit) -> Found {
    begin_gathering(has_after, after);
    gather_threshold = selection_threshold(pixel, frame.index, frame.seed);
    gather_corrects = true;
    var transparent = false;
    loop {
        gather_front(ray);
        for (var at = 0u; at < layer_count; at += 1u) {
            transparent = transparent || layers[at].alpha < 1.0;
        }
        if !gather_goes_on() {
            break;
        }
    }
    if gather_ended {
        return Found(true, whole_hit(ray, layers[layer_count - 1u]), transparent, false, vec3f(0.0));
    }
    // What had no memory comes last, as one fragment.
    let rest = tail(pixel);
    let visibility = visibility_before(layer_count) * (1.0 - rest.w);
    let is_tail = rest.w > 0.0 && 1.0 - visibility > gather_threshold;
    return Found(false, after, transparent, is_tail, rest.xyz / max(rest.w, MIN_VISIBILITY));
}
