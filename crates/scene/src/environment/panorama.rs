//! Surroundings from a picture: an equirectangular panorama, filtered once so that a look-up is a texel or
//! two.
//!
//! All that a look-up needs lies in one image, so that a GPU has it as one texture: the first row is a table
//! of the levels, and the levels lie below it, one under the other. They are
//!
//! * [`LEVEL_SHARP`], the panorama itself, which camera rays and mirrors see;
//! * after it [`ROUGHNESS_STEPS`] levels of rising roughness, which glossy surfaces see: means over the lobe
//!   of GGX that is seen from its normal (Karis 2013, *Real Shading in Unreal Engine 4*: the first of two
//!   sums), by samples of its distribution from smaller pictures (Křivánek, Colbert 2008, *Real-time Shading
//!   with Filtered Importance Sampling*);
//! * [`LEVEL_DIFFUSE`], the mean weighed by the cosine, which matt surfaces see.
//!
//! What is looked up casts no shadows. So the strongest light of a panorama is taken out of it where it is
//! compact, the sun above all, and becomes a directional light, which does ([`DistantLight`]). Importance
//! sampling of the whole panorama, with a ray for each sample, would shadow all of it, and be noise in
//! methods that are compared by their noise.
//!
//! The middle of a panorama is what lies towards +X, a quarter of its width further right is +Z, its top is
//! +Y: three.js and the viewers that are built on it turn them so.

use std::{
    f32::consts::{FRAC_PI_2, PI, TAU},
    fmt,
};

use glam::Vec3;
use sheer_core::hash::Fnv1a;
use sheer_image::{Image, ImageError};

/// What camera rays and mirrors see.
pub const LEVEL_SHARP: u32 = 0;
/// How many levels of greater roughness follow, evenly up to a perceptual roughness of 1.
pub const ROUGHNESS_STEPS: u32 = 8;
/// What a matt surface sees.
pub const LEVEL_DIFFUSE: u32 = LEVEL_SHARP + ROUGHNESS_STEPS + 1;
const LEVEL_COUNT: u32 = LEVEL_DIFFUSE + 1;

/// Columns of the rough levels: two or more to the width of their lobes.
const ROUGH_COLUMNS: [u32; ROUGHNESS_STEPS as usize] = [256, 256, 128, 128, 64, 64, 64, 64];
/// Columns of the level of matt surfaces, and of what it is summed from.
const DIFFUSE_COLUMNS: u32 = 64;
/// Wider panoramas are made smaller: at a field of view of 60 degrees a picture of 340 columns would still
/// see each texel.
const MOST_COLUMNS: u32 = 2048;
/// Samples of a lobe.
const SAMPLES: u32 = 128;

/// Columns of the picture in which the strongest light is looked for.
const SEARCH_COLUMNS: u32 = 512;
/// The strongest light is what is at least this share as bright as the brightest texel, around it.
const LEAST_BRIGHTNESS: f32 = 0.5;
/// A light is compact if it lies within this angle of its middle, 20 degrees: its shadow is that of a point.
const MOST_RADIUS_RAD: f32 = 0.35;
/// Lobes as wide as this share of a light's radius, or narrower, show its shape: it stays in what they see.
const NARROW_LOBE: f32 = 0.25;
/// A light below this share of all light stays in the panorama.
const LEAST_LIGHT: f32 = 1.0 / 16.0;

/// A light of a panorama that casts shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistantLight {
    /// Unit direction towards it.
    pub direction: Vec3,
    /// Irradiance on a surface that faces it, linear, in the unit of the panorama's radiance.
    pub irradiance: Vec3,
}

/// A panorama, filtered for look-ups.
#[derive(Clone, PartialEq)]
pub struct EnvironmentMap {
    texels: Image<[f32; 4]>,
}

/// By its size and a hash of its texels, of which there are millions.
impl fmt::Debug for EnvironmentMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut hash = Fnv1a::EMPTY;
        hash.add(self.texels.as_slice().iter().flatten().flat_map(|value| value.to_le_bytes()));
        let size = self.texels.size();
        f.debug_struct("EnvironmentMap").field("size", &size).field("hash", &hash.value()).finish()
    }
}

