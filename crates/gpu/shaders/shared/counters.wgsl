// What a frame costs (`Counters`): summed up in registers, added to the frame's counters once an invocation.
#import shared/pass

struct Counted {
    camera_rays: u32,
    hits: u32,
    shaded: u32,
    merged: u32,
}

var<private> counted: Counted;
var<private> counted_shadow_rays: u32;

fn hand_in(counter: u32, count: u32) {
    // All fragments of a picture may come here: what did not happen costs nothing.
    if count != 0u {
        atomicAdd(&counters[counter], count);
    }
}

// Adds what this invocation has counted to the frame's counters.
fn hand_in_counts() {
    hand_in(COUNTER_CAMERA_RAYS, counted.camera_rays);
    hand_in(COUNTER_SHADOW_RAYS, counted_shadow_rays);
    hand_in(COUNTER_HITS, counted.hits);
    hand_in(COUNTER_SHADED, counted.shaded);
    hand_in(COUNTER_MERGED, counted.merged);
}
