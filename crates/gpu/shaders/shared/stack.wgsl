// Layers of a pixel, sorted by depth: twin of crates/render/src/method/stack.rs. The method says how many may
// stay: P_K.
#import shared/drawn

// A fragment, or several that were merged.
struct StackLayer {
    rgb_premul: vec3f,
    transmittance: f32,
    // Depth of the nearest fragment in it, with its tie-breaker.
    depth: f32,
    triangle: u32,
}

// The nearest first; one more than may stay.
var<private> stack: array<StackLayer, P_K + 1u>;
var<private> stack_count: u32;

// Both as one; it keeps the depth of the one in front.
fn layer_over(front: StackLayer, behind: StackLayer) -> StackLayer {
    return StackLayer(
        front.rgb_premul + front.transmittance * behind.rgb_premul,
        front.transmittance * behind.transmittance,
        front.depth,
        front.triangle,
    );
}

// Puts a layer where its depth belongs.
fn insert_into_stack(layer: StackLayer) {
    var at = stack_count;
    while at > 0u && is_in_front(layer.depth, layer.triangle, stack[at - 1u].depth, stack[at - 1u].triangle) {
        stack[at] = stack[at - 1u];
        at -= 1u;
    }
    stack[at] = layer;
    stack_count += 1u;
}

// Merges the two furthest layers.
fn merge_furthest() {
    stack_count -= 1u;
    stack[stack_count - 1u] = layer_over(stack[stack_count - 1u], stack[stack_count]);
}
