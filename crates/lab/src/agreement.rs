//! A frame of two renderers held against each other: the same fragments in the same pixels, in the same
//! colours, as far away and as fast.
//!
//! Renderers that decide by the same integers and the same arithmetic differ where they find other hits: at
//! the edges of triangles, which only who knows the geometry can tell. That is the CPU's [`Stage`]. Beyond
//! that, hardware adds in half floats, and its roots and powers round in their own way; what that may amount
//! to is a [`Tolerance`].

use std::fmt;

use sheer_image::Planes;
use sheer_metrics::FragmentDifference;
use sheer_render::{Method, Stage, method::Family};

use crate::Result;

/// Hardware rounds the corners of triangles to 1/256 of a pixel (Vulkan asks for 1/16 at least), and the
/// projection rounds before that.
const EDGE_PX: f32 = 1.0 / 64.0;
/// Depths of one surface differ by no more than this share: it is recomputed from a hit's weights, which have
/// 24 bits.
const DEPTH_SHARE: f32 = 1e-4;
/// Projected positions of large pictures have rounding errors of a thousandth of a pixel.
const MOTION_PX: f32 = 1e-2;
/// Methods that keep sums alone: where layers hide the background they do not know which fragment is the
/// furthest and stands for the pixel.
const WITHOUT_FRAGMENT: [&str; 3] = ["weighted", "moments", "stochastic"];

/// How far a rendering may be from the CPU's of the same frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Of a colour channel, as a share of the larger of both values or, below that, of a display's white.
    pub colour: f32,
    /// Share of pixels whose colour may differ by more: where rays of light pass the edge of what casts a
    /// shadow.
    pub colour_share: f64,
    /// Share of pixels that may show another fragment, at edges.
    pub other_share: f64,
    /// Share of pixels away from edges that may show another fragment; none where the method does not say
    /// which one it shows.
    pub inside_share: Option<f64>,
    /// Share of pixels of one fragment that may have another depth, motion or transparency: whether something
    /// transparent lies before a surface is a matter of edges, too.
    pub surface_share: f64,
}

impl Tolerance {
    /// What a frame of a method may differ by.
    #[must_use]
    pub fn of(method: &Method) -> Self {
        let id = method.info().id;
        // A logarithm of another last bit may draw another threshold.
        let inside_share = if id == "hashed" { 0.001 } else { 0.0 };
        let inside_share = (!WITHOUT_FRAGMENT.contains(&id)).then_some(inside_share);
        let (colour, colour_share) = match method.family() {
            // Accuracy of half floats, 2⁻¹¹, twice.
            Family::Threshold | Family::Selection => (1.0 / 1024.0, 0.002),
            // Half floats round sums, weights and products by 2⁻¹² a fragment; up to 32 of them, once each.
            // Each of a pixel's fragments may have its edge there, or that of its shadow.
            Family::Ordered | Family::Unordered => (1.0 / 128.0, 0.005),
        };
        // There are scenes with an edge in every pixel.
        Self { colour, colour_share, other_share: 1.0, inside_share, surface_share: 0.002 }
    }
}

/// How two renderings of one frame differ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disagreement {
    /// How many pixels a picture has.
    pub pixels: usize,
    /// Pixels that show another fragment, where the method says which.
    pub others: usize,
    /// Those among them that are away from the edges of triangles.
    pub inside: usize,
    /// Pixels of the same fragment whose colour differs by more than the tolerance.
    pub colours: usize,
    /// The largest difference of colours that does not.
    pub worst_colour: f32,
    /// Pixels of the same fragment with another depth.
    pub depths: usize,
    /// Pixels of the same fragment with other motion.
    pub motions: usize,
    /// Pixels of the same fragment that have something transparent before it on one side alone.
    pub transparencies: usize,
}

impl Disagreement {
    /// Compares a rendering with that of the CPU, made from `stage`.
    ///
    /// # Errors
    /// The pictures have different sizes.
    pub fn measure(stage: &Stage, expected: &Planes, found: &Planes, tolerance: Tolerance) -> Result<Self> {
        let (width, height) = expected.colour.size();
        let names_fragments = tolerance.inside_share.is_some();
        let fragments = if names_fragments {
            FragmentDifference::measure(expected, found, tolerance.colour)?
        } else {
            // Colours alone tell.
            let mut colours = found.clone();
            colours.instance.clone_from(&expected.instance);
            colours.primitive.clone_from(&expected.primitive);
            FragmentDifference::measure(expected, &colours, tolerance.colour)?
        };
        let is_inside = |&&other: &&(u32, u32)| !stage.is_near_edge(other, [width, height], EDGE_PX);
        let mut disagreement = Self {
            pixels: fragments.pixels,
            others: fragments.others.len(),
            inside: fragments.others.iter().filter(is_inside).count(),
            colours: fragments.colours,
            worst_colour: fragments.worst,
            ..Self::default()
        };
        for at in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let [a, b] = [expected, found].map(|planes| planes.pixel(at.0, at.1));
            // Another surface lies elsewhere and moves in another way.
            if [a.instance, a.primitive] != [b.instance, b.primitive] {
                continue;
            }
            // Not a number is near nothing; the background is infinitely far on both sides.
            let nearer = a.depth.abs().min(b.depth.abs());
            let is_as_far = a.depth == b.depth || (a.depth - b.depth).abs() <= DEPTH_SHARE * nearer;
            let moves_alike = a.motion.into_iter().zip(b.motion).all(|(a, b)| (a - b).abs() <= MOTION_PX);
            disagreement.depths += usize::from(!is_as_far);
            disagreement.motions += usize::from(!moves_alike);
            disagreement.transparencies += usize::from(a.transparent != b.transparent);
        }
        Ok(disagreement)
    }

    /// Share of pixels that show another fragment or another colour, 0 to 1.
    #[must_use]
    pub fn picture_share(&self) -> f64 {
        self.share(self.others + self.colours)
    }

    /// Share of pixels that show the same fragment with another depth, motion or transparency; each counts. 0
    /// where all agree.
    #[must_use]
    pub fn surface_share(&self) -> f64 {
        self.share(self.depths + self.motions + self.transparencies)
    }

    /// Whether few colours differ, and fragments only where the CPU meets other triangles right beside the
    /// pixel's centre.
    #[must_use]
    pub fn shows_same(&self, tolerance: Tolerance) -> bool {
        self.share(self.colours) <= tolerance.colour_share
            && self.share(self.others) <= tolerance.other_share
            && self.share(self.inside) <= tolerance.inside_share.unwrap_or(0.0)
    }

    /// Whether the same fragments are where they should be and move as they should.
    #[must_use]
    pub fn has_same_surfaces(&self, tolerance: Tolerance) -> bool {
        [self.depths, self.motions, self.transparencies]
            .into_iter()
            .all(|count| self.share(count) <= tolerance.surface_share)
    }

    fn share(&self, count: usize) -> f64 {
        count as f64 / self.pixels as f64
    }
}

