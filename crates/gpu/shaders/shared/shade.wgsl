// Shading: glTF metallic-roughness under punctual lights with shadows, and the environment. Twin of
// crates/render/src/cpu/shade.rs.
#import shared/camera
#import shared/environment
#import shared/frame
#import shared/hit
#import shared/receiver
#import shared/scene
#import shared/surface
#import shared/vector
#import shadow
#import tint

// Light that arrives at a surface from one light.
struct Incident {
    // False beyond the light's range or outside its cone; then the rest means nothing.
    arrives: bool,
    // Unit direction towards the light.
    to_light: vec3f,
    // From the surface to the light, world units.
    distance: f32,
    // Irradiance on a surface that faces the light.
    irradiance: vec3f,
}

// The terms of the BRDF that do not depend on the light (glTF 2.0, appendix B.3).
struct Reflectance {
    // Albedo of the diffuse lobe.
    diffuse: vec3f,
    // Specular reflectance at normal incidence.
    f0: vec3f,
    n_dot_v: f32,
    // Perceptual, no less than MIN_ROUGHNESS.
    roughness: f32,
}

// Linear radiance times exposure of a hit, as it arrives through the tints of all glass in front of it: twin
// of `Tracer::shade_through_glass`.
fn shade(ray: CameraRay, hit: Hit, pixel: vec2u) -> vec3f {
    return shade_unfiltered(ray, hit, pixel) * tint_before(ray, true, hit);
}

// The same as it leaves the hit, less what shines through it: twin of `Tracer::shade`.
fn shade_unfiltered(ray: CameraRay, hit: Hit, pixel: vec2u) -> vec3f {
    return radiance_of(ray, hit, pixel) * own_share(ray, hit);
}

// The same of an ordinary surface.
fn radiance_of(ray: CameraRay, hit: Hit, pixel: vec2u) -> vec3f {
    // As wide as a pixel is at the depth of the hit, which is nearer than the hit itself towards corners.
    let position = position_at(hit.triangle, vec3f(1.0 - hit.u - hit.v, hit.u, hit.v));
    let beam = Beam(ray.direction, pixel_width_at(view_depth(position)));
    let surface = surface_at(hit, beam);
    let to_viewer = -ray.direction;
    if surface.model == MODEL_UNLIT || surface.model == MODEL_LUMINOUS {
        return surface.base_colour * frame.exposure;
    }
    // The environment is asked in one place for all models: software drivers compile each call anew, for
    // seconds.
    var facing = surface.normal;
    if surface.model == MODEL_FIBRE {
        // The side that is seen of a round thing looks towards the viewer as far as its direction allows.
        facing = normalize_or(across(surface.normal, to_viewer), to_viewer);
    }
    var diffuse = vec3f(0.0);
    let is_smoke = surface.model == MODEL_SMOKE;
    for (var side = 0u; side < select(1u, 2u, is_smoke); side++) {
        diffuse += environment_diffuse(select(facing, to_viewer, side == 1u));
    }
    var radiance = surface.emissive;
    if is_smoke {
        radiance += surface.base_colour * (0.5 * diffuse);
    } else if surface.model == MODEL_FIBRE {
        radiance += surface.base_colour * diffuse * surface.occlusion;
    } else {
        let reflectance = reflectance_of(surface, to_viewer);
        let reflected = normalize_or(2.0 * reflectance.n_dot_v * surface.normal - to_viewer, surface.normal);
        let specular = environment_radiance(reflected, surface.roughness);
        let ambient = reflectance.diffuse * diffuse + environment_specular(reflectance) * specular;
        radiance += ambient * surface.occlusion;
    }
    radiance += lit(surface, to_viewer, beam.width, vec3u(pixel, hit.triangle));
    return radiance * frame.exposure;
}

