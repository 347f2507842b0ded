// What shading needs to know of a point on a surface: twin of `Frame::surface` in crates/scene/src/frame.rs.
#import shared/hit
#import shared/scene
#import shared/texture
#import shared/vector

// As `sheer_scene::Surface`. Colours are linear.
struct Surface {
    // Where the point is, world.
    position: vec3f,
    previous_position: vec3f,
    // Unit normal of the triangle, towards the viewer.
    geometric_normal: vec3f,
    // Unit normal for shading, towards the viewer's side; of a fibre its direction.
    normal: vec3f,
    // Whether the front is seen.
    front: bool,
    base_colour: vec3f,
    metallic: f32,
    // Perceptual, 0 to 1.
    roughness: f32,
    emissive: vec3f,
    occlusion: f32,
    // One of the numbers MODEL_….
    model: u32,
}

// A ray and how wide it is where it meets a surface: what textures are looked up with.
struct Beam {
    // Unit direction, world.
    direction: vec3f,
    // Across it, world units.
    width: f32,
}

// The ellipse on a triangle that a beam covers: twin of `Ellipse` in crates/scene/src/frame/footprint.rs. Its
// axes from end to end, in lengths of the triangle's second and third edge from the first corner.
struct Ellipse {
    along: vec2f,
    across: vec2f,
}

// Vertex attributes at a point of a triangle.
struct Attributes {
    object: u32,
    primitive: u32,
    weights: vec3f,
    corners: array<vec3f, 3>,
    // Interpolated normal, world, unit length, on the front's side.
    normal: vec3f,
    // World, with the bitangent's sign in w.
    tangent: vec4f,
    has_tangent: bool,
    tint: vec3f,
}

fn weigh2(weights: vec3f, values: array<vec2f, 3>) -> vec2f {
    return values[0] * weights.x + values[1] * weights.y + values[2] * weights.z;
}

fn weigh3(weights: vec3f, values: array<vec3f, 3>) -> vec3f {
    return values[0] * weights.x + values[1] * weights.y + values[2] * weights.z;
}

fn weigh4(weights: vec3f, values: array<vec4f, 3>) -> vec4f {
    return values[0] * weights.x + values[1] * weights.y + values[2] * weights.z;
}

fn gather3(list: u32, vertices: array<u32, 3>) -> array<vec3f, 3> {
    return array(attribute3(list, vertices[0]), attribute3(list, vertices[1]), attribute3(list, vertices[2]));
}

fn gather4(list: u32, vertices: array<u32, 3>) -> array<vec4f, 3> {
    return array(attribute4(list, vertices[0]), attribute4(list, vertices[1]), attribute4(list, vertices[2]));
}

// A column of an object's matrices, or a quad's axis.
fn axis(object: u32, first: u32) -> vec3f {
    return vec3f(objects[object].axes[first], objects[object].axes[first + 1u], objects[object].axes[first + 2u]);
}

// A matrix whose columns begin at `first`, times a vector.
fn rotate(object: u32, first: u32, vector: vec3f) -> vec3f {
    return axis(object, first) * vector.x + axis(object, first + 3u) * vector.y + axis(object, first + 6u) * vector.z;
}

fn deformed_normal(index: u32) -> vec3f {
    let at = 3u * index;
    return vec3f(deformed_normals[at], deformed_normals[at + 1u], deformed_normals[at + 2u]);
}

// Where a point of a triangle is, world.
fn position_at(triangle: u32, weights: vec3f) -> vec3f {
    return weigh3(weights, corners_in_world(triangle));
}

// Where it was in the previous frame.
fn previous_position_at(triangle: u32, weights: vec3f) -> vec3f {
    return weigh3(weights, previous_corners_in_world(triangle));
}

fn surface_at(hit: Hit, beam: Beam) -> Surface {
    let triangle = hit.triangle;
    let weights = vec3f(1.0 - hit.u - hit.v, hit.u, hit.v);
    let corners = corners_in_world(triangle);
    let object = triangles[triangle].x;
    let material = objects[object].material;
    let front = is_front(triangle, hit.front);
    let to_b = corners[1] - corners[0];
    let to_c = corners[2] - corners[0];
    let power = evening_power(to_b, to_c);
    let winding_normal = normalize_or(cross(to_b * power, to_c * power), vec3f(0.0));
    let geometric_normal = select(-winding_normal, winding_normal, hit.front);
    // The outward normal is that of the front side.
    let outward = select(-geometric_normal, geometric_normal, front);
    let found = attributes_at(object, triangle, weights, corners, outward);

    var surface: Surface;
    surface.position = weigh3(weights, corners);
    surface.previous_position = previous_position_at(triangle, weights);
    surface.geometric_normal = geometric_normal;
    surface.normal = found.normal;
    surface.front = front;
    surface.base_colour = materials[material].base_colour * found.tint;
    surface.metallic = materials[material].metallic;
    surface.roughness = materials[material].roughness;
    surface.emissive = materials[material].emissive;
    surface.occlusion = 1.0;
    surface.model = materials[material].model;
    surface = apply_textures(material, found, beam, surface);
    if !front && surface.model != MODEL_SMOKE && surface.model != MODEL_FIBRE {
        surface.normal = -surface.normal;
    }
    return surface;
}

