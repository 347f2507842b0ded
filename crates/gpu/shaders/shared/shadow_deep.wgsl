// Deep shadow rays: the exact light that passes everything between a point and a light (STD section 3.1).
// Twin of crates/render/src/shadow/deep.rs.
#import shared/hit
#import shared/receiver
#import shared/scene
#import shared/counters
#import shared/surface
#expand traverse VISITOR=shadow

// What is left of the light.
var<private> light_left: vec3f;
// Of the beam to the light, world units.
var<private> light_width: f32;

// Transmittance of everything between a point and a light; every light has the same rays.
fn shadow_transmittance(light: u32, receiver: Receiver) -> vec3f {
    let lifted = lift(receiver);
    // Lifted towards the light's side of the surface.
    let side = signum(dot(receiver.normal, receiver.to_light));
    let origin = receiver.position + receiver.normal * (side * lifted);
    let distance = receiver.distance - 2.0 * lifted;
    light_left = vec3f(1.0);
    light_width = receiver.width;
    counted_shadow_rays += 1u;
    // A ray that ends before it begins is not allowed to be asked for.
    if distance > 0.0 {
        traverse_shadow(origin, receiver.to_light, 0.0, distance);
    }
    return light_left;
}

fn visit_shadow(hit: Hit) -> u32 {
    let alpha = opacity(hit.triangle, hit.u, hit.v, light_width);
    if alpha >= MIN_ALPHA {
        if frame.tinted != 0u {
            light_left *= light_through(hit.triangle, hit.u, hit.v, hit.front, alpha, light_width);
        } else {
            light_left *= 1.0 - alpha;
        }
    }
    if max_element(light_left) <= MIN_VISIBILITY {
        light_left = vec3f(0.0);
        return STOP;
    }
    return GO_ON;
}
