// One shaded fragment a pixel and what is known of its layers without shading: twin of `Tracer::layered`.
// pass/shade.wgsl does the rest.
#import behind
#import choose
#import shared/camera
#import shared/counters
#import shared/found
#import shared/gather
#import shared/project_motion
#import struct/LayersRecord
#import tail
#import tint

@group(GROUP_PASS) @binding(BIND_LAYERS) var<storage, read_write> layer_records: array<LayersRecord>;

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_find(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    pixel_at = id.xy;
    let ray = camera_ray(sample_of(pixel_at));
    let index = pixel_at.y * frame.size.x + pixel_at.x;

    // The front, as far as anything is seen through it, and what is opaque behind it.
    begin_gathering(false, Hit());
    gather_share = DENSE_VISIBILITY;
    gather_corrects = true;
    begin_choice(pixel_at);
    var visibility = 1.0;
    var fragment_count = 0u;
    var weights = 0.0;
    var position = vec3f(0.0);
    var previous = vec3f(0.0);
    var has_opaque = false;
    var opaque = no_hit();
    var last = no_hit();
    loop {
        gather_front(ray);
        for (var at = 0u; at < layer_count; at += 1u) {
            let layer = layers[at];
            let hit = whole_hit(ray, layer);
            if layer.alpha >= 1.0 {
                has_opaque = true;
                opaque = hit;
                continue;
            }
            let weight = visibility - layer.visibility;
            let of_vertices = vec3f(1.0 - hit.u - hit.v, hit.u, hit.v);
            position += position_at(hit.triangle, of_vertices) * weight;
            previous += previous_position_at(hit.triangle, of_vertices) * weight;
            weights += weight;
            visibility = layer.visibility;
            fragment_count += 1u;
            last = hit;
            choose_on_the_way(pixel_at, ray, hit, layer.alpha);
        }
        if !gather_goes_on() {
            break;
        }
    }
    // What had no memory comes last, as one fragment; where it moves is not known.
    var rest = vec4f(0.0);
    if !gather_ended {
        rest = tail(pixel_at);
    }
    let before_rest = visibility;
    visibility *= 1.0 - rest.w;
    let has_front = fragment_count > 0u || rest.w > 0.0;
    // Hardly anything is seen through it: all there is counts as the front.
    let is_dense = gather_ended && !has_opaque;
    let coverage = select(select(0.0, 1.0 - visibility, has_front), 1.0, is_dense);

    // The fragment that is shaded.
    let front = Front(coverage, is_dense, fragment_count, last, before_rest, rest.w);
    let choice = choose_at_the_end(pixel_at, ray, front);
    var found = Found(has_opaque, opaque, has_front, false, vec3f(0.0));
    if choice.is_front || is_dense {
        let rgb = rest.xyz / max(rest.w, MIN_VISIBILITY);
        found = Found(choice.is_found, choice.hit, true, choice.is_tail, rgb);
    }
    surfaces[index] = surface_from_found(found);
    // A back is kept as it is, and seen through the glass of this frame.
    let has_back = !is_dense && has_front;
    var tint = vec3f(1.0);
    if has_back {
        tint = tint_before(ray, has_opaque, opaque);
        surfaces[index].w |= select(SURFACE_BEHIND_GLASS, 0u, choice.is_front);
    }

    // How both layers move.
    var record: LayersRecord;
    record.coverage = coverage;
    let absorbed = (1.0 - coverage) * (vec3f(1.0) - tint);
    record.absorbed = array(absorbed.x, absorbed.y, absorbed.z);
    record.share = choice.share;
    record.is_front = select(0u, 1u, choice.is_front || is_dense);
    record.front_depth = NO_DEPTH;
    if weights > 0.0 {
        record.front_motion = motion_between(position / weights, previous / weights);
        record.front_depth = view_depth(position / weights);
    }
    if is_dense {
        record.back_motion = record.front_motion;
        record.back_depth = record.front_depth;
    } else if has_opaque {
        let of_vertices = vec3f(1.0 - opaque.u - opaque.v, opaque.u, opaque.v);
        let now = position_at(opaque.triangle, of_vertices);
        record.back_motion = motion_between(now, previous_position_at(opaque.triangle, of_vertices));
        record.back_depth = view_depth(now);
    } else {
        record.back_motion = motion_behind(pixel_at, ray);
        record.back_depth = depth_behind(pixel_at);
    }
    layer_records[index] = record;
    hand_in_counts();
}
