// Our own tree of eight children a node, in the layout of sheer_accel::PackedTree.
#import shared/intersect
#import struct/BvhBlock
#import struct/BvhHeader
#import struct/BvhNode

struct BvhNodes {
    header: BvhHeader,
    nodes: array<BvhNode>,
}

@group(GROUP_SCENE) @binding(BIND_ACCEL) var<storage, read> bvh_nodes: BvhNodes;
@group(GROUP_SCENE) @binding(BIND_ACCEL_TRIANGLES) var<storage, read> bvh_blocks: array<BvhBlock>;

// The ray as the box test needs it: widened, so that no box is missed that holds a triangle the triangle test
// would hit; see `Slabs` in sheer_accel for the bounds. BVH_SLACK there counts a rounding after each
// operation; fusing saves some.
struct Slabs {
    origin_near: vec3f,
    origin_far: vec3f,
    inverse_near: vec3f,
    inverse_far: vec3f,
    // Rows of BvhNode.bounds that the ray enters and leaves by.
    near: vec3u,
    far: vec3u,
    t_min: f32,
}

fn slabs_of(origin: vec3f, direction: vec3f, t_min: f32) -> Slabs {
    let speed = abs(direction);
    let fastest = max(max(speed.x, speed.y), speed.z);
    let reach = max(abs(bvh_nodes.header.lower - origin), abs(bvh_nodes.header.upper - origin));
    let widest = max(max(reach.x, reach.y), reach.z);
    let backwards = bitcast<vec3u>(direction) >> vec3u(31u) != vec3u(0u);
    let distance = (reach + widest) * BVH_PADDING + abs(origin) * BVH_ORIGIN_PADDING;
    let pad = select(distance, -distance, backwards);
    let slowed = max(speed, vec3f(fastest * BVH_SLOWEST));
    let inverse = 1.0 / select(slowed, -slowed, backwards);
    let lower = vec3u(0u, 1u, 2u);
    let upper = vec3u(3u, 4u, 5u);
    return Slabs(
        origin + pad,
        origin - pad,
        inverse * (1.0 - BVH_SLACK),
        inverse * (1.0 + BVH_SLACK),
        select(lower, upper, backwards),
        select(upper, lower, backwards),
        max(t_min, 0.0),
    );
}

// Distances at which the ray enters four of a node's boxes, and those at which it leaves them.
struct Passage {
    near: vec4f,
    far: vec4f,
}

fn passage(slabs: Slabs, node: u32, half: u32, t_max: f32) -> Passage {
    var near = vec4f(slabs.t_min);
    var far = vec4f(t_max);
    for (var axis = 0u; axis < 3u; axis++) {
        let entry = bvh_nodes.nodes[node].bounds[slabs.near[axis]][half];
        let exit = bvh_nodes.nodes[node].bounds[slabs.far[axis]][half];
        near = max(near, (entry - slabs.origin_near[axis]) * slabs.inverse_near[axis]);
        far = min(far, (exit - slabs.origin_far[axis]) * slabs.inverse_far[axis]);
    }
    return Passage(near, far);
}

fn intersect_block(ray: WatertightRay, block: u32, lane: u32) -> Hit {
    let axes = ray.axes;
    let corners = sheared(
        ray,
        vec3f(
            bvh_blocks[block].vertices[axes.x][0][lane],
            bvh_blocks[block].vertices[axes.x][1][lane],
            bvh_blocks[block].vertices[axes.x][2][lane],
        ),
        vec3f(
            bvh_blocks[block].vertices[axes.y][0][lane],
            bvh_blocks[block].vertices[axes.y][1][lane],
            bvh_blocks[block].vertices[axes.y][2][lane],
        ),
        vec3f(
            bvh_blocks[block].vertices[axes.z][0][lane],
            bvh_blocks[block].vertices[axes.z][1][lane],
            bvh_blocks[block].vertices[axes.z][2][lane],
        ),
    );
    return intersect_sheared(ray, corners, bvh_blocks[block].triangles[lane]);
}
