// What a frame is rendered with, the same in every pass.

// A camera at one moment (`CameraPose`): columns of world_from_camera, and its lens.
struct Camera {
    x_axis: vec3f,
    // Tangent of half the vertical field of view; without meaning for an orthographic camera.
    tan_half_fov: f32,
    y_axis: vec3f,
    // Half the height of the view, world units; without meaning for a perspective camera.
    half_height: f32,
    z_axis: vec3f,
    is_orthographic: u32,
    eye: vec3f,
    padding: u32,
}

struct Frame {
    camera: Camera,
    previous_camera: Camera,
    // Pixels.
    size: vec2u,
    // Offset of the sample from the pixel centre, pixels.
    jitter: vec2f,
    index: u32,
    seed: u32,
    triangle_count: u32,
    // Triangles before this one never move.
    static_count: u32,
    light_count: u32,
    lobe_count: u32,
    background_kind: u32,
    // Whether the light that passes a surface somewhere takes its colour.
    tinted: u32,
    background_rgb: vec3f,
    exposure: f32,
    zenith: vec3f,
    // Ray origins are lifted off surfaces by this much, world units.
    lift: f32,
    horizon: vec3f,
    // No surface is nearer or further along the view axis, scene units; both above 0.
    depth_near: f32,
    ground: vec3f,
    depth_far: f32,
    // A power of two that no distance along a camera ray exceeds, world units.
    reach: f32,
    // Of the hybrid: visibility from which on one ray stands for the rest, and the most exact fragments.
    hybrid_visibility: f32,
    hybrid_layers: u32,
    // 1 / size.y, by the CPU's division.
    inverse_height: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
