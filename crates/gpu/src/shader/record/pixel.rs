//! What passes leave in each pixel for one another and for the rest of the program. Pixels lie row by row.

use glam::{UVec2, Vec2, Vec3};

use crate::shader::declaration::shader_struct;

shader_struct! {
    /// What a frame knows of a pixel, as `sheer_image::Pixel`.
    struct PixelRecord {
        /// Linear RGBA, premultiplied.
        colour: [f32; 4] => "vec4f",
        /// Pixels, from this frame to the last: where the surface was, minus where it is.
        motion: Vec2,
        /// Along the view axis, scene units; without meaning where nothing is, since shaders have no word for
        /// infinity.
        depth: f32,
        /// 1 where a transparent fragment takes part.
        transparent: u32,
        /// Of the surface that stands for the pixel; NONE where nothing is.
        instance: u32,
        /// Of the surface that stands for the pixel; NONE where nothing is.
        primitive: u32,
        /// Fills the last row.
        padding: UVec2,
    }
}

shader_struct! {
    /// What a frame knows of the layers of a pixel, as `sheer_image::PixelLayers`.
    struct LayersRecord {
        /// Share of the front in what is seen, 0 to 1.
        coverage: f32,
        /// Probability with which the shaded fragment was to be one of the front.
        share: f32,
        /// Pixels, as `PixelRecord::motion`.
        front_motion: Vec2,
        /// Pixels, as `PixelRecord::motion`.
        back_motion: Vec2,
        /// Along the view axis, scene units; NO_DEPTH without a front.
        front_depth: f32,
        /// Along the view axis, scene units; NO_DEPTH where nothing is.
        back_depth: f32,
        /// 1 where the shaded fragment is one of the front.
        is_front: u32,
        /// Shares of the back's red, green and blue that coloured glass in the front absorbs.
        absorbed: [f32; 3],
    }
}

shader_struct! {
    /// What a frame costs, as `sheer_render::Counters`: shaders see an array of words and name them by
    /// COUNTER_… .
    struct Counts {
        /// Rays from the camera.
        camera_rays: u32,
        /// Rays towards lights, and from them where maps are made.
        shadow_rays: u32,
        /// Hits that a method was asked about.
        hits: u32,
        /// Fragments that were shaded.
        shaded: u32,
        /// Fragments that were merged with others or dropped.
        merged: u32,
    }
}

shader_struct! {
    /// What the fragments of a pixel leave for those that come after them: shaders see an array of words and
    /// name them by STATS_… . All are 0 at first.
    struct FragmentStats {
        /// Bits of the distance of the furthest fragment, which are ordered as positive numbers are.
        furthest: u32,
        /// The triangle at that distance with the largest number.
        triangle: u32,
        /// How many fragments there are.
        hits: u32,
        /// How many of them were shaded.
        shaded: u32,
        /// Rays of light that took.
        shadow_rays: u32,
    }
}

shader_struct! {
    /// What the fragments of a pixel that are tested leave for the pass that collects them: shaders see an
    /// array of words and name them by TESTED_… . Both are 0 at first.
    struct Tested {
        /// The complement of the bits of the distance of the nearest fragment that is neither opaque nor
        /// nothing; 0 for none.
        nearest: u32,
        /// How many fragments were tested.
        count: u32,
    }
}

shader_struct! {
    /// An element of the lists of fragments, one a pixel, in one pool for all (Yang et al. 2010, Real-Time
    /// Concurrent Linked List Construction on the GPU).
    struct ListNode {
        /// The fragment's triangle.
        triangle: u32,
        /// Index of the next node, counted from 1; LIST_END after the last.
        next: u32,
    }
}

shader_struct! {
    /// Which round of stochastic transparency is drawn.
    struct Round {
        /// Number of the round, from 0 on.
        index: u32,
    }
}

shader_struct! {
    /// Sums over the samples of a pixel (ST section 4): F(B) and F(B1), or F(U) and F(U1), times the number
    /// of samples.
    struct RoundSums {
        /// Sum of the colours, linear and premultiplied.
        rgb: Vec3,
        /// The same sum with all colours 1.
        ones: f32,
        /// Samples that nothing covered.
        empty: u32,
        /// Fills the last row.
        padding: [u32; 3],
    }
}
