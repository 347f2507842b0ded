//! The pixels whose rays are traced together.
//!
//! A tile is small enough that its rays meet much the same triangles, and large enough that what they share,
//! the descent through the tree, weighs little. What a pixel shows does not depend on its tile.

use glam::Vec2;
use sheer_accel::{Hit, Ray};
use sheer_scene::CameraRay;

use super::tracer::Tracer;

/// Side of a tile, pixels; as many rays as descend the tree together.
pub(super) const TILE_SIDE: u32 = 8;

/// A pixel and its ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRay {
    /// Column and row.
    pub(super) at: [u32; 2],
    /// Where the ray goes through, in pixels.
    pub(super) sample: Vec2,
    pub(super) camera: CameraRay,
    /// The hit behind which to look; not again at this one.
    pub(super) after: Option<Hit>,
}

/// Columns and rows of a tile's pixels that lie within a picture, from that of its upper left pixel. The
/// order is Morton's: any 8 or 16 consecutive ones of a whole tile are a block of 4×2 or 4×4.
pub(super) fn pixels_of_tile(
    [left, top]: [u32; 2],
    [width, height]: [u32; 2],
) -> impl Iterator<Item = [u32; 2]> {
    let even_bits = |index: u32| index & 1 | index >> 1 & 2 | index >> 2 & 4;
    (0..TILE_SIDE * TILE_SIDE)
        .map(move |index| [left + even_bits(index), top + even_bits(index >> 1)])
        .filter(move |&[x, y]| x < width && y < height)
}

impl Tracer<'_> {
    /// The rays through the one sample of each of some pixels.
    pub(super) fn pixel_rays(&self, pixels: &[[u32; 2]]) -> Vec<PixelRay> {
        let ray = |&at: &[u32; 2]| {
            let sample = self.sample(at);
            PixelRay { at, sample, camera: self.camera_ray(sample), after: None }
        };
        pixels.iter().map(ray).collect()
    }

    /// What is left to trace of the rays of pixels: each begins at the hit behind which it looks,
    /// inclusively, for there may be a second one at its depth.
    pub(super) fn rays_left(&self, rays: &[PixelRay]) -> Vec<Ray> {
        let left = |ray: &PixelRay| {
            let whole = self.ray(&ray.camera);
            Ray { t_min: ray.after.map_or(whole.t_min, |hit| hit.t), ..whole }
        };
        rays.iter().map(left).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_picture_once_and_groups_are_blocks() {
        let size = [21, 13];
        let mut counts = [[0; 21]; 13];
        for top in (0..size[1]).step_by(TILE_SIDE as usize) {
            for left in (0..size[0]).step_by(TILE_SIDE as usize) {
                for [x, y] in pixels_of_tile([left, top], size) {
                    counts[y as usize][x as usize] += 1;
                }
            }
        }
        assert_eq!(counts, [[1; 21]; 13]);
        let whole: Vec<_> = pixels_of_tile([0, 0], [8, 8]).collect();
        for (count, block) in [(8, [3, 1]), (16, [3, 3])] {
            for group in whole.chunks(count) {
                let spread = |axis: usize| {
                    let along = group.iter().map(|at| at[axis]);
                    along.clone().max().unwrap() - along.min().unwrap()
                };
                assert_eq!([spread(0), spread(1)], block);
            }
        }
    }
}
