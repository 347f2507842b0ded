// What a frame knows of a pixel (`sheer_image::Pixel`); pixels lie row by row.
struct PixelRecord {
    // Linear, premultiplied.
    colour: vec4f,
    // Pixels, from this frame to the last: where the surface was, minus where it is.
    motion: vec2f,
    // Along the view axis, scene units.
    depth: f32,
    // 1 where a transparent fragment takes part.
    transparent: u32,
    instance: u32,
    primitive: u32,
    padding: vec2u,
}
