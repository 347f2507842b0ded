// What the fragments of a pixel tell those that come after them: a few words a pixel, all 0 at first.
#import shared/frame

const STATS_WORDS: u32 = 5u;
// Bits of the distance of the furthest fragment, which are ordered as positive numbers are.
const STATS_FURTHEST: u32 = 0u;
// The triangle at that distance with the largest number.
const STATS_TRIANGLE: u32 = 1u;
// Fragments.
const STATS_HITS: u32 = 2u;
// Fragments that were shaded, and rays of light that took.
const STATS_SHADED: u32 = 3u;
const STATS_SHADOW_RAYS: u32 = 4u;

fn stats_index(pixel: vec2u) -> u32 {
    return STATS_WORDS * (pixel.y * frame.size.x + pixel.x);
}
