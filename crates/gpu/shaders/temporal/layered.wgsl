// Layered accumulation: twin of crates/render/src/temporal/layered.rs. Three passes: each layer's history is
// moved to where it is now, new samples are held against it, and the picture is put together.
#import shared/resample
#import shared/temporal_uniform
#import shared/vector
#import struct/KeptLayers
#import struct/LayersRecord
#import struct/PixelRecord

@group(GROUP_TEMPORAL) @binding(BIND_NEW_PIXELS) var<storage, read> pixels: array<PixelRecord>;
@group(GROUP_TEMPORAL) @binding(BIND_NEXT_HISTORY) var<storage, read_write> next_history: array<vec4f>;
@group(GROUP_TEMPORAL) @binding(BIND_NEW_LAYERS) var<storage, read> layers: array<LayersRecord>;
@group(GROUP_TEMPORAL) @binding(BIND_KEPT) var<storage, read> kept: array<KeptLayers>;
@group(GROUP_TEMPORAL) @binding(BIND_MOVED) var<storage, read_write> moved: array<KeptLayers>;
@group(GROUP_TEMPORAL) @binding(BIND_NEXT_KEPT) var<storage, read_write> next_kept: array<KeptLayers>;

// What has been averaged of one layer of a pixel.
struct Mean {
    colour: vec4f,
    weight: f32,
    count: f32,
    variance: f32,
}

fn no_mean() -> Mean {
    return Mean(vec4f(0.0), 0.0, 0.0, 0.0);
}

fn front_of(record: KeptLayers) -> Mean {
    return Mean(record.front_colour, record.front_sums.x, record.front_sums.y, record.front_sums.z);
}

fn back_of(record: KeptLayers) -> Mean {
    return Mean(record.back_colour, record.back_sums.x, record.back_sums.y, record.back_sums.z);
}

fn mean_of(record: KeptLayers, is_front: bool) -> Mean {
    if is_front {
        return front_of(record);
    }
    return back_of(record);
}

// What glass absorbs, and the coverage.
fn hidden_of(record: KeptLayers) -> vec4f {
    return vec4f(record.absorbed, record.front_sums.w);
}

fn hidden_by(record: LayersRecord) -> vec4f {
    return vec4f(record.absorbed[0], record.absorbed[1], record.absorbed[2], record.coverage);
}

fn kept_of(front: Mean, back: Mean, hidden: vec4f, coverage_count: f32, back_depth: f32) -> KeptLayers {
    return KeptLayers(
        front.colour,
        back.colour,
        vec4f(front.weight, front.count, front.variance, hidden.w),
        vec4f(back.weight, back.count, back.variance, coverage_count),
        hidden.xyz,
        back_depth,
    );
}

// The most samples of a mean after so many frames that show the same.
fn still_samples() -> f32 {
    return f32(temporal.still_count) / STILL_GAIN;
}

// Whether these are so many that the histories are plain means from here on.
fn is_settled() -> bool {
    return temporal.count > 0u && still_samples() > 1.0 / P_WEIGHT;
}

// With another sample.
fn plus(mean: Mean, colour: vec4f, weight: f32, most: f32) -> Mean {
    let count = min(mean.count + 1.0, most);
    let mean_weight = mean.weight + (weight - mean.weight) / count;
    if mean_weight <= 0.0 {
        return mean;
    }
    let gain = min(weight / (count * mean_weight), 1.0);
    let offset = colour - mean.colour;
    let variance = (1.0 - gain) * (mean.variance + gain * offset.x * offset.x);
    return Mean(mean.colour + offset * gain, mean_weight, count, variance);
}

// How much of a layer there is in a pixel, over the probability of choosing it.
fn weight_of(record: LayersRecord, is_front: bool) -> f32 {
    let part = select(1.0 - record.coverage, record.coverage, is_front);
    let probability = select(1.0 - record.share, record.share, is_front);
    if probability > 0.0 {
        return part / probability;
    }
    return 1.0;
}

// Whether a pixel of the history has a layer that fits: the back, if its depth lies between these.
fn fits(record: KeptLayers, is_front: bool, depths: vec2f) -> bool {
    if is_front {
        return record.front_sums.y > 0.0;
    }
    return record.back_sums.y > 0.0 && record.back_depth >= depths.x && record.back_depth <= depths.y;
}

fn texel_front(pixel: vec2u) -> vec4f {
    return kept[index_of(pixel)].front_colour;
}
#expand shared/sharp TEXEL=front