// Vertex attributes of a triangle, interpolated at a point of it; `outward` stands in for normals that a mesh
// lacks.
fn attributes_at(
    object: u32, triangle: u32, weights: vec3f, corners: array<vec3f, 3>, outward: vec3f,
) -> Attributes {
    var found: Attributes;
    found.object = object;
    found.primitive = triangle - objects[object].first_triangle;
    found.weights = weights;
    found.corners = corners;
    found.tint = vec3f(1.0);
    found.has_tangent = false;
    if objects[object].look == LOOK_QUAD {
        let right = axis(object, 0u);
        let up = axis(object, 3u);
        // A sphere inscribed in the quad; the corners outside it look sideways.
        let disc = weigh2(weights, quad_uvs(found.primitive)) * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
        let height = sqrt(max(1.0 - dot(disc, disc), 0.05));
        let normal = right * disc.x + up * disc.y + cross(right, up) * height;
        found.normal = normal * (1.0 / sqrt(dot(normal, normal)));
        found.tint = axis(object, 10u);
        return found;
    }
    let vertices = mesh_vertices(object, found.primitive);
    let mesh = objects[object].mesh;
    var normal = outward;
    if objects[object].look == LOOK_RIGID {
        if mesh.normals != NONE {
            normal = rotate(object, 0u, weigh3(weights, gather3(mesh.normals, vertices)));
        }
        if mesh.tangents != NONE {
            let tangent = weigh4(weights, gather4(mesh.tangents, vertices));
            found.tangent = vec4f(rotate(object, 9u, tangent.xyz), tangent.w);
            found.has_tangent = true;
        }
    } else if objects[object].first_deformed_normal != NONE {
        let first = objects[object].first_deformed_normal;
        let normals = array(
            deformed_normal(first + vertices[0]),
            deformed_normal(first + vertices[1]),
            deformed_normal(first + vertices[2]),
        );
        normal = weigh3(weights, normals);
        if mesh.tangents != NONE {
            let first_tangent = first + mesh.vertex_count;
            let tangents = array(
                deformed_normal(first_tangent + vertices[0]),
                deformed_normal(first_tangent + vertices[1]),
                deformed_normal(first_tangent + vertices[2]),
            );
            let bitangent_sign = weigh4(weights, gather4(mesh.tangents, vertices)).w;
            found.tangent = vec4f(weigh3(weights, tangents), bitangent_sign);
            found.has_tangent = true;
        }
    }
    if mesh.colours != NONE {
        found.tint = weigh4(weights, gather4(mesh.colours, vertices)).rgb;
    }
    found.normal = normalize_or(normal, vec3f(0.0, 1.0, 0.0));
    return found;
}

// Texture coordinates of a triangle's corners, as a texture is used.
fn corner_uvs(found: Attributes, used: TextureUse) -> array<vec2f, 3> {
    let object = found.object;
    var raw: array<vec2f, 3>;
    if objects[object].look == LOOK_QUAD {
        let tile_origin = vec2f(objects[object].axes[6], objects[object].axes[7]);
        let tile_size = vec2f(objects[object].axes[8], objects[object].axes[9]);
        let local = quad_uvs(found.primitive);
        raw = array(
            tile_origin + local[0] * tile_size, tile_origin + local[1] * tile_size, tile_origin + local[2] * tile_size,
        );
    } else if used.uv_set < objects[object].mesh.uv_set_count {
        let list = objects[object].mesh.uv_sets + 2u * used.uv_set * objects[object].mesh.vertex_count;
        let vertices = mesh_vertices(object, found.primitive);
        raw = array(
            attribute2(list, vertices[0]), attribute2(list, vertices[1]), attribute2(list, vertices[2]),
        );
    }
    return array(transform_uv(used, raw[0]), transform_uv(used, raw[1]), transform_uv(used, raw[2]));
}

fn transform_uv(used: TextureUse, uv: vec2f) -> vec2f {
    return used.x_axis * uv.x + used.y_axis * uv.y + used.translation;
}