// Sum over all lights: irradiance × response × transmittance; shadows are looked for wherever the surface can
// respond, with beams of `width`, world units.
fn lit(surface: Surface, to_viewer: vec3f, width: f32, key: vec3u) -> vec3f {
    var sum = vec3f(0.0);
    for (var index = 0u; index < frame.light_count; index++) {
        let incident = arriving(index, surface.position);
        if !incident.arrives || !responds(surface, incident.to_light) {
            continue;
        }
        let receiver = Receiver(
            surface.position, surface.geometric_normal, incident.to_light, incident.distance, width, key,
        );
        let transmittance = shadow_transmittance(index, receiver);
        sum += incident.irradiance * response(surface, to_viewer, incident.to_light) * transmittance;
    }
    return sum;
}

// Whether light from that direction can leave the surface towards the viewer.
fn responds(surface: Surface, to_light: vec3f) -> bool {
    return surface.model != MODEL_METALLIC_ROUGHNESS || dot(surface.normal, to_light) > 0.0;
}

// Share of the irradiance that leaves the surface towards the viewer, the cosine included.
fn response(surface: Surface, to_viewer: vec3f, to_light: vec3f) -> vec3f {
    switch surface.model {
        case MODEL_SMOKE: {
            return smoke_phase(surface, to_viewer, to_light);
        }
        case MODEL_FIBRE: {
            return fibre_scattering(surface, to_viewer, to_light);
        }
        default: {
            let n_dot_l = dot(surface.normal, to_light);
            return reflect_light(reflectance_of(surface, to_viewer), surface, to_viewer, to_light) * n_dot_l;
        }
    }
}

// Light from a punctual light at a point (`KHR_lights_punctual`).
fn arriving(index: u32, position: vec3f) -> Incident {
    let light = lights[index];
    if light.kind == LIGHT_DIRECTIONAL {
        return Incident(true, -light.direction, FAR_AWAY, light.intensity);
    }
    let toward = light.position - position;
    let distance = length(toward);
    // Neither a direction nor a falloff has a value at the light itself.
    if !(distance > 0.0) {
        return Incident(false, vec3f(0.0), 0.0, vec3f(0.0));
    }
    let to_light = toward / distance;
    var strength = falloff(distance, light.range);
    if light.kind == LIGHT_SPOT {
        let cosine = dot(light.direction, -to_light);
        let cone = clamp(
            (cosine - light.outer_cosine) / max(light.inner_cosine - light.outer_cosine, LEAST_CONE), 0.0, 1.0,
        );
        strength = strength * cone * cone;
    }
    return Incident(strength > 0.0, to_light, distance, light.intensity * strength);
}

fn falloff(distance: f32, range: f32) -> f32 {
    let share = distance / range;
    let square = share * share;
    let window = clamp(1.0 - square * square, 0.0, 1.0);
    return window / max(distance * distance, LEAST_SQUARE_DISTANCE);
}

fn reflectance_of(surface: Surface, to_viewer: vec3f) -> Reflectance {
    return Reflectance(
        surface.base_colour * (1.0 - surface.metallic),
        lerp(vec3f(DIELECTRIC_F0), surface.base_colour, surface.metallic),
        max(dot(surface.normal, to_viewer), LEAST_COSINE),
        clamp(surface.roughness, MIN_ROUGHNESS, 1.0),
    );
}

// BRDF value: Lambert, and GGX with height-correlated Smith shadowing and Schlick's Fresnel (glTF 2.0,
// appendix B.3).
fn reflect_light(reflectance: Reflectance, surface: Surface, to_viewer: vec3f, to_light: vec3f) -> vec3f {
    let half_way = normalize_or(to_viewer + to_light, surface.normal);
    let n_dot_l = max(dot(surface.normal, to_light), LEAST_COSINE);
    let n_dot_h = clamp(dot(surface.normal, half_way), 0.0, 1.0);
    let v_dot_h = clamp(dot(to_viewer, half_way), 0.0, 1.0);
    let alpha = reflectance.roughness * reflectance.roughness;
    let alpha2 = alpha * alpha;
    let lobe = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
    let distribution = alpha2 / (PI * lobe * lobe);
    let visibility =
        0.5 / (masking(alpha2, reflectance.n_dot_v, n_dot_l) + masking(alpha2, n_dot_l, reflectance.n_dot_v));
    let miss = 1.0 - v_dot_h;
    let miss2 = miss * miss;
    let fresnel = reflectance.f0 + (vec3f(1.0) - reflectance.f0) * (miss2 * miss2 * miss);
    return (vec3f(1.0) - fresnel) * reflectance.diffuse / PI + fresnel * (distribution * visibility);
}

