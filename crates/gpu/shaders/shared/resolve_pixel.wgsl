// From what a ray has found to a pixel with depth, motion and ids: twins of `Tracer::pixel`, `seen` and
// `background`.
#import backdrop
#import behind
#import shared/camera
#import shared/counters
#import shared/found
#import shared/pass
#import shared/project_motion
#import shared/scene
#import shared/shade
#import shared/surface
#import tint

// A premultiplied colour as it is seen through glass: twin of `Premul::filtered`.
fn filtered_by(colour: vec4f, tint: vec3f) -> vec4f {
    return vec4f(colour.rgb * tint, 1.0 - mean_channel(tint) * (1.0 - colour.w));
}

// The background through the tints of all glass.
fn background_through_glass(ray: CameraRay) -> vec4f {
    return filtered_by(background(ray), tint_before(ray, false, Hit()));
}

// A hit taken as opaque, or the background, as if no glass were in front of it; premultiplied.
fn unfiltered(ray: CameraRay, found: bool, hit: Hit, pixel: vec2u) -> vec4f {
    if found {
        counted.shaded += 1u;
        return vec4f(shade_unfiltered(ray, hit, pixel), 1.0);
    }
    return background(ray);
}

// The same through all glass in front of it.
fn seen(ray: CameraRay, found: bool, hit: Hit, pixel: vec2u) -> vec4f {
    return filtered_by(unfiltered(ray, found, hit, pixel), tint_before(ray, found, hit));
}

// What a stochastic ray shows, premultiplied; glass has its part in it unless the pixel is a layer behind it.
fn seen_by(ray: CameraRay, found: Found, is_behind_glass: bool, pixel: vec2u) -> vec4f {
    if found.is_tail {
        return vec4f(found.tail_rgb, 1.0);
    }
    let colour = unfiltered(ray, found.found, found.hit, pixel);
    if is_behind_glass {
        return colour;
    }
    return filtered_by(colour, tint_before(ray, found.found, found.hit));
}

// One premultiplied colour over another.
fn over(front: vec4f, back: vec4f) -> vec4f {
    return front + (1.0 - front.w) * back;
}

// Writes a pixel that shows a premultiplied colour and has the depth, motion and ids of a hit, or of the far
// distance without one.
fn write_pixel(pixel: vec2u, colour: vec4f, ray: CameraRay, found: bool, hit: Hit, transparent: bool) {
    var record: PixelRecord;
    record.colour = colour;
    record.transparent = select(0u, 1u, transparent);
    if found {
        let weights = vec3f(1.0 - hit.u - hit.v, hit.u, hit.v);
        let position = position_at(hit.triangle, weights);
        record.motion = motion_between(position, previous_position_at(hit.triangle, weights));
        record.depth = view_depth(position);
        record.instance = objects[triangles[hit.triangle].x].id;
        record.primitive = primitive(hit.triangle);
    } else {
        record.motion = motion_behind(pixel, ray);
        record.depth = depth_behind(pixel);
        record.instance = NONE;
        record.primitive = NONE;
    }
    pixels[pixel.y * frame.size.x + pixel.x] = record;
}