fn texture_size(texture: u32) -> vec2f {
    return vec2f(textures[texture].size);
}

// A power of two that brings the largest component of two vectors to between 1 and 2.
fn evening_power(a: vec3f, b: vec3f) -> f32 {
    let largest = max(abs(a), abs(b));
    let bits = bitcast<u32>(max(largest.x, max(largest.y, largest.z))) & 0x7f800000u;
    return bitcast<f32>(0x7f000000u - min(bits, 0x7f000000u));
}

// Where a beam meets a triangle.
fn ellipse_of(corners: array<vec3f, 3>, beam: Beam) -> Ellipse {
    let power = evening_power(corners[1] - corners[0], corners[2] - corners[0]);
    let to_b = (corners[1] - corners[0]) * power;
    let to_c = (corners[2] - corners[0]) * power;
    let width = beam.width * power;
    let area_normal = cross(to_b, to_c);
    let square = dot(area_normal, area_normal);
    let normal = area_normal * (1.0 / sqrt(square));
    // Across the beam it is as wide as the beam, along it longer.
    var across = cross(normal, beam.direction);
    if !(dot(across, across) > HEAD_ON) {
        across = to_b;
    }
    across = normalize_or(across, vec3f(0.0));
    let along = cross(normal, across);
    let stretch = 1.0 / max(abs(dot(normal, beam.direction)), LEAST_GRAZING);
    let to_edges = 1.0 / square;
    return Ellipse(
        in_edges(along * (width * stretch), to_b, to_c, area_normal) * to_edges,
        in_edges(across * width, to_b, to_c, area_normal) * to_edges,
    );
}

fn in_edges(axis: vec3f, to_b: vec3f, to_c: vec3f, area_normal: vec3f) -> vec2f {
    return vec2f(dot(cross(axis, to_c), area_normal), dot(cross(to_b, axis), area_normal));
}

// What a lookup by the coordinates of the corners sees of a texture of a size.
fn footprint_of(ellipse: Ellipse, uvs: array<vec2f, 3>, size: vec2f) -> Footprint {
    let to_b = uvs[1] - uvs[0];
    let to_c = uvs[2] - uvs[0];
    let along = to_b * ellipse.along.x + to_c * ellipse.along.y;
    let across = to_b * ellipse.across.x + to_c * ellipse.across.y;
    let length_along = length(along * size);
    let length_across = length(across * size);
    // Stretched coordinates may make the shorter axis the longer one.
    if length_along >= length_across {
        return Footprint(along, length_along, length_across);
    }
    return Footprint(across, length_across, length_along);
}

// Texels along a world unit of a triangle whose corners have texture coordinates, in a texture of a size; 0
// for a triangle without an area.
fn texel_density(corners: array<vec3f, 3>, uvs: array<vec2f, 3>, size: vec2f) -> f32 {
    let power = evening_power(corners[1] - corners[0], corners[2] - corners[0]);
    let area = length(cross((corners[1] - corners[0]) * power, (corners[2] - corners[0]) * power));
    let to_b = uvs[1] - uvs[0];
    let to_c = uvs[2] - uvs[0];
    let uv_area = abs(to_b.x * to_c.y - to_b.y * to_c.x);
    if !(area > 0.0) {
        return 0.0;
    }
    return sqrt(uv_area * size.x * size.y / area) * power;
}

// Multiplies textures into the surface and bends its normal. One after the other in a loop: a driver that
// inlines everything compiles the lookup once instead of five times.
fn apply_textures(material: u32, found: Attributes, beam: Beam, bare: Surface) -> Surface {
    var surface = bare;
    let ellipse = ellipse_of(found.corners, beam);
    for (var index = 0u; index < SHADED_TEXTURE_COUNT; index++) {
        let used = materials[material].textures[index];
        if used.texture == NONE {
            continue;
        }
        let uvs = corner_uvs(found, used);
        let footprint = footprint_of(ellipse, uvs, texture_size(used.texture));
        let texel = sample(used.texture, weigh2(found.weights, uvs), footprint);
        switch index {
            case TEXTURE_BASE_COLOUR: {
                surface.base_colour *= texel.rgb;
            }
            case TEXTURE_METALLIC_ROUGHNESS: {
                surface.roughness *= texel.y;
                surface.metallic *= texel.z;
            }
            case TEXTURE_EMISSIVE: {
                surface.emissive *= texel.rgb;
            }
            case TEXTURE_OCCLUSION: {
                surface.occlusion = 1.0 + materials[material].occlusion_strength * (texel.x - 1.0);
            }
            default: {
                let scale = materials[material].normal_scale;
                surface.normal = bend(found, uvs, (texel.xyz * 2.0 - vec3f(1.0)) * vec3f(scale, scale, 1.0));
            }
        }
    }
    return surface;
}

