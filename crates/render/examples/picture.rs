//! A scene, a method, 64 samples a pixel, a PNG file: `cargo run --release --example picture -- picture.png`.

use std::{env, error::Error, path::Path};

use sheer_image::{DisplayShare, Metadata, Tone, write_png};
use sheer_render::{Antialiasing, Pipeline, Settings, Stage};

fn main() -> Result<(), Box<dyn Error>> {
    let name = env::args().nth(1).unwrap_or_else(|| "picture.png".to_owned());
    write(Path::new(&name), [480, 270])
}

/// Renders a picture of so many pixels into a file.
pub(crate) fn write(path: &Path, size: [u32; 2]) -> Result<(), Box<dyn Error>> {
    // A name of the gallery, or a file: glTF, OBJ, PLY, STL, hair.
    let scene = sheer_gallery::open("smoke-square")?.scene;
    let mut stage = Stage::new(scene, &Default::default(), None)?;
    let settings = Settings { size, start_secs: 2.0, ..Settings::default() };
    // `ACCUMULATE` holds the time still: the picture is the mean of its frames.
    let mut pipeline = Pipeline::new("joint".parse()?, Antialiasing::ACCUMULATE, settings)?;
    for index in 0..64 {
        stage.advance(pipeline.clock().at(index));
        pipeline.render(&stage, index)?;
    }
    // Linear, premultiplied; displayed by the tone curve and sRGB.
    let colour = &pipeline.planes().colour;
    write_png(path, colour, Tone::default(), &DisplayShare::Nothing, &Metadata::default())?;
    Ok(())
}