fn texel_back(pixel: vec2u) -> vec4f {
    return kept[index_of(pixel)].back_colour;
}
#expand shared/sharp TEXEL=back

fn texel_coverage(pixel: vec2u) -> vec4f {
    return hidden_of(kept[index_of(pixel)]);
}
#expand shared/sharp TEXEL=coverage

// The mean of the pixels around a place that fit; sharp where all do.
fn fetched(place: Place, is_front: bool, depths: vec2f) -> Mean {
    var fitting = 0.0;
    var mean = no_mean();
    var all_fit = true;
    for (var dy = -1; dy <= 2; dy += 1) {
        for (var dx = -1; dx <= 2; dx += 1) {
            let record = kept[index_of(clamped(place.pixel + vec2i(dx, dy)))];
            if !fits(record, is_front, depths) {
                all_fit = false;
                continue;
            }
            let weight = bilinear(place, vec2i(dx, dy));
            let of_pixel = mean_of(record, is_front);
            fitting += weight;
            mean.colour += of_pixel.colour * weight;
            mean.weight += of_pixel.weight * weight;
            mean.count += of_pixel.count * weight;
            mean.variance += of_pixel.variance * weight;
        }
    }
    if fitting < LEAST_FITTING {
        return no_mean();
    }
    var colour = mean.colour / fitting;
    if all_fit && is_front {
        colour = sharp_front(place);
    } else if all_fit {
        colour = sharp_back(place);
    }
    return Mean(colour, mean.weight / fitting, mean.count / fitting, mean.variance / fitting);
}

// The history of a pixel, each layer by its own motion; the front where it is now or just beside.
@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_move(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= temporal.size) {
        return;
    }
    let at = index_of(id.xy);
    if temporal.count == 0u {
        moved[at] = kept_of(no_mean(), no_mean(), vec4f(0.0), 0.0, FAR_AWAY);
        return;
    }
    if is_settled() {
        return;
    }
    let own = layers[at];
    var front_coverage = own.coverage;
    var front_motion = own.front_motion;
    var nearest = FAR_AWAY;
    var furthest = 0.0;
    for (var dy = -1; dy <= 1; dy += 1) {
        for (var dx = -1; dx <= 1; dx += 1) {
            let neighbour = layers[index_of(clamped(vec2i(id.xy) + vec2i(dx, dy)))];
            nearest = min(nearest, neighbour.back_depth);
            furthest = max(furthest, min(neighbour.back_depth, FAR_AWAY));
            // A jittered ray misses a thin front now and then.
            if own.coverage <= 0.0 && neighbour.coverage > front_coverage {
                front_coverage = neighbour.coverage;
                front_motion = neighbour.front_motion;
            }
        }
    }
    var back = no_mean();
    let back_place = place_of(vec2f(id.xy) + own.back_motion);
    if back_place.is_inside {
        let depths = vec2f(nearest * (1.0 - DEPTH_TOLERANCE), furthest * (1.0 + DEPTH_TOLERANCE));
        back = fetched(back_place, false, depths);
    }
    var place = back_place;
    if front_coverage > 0.0 {
        place = place_of(vec2f(id.xy) + front_motion);
    }
    var front = no_mean();
    var hidden = vec4f(0.0);
    var coverage_count = 0.0;
    if place.is_inside {
        // Without a front all around, nothing of one is left by the clip.
        if front_coverage > 0.0 {
            front = fetched(place, true, vec2f(0.0));
            hidden = sharp_coverage(place);
        }
        for (var dy = 0; dy <= 1; dy += 1) {
            for (var dx = 0; dx <= 1; dx += 1) {
                let record = kept[index_of(clamped(place.pixel + vec2i(dx, dy)))];
                coverage_count += record.back_sums.w * bilinear(place, vec2i(dx, dy));
            }
        }
    }
    moved[at] = kept_of(front, back, hidden, coverage_count, FAR_AWAY);
}

// Sums over the samples of a layer in a neighbourhood.
struct Sums {
    all_weights: f32,
    colours: vec4f,
    weights: f32,
    squared_weights: f32,
    residuals: vec4f,
    squared_residuals: vec4f,
}

// With a sample. Weights are under a tent, so that a shift by the mean residual lessens every wave in a
// history.
fn added(sums: Sums, colour: vec4f, weight: f32, history: Mean) -> Sums {
    var sum = sums;
    sum.all_weights += weight;
    sum.colours += colour * weight;
    if history.count > 0.0 {
        let residual = colour - history.colour;
        sum.weights += weight;
        sum.squared_weights += weight * weight;
        sum.residuals += residual * weight;
        sum.squared_residuals += residual * residual * weight;
    }
    return sum;
}

