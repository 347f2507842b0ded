// The scene as `src/scene` sends it, and the opacity of its triangles: twin of `Frame` in
// crates/scene/src/frame.rs.
#import shared/frame
#import shared/hit
#import shared/texture
#import struct/Light
#import struct/Material
#import struct/Object
#import struct/Opacity

// Nine floats a triangle, world.
@group(GROUP_SCENE) @binding(BIND_POSITIONS) var<storage, read> positions: array<f32>;
// The same of the triangles from frame.static_count on, in the previous frame.
@group(GROUP_SCENE) @binding(BIND_PREVIOUS_POSITIONS) var<storage, read> previous_positions: array<f32>;
// A triangle's object, and its opacity slot with flags.
@group(GROUP_SCENE) @binding(BIND_TRIANGLES) var<storage, read> triangles: array<vec2u>;
@group(GROUP_SCENE) @binding(BIND_OBJECTS) var<storage, read> objects: array<Object>;
@group(GROUP_SCENE) @binding(BIND_OPACITIES) var<storage, read> opacities: array<Opacity>;
@group(GROUP_SCENE) @binding(BIND_ATTRIBUTES) var<storage, read> attributes: array<f32>;
@group(GROUP_SCENE) @binding(BIND_INDICES) var<storage, read> indices: array<u32>;
@group(GROUP_SCENE) @binding(BIND_DEFORMED_NORMALS) var<storage, read> deformed_normals: array<f32>;
@group(GROUP_SCENE) @binding(BIND_MATERIALS) var<storage, read> materials: array<Material>;
@group(GROUP_SCENE) @binding(BIND_LIGHTS) var<storage, read> lights: array<Light>;

// Index of a triangle within its object, as `PrimitiveIndex()`.
fn primitive(triangle: u32) -> u32 {
    return triangle - objects[triangles[triangle].x].first_triangle;
}

// Whether a ray that sees a triangle's vertices counter-clockwise (or not) sees its front: mirrored objects
// are turned around.
fn is_front(triangle: u32, counter_clockwise: bool) -> bool {
    return counter_clockwise != ((triangles[triangle].y & MIRRORED) != 0u);
}

fn is_back(hit: Hit) -> bool {
    return !is_front(hit.triangle, hit.front);
}

fn is_opaque(triangle: u32) -> bool {
    return (triangles[triangle].y & OPAQUE) != 0u;
}

// Opacity of a point of a triangle, 0 to 1; `u` and `v` are the barycentric weights of the second and third
// vertex, `width` is that of the beam that sees it, world units.
fn opacity(triangle: u32, u: f32, v: f32, width: f32) -> f32 {
    let slot = triangles[triangle].y;
    if (slot & OPAQUE) != 0u {
        return 1.0;
    }
    return table_opacity(slot, u, v, width);
}

// The same for a camera ray: the back of a single-sided surface is not there.
fn opacity_for_camera(triangle: u32, u: f32, v: f32, counter_clockwise: bool, width: f32) -> f32 {
    let slot = triangles[triangle].y;
    let front = counter_clockwise != ((slot & MIRRORED) != 0u);
    if (slot & SINGLE_SIDED) != 0u && !front {
        return 0.0;
    }
    if (slot & OPAQUE) != 0u {
        return 1.0;
    }
    return table_opacity(slot, u, v, width);
}

fn table_opacity(slot: u32, u: f32, v: f32, width: f32) -> f32 {
    let entry = slot & SLOT;
    let w = 1.0 - u - v;
    // From the first vertex on, not as a weighted sum: three equal alphas give exactly theirs, so that 1
    // stays opaque.
    let first = opacities[entry].alpha[0];
    let second = opacities[entry].alpha[1];
    let third = opacities[entry].alpha[2];
    var alpha = first + u * (second - first) + v * (third - first);
    let texture = opacities[entry].texture;
    if texture != NO_TEXTURE {
        let uv = w * opacities[entry].uv[0] + u * opacities[entry].uv[1] + v * opacities[entry].uv[2];
        alpha *= sample_alpha(texture, uv, width * opacities[entry].texel_density);
    }
    let cutoff = opacities[entry].cutoff;
    if cutoff >= 0.0 {
        alpha = select(0.0, 1.0, alpha >= cutoff);
    }
    return clamp(alpha * opacities[entry].opacity, 0.0, 1.0);
}

// Corners of a particle quad's two triangles in its tile, as QUAD_UVS of the CPU.
fn quad_uvs(primitive: u32) -> array<vec2f, 3> {
    if (primitive & 1u) == 0u {
        return array(vec2f(0.0, 1.0), vec2f(1.0, 1.0), vec2f(1.0, 0.0));
    }
    return array(vec2f(0.0, 1.0), vec2f(1.0, 0.0), vec2f(0.0, 0.0));
}

// A triangle's vertices in its mesh.
fn mesh_vertices(object: u32, primitive: u32) -> array<u32, 3> {
    let first = objects[object].mesh.first_index + 3u * primitive;
    return array(indices[first], indices[first + 1u], indices[first + 2u]);
}

fn attribute2(list: u32, vertex: u32) -> vec2f {
    let at = list + 2u * vertex;
    return vec2f(attributes[at], attributes[at + 1u]);
}

fn attribute3(list: u32, vertex: u32) -> vec3f {
    let at = list + 3u * vertex;
    return vec3f(attributes[at], attributes[at + 1u], attributes[at + 2u]);
}

fn attribute4(list: u32, vertex: u32) -> vec4f {
    let at = list + 4u * vertex;
    return vec4f(attributes[at], attributes[at + 1u], attributes[at + 2u], attributes[at + 3u]);
}

// Corners of a triangle in world.
fn corners_in_world(triangle: u32) -> array<vec3f, 3> {
    let at = 9u * triangle;
    return array(
        vec3f(positions[at], positions[at + 1u], positions[at + 2u]),
        vec3f(positions[at + 3u], positions[at + 4u], positions[at + 5u]),
        vec3f(positions[at + 6u], positions[at + 7u], positions[at + 8u]),
    );
}

// Where they were in the previous frame.
fn previous_corners_in_world(triangle: u32) -> array<vec3f, 3> {
    if triangle < frame.static_count {
        return corners_in_world(triangle);
    }
    let at = 9u * (triangle - frame.static_count);
    return array(
        vec3f(previous_positions[at], previous_positions[at + 1u], previous_positions[at + 2u]),
        vec3f(previous_positions[at + 3u], previous_positions[at + 4u], previous_positions[at + 5u]),
        vec3f(previous_positions[at + 6u], previous_positions[at + 7u], previous_positions[at + 8u]),
    );
}

// Corners of a triangle in the space of its object, where they never move: those of the mesh, not skinned or
// morphed, or of a square of side 1 for a particle.
fn corners_in_object(triangle: u32) -> array<vec3f, 3> {
    let object = triangles[triangle].x;
    let primitive = triangle - objects[object].first_triangle;
    if objects[object].look == LOOK_QUAD {
        let corners = quad_uvs(primitive);
        return array(vec3f(corners[0], 0.0), vec3f(corners[1], 0.0), vec3f(corners[2], 0.0));
    }
    let list = objects[object].mesh.positions;
    let vertices = mesh_vertices(object, primitive);
    return array(attribute3(list, vertices[0]), attribute3(list, vertices[1]), attribute3(list, vertices[2]));
}
