// The nearest fragments of a ray, front to back, in bounded memory: twin of `Tracer::gather_front`.
//
// One traversal gathers LAYER_CAPACITY layers. Where the rest is needed, too, the next one starts behind the
// last fragment: nothing is dropped, whatever the number of layers, and those rays are counted.
#import shared/alpha
#import shared/counters
#import shared/decide
#import shared/intersect

// 16 bytes, for they are moved often: the other numbers of a hit are worked out again where it is shaded.
struct Layer {
    t: f32,
    triangle: u32,
    alpha: f32,
    // What is seen through it and everything in front of it.
    visibility: f32,
}

var<private> layers: array<Layer, LAYER_CAPACITY>;
var<private> layer_count: u32;
// Whether the fragments gathered are enough.
var<private> gather_ended: bool;
var<private> gather_has_after: bool;
var<private> gather_after: Hit;
// Of what has been gathered by the traversals before.
var<private> gather_count_before: u32;
var<private> gather_visibility_before: f32;
// What is enough: coverage above a threshold, visibility down to a share, or so many fragments.
var<private> gather_threshold: f32;
var<private> gather_share: f32;
var<private> gather_most: u32;
// Whether alpha is corrected to coverage.
var<private> gather_corrects: bool;

// Where a layer lies; its weights and side are not known.
fn hit_of_layer(layer: Layer) -> Hit {
    return Hit(layer.t, 0.0, 0.0, layer.triangle, false);
}

// The whole hit of a layer.
fn whole_hit(ray: CameraRay, layer: Layer) -> Hit {
    return barycentrics(watertight_ray(ray.origin, ray.direction), layer.triangle);
}

fn is_enough(count: u32, visibility: f32) -> bool {
    return 1.0 - visibility > gather_threshold || visibility <= gather_share || count >= gather_most;
}

fn visibility_before(index: u32) -> f32 {
    if index == 0u {
        return gather_visibility_before;
    }
    return layers[index - 1u].visibility;
}

fn visit_gather(hit: Hit) -> u32 {
    if gather_has_after && !is_behind(hit, gather_after) {
        return GO_ON;
    }
    counted.hits += 1u;
    var alpha = alpha_of(hit);
    if gather_corrects {
        alpha = coverage(alpha);
    }
    if alpha <= 0.0 {
        return GO_ON;
    }
    var index = layer_count;
    while index > 0u && is_behind_at(layers[index - 1u].t, layers[index - 1u].triangle, hit.t, hit.triangle) {
        index -= 1u;
    }
    if gather_ended && index == layer_count {
        return END_HERE;
    }
    if index == LAYER_CAPACITY {
        return END_HERE;
    }
    if layer_count == LAYER_CAPACITY {
        // The furthest makes room, even if it was the end; the next traversal finds it again.
        layer_count -= 1u;
        gather_ended = false;
    }
    for (var at = layer_count; at > index; at -= 1u) {
        layers[at] = layers[at - 1u];
    }
    layers[index] = Layer(hit.t, hit.triangle, alpha, 1.0);
    layer_count += 1u;
    // A fragment found late, in front of others, only lowers the visibility behind them: the end never moves
    // away.
    var visibility = visibility_before(index);
    for (var at = index; at < layer_count; at += 1u) {
        visibility *= 1.0 - layers[at].alpha;
        layers[at].visibility = visibility;
        if is_enough(gather_count_before + at + 1u, visibility) {
            gather_ended = true;
            layer_count = at + 1u;
        }
    }
    let is_full = gather_ended || layer_count == LAYER_CAPACITY;
    return select(GO_ON, END_HERE, is_full && index + 1u == layer_count);
}
#expand camera VISITOR=gather

// Starts over behind `after`.
fn begin_gathering(has_after: bool, after: Hit) {
    gather_has_after = has_after;
    gather_after = after;
    gather_count_before = 0u;
    gather_visibility_before = 1.0;
    gather_threshold = 2.0;
    gather_share = -1.0;
    gather_most = NONE;
    gather_corrects = false;
}

// Gathers the next fragments.
fn gather_front(ray: CameraRay) {
    layer_count = 0u;
    gather_ended = false;
    let t_min = select(ray.nearest, gather_after.t, gather_has_after);
    traverse_gather(ray.origin, ray.direction, t_min, ray.furthest);
    counted.camera_rays += 1u;
}

// Whether there may be more fragments that matter than those gathered; makes ready to gather them.
fn gather_goes_on() -> bool {
    if gather_ended || layer_count < LAYER_CAPACITY {
        return false;
    }
    gather_has_after = true;
    gather_after = hit_of_layer(layers[layer_count - 1u]);
    gather_count_before += layer_count;
    gather_visibility_before = layers[layer_count - 1u].visibility;
    return true;
}