struct Samples {
    count: f32,
    sum: vec4f,
    squares: vec4f,
}

// Pulls a history into the wide ellipsoid of samples around: twin of `clipped`.
fn clip(mean: Mean, samples: Samples) -> Mean {
    if samples.count < LEAST_CLIPPING || mean.count <= 0.0 {
        return mean;
    }
    let middle = samples.sum / samples.count;
    let deviation = sqrt(max(samples.squares / samples.count - middle * middle, vec4f(0.0))) * CLIP_SIGMAS;
    let offset = mean.colour - middle;
    let reach = length(offset / max(deviation, vec4f(LEAST_ERROR)));
    if reach <= 1.0 {
        return mean;
    }
    return Mean(middle + offset / reach, mean.weight, mean.count, mean.variance);
}

// Pulls a history to within some standard errors of what the samples around say, and forgets some of its
// samples the further off it was.
fn rectified(mean: Mean, sums: Sums, sigmas: f32) -> Mean {
    let samples = sums.weights * sums.weights / max(sums.squared_weights, LEAST_NORMAL);
    if samples < LEAST_SAMPLES {
        return mean;
    }
    let residual = sums.residuals / sums.weights;
    let squares = sums.squared_residuals / sums.weights;
    let variance = max(squares - residual * residual, vec4f(0.0));
    let error = sqrt(variance / (samples - 1.0));
    // As far out as Student's distribution has what the normal one has within so many standard errors.
    let few = 1.0 + (sigmas * sigmas + 1.0) / (4.0 * (samples - 1.0));
    let excess = max(abs(residual) - error * (sigmas * few), vec4f(0.0));
    let reach = abs(residual.x) / max(error.x * few, LEAST_ERROR);
    let doubt = clamp((reach - DOUBT_STARTS) / (DOUBT_ENDS - DOUBT_STARTS), 0.0, 1.0);
    let count = mean.count * (1.0 - MOST_FORGOTTEN * doubt);
    let colour = mean.colour + sign(residual) * excess;
    return Mean(colour / max(colour.w, 1.0), mean.weight, count, mean.variance);
}

// A layer of a pixel after the frame.
fn updated(history: Mean, sums: Sums, colour: vec4f, is_sampled: bool, weight: f32, sigmas: f32) -> Mean {
    var mean = history;
    if mean.count > 0.0 {
        mean = rectified(mean, sums, sigmas);
    } else if !is_sampled && sums.all_weights > 0.0 {
        mean = Mean(sums.colours / sums.all_weights, weight, BORROWED_COUNT, 0.0);
    }
    if is_sampled {
        return plus(mean, colour, weight, 1.0 / P_WEIGHT);
    }
    return mean;
}

