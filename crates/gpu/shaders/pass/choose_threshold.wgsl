// The nearest fragment that reaches its threshold: twin of `by_threshold` in
// crates/render/src/cpu/layered.rs.
#import method
#import shared/choice
#import shared/decide
#import shared/gather
#import shared/site_of

var<private> chosen: Hit;
var<private> has_chosen: bool;

fn begin_choice(pixel: vec2u) {
    has_chosen = false;
}

fn choose_on_the_way(pixel: vec2u, ray: CameraRay, hit: Hit, alpha: f32) {
    if !has_chosen && keeps(alpha, threshold(site_of(pixel, ray, hit))) {
        chosen = hit;
        has_chosen = true;
    }
}

fn choose_at_the_end(pixel: vec2u, ray: CameraRay, front: Front) -> Choice {
    if front.is_dense && !has_chosen {
        // What lies behind, opaque or not: alphas and thresholds decide on.
        begin_gathering(true, front.last);
        gather_share = MIN_VISIBILITY;
        gather_corrects = true;
        loop {
            gather_front(ray);
            for (var at = 0u; at < layer_count; at += 1u) {
                choose_on_the_way(pixel, ray, whole_hit(ray, layers[at]), layers[at].alpha);
            }
            if has_chosen || !gather_goes_on() {
                break;
            }
        }
    }
    return Choice(has_chosen, has_chosen, false, chosen, front.coverage);
}
