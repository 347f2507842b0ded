// One of the front with a share of the coverage, kept away from both ends; within the front the fragment with
// which the coverage exceeds the threshold, spread over it: twin of `by_selection` in
// crates/render/src/cpu/layered.rs.
#import method
#import shared/choice
#import shared/gather

var<private> choice_threshold: f32;

fn begin_choice(pixel: vec2u) {
    choice_threshold = selection_threshold(pixel, frame.index, frame.seed);
}

// What the front covers has to be known first.
fn choose_on_the_way(pixel: vec2u, ray: CameraRay, hit: Hit, alpha: f32) {}

fn choose_at_the_end(pixel: vec2u, ray: CameraRay, front: Front) -> Choice {
    let coverage = front.coverage;
    var share = coverage;
    if coverage > 0.0 && coverage < 1.0 {
        share = clamp(coverage, LEAST_SHARE, 1.0 - LEAST_SHARE);
    }
    if choice_threshold >= share {
        return Choice(false, false, false, front.last, share);
    }
    let wanted = choice_threshold / share * coverage;
    if front.rest_alpha > 0.0 && 1.0 - front.visibility_before_rest <= wanted {
        return Choice(true, false, true, front.last, share);
    }
    if gather_count_before == 0u {
        // All of the front is at hand.
        for (var at = 0u; at < layer_count; at += 1u) {
            if layers[at].alpha < 1.0 && 1.0 - layers[at].visibility > wanted {
                return Choice(true, true, false, whole_hit(ray, layers[at]), share);
            }
        }
    }
    if gather_count_before != 0u || front.is_dense {
        begin_gathering(false, no_hit());
        gather_threshold = wanted;
        gather_corrects = true;
        loop {
            gather_front(ray);
            if !gather_goes_on() {
                break;
            }
        }
        if gather_ended && (front.is_dense || layers[layer_count - 1u].alpha < 1.0) {
            return Choice(true, true, false, whole_hit(ray, layers[layer_count - 1u]), share);
        }
        if front.is_dense {
            return Choice(true, false, false, front.last, share);
        }
    }
    // Rounding may leave a threshold just below the share beyond the last fragment.
    return Choice(true, true, false, front.last, share);
}
