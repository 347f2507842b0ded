// Where the words of `FragmentStats` lie.
#import shared/frame

fn stats_index(pixel: vec2u) -> u32 {
    return STATS_WORDS * (pixel.y * frame.size.x + pixel.x);
}
