//! How much of a texture the beam of a pixel sees.
//!
//! A beam is a cone around a ray, or a cylinder (Akenine-Möller et al. 2019, *Texture Level of Detail
//! Strategies for Real-Time Ray Tracing*): a sample's own up to the surface that is seen, from there on to a
//! light one of the width that it has there. Lookups of opacity, which outnumber all others, take a beam as
//! if it met its surface head on: the ellipse that it covers at a grazing angle is longer, never narrower.
//! Lookups for shading take the ellipse.

use glam::{Vec2, Vec3};

use crate::texture::Footprint;

/// Beams that graze a surface count as if they met it at an angle with this cosine: a division. Their ellipse
/// is a thousand times as long as wide, which no texture needs.
pub const LEAST_GRAZING: f32 = 1e-3;

/// Beams count as head on below this square of the sine of their angle: rounding would turn the axes of their
/// ellipse, which is a circle there.
pub const HEAD_ON: f32 = 1e-6;

/// A power of two that brings the largest component of two vectors to between 1 and 2: whatever the unit of a
/// scene, products of what is scaled by it neither overflow nor vanish, and no bit is lost.
pub(super) fn evening_power(a: Vec3, b: Vec3) -> f32 {
    const EXPONENT: u32 = 0x7f80_0000;
    /// The exponents of x and 1 / x add up to this, for a power of two.
    const BOTH_EXPONENTS: u32 = 0x7f00_0000;
    let largest = a.abs().max(b.abs()).max_element();
    f32::from_bits(BOTH_EXPONENTS.saturating_sub(largest.to_bits() & EXPONENT))
}

/// Texels along a world unit of a triangle whose corners have texture coordinates, in a texture of a size;
/// where coordinates are stretched, the geometric mean. 0 for a triangle without an area.
pub(super) fn texel_density(corners: &[Vec3; 3], uvs: &[Vec2; 3], size: Vec2) -> f32 {
    let [a, b, c] = corners;
    let power = evening_power(b - a, c - a);
    let area = ((b - a) * power).cross((c - a) * power).length();
    let uv_area = (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]).abs();
    let density = (uv_area * size.x * size.y / area).sqrt() * power;
    if density < f32::INFINITY { density } else { 0.0 }
}

/// The ellipse on a triangle that a beam covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// Its axes from end to end, in lengths of the triangle's second and third edge from the first corner.
    axes: [Vec2; 2],
}

impl Ellipse {
    /// Where a beam of a width around a unit direction meets a triangle.
    pub(super) fn new(corners: &[Vec3; 3], direction: Vec3, width: f32) -> Self {
        let [to_b, to_c] = [corners[1] - corners[0], corners[2] - corners[0]];
        let power = evening_power(to_b, to_c);
        let (to_b, to_c, width) = (to_b * power, to_c * power, width * power);
        let area_normal = to_b.cross(to_c);
        let square = area_normal.length_squared();
        let normal = area_normal * square.sqrt().recip();
        // Across the beam it is as wide as the beam, along it longer.
        let across = normal.cross(direction);
        let across = if across.length_squared() > HEAD_ON { across } else { to_b }.normalize_or_zero();
        let along = normal.cross(across);
        let stretch = normal.dot(direction).abs().max(LEAST_GRAZING).recip();
        let in_edges = |axis: Vec3| {
            Vec2::new(axis.cross(to_c).dot(area_normal), to_b.cross(axis).dot(area_normal)) * square.recip()
        };
        Self { axes: [in_edges(along * (width * stretch)), in_edges(across * width)] }
    }

    /// What a lookup by the coordinates of the corners sees of a texture of a size.
    pub(super) fn footprint(&self, uvs: &[Vec2; 3], size: Vec2) -> Footprint {
        let [to_b, to_c] = [uvs[1] - uvs[0], uvs[2] - uvs[0]];
        let [along, across] = self.axes.map(|axis| to_b * axis.x + to_c * axis.y);
        let [length, width] = [along, across].map(|axis| (axis * size).length());
        // Stretched coordinates may make the shorter axis the longer one.
        if length >= width {
            Footprint { axis: along, length, width }
        } else {
            Footprint { axis: across, length: width, width: length }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];
    const UVS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

    #[test]
    fn a_beam_covers_a_circle_head_on_and_a_longer_ellipse_at_an_angle() {
        let size = Vec2::splat(100.0);
        let of = |direction: Vec3| Ellipse::new(&CORNERS, direction.normalize(), 0.1).footprint(&UVS, size);
        let circle = of(Vec3::NEG_Z);
        assert!((circle.length - 10.0).abs() < 1e-4 && (circle.width - 10.0).abs() < 1e-4, "{circle:?}");
        // At 60° from the normal twice as long, in the direction of the beam.
        let slanted = of(Vec3::new(3.0_f32.sqrt(), 0.0, -1.0));
        assert!((slanted.length - 20.0).abs() < 1e-3 && (slanted.width - 10.0).abs() < 1e-4, "{slanted:?}");
        assert!((slanted.axis.abs() - Vec2::new(0.2, 0.0)).length() < 1e-5, "{slanted:?}");
    }

    #[test]
    fn a_power_of_two_evens_out_any_unit() {
        for largest in [f32::MIN_POSITIVE, 1e-30, 0.7, 1.0, 3.0, 1e30] {
            let scaled = largest * evening_power(Vec3::new(0.0, -largest, 0.5 * largest), Vec3::ZERO);
            assert!((1.0..2.0).contains(&scaled), "{largest} became {scaled}");
        }
        assert!(evening_power(Vec3::ZERO, Vec3::ZERO).is_finite());
    }

    #[test]
    fn a_beam_covers_the_same_in_any_unit() {
        for unit in [1e-15, 1e15] {
            let corners = CORNERS.map(|corner| corner * unit);
            let beam = Ellipse::new(&corners, Vec3::NEG_Z, 0.1 * unit);
            let circle = beam.footprint(&UVS, Vec2::splat(100.0));
            assert!((circle.length - 10.0).abs() < 1e-4, "{circle:?}");
        }
    }

    #[test]
    fn density_counts_texels_of_a_unit() {
        assert!((texel_density(&CORNERS, &UVS, Vec2::new(400.0, 100.0)) - 200.0).abs() < 1e-3);
        let larger = CORNERS.map(|corner| corner * 2.0);
        assert!((texel_density(&larger, &UVS, Vec2::splat(64.0)) - 32.0).abs() < 1e-4);
        for unit in [1e-15, 1e15] {
            let other = CORNERS.map(|corner| corner * unit);
            let density = texel_density(&other, &UVS, Vec2::splat(64.0)) * unit;
            assert!((density - 64.0).abs() < 1e-4, "{density} of {unit}");
        }
        assert_eq!(texel_density(&[Vec3::ZERO; 3], &UVS, Vec2::splat(64.0)), 0.0);
        assert_eq!(texel_density(&[Vec3::ZERO; 3], &[Vec2::ZERO; 3], Vec2::splat(64.0)), 0.0);
    }

    #[test]
    fn a_triangle_without_an_area_or_a_beam_in_its_plane_is_no_harm() {
        for corners in [[Vec3::ZERO; 3], [Vec3::ZERO, Vec3::X, Vec3::X * 2.0], CORNERS] {
            let footprint = Ellipse::new(&corners, Vec3::X, 0.1).footprint(&UVS, Vec2::splat(8.0));
            assert!(footprint.width <= footprint.length || footprint.length.is_nan(), "{footprint:?}");
        }
    }
}