impl EnvironmentMap {
    /// Filters a panorama of linear radiance, finite and not negative, top row first; the light that has been
    /// taken out of it, if one is strong and compact.
    ///
    /// # Errors
    /// [`ImageError::Size`] if memory does not suffice.
    pub fn new(panorama: &Image<[f32; 3]>) -> Result<(Self, Option<DistantLight>), ImageError> {
        let is_small = panorama.width() <= MOST_COLUMNS;
        let mut seen = if is_small { panorama.clone() } else { halved(panorama)? };
        while seen.width() > MOST_COLUMNS {
            seen = halved(&seen)?;
        }
        let parted = strongest_light(&seen)?;
        let whole = chain(seen)?;
        let rest = parted.as_ref().map(|parted| chain(parted.rest.clone())).transpose()?;

        let mut levels = vec![whole[0].clone()];
        for (step, columns) in (1..).zip(ROUGH_COLUMNS) {
            let roughness = step as f32 / ROUGHNESS_STEPS as f32;
            let shows_shape = |parted: &Parted| roughness * roughness <= NARROW_LOBE * parted.radius_rad;
            let sources = rest.as_ref().filter(|_| !parted.as_ref().is_some_and(shows_shape));
            levels.push(glossy(sources.unwrap_or(&whole), roughness, columns)?);
        }
        levels.push(matt(rest.as_ref().unwrap_or(&whole))?);
        Ok((Self { texels: stacked(&levels)? }, parted.map(|parted| parted.light)))
    }

    /// All of it times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f32) -> Self {
        let columns = self.texels.width() as usize;
        for texel in &mut self.texels.as_mut_slice()[columns..] {
            *texel = texel.map(|value| value * factor);
        }
        self
    }

    /// The table of levels (first row, columns and rows of each as numbers), and below it their texels.
    #[must_use]
    pub fn texels(&self) -> &Image<[f32; 4]> {
        &self.texels
    }

    /// Radiance from a unit direction at a level, or between it and the next.
    #[must_use]
    pub fn at(&self, direction: Vec3, level: f32) -> Vec3 {
        let first = level as u32;
        let share = level - first as f32;
        let radiance = self.at_level(direction, first);
        if share > 0.0 { radiance.lerp(self.at_level(direction, first + 1), share) } else { radiance }
    }

    fn at_level(&self, direction: Vec3, level: u32) -> Vec3 {
        let [first_row, columns, rows, _] = self.texels[(level, 0)].map(|number| number as i32);
        let place = place_of(direction);
        let (x, y) = (place[0] * columns as f32 - 0.5, place[1] * rows as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (right_share, low_share) = (x - left, y - top);
        let texel = |dx: i32, dy: i32| {
            let column = (left as i32 + dx).rem_euclid(columns);
            let row = first_row + (top as i32 + dy).clamp(0, rows - 1);
            let [r, g, b, _] = self.texels[(column as u32, row as u32)];
            Vec3::new(r, g, b)
        };
        let upper = texel(0, 0).lerp(texel(1, 0), right_share);
        let lower = texel(0, 1).lerp(texel(1, 1), right_share);
        upper.lerp(lower, low_share)
    }
}

/// Coefficients of the odd powers, from the first, of a fit of the arcus tangent on [-1, 1] (Mazzo 2021,
/// *Efficient Approximate Arctan2*): to 2e-6, which is a thousandth of a texel.
pub const ANGLE_FIT: [f32; 4] = [0.999_977_26, -0.332_623_47, 0.193_543_46, -0.116_432_87];
/// The two that follow.
pub const ANGLE_FIT_END: [f32; 2] = [0.052_653_32, -0.011_721_2];

