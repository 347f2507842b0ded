// Calls visit_VISITOR for hits within [t_min, t_max], near boxes first; each triangle once. Twin of
// `traverse` in sheer_accel.
#import shared/accel_bvh
#import shared/intersect
#import shared/visit

fn traverse_VISITOR(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32) {
    if bvh_nodes.header.root == BVH_NONE || !is_traceable(origin, direction) {
        return;
    }
    let slabs = slabs_of(origin, direction, t_min);
    let ray = watertight_ray(origin, direction);
    var farthest = t_max;
    // Bits of the distance at which the ray enters, which are ordered like the number, and the child. In the
    // function, not shared with other traversals: a visitor may trace rays itself.
    var stack: array<vec2u, BVH_STACK_SIZE>;
    stack[0] = vec2u(bitcast<u32>(abs(slabs.t_min)), bvh_nodes.header.root);
    var count = 1u;
    while count > 0u {
        count--;
        let child = stack[count].y;
        if bitcast<f32>(stack[count].x) > farthest {
            continue;
        }
        if (child & BVH_BLOCK) == 0u {
            // The children that the ray enters go on the stack, the nearest on top.
            let first = count;
            for (var half = 0u; half < 2u; half++) {
                let boxes = passage(slabs, child, half, farthest);
                let children = bvh_nodes.nodes[child].children[half];
                for (var lane = 0u; lane < 4u; lane++) {
                    if boxes.near[lane] <= boxes.far[lane] && children[lane] != BVH_NONE {
                        // Turns -0 into +0, whose bits sort below all other distances.
                        let near = bitcast<u32>(abs(boxes.near[lane]));
                        var slot = count;
                        while slot > first && stack[slot - 1u].x < near {
                            stack[slot] = stack[slot - 1u];
                            slot--;
                        }
                        stack[slot] = vec2u(near, children[lane]);
                        count++;
                    }
                }
            }
            continue;
        }
        let block = child & ~BVH_BLOCK;
        for (var lane = 0u; lane < 8u && bvh_blocks[block].triangles[lane] != BVH_NONE; lane++) {
            let hit = intersect_block(ray, block, lane);
            if !(slabs.t_min <= hit.t && hit.t <= farthest) {
                continue;
            }
            let answer = visit_VISITOR(hit);
            if answer == STOP {
                return;
            }
            if answer == END_HERE {
                farthest = hit.t;
            }
        }
    }
}
