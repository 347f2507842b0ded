//! Pixels as passes write them, and as the rest of the program reads them.

use rayon::prelude::*;
use sheer_image::{Pixel, Planes};

use crate::{device::Gpu, error::GpuError, resource::buffer::buffer, shader::record::pixel::PixelRecord};

/// Bytes of a pixel in a buffer.
pub(crate) const PIXEL_BYTES: u64 = size_of::<PixelRecord>() as u64;
/// Bytes of a pixel's history: linear RGBA, premultiplied.
pub(crate) const COLOUR_BYTES: u64 = size_of::<[f32; 4]>() as u64;

impl PixelRecord {
    /// The pixel, with a colour in place of its own.
    fn with_colour(self, colour: [f32; 4]) -> Pixel {
        let is_empty = self.instance == Planes::NO_ID;
        Pixel {
            colour,
            depth: if is_empty { f32::INFINITY } else { self.depth },
            motion: self.motion.into(),
            instance: self.instance,
            primitive: self.primitive,
            transparent: self.transparent != 0,
        }
    }
}

/// Reads a picture back: everything of `pixels` but the colours, which are those of `colour`.
///
/// # Errors
/// The device is lost or has no memory left, or the machine has none for the picture.
pub(crate) fn read_planes(
    gpu: &Gpu,
    pixels: &wgpu::Buffer,
    colour: &wgpu::Buffer,
    [width, height]: [u32; 2],
) -> Result<Planes, GpuError> {
    /// Rows that a thread fills at a time.
    const ROWS: u32 = 16;
    let mut planes = Planes::new(width, height)?;
    let count = u64::from(width) * u64::from(height);
    let device = gpu.device();
    let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let pixels_read = buffer(&device, "pixels to read", count * PIXEL_BYTES, usage);
    let colour_read = buffer(&device, "colour to read", count * COLOUR_BYTES, usage);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(pixels, 0, &pixels_read, 0, count * PIXEL_BYTES);
    encoder.copy_buffer_to_buffer(colour, 0, &colour_read, 0, count * COLOUR_BYTES);
    gpu.queue().submit([encoder.finish()]);
    pixels_read.map_async(wgpu::MapMode::Read, .., |_| ());
    colour_read.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.wait()?;
    let view = |buffer: &wgpu::Buffer| {
        let lost = |error: wgpu::MapRangeError| GpuError::DeviceLost { reason: error.to_string() };
        buffer.get_mapped_range(..).map_err(lost)
    };
    let (pixels, colour) = (view(&pixels_read)?, view(&colour_read)?);
    let pixels: &[PixelRecord] = bytemuck::cast_slice(&pixels);
    let colour: &[[f32; 4]] = bytemuck::cast_slice(&colour);
    planes.par_bands_mut(ROWS).for_each(|mut band| {
        for row in 0..band.height() {
            for x in 0..width {
                let at = (band.y + row) as usize * width as usize + x as usize;
                band.set(x, row, pixels[at].with_colour(colour[at]));
            }
        }
    });
    Ok(planes)
}