/// The angle from the axis of `x` to a point, radians; 0 for none. GPUs have an arcus tangent each of its
/// own.
fn angle(y: f32, x: f32) -> f32 {
    let (less, more) = (y.abs().min(x.abs()), y.abs().max(x.abs()));
    let ratio = if more > 0.0 { less / more } else { 0.0 };
    let square = ratio * ratio;
    let [first, third, fifth, seventh] = ANGLE_FIT;
    let [ninth, eleventh] = ANGLE_FIT_END;
    let end = seventh + square * (ninth + square * eleventh);
    let octant = ratio * (first + square * (third + square * (fifth + square * end)));
    let quadrant = if y.abs() > x.abs() { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    if y < 0.0 { -half } else { half }
}

/// Where a unit direction lies in a panorama: shares of its width and height.
fn place_of(direction: Vec3) -> [f32; 2] {
    let azimuth = angle(direction.z, direction.x);
    let polar = angle((direction.x * direction.x + direction.z * direction.z).sqrt(), direction.y);
    [azimuth / TAU + 0.5, polar / PI]
}

/// The unit direction of the middle of a texel.
fn direction_of<T>(image: &Image<T>, x: u32, y: u32) -> Vec3 {
    let azimuth = ((x as f32 + 0.5) / image.width() as f32 - 0.5) * TAU;
    let polar = (y as f32 + 0.5) / image.height() as f32 * PI;
    Vec3::new(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin())
}

/// The solid angle of a texel of a row, steradians.
fn solid_angle<T>(image: &Image<T>, y: u32) -> f32 {
    let [top, bottom] = [y, y + 1].map(|edge| (edge as f32 / image.height() as f32 * PI).cos());
    TAU / image.width() as f32 * (top - bottom)
}

/// Half as wide and high: means of four texels, weighed by their solid angles.
fn halved(image: &Image<[f32; 3]>) -> Result<Image<[f32; 3]>, ImageError> {
    let (columns, rows) = image.size();
    Image::par_from_fn((columns / 2).max(1), (rows / 2).max(1), |x, y| {
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for row in [2 * y, (2 * y + 1).min(rows - 1)] {
            for column in [2 * x, (2 * x + 1).min(columns - 1)] {
                let weight = solid_angle(image, row);
                sum += Vec3::from_array(image[(column, row)]) * weight;
                weights += weight;
            }
        }
        (sum / weights).to_array()
    })
}

/// A picture, then each half as wide, down to one column or row.
fn chain(image: Image<[f32; 3]>) -> Result<Vec<Image<[f32; 3]>>, ImageError> {
    let mut chain = vec![image];
    while let Some(last) = chain.last().filter(|last| last.width() > 1 && last.height() > 1) {
        chain.push(halved(last)?);
    }
    Ok(chain)
}

/// The texels around a direction, weighed by distance.
fn bilinear(image: &Image<[f32; 3]>, direction: Vec3) -> Vec3 {
    let (columns, rows) = (i64::from(image.width()), i64::from(image.height()));
    let place = place_of(direction);
    let (x, y) = (place[0] * columns as f32 - 0.5, place[1] * rows as f32 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let texel = |dx: i64, dy: i64| {
        Vec3::from_array(*image.get_clamped((left as i64 + dx).rem_euclid(columns), top as i64 + dy))
    };
    let upper = texel(0, 0).lerp(texel(1, 0), x - left);
    upper.lerp(texel(0, 1).lerp(texel(1, 1), x - left), y - top)
}

/// What a glossy surface sees, looked at along its normal. `sources`: the sharp picture, then each half as
/// wide.
fn glossy(sources: &[Image<[f32; 3]>], roughness: f32, columns: u32) -> Result<Image<[f32; 3]>, ImageError> {
    let alpha2 = roughness.powi(4);
    let (width, height) = sources[0].size();
    let texel = 4.0 * PI / (width as f32 * height as f32);

    // Directions about +Z with their weights, and the picture that each looks at.
    let samples: Vec<(Vec3, f32, usize)> = (0..SAMPLES)
        .map(|index| {
            let [along, around] =
                [(index as f32 + 0.5) / SAMPLES as f32, index.reverse_bits() as f32 / u32::MAX as f32 * TAU];
            let cosine2 = (1.0 - along) / (1.0 + (alpha2 - 1.0) * along);
            let (cosine, sine) = (cosine2.sqrt(), (1.0 - cosine2).max(0.0).sqrt());
            let half = Vec3::new(sine * around.cos(), sine * around.sin(), cosine);
            let direction = 2.0 * cosine * half - Vec3::Z;
            let lobe = cosine2 * (alpha2 - 1.0) + 1.0;
            let density = alpha2 / (PI * lobe * lobe) / 4.0;
            // The texels around a direction are as wide again, which hides that samples are few.
            let wanted = 0.5 * (1.0 / (SAMPLES as f32 * density) / texel).log2();
            let source = (wanted.max(0.0).round() as usize).min(sources.len() - 1);
            (direction, direction.z, source)
        })
        .filter(|&(_, weight, _)| weight > 0.0)
        .collect();
    let weights: f32 = samples.iter().map(|&(_, weight, _)| weight).sum();

    let target = Image::filled(columns, columns / 2, ())?;
    Image::par_from_fn(columns, columns / 2, |x, y| {
        let axis = direction_of(&target, x, y);
        let (side, up) = axis.any_orthonormal_pair();
        let sum = samples.iter().fold(Vec3::ZERO, |sum, &(direction, weight, source)| {
            let direction = side * direction.x + up * direction.y + axis * direction.z;
            sum + bilinear(&sources[source], direction) * weight
        });
        (sum / weights).to_array()
    })
}

/// What a matt surface sees: the mean over its hemisphere, weighed by the cosine.
fn matt(sources: &[Image<[f32; 3]>]) -> Result<Image<[f32; 3]>, ImageError> {
    let source = sources.iter().find(|source| source.width() <= DIFFUSE_COLUMNS);
    let source = source.expect("the last of the sources has one column or one row");
    let lights: Vec<(Vec3, Vec3, f32)> = (0..source.height())
        .flat_map(|y| (0..source.width()).map(move |x| (x, y)))
        .map(|(x, y)| {
            let radiance = Vec3::from_array(source[(x, y)]);
            (direction_of(source, x, y), radiance, solid_angle(source, y))
        })
        .collect();
    let target = Image::filled(DIFFUSE_COLUMNS, DIFFUSE_COLUMNS / 2, ())?;
    Image::par_from_fn(DIFFUSE_COLUMNS, DIFFUSE_COLUMNS / 2, |x, y| {
        let normal = direction_of(&target, x, y);
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for &(direction, radiance, solid_angle) in &lights {
            let weight = normal.dot(direction).max(0.0) * solid_angle;
            sum += radiance * weight;
            weights += weight;
        }
        (sum / weights).to_array()
    })
}

/// The table and the levels below each other.
fn stacked(levels: &[Image<[f32; 3]>]) -> Result<Image<[f32; 4]>, ImageError> {
    let columns = levels.iter().map(Image::width).max().unwrap_or(0).max(LEVEL_COUNT);
    let rows = 1 + levels.iter().map(Image::height).sum::<u32>();
    let mut texels = Image::filled(columns, rows, [0.0; 4])?;
    let mut first_row = 1;
    for (column, level) in (0..).zip(levels) {
        // Whole numbers of fewer than 24 bits.
        texels[(column, 0)] = [first_row as f32, level.width() as f32, level.height() as f32, 0.0];
        for (y, row) in (first_row..).zip(level.rows()) {
            for (x, &[r, g, b]) in (0..).zip(row) {
                texels[(x, y)] = [r, g, b, 1.0];
            }
        }
        first_row += level.height();
    }
    Ok(texels)
}

fn luminance(rgb: [f32; 3]) -> f32 {
    Vec3::from_array(rgb).dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// A panorama without its strongest light, and that.
struct Parted {
    light: DistantLight,
    /// Radius of the cone that it lies in.
    radius_rad: f32,
    rest: Image<[f32; 3]>,
}

/// Takes the brightest light out, if it is compact and a good part of all light.
fn strongest_light(panorama: &Image<[f32; 3]>) -> Result<Option<Parted>, ImageError> {
    let mut coarse = panorama.clone();
    while coarse.width() > SEARCH_COLUMNS {
        coarse = halved(&coarse)?;
    }
    let Some((middle, radius_rad)) = brightest_spot(&coarse)? else { return Ok(None) };

    // What is around it would be seen in its place; it is what is brighter.
    let ring_rad = 1.5 * radius_rad;
    let (mut around, mut around_weights) = (Vec3::ZERO, 0.0);
    let mut all = 0.0;
    let texels = || (0..panorama.height()).flat_map(|y| (0..panorama.width()).map(move |x| (x, y)));
    let angle_to = |x: u32, y: u32| direction_of(panorama, x, y).dot(middle).clamp(-1.0, 1.0).acos();
    for (x, y) in texels() {
        let weight = solid_angle(panorama, y);
        all += luminance(panorama[(x, y)]) * weight;
        if (radius_rad..=ring_rad).contains(&angle_to(x, y)) {
            around += Vec3::from_array(panorama[(x, y)]) * weight;
            around_weights += weight;
        }
    }
    if around_weights <= 0.0 {
        return Ok(None);
    }
    around /= around_weights;
    let mut rest = panorama.clone();
    let (mut irradiance, mut direction) = (Vec3::ZERO, Vec3::ZERO);
    for (x, y) in texels().filter(|&(x, y)| angle_to(x, y) < radius_rad) {
        let radiance = Vec3::from_array(panorama[(x, y)]);
        let left = radiance.min(around);
        let taken = (radiance - left) * solid_angle(panorama, y);
        irradiance += taken;
        direction += direction_of(panorama, x, y) * luminance(taken.to_array());
        rest[(x, y)] = left.to_array();
    }
    if luminance(irradiance.to_array()) < LEAST_LIGHT * all {
        return Ok(None);
    }
    let light = DistantLight { direction: direction.normalize_or(middle), irradiance };
    Ok(Some(Parted { light, radius_rad, rest }))
}

/// The middle of what is about as bright as the brightest texel and touches it, and the radius of a cone
/// around it, if that is compact.
fn brightest_spot(coarse: &Image<[f32; 3]>) -> Result<Option<(Vec3, f32)>, ImageError> {
    let (columns, rows) = coarse.size();
    let brightness = coarse.par_map(|&texel| luminance(texel));
    let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let Some(peak) = places.max_by(|&a, &b| brightness[a].total_cmp(&brightness[b])) else { return Ok(None) };
    let least = LEAST_BRIGHTNESS * brightness[peak];
    if least <= 0.0 {
        return Ok(None);
    }

    // All that touches it, around the back as well; what is too large is given up on the way.
    let peak_direction = direction_of(coarse, peak.0, peak.1);
    let texel_rad = PI / rows as f32;
    let mut is_found = Image::filled(columns, rows, false)?;
    let mut found = vec![peak];
    is_found[peak] = true;
    let mut at = 0;
    while let Some(&(x, y)) = found.get(at) {
        at += 1;
        if direction_of(coarse, x, y).dot(peak_direction) < (2.0 * MOST_RADIUS_RAD).cos() && at > 1 {
            return Ok(None);
        }
        for (dx, dy) in [(columns - 1, 1), (0, 0), (0, 2), (1, 1)] {
            let next = ((x + dx) % columns, (y + dy).saturating_sub(1).min(rows - 1));
            if !is_found[next] && brightness[next] >= least {
                is_found[next] = true;
                found.push(next);
            }
        }
    }
    let middle = found.iter().fold(Vec3::ZERO, |sum, &(x, y)| {
        sum + direction_of(coarse, x, y) * (brightness[(x, y)] * solid_angle(coarse, y))
    });
    let middle = middle.normalize_or(peak_direction);
    let furthest = found
        .iter()
        .map(|&(x, y)| direction_of(coarse, x, y).dot(middle).clamp(-1.0, 1.0).acos())
        .fold(0.0_f32, f32::max);
    let is_compact = furthest <= MOST_RADIUS_RAD || found.len() == 1;
    // Up to the far corners of its texels.
    Ok(is_compact.then_some((middle, furthest + texel_rad)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

    fn map(panorama: &Image<[f32; 3]>) -> EnvironmentMap {
        EnvironmentMap::new(panorama).unwrap().0
    }

    /// A panorama whose radiance is a function of direction.
    fn panorama(columns: u32, radiance: impl Fn(Vec3) -> f32) -> Image<[f32; 3]> {
        let place = Image::filled(columns, columns / 2, ()).unwrap();
        Image::from_fn(columns, columns / 2, |x, y| {
            let radiance = radiance(direction_of(&place, x, y));
            [radiance, 0.5 * radiance, 0.0]
        })
        .unwrap()
    }

    #[test]
    fn even_light_is_the_same_at_every_level() {
        let map = map(&Image::filled(64, 32, [0.75, 0.5, 0.25]).unwrap());
        for level in 0..LEVEL_COUNT {
            for axis in AXES {
                let seen = map.at(axis, level as f32);
                assert!(
                    (seen - Vec3::new(0.75, 0.5, 0.25)).abs().max_element() < 1e-5,
                    "{level} {axis}: {seen}"
                );
            }
        }
    }

    #[test]
    fn angles_are_those_of_the_arcus_tangent() {
        for step in -1000..=1000 {
            let wanted = step as f32 / 1000.0 * PI;
            let (y, x) = wanted.sin_cos();
            let error = (angle(3.0 * y, 3.0 * x) - y.atan2(x)).abs();
            assert!(error < 3e-6, "{wanted}: {error}");
        }
        assert_eq!(angle(0.0, 0.0), 0.0);
    }

    #[test]
    fn the_middle_is_x_and_a_quarter_to_the_right_is_z() {
        // Four stripes of columns and a bright top.
        let stripes = Image::from_fn(256, 128, |x, y| {
            if y < 16 { [9.0; 3] } else { [(x + 32) / 64 % 4 + 1, 0, 0].map(|value| value as f32) }
        });
        let map = map(&stripes.unwrap());
        let seen = [Vec3::NEG_X, Vec3::NEG_Z, Vec3::X, Vec3::Z].map(|axis| map.at(axis, 0.0).x);
        assert_eq!(seen, [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(map.at(Vec3::Y, 0.0).x, 9.0);
    }

    #[test]
    fn a_matt_surface_sees_the_mean_weighed_by_the_cosine() {
        // Radiance (1 + y) / 2: the mean over a hemisphere around n is 1/2 + n.y / 3.
        let map = map(&panorama(256, |direction| 0.5 * (1.0 + direction.y)));
        for normal in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(0.6, 0.8, 0.0)] {
            let seen = map.at(normal, LEVEL_DIFFUSE as f32).x;
            // The texels around a direction are as wide again, which hides that samples are few.
            let wanted = 0.5 + normal.y / 3.0;
            assert!((seen - wanted).abs() < 4e-3, "{normal}: {seen} in place of {wanted}");
        }
    }

    #[test]
    fn a_glossy_surface_sees_the_mean_over_its_lobe() {
        // A bright cap of 20 degrees, not bright enough to be taken out, against sums over the lobe of GGX.
        let cap = (20.0_f32).to_radians().cos();
        let map = map(&panorama(512, |direction| if direction.z > cap { 1.0 } else { 0.5 }));
        for step in [2, 4, 6, 8] {
            let roughness = step as f32 / ROUGHNESS_STEPS as f32;
            let alpha2 = roughness.powi(4);
            let (mut sum, mut weights) = (0.0, 0.0);
            for index in 0..20_000 {
                let polar = (index as f32 + 0.5) / 20_000.0 * 0.5 * PI;
                let cosine = (0.5 * polar).cos();
                let lobe = cosine * cosine * (alpha2 - 1.0) + 1.0;
                let weight = alpha2 / (lobe * lobe) * polar.cos() * polar.sin();
                sum += weight * if polar.cos() > cap { 1.0 } else { 0.5 };
                weights += weight;
            }
            let seen = map.at(Vec3::Z, (LEVEL_SHARP + step) as f32).x;
            assert!((seen - sum / weights).abs() < 0.03, "{roughness}: {seen} in place of {}", sum / weights);
        }
        // Between two levels their mean is seen.
        let between = map.at(Vec3::X, 3.5);
        assert!((between - 0.5 * (map.at(Vec3::X, 3.0) + map.at(Vec3::X, 4.0))).abs().max_element() < 1e-6);
    }

    #[test]
    fn a_sun_becomes_a_light_of_its_own_and_nothing_is_lost() {
        let towards = Vec3::new(0.3, 0.7, -0.6).normalize();
        let disc = (1.5_f32).to_radians();
        let sky = panorama(1024, |direction| if direction.dot(towards) > disc.cos() { 2000.0 } else { 0.5 });
        let (map, light) = EnvironmentMap::new(&sky).unwrap();
        let light = light.expect("the sun is strong and small");
        assert!(light.direction.dot(towards) > (0.3_f32).to_radians().cos(), "{light:?}");
        let disc_sr = TAU * (1.0 - disc.cos());
        let wanted = 1999.5 * disc_sr;
        assert!((light.irradiance.x / wanted - 1.0).abs() < 0.05, "{light:?}, {wanted} wanted");
        assert!((light.irradiance.y / light.irradiance.x - 0.5).abs() < 1e-3);
        // It is still there to be seen, but in no blurred reflection.
        assert!(map.at(towards, LEVEL_SHARP as f32).x > 1900.0);
        for level in LEVEL_SHARP + 1..=LEVEL_DIFFUSE {
            let seen = map.at(towards, level as f32).x;
            assert!((seen - 0.5).abs() < 0.02, "{level}: {seen}");
        }
    }

    #[test]
    fn a_soft_box_keeps_its_shape_where_reflections_show_it() {
        let towards = Vec3::new(0.0, 0.6, 0.8);
        let radius = (15.0_f32).to_radians();
        let room = panorama(512, |direction| if direction.dot(towards) > radius.cos() { 40.0 } else { 1.0 });
        let (map, light) = EnvironmentMap::new(&room).unwrap();
        assert!(light.is_some());
        let seen = [0, 1, 2, 4, ROUGHNESS_STEPS, LEVEL_DIFFUSE].map(|level| map.at(towards, level as f32).x);
        assert!(seen[..3].iter().all(|&seen| seen > 30.0), "{seen:?}");
        assert!(seen[3..].iter().all(|&seen| (seen - 1.0).abs() < 0.05), "{seen:?}");
    }

    #[test]
    fn lights_that_are_large_or_weak_stay_where_they_are() {
        let towards = Vec3::new(0.0, 0.6, 0.8);
        let of = |radius: f32, radiance: f32| {
            let sky = panorama(512, |direction| {
                if direction.dot(towards) > radius.to_radians().cos() { radiance } else { 1.0 }
            });
            EnvironmentMap::new(&sky).unwrap().1
        };
        // A bright wall of 25 degrees around, and a star.
        assert_eq!(of(25.0, 50.0), None);
        assert_eq!(of(1.0, 20.0), None);
        assert!(of(5.0, 400.0).is_some());
        let (map, light) = EnvironmentMap::new(&Image::filled(4, 2, [0.0; 3]).unwrap()).unwrap();
        assert_eq!((map.at(Vec3::X, 0.0), light), (Vec3::ZERO, None));
    }

    #[test]
    fn the_smallest_panorama_is_one() {
        let map = map(&Image::from_vec(2, 1, vec![[1.0; 3], [3.0; 3]]).unwrap());
        for level in 0..LEVEL_COUNT {
            assert!(AXES.iter().all(|&axis| map.at(axis, level as f32).is_finite()));
        }
    }

    #[test]
    fn strength_scales_all_levels_and_other_light_is_another_map() {
        let sky = panorama(64, |direction| 1.0 + direction.y);
        let [one, two] = [1.0, 2.0].map(|factor| map(&sky).scaled(factor));
        for level in 0..LEVEL_COUNT {
            assert_eq!(two.at(Vec3::Z, level as f32), 2.0 * one.at(Vec3::Z, level as f32));
        }
        assert_ne!(format!("{one:?}"), format!("{two:?}"));
        assert_eq!(format!("{one:?}"), format!("{:?}", map(&sky)));
    }
}