// A tangent-space normal in world. Without a given tangent it follows the texture's u axis across the
// triangle.
fn bend(found: Attributes, uvs: array<vec2f, 3>, in_tangent: vec3f) -> vec3f {
    var along = found.tangent.xyz;
    var bitangent_sign = found.tangent.w;
    if !found.has_tangent {
        let to_b = uvs[1] - uvs[0];
        let to_c = uvs[2] - uvs[0];
        let area = to_b.x * to_c.y - to_b.y * to_c.x;
        let b = found.corners[1] - found.corners[0];
        let c = found.corners[2] - found.corners[0];
        along = (b * to_c.y - c * to_b.y) * signum(area);
        bitangent_sign = handedness(found, area);
    }
    let tangent = normalize_or(along - found.normal * dot(found.normal, along), vec3f(0.0));
    if all(tangent == vec3f(0.0)) {
        return found.normal;
    }
    let bitangent = cross(found.normal, tangent) * bitangent_sign;
    return normalize_or(
        tangent * in_tangent.x + bitangent * in_tangent.y + found.normal * in_tangent.z, found.normal,
    );
}

// Sign of `normal × tangent` against the direction in which the image's v falls: up in the image is +Y of a
// normal map.
fn handedness(found: Attributes, uv_area: f32) -> f32 {
    let winding = cross(found.corners[1] - found.corners[0], found.corners[2] - found.corners[0]);
    return -(signum(uv_area) * signum(dot(winding, found.normal)));
}

// Light that a surface lets through in its colour: twin of `sheer_scene::Transmitted`.
struct Transmitted {
    // Share of the light that meets the surface, before it is filtered.
    share: f32,
    // What is left of that in red, green and blue.
    filtered: vec3f,
}

// Share of the light, red, green and blue, that passes a point of a triangle whose opacity there is `alpha`,
// in a beam of a width that finds its vertices counter-clockwise (or not): see `Frame::light_through`.
fn light_through(triangle: u32, u: f32, v: f32, counter_clockwise: bool, alpha: f32, width: f32) -> vec3f {
    let passing = transmitted(triangle, u, v, counter_clockwise, alpha, width);
    return vec3f(1.0 - alpha) - passing.share * (vec3f(1.0) - passing.filtered);
}

// The light that a point of a triangle transmits in its colour: twin of `Frame::transmitted`; of what has no
// transmission none.
fn transmitted(
    triangle: u32, u: f32, v: f32, counter_clockwise: bool, alpha: f32, width: f32,
) -> Transmitted {
    let slot = triangles[triangle].y;
    if (slot & TINTED) == 0u || (slot & OPAQUE) != 0u {
        return Transmitted(0.0, vec3f(1.0));
    }
    let weights = vec3f(1.0 - u - v, u, v);
    let object = triangles[triangle].x;
    let material = objects[object].material;
    let found = attributes_at(object, triangle, weights, corners_in_world(triangle), vec3f(0.0));
    // Base colour and thickness, by one lookup in a loop.
    var filtered = materials[material].base_colour * found.tint;
    var thickness = materials[material].thickness;
    let has_body = thickness > 0.0 && is_front(triangle, counter_clockwise);
    for (var index = 0u; index < select(1u, 2u, has_body); index++) {
        let place = select(TEXTURE_BASE_COLOUR, TEXTURE_THICKNESS, index == 1u);
        let used = materials[material].textures[place];
        if used.texture == NONE {
            continue;
        }
        let uvs = corner_uvs(found, used);
        let density = texel_density(found.corners, uvs, texture_size(used.texture));
        let texel = sample(used.texture, weigh2(weights, uvs), round_footprint(width * density));
        if index == 0u {
            filtered *= texel.rgb;
        } else {
            thickness *= texel.y;
        }
    }
    filtered = clamp(filtered, vec3f(0.0), vec3f(1.0));
    // A ray meets the front of a closed body once on its way through: the whole thickness counts there.
    if has_body {
        filtered *= exp(-materials[material].absorption * (thickness * scale_of(object)));
    }
    let transmission = materials[material].transmission;
    let share = min(alpha * (transmission / (1.0 - transmission)), 1.0 - alpha);
    return Transmitted(share, filtered);
}

// World units a unit of an object's mesh: twin of `Look::scale`.
fn scale_of(object: u32) -> f32 {
    if objects[object].look != LOOK_RIGID {
        return 1.0;
    }
    return pow(abs(dot(axis(object, 9u), cross(axis(object, 12u), axis(object, 15u)))), 1.0 / 3.0);
}
