// From world to the texels of a light's map: twin of crates/render/src/shadow/projection.rs.
#import shared/frame
#import shared/receiver
#import shared/vector
#import struct/ShadowFace
#import struct/ShadowLight

@group(GROUP_PASS) @binding(BIND_SHADOW_LIGHTS) var<storage, read> shadow_lights: array<ShadowLight>;
@group(GROUP_PASS) @binding(BIND_SHADOW_FACES) var<storage, read> shadow_faces: array<ShadowFace>;

struct LightRay {
    origin: vec3f,
    // From the light, unit length.
    direction: vec3f,
}

// Where a point lies in a map.
struct MapCoordinate {
    // False outside the map, where nothing is lit or nothing is.
    inside: bool,
    // Index of the face among those of the light.
    face: u32,
    // In texels from the corner.
    at: vec2f,
    // World units along the ray from the light.
    depth: f32,
    // Sides of a texel there, world units.
    texel: vec2f,
}

// A texel of a light, and the depth that counts as the receiver's there.
struct Tap {
    texel: u32,
    depth: f32,
}

// The ray from the light through a point of a face.
fn light_ray(light: u32, face_of_light: u32, at: vec2f) -> LightRay {
    let face = shadow_faces[shadow_lights[light].first_face + face_of_light];
    if face.is_central == 0u {
        let corner = face.origin + vec3f(at * vec2f(face.width, face.height), 0.0);
        let origin = sum_in_order(face.right * corner.x, face.up * corner.y, face.forward * corner.z);
        return LightRay(origin, face.forward);
    }
    let beside = (at * (2.0 / f32(shadow_lights[light].side)) - 1.0) * face.width;
    return LightRay(face.origin, normalized(sum_in_order(face.right * beside.x, face.up * beside.y, face.forward)));
}

// The longer side of a texel of a face at a depth, world units.
fn texel_side(light: u32, face_of_light: u32, depth: f32) -> f32 {
    let face = shadow_faces[shadow_lights[light].first_face + face_of_light];
    if face.is_central == 0u {
        return max(face.width, face.height);
    }
    return 2.0 / f32(shadow_lights[light].side) * face.width * depth;
}

// The face that a point lies in front of.
fn face_towards(light: u32, point: vec3f) -> u32 {
    var best = 0u;
    var furthest = -FAR_AWAY;
    for (var face = 0u; face < shadow_lights[light].face_count; face += 1u) {
        let other = shadow_faces[shadow_lights[light].first_face + face];
        let ahead = dot(other.forward, point - other.origin);
        if ahead >= furthest {
            best = face;
            furthest = ahead;
        }
    }
    return best;
}

fn in_face(face: ShadowFace, vector: vec3f) -> vec3f {
    return vec3f(dot(face.right, vector), dot(face.up, vector), dot(face.forward, vector));
}

fn map_coordinate(light: u32, point: vec3f) -> MapCoordinate {
    let face_of_light = face_towards(light, point);
    let face = shadow_faces[shadow_lights[light].first_face + face_of_light];
    let side = f32(shadow_lights[light].side);
    var coordinate = MapCoordinate(false, face_of_light, vec2f(0.0), 0.0, vec2f(face.width, face.height));
    if face.is_central == 0u {
        let local = in_face(face, point) - face.origin;
        coordinate.at = local.xy / coordinate.texel;
        coordinate.depth = local.z;
    } else {
        let local = in_face(face, point - face.origin);
        // Behind the eye and beside it there is none.
        if local.z <= 0.0 {
            return coordinate;
        }
        coordinate.at = 0.5 * side * (local.xy / (local.z * face.width) + 1.0);
        coordinate.depth = length(local);
        coordinate.texel = vec2f(2.0 * face.width * local.z / side);
    }
    coordinate.inside = all(coordinate.at >= vec2f(0.0)) && all(coordinate.at <= vec2f(side)) && coordinate.depth >= 0.0;
    return coordinate;
}

// The texel at a point, the nearest one of the face, and the depth that counts as the receiver's there: where
// its plane meets the texel's ray, less a bias.
fn tap(light: u32, receiver: Receiver, coordinate: MapCoordinate, beside: vec2f) -> Tap {
    let side = shadow_lights[light].side;
    let at = clamp(floor(beside), vec2f(0.0), vec2f(f32(side) - 1.0));
    let middle = at + 0.5;
    let texel = (coordinate.face * side + u32(at.y)) * side + u32(at.x);
    let ray = light_ray(light, coordinate.face, middle);
    let offset = length((middle - coordinate.at) * coordinate.texel);
    let cosine = dot(receiver.normal, ray.direction);
    let limit = STEEPEST * offset;
    var depth = coordinate.depth;
    if cosine != 0.0 {
        let on_plane = dot(receiver.position - ray.origin, receiver.normal) / cosine;
        depth = clamp(on_plane, coordinate.depth - limit, coordinate.depth + limit);
    }
    let facet = FACET_SLOPE * offset / max(cosine * cosine, 1.0 / STEEPEST);
    return Tap(texel, depth - facet - lift(receiver) - DEPTH_ROUNDING * coordinate.depth);
}