impl fmt::Display for Disagreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pixels, others, inside, colours, worst_colour, depths, motions, transparencies } = self;
        write!(
            f,
            "of {pixels} pixels {others} show another fragment, {inside} of them away from edges, {colours} another colour (the others \
             differ by {worst_colour} at most), {depths} have another depth, {motions} other motion, {transparencies} other transparency"
        )
    }
}

#[cfg(test)]
mod tests {
    use sheer_render::{Antialiasing, Settings, backend::Cpu};
    use sheer_scene::CameraChoice;

    use super::*;
    use crate::picture;

    const SCENE: &str = "layers:count=3,alpha=0.3";

    fn rendered(stage: &mut Stage, method: &str) -> Planes {
        let settings = Settings { size: [128, 72], first_frame: 4, ..Settings::default() };
        picture(&Cpu, stage, &method.parse().unwrap(), Antialiasing::NONE, settings, 1).unwrap().0
    }

    /// What comes of a picture of a method of which something has been changed.
    fn changed(method: &str, change: impl Fn(&mut Planes, (u32, u32))) -> (Disagreement, Tolerance) {
        let scene = sheer_gallery::open(SCENE).unwrap().scene;
        let mut stage = Stage::new(scene, &CameraChoice::Default, None).unwrap();
        let expected = rendered(&mut stage, method);
        let mut found = expected.clone();
        for at in (0..72).step_by(4).flat_map(|y| (0..128).step_by(4).map(move |x| (x, y))) {
            change(&mut found, at);
        }
        let tolerance = Tolerance::of(&method.parse().unwrap());
        (Disagreement::measure(&stage, &expected, &found, tolerance).unwrap(), tolerance)
    }

    #[test]
    fn a_picture_agrees_with_itself() {
        let (disagreement, tolerance) = changed("std", |_, _| ());
        assert_eq!(disagreement, Disagreement { pixels: 128 * 72, ..Disagreement::default() });
        assert!(disagreement.shows_same(tolerance) && disagreement.has_same_surfaces(tolerance));
    }

    #[test]
    fn ids_of_methods_that_have_them_are_compared() {
        for method in ["std", "joint", "baseline", "list", "peel", "kbuffer", "mlab", "adaptive"] {
            let (disagreement, tolerance) = changed(method, |planes, at| planes.primitive[at] ^= 1);
            assert!(disagreement.others > 500 && !disagreement.shows_same(tolerance), "{method}");
        }
        for method in ["weighted", "moments", "stochastic"] {
            let (disagreement, tolerance) = changed(method, |planes, at| planes.primitive[at] ^= 1);
            assert!(disagreement.others == 0 && disagreement.shows_same(tolerance), "{method}");
            let (disagreement, tolerance) = changed(method, |planes, at| planes.colour[at][1] += 0.1);
            assert!(!disagreement.shows_same(tolerance), "{method}");
        }
    }

    #[test]
    fn depth_motion_and_transparency_are_compared() {
        /// Changes a pixel, given by column and row.
        type Change = fn(&mut Planes, (u32, u32));
        let changes: [Change; 4] = [
            |planes, at| planes.depth[at] = 1.001 * planes.depth[at].min(1e3),
            |planes, at| planes.motion[at][1] += 0.02,
            |planes, at| planes.motion[at][0] = f32::NAN,
            |planes, at| planes.transparent[at] ^= true,
        ];
        for (which, change) in changes.into_iter().enumerate() {
            let (disagreement, tolerance) = changed("std", change);
            assert!(disagreement.shows_same(tolerance), "{which}: {disagreement}");
            assert!(!disagreement.has_same_surfaces(tolerance), "{which}: {disagreement}");
        }
    }

    #[test]
    fn methods_are_told_apart() {
        let scene = sheer_gallery::open("smoke-square:particles=200").unwrap().scene;
        let mut stage = Stage::new(scene, &CameraChoice::Default, None).unwrap();
        for [method, other] in [
            ["std", "roulette"],
            ["joint", "std"],
            ["weighted", "moments"],
            ["mlab", "peel"],
            ["hashed", "std"],
        ] {
            let (expected, found) = (rendered(&mut stage, method), rendered(&mut stage, other));
            let tolerance = Tolerance::of(&method.parse().unwrap());
            let disagreement = Disagreement::measure(&stage, &expected, &found, tolerance).unwrap();
            assert!(!disagreement.shows_same(tolerance), "{other} passes for {method}: {disagreement}");
        }
    }
}
