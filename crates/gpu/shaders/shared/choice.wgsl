// Which fragment of a pixel is shaded, and what is known of its front by then.
#import shared/hit

struct Front {
    // Share of the front in what is seen.
    coverage: f32,
    // Hardly anything is seen through it, so that what lies behind has not been looked for.
    is_dense: bool,
    fragment_count: u32,
    // The last of the fragments.
    last: Hit,
    // What is seen through all that have a node of their own, and the opacity of the others together.
    visibility_before_rest: f32,
    rest_alpha: f32,
}

struct Choice {
    // One of the front.
    is_front: bool,
    // There is a surface; the background otherwise.
    is_found: bool,
    // The fragments that a full list had no node for stand for the front.
    is_tail: bool,
    hit: Hit,
    // Probability with which it was to be one of the front.
    share: f32,
}
