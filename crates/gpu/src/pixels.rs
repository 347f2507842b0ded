//! Pixels as passes write them, and as the rest of the program reads them.

use rayon::prelude::*;
use sheer_image::{Image, Pixel, PixelLayers, Planes};

use crate::{
    device::Gpu,
    error::GpuError,
    resource::buffer::buffer,
    shader::{
        numbers::NO_DEPTH,
        record::pixel::{LayersRecord, PixelRecord},
    },
};

/// Bytes of a pixel in a buffer.
pub(crate) const PIXEL_BYTES: u64 = size_of::<PixelRecord>() as u64;
/// Bytes of what is known of a pixel's layers.
pub(crate) const LAYERS_BYTES: u64 = size_of::<LayersRecord>() as u64;
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
            layers: PixelLayers::EMPTY,
        }
    }
}

impl From<LayersRecord> for PixelLayers {
    fn from(record: LayersRecord) -> Self {
        let depth = |depth: f32| if depth >= NO_DEPTH { f32::INFINITY } else { depth };
        Self {
            coverage: record.coverage,
            absorbed: record.absorbed,
            share: record.share,
            is_front: record.is_front != 0,
            front_motion: record.front_motion.into(),
            front_depth: depth(record.front_depth),
            back_motion: record.back_motion.into(),
            back_depth: depth(record.back_depth),
        }
    }
}

/// Reads a buffer of a picture back, row by row.
fn read_pixels<T: bytemuck::AnyBitPattern>(
    gpu: &Gpu,
    buffer_of_pixels: &wgpu::Buffer,
    count: u64,
) -> Result<Vec<T>, GpuError> {
    let bytes = count * size_of::<T>() as u64;
    let device = gpu.device();
    let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let read = buffer(&device, "pixels to read", bytes, usage);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer_of_pixels, 0, &read, 0, bytes);
    gpu.queue().submit([encoder.finish()]);
    read.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.wait()?;
    let lost = |error: wgpu::MapRangeError| GpuError::DeviceLost { reason: error.to_string() };
    let view = read.get_mapped_range(..).map_err(lost)?;
    Ok(bytemuck::cast_slice(&view).to_vec())
}

/// Reads a picture back: everything of `pixels` but the colours, which are those of `colour`; with what is
/// known of the layers, if anything is.
///
/// # Errors
/// The device is lost or has no memory left, or the machine has none for the picture.
pub(crate) fn read_planes(
    gpu: &Gpu,
    pixels: &wgpu::Buffer,
    colour: &wgpu::Buffer,
    layers: Option<&wgpu::Buffer>,
    [width, height]: [u32; 2],
) -> Result<Planes, GpuError> {
    /// Rows that a thread fills at a time.
    const ROWS: u32 = 16;
    let mut planes = Planes::new(width, height)?;
    let count = u64::from(width) * u64::from(height);
    let pixels: Vec<PixelRecord> = read_pixels(gpu, pixels, count)?;
    let colour: Vec<[f32; 4]> = read_pixels(gpu, colour, count)?;
    planes.par_bands_mut(ROWS).for_each(|mut band| {
        for row in 0..band.height() {
            for x in 0..width {
                let at = (band.y + row) as usize * width as usize + x as usize;
                band.set(x, row, pixels[at].with_colour(colour[at]));
            }
        }
    });
    if let Some(layers) = layers {
        let records: Vec<LayersRecord> = read_pixels(gpu, layers, count)?;
        let layers = records.into_iter().map(PixelLayers::from).collect();
        planes.layers = Some(Image::from_vec(width, height, layers)?);
    }
    Ok(planes)
}