// With another sample of what stands still.
fn averaged(record: KeptLayers, own: LayersRecord, colour: vec4f) -> KeptLayers {
    let most = still_samples();
    var front = front_of(record);
    var back = back_of(record);
    if own.is_front != 0u {
        front = plus(front, colour, weight_of(own, true), most);
    } else {
        back = plus(back, colour, weight_of(own, false), most);
    }
    let count = min(record.back_sums.w + 1.0, most);
    let hidden = hidden_of(record) + (hidden_by(own) - hidden_of(record)) / count;
    return kept_of(front, back, hidden, count, min(own.back_depth, FAR_AWAY));
}

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_update(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= temporal.size) {
        return;
    }
    let at = index_of(id.xy);
    let own = layers[at];
    if is_settled() {
        next_kept[at] = averaged(kept[at], own, ycocga_from_rgba(pixels[at].colour));
        return;
    }
    let history = moved[at];
    var front_sums: Sums;
    var back_sums: Sums;
    let radius = i32(P_RADIUS);
    // Pixels of the picture alone: those beyond its edges are not there twice.
    let low = max(vec2i(id.xy) - radius, vec2i(0));
    let high = min(vec2i(id.xy) + radius, vec2i(temporal.size) - 1);
    for (var y = low.y; y <= high.y; y += 1) {
        for (var x = low.x; x <= high.x; x += 1) {
            let index = index_of(vec2u(vec2i(x, y)));
            let record = layers[index];
            let colour = ycocga_from_rgba(pixels[index].colour);
            let tent = 1.0 - abs(vec2f(vec2i(x, y) - vec2i(id.xy))) / f32(radius + 1);
            let share = tent.x * tent.y;
            if record.is_front != 0u {
                front_sums = added(front_sums, colour, weight_of(record, true) * share, front_of(moved[index]));
            } else {
                back_sums = added(back_sums, colour, weight_of(record, false) * share, back_of(moved[index]));
            }
        }
    }
    // What is absorbed and the coverage are exact in each frame; the back is clipped to its samples around.
    var sum = vec4f(0.0);
    var squares = vec4f(0.0);
    var back_samples: Samples;
    for (var dy = -1; dy <= 1; dy += 1) {
        for (var dx = -1; dx <= 1; dx += 1) {
            let index = index_of(clamped(vec2i(id.xy) + vec2i(dx, dy)));
            let hidden = hidden_by(layers[index]);
            sum += hidden;
            squares += hidden * hidden;
            if layers[index].is_front == 0u {
                let colour = ycocga_from_rgba(pixels[index].colour);
                back_samples.count += 1.0;
                back_samples.sum += colour;
                back_samples.squares += colour * colour;
            }
        }
    }
    let mean = sum / 9.0;
    let deviation = sqrt(max(squares / 9.0 - mean * mean, vec4f(0.0)));
    let clipped = clamp(hidden_of(history), mean - deviation, mean + deviation);
    let count = min(history.back_sums.w + 1.0, 1.0 / P_WEIGHT);

    let colour = ycocga_from_rgba(pixels[at].colour);
    let is_front = own.is_front != 0u;
    let front = updated(front_of(history), front_sums, colour, is_front, weight_of(own, true), P_SIGMA);
    let back =
        updated(clip(back_of(history), back_samples), back_sums, colour, !is_front, weight_of(own, false), P_SIGMA * BACK_SIGMAS);
    let hidden = clipped + (hidden_by(own) - clipped) / count;
    next_kept[at] = kept_of(front, back, hidden, count, min(own.back_depth, FAR_AWAY));
}

// The front as it is shown: as far towards the mean of the pixels around as what differs there is noise by
// what its samples vary over time (Lee 1980).
fn smoothed(pixel: vec2u) -> vec4f {
    let own = next_kept[index_of(pixel)].front_colour;
    var count = 0.0;
    var sum = vec4f(0.0);
    var squares = 0.0;
    var near_count = 0.0;
    var noise = 0.0;
    for (var dy = -SMOOTHING_RADIUS; dy <= SMOOTHING_RADIUS; dy += 1) {
        for (var dx = -SMOOTHING_RADIUS; dx <= SMOOTHING_RADIUS; dx += 1) {
            let neighbour = front_of(next_kept[index_of(clamped(vec2i(pixel) + vec2i(dx, dy)))]);
            if neighbour.count <= 0.0 {
                continue;
            }
            count += 1.0;
            sum += neighbour.colour;
            squares += neighbour.colour.x * neighbour.colour.x;
            if abs(dx) <= 1 && abs(dy) <= 1 {
                near_count += 1.0;
                noise += neighbour.variance / max(neighbour.count, 1.0);
            }
        }
    }
    let mean = sum / count;
    let spread = max(squares / count - mean.x * mean.x, 0.0);
    noise = P_SMOOTH * noise / near_count;
    var gain = 1.0;
    if spread > 0.0 {
        gain = max(1.0 - noise / spread, 0.0);
    }
    return mean + (own - mean) * gain;
}

// The picture: the front over the back.
@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_show(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= temporal.size) {
        return;
    }
    let own = next_kept[index_of(id.xy)];
    var coverage = own.front_sums.w;
    if own.front_sums.y <= 0.0 {
        coverage = 0.0;
    } else if own.back_sums.y <= 0.0 {
        coverage = 1.0;
    }
    var front = vec4f(0.0);
    if coverage > 0.0 {
        front = smoothed(id.xy);
    }
    var shown = rgba_from_ycocga(front * coverage + own.back_colour * (1.0 - coverage));
    if any(own.absorbed != vec3f(0.0)) {
        let absorbed = vec4f(own.absorbed, mean_channel(own.absorbed));
        // Behind a clear back, what is absorbed is covered.
        shown += vec4f(0.0, 0.0, 0.0, absorbed.w) - rgba_from_ycocga(own.back_colour) * absorbed;
    }
    next_history[index_of(id.xy)] = shown;
}