fn masking(alpha2: f32, cosine: f32, other: f32) -> f32 {
    return other * sqrt(cosine * cosine * (1.0 - alpha2) + alpha2);
}

// Directional albedo of the specular lobe (Karis 2014, *Physically Based Shading on Mobile*).
fn environment_specular(reflectance: Reflectance) -> vec3f {
    let r = reflectance.roughness;
    let fit = SPECULAR_FIT_SLOPES * r + SPECULAR_FIT_STARTS;
    let grazing = min(fit.x * fit.x, exp2(SPECULAR_FIT_FALL * reflectance.n_dot_v)) * fit.x + fit.y;
    let scale = -SPECULAR_FIT_GRAZING * grazing + fit.z;
    let bias = SPECULAR_FIT_GRAZING * grazing + fit.w;
    return reflectance.f0 * scale + vec3f(max(bias, 0.0));
}

// Scattering of a puff: light wraps around its inscribed ball, and some of it shines through towards the
// viewer.
fn smoke_phase(surface: Surface, to_viewer: vec3f, to_light: vec3f) -> vec3f {
    let around = (dot(surface.normal, to_light) + SMOKE_WRAP) / (1.0 + SMOKE_WRAP);
    let wrapped_light = max(around, 0.0) / (1.0 + SMOKE_WRAP);
    let g = SMOKE_ANISOTROPY;
    let cosine = -dot(to_viewer, to_light);
    let forward = (1.0 - g * g) / (4.0 * pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
    return surface.base_colour * (SMOKE_SHARES.x * wrapped_light + SMOKE_SHARES.y * forward) / PI;
}

// The part of a direction that is perpendicular to a unit axis.
fn across(along: vec3f, direction: vec3f) -> vec3f {
    return direction - along * dot(along, direction);
}

// Scattering of a fibre, the cosine of the light included (Marschner et al. 2003, Karis 2016, Kajiya and Kay
// 1989; see the CPU's).
fn fibre_scattering(surface: Surface, to_viewer: vec3f, to_light: vec3f) -> vec3f {
    let along = surface.normal;
    let light_across = across(along, to_light);
    let view_across = across(along, to_viewer);
    let cosine = length(light_across);
    // Of the angle around the fibre.
    let around = clamp(
        dot(normalize_or(light_across, vec3f(0.0)), normalize_or(view_across, vec3f(0.0))), -1.0, 1.0,
    );
    let rise = dot(along, to_light) + dot(along, to_viewer);
    let rough = max(surface.roughness, MIN_ROUGHNESS);
    let width = rough * rough;
    let reflected = FIBRE_SURFACE * fibre_lobe(rise, -2.0 * FIBRE_TILT, width) * 0.25 * sqrt(0.5 + 0.5 * around);
    let through = FIBRE_THROUGH * fibre_lobe(rise, FIBRE_TILT, 0.5 * width) * exp(FIBRE_THROUGH_FIT.x * around + FIBRE_THROUGH_FIT.y);
    let back = FIBRE_BACK * fibre_lobe(rise, 4.0 * FIBRE_TILT, 2.0 * width) * exp(FIBRE_BACK_FIT.x * around + FIBRE_BACK_FIT.y);
    let diffuse = (1.0 - FIBRE_THROUGH - FIBRE_BACK) * (1.0 + around) / (PI * PI);
    let inside = (1.0 - FIBRE_SURFACE) * (through + back + diffuse);
    return (vec3f(reflected) + surface.base_colour * inside) * cosine;
}

fn fibre_lobe(rise: f32, tilt: f32, width: f32) -> f32 {
    let offset = (rise - tilt) / width;
    return exp(-0.5 * offset * offset) / (width * sqrt(2.0 * PI));
}
