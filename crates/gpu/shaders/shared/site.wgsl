// What a threshold may depend on: `Site` of sheer_render::contract, one hit.
struct Site {
    // Column and row, from the upper left.
    pixel: vec2u,
    frame: u32,
    seed: u32,
    // InstanceID() of STD Listing 4, GeometryIndex(), PrimitiveIndex().
    instance: u32,
    geometry: u32,
    primitive: u32,
    // HitKind(): 0 front, 1 back.
    back: u32,
    // Of the hit, world.
    position: vec3f,
    // In the space of the object, before it moves and bends; this and the next only where the method says
    // USES_OBJECT_SPACE.
    position_in_object: vec3f,
    // Length that a pixel covers there, along its longer axis; may be infinite.
    footprint_in_object: f32,
}
