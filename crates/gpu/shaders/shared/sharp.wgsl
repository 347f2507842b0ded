// The mean of a history around a place by Catmull and Rom's weights, which keep edges that bilinear lookups
// would blur a little more in every frame; each channel within the range of the four pixels around: twin of
// `Place::sharp`. TEXEL stands for what is looked up, by a function `texel_TEXEL` of a pixel.
#import shared/resample

fn sharp_TEXEL(place: Place) -> vec4f {
    if all(place.share == vec2f(0.0)) {
        return texel_TEXEL(clamped(place.pixel));
    }
    let wx = catmull_rom(place.share.x);
    let wy = catmull_rom(place.share.y);
    var sum = vec4f(0.0);
    var low = vec4f(GREATEST);
    var high = vec4f(-GREATEST);
    for (var dy = -1; dy <= 2; dy += 1) {
        for (var dx = -1; dx <= 2; dx += 1) {
            let value = texel_TEXEL(clamped(place.pixel + vec2i(dx, dy)));
            sum += value * (wx[dx + 1] * wy[dy + 1]);
            if dx >= 0 && dx <= 1 && dy >= 0 && dy <= 1 {
                low = min(low, value);
                high = max(high, value);
            }
        }
    }
    return clamp(sum, low, high);
}
