// The scene as `src/scene` sends it, and the opacity of its triangles: twin of `Frame` in crates/scene/src/frame.rs.
#import shared/frame
#import shared/hit
#import shared/texture

// Where a mesh's lists lie: offsets in floats into `attributes`, or NONE.
struct MeshOffsets {
    first_index: u32,
    vertex_count: u32,
    positions: u32,
    normals: u32,
    tangents: u32,
    colours: u32,
    uv_sets: u32,
    uv_set_count: u32,
}

struct Object {
    id: u32,
    geometry: u32,
    material: u32,
    first_triangle: u32,
    look: u32,
    first_deformed_normal: u32,
    mesh: MeshOffsets,
    // Rigid: columns of `normal_from_object`, then of `vector_from_object`. Quad: right, up, tile origin, tile size, tint.
    axes: array<f32, 18>,
}

// What the any-hit test reads.
struct Opacity {
    // Of the three vertices, the texture's transform included.
    uv: array<vec2f, 3>,
    // Factor at each vertex.
    alpha: array<f32, 3>,
    // NO_TEXTURE: none.
    texture: u32,
    // Alpha test; negative: none.
    cutoff: f32,
    // Factor after the alpha test.
    opacity: f32,
}

// A material's use of a texture; the first three are `texture_from_mesh_uv`.
struct TextureUse {
    x_axis: vec2f,
    y_axis: vec2f,
    translation: vec2f,
    texture: u32,
    uv_set: u32,
}

struct Material {
    base_colour: vec3f,
    model: u32,
    emissive: vec3f,
    metallic: f32,
    roughness: f32,
    transmission: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    // By TEXTURE_BASE_COLOUR, …
    textures: array<TextureUse, TEXTURE_COUNT>,
}

struct Light {
    position: vec3f,
    kind: u32,
    direction: vec3f,
    range: f32,
    intensity: vec3f,
    inner_cosine: f32,
    outer_cosine: f32,
}

// Nine floats a triangle, world.
@group(0) @binding(1) var<storage, read> positions: array<f32>;
// The same of the triangles from frame.static_count on, in the previous frame.
@group(0) @binding(2) var<storage, read> previous_positions: array<f32>;
// A triangle's object, and its opacity slot with flags.
@group(0) @binding(3) var<storage, read> triangles: array<vec2u>;
@group(0) @binding(4) var<storage, read> objects: array<Object>;
@group(0) @binding(5) var<storage, read> opacities: array<Opacity>;
@group(0) @binding(6) var<storage, read> attributes: array<f32>;
@group(0) @binding(7) var<storage, read> indices: array<u32>;
@group(0) @binding(8) var<storage, read> deformed_normals: array<f32>;
@group(0) @binding(9) var<storage, read> materials: array<Material>;
@group(0) @binding(12) var<storage, read> lights: array<Light>;

// Index of a triangle within its object, as `PrimitiveIndex()`.
fn primitive(triangle: u32) -> u32 {
    return triangle - objects[triangles[triangle].x].first_triangle;
}

// Whether a ray that sees a triangle's vertices counter-clockwise (or not) sees its front: mirrored objects are turned around.
fn is_front(triangle: u32, counter_clockwise: bool) -> bool {
    return counter_clockwise != ((triangles[triangle].y & MIRRORED) != 0u);
}

fn is_back(hit: Hit) -> bool {
    return !is_front(hit.triangle, hit.front);
}

fn is_opaque(triangle: u32) -> bool {
    return (triangles[triangle].y & OPAQUE) != 0u;
}

// Opacity of a point of a triangle, 0 to 1; `u` and `v` are the barycentric weights of the second and third vertex.
fn opacity(triangle: u32, u: f32, v: f32) -> f32 {
    let slot = triangles[triangle].y;
    if (slot & OPAQUE) != 0u {
        return 1.0;
    }
    return table_opacity(slot, u, v);
}

// The same for a camera ray: the back of a single-sided surface is not there.
fn opacity_for_camera(triangle: u32, u: f32, v: f32, counter_clockwise: bool) -> f32 {
    let slot = triangles[triangle].y;
    let front = counter_clockwise != ((slot & MIRRORED) != 0u);
    if (slot & SINGLE_SIDED) != 0u && !front {
        return 0.0;
    }
    if (slot & OPAQUE) != 0u {
        return 1.0;
    }
    return table_opacity(slot, u, v);
}

fn table_opacity(slot: u32, u: f32, v: f32) -> f32 {
    let entry = slot & SLOT;
    let w = 1.0 - u - v;
    // From the first vertex on, not as a weighted sum: three equal alphas give exactly theirs, so that 1 stays opaque.
    let first = opacities[entry].alpha[0];
    let second = opacities[entry].alpha[1];
    let third = opacities[entry].alpha[2];
    var alpha = first + u * (second - first) + v * (third - first);
    let texture = opacities[entry].texture;
    if texture != NO_TEXTURE {
        let uv = w * opacities[entry].uv[0] + u * opacities[entry].uv[1] + v * opacities[entry].uv[2];
        alpha *= sample_alpha(texture, uv);
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

// Corners of a triangle in the space of its object, where they never move: those of the mesh, not skinned or morphed, or of a square of
// side 1 for a particle.
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
