//! Numbers of bind groups and of what is bound there. Shaders know them by the same names.
//!
//! Every pass binds group 0, the scene and the frame, and group 1, the pixels that come of it; group 2 is its
//! own. What a method binds there beside has its name and number where the method says how it is drawn
//! ([`Binding`]). Passes that add frames up see pixels alone, and group 0 is theirs.

use sheer_render::contract::Binding;

/// Declares constants and lists them.
macro_rules! numbers {
    ($($(#[doc = $doc:literal])+ $name:ident = $value:expr;)+) => {
        $($(#[doc = $doc])+ pub(crate) const $name: u32 = $value;)+

        /// Every number by its name.
        pub(crate) const ALL: &[(&str, u32)] = &[$((stringify!($name), $name)),+];
    };
}

numbers! {
    /// The scene and the frame.
    GROUP_SCENE = 0;
    /// The pixels, what they cost, and the shadow maps.
    GROUP_PASS = 1;
    /// What one pass needs beside the others.
    GROUP_OWN = 2;
    /// All that passes see that add frames up.
    GROUP_TEMPORAL = 0;

    /// Group 0: the uniform of the frame.
    BIND_FRAME = 0;
    /// Group 0: nine floats a triangle, world.
    BIND_POSITIONS = 1;
    /// Group 0: the same of what moves, in the frame before.
    BIND_PREVIOUS_POSITIONS = 2;
    /// Group 0: object and opacity slot of each triangle.
    BIND_TRIANGLES = 3;
    /// Group 0: `Object`s.
    BIND_OBJECTS = 4;
    /// Group 0: `Opacity` of the triangles that have one.
    BIND_OPACITIES = 5;
    /// Group 0: vertex attributes of all meshes, floats.
    BIND_ATTRIBUTES = 6;
    /// Group 0: vertex indices of all meshes.
    BIND_INDICES = 7;
    /// Group 0: three floats a vertex that is skinned or morphed.
    BIND_DEFORMED_NORMALS = 8;
    /// Group 0: `Material`s.
    BIND_MATERIALS = 9;
    /// Group 0: `Texture`s.
    BIND_TEXTURES = 10;
    /// Group 0: the texels of all textures.
    BIND_ATLAS = 11;
    /// Group 0: `Light`s.
    BIND_LIGHTS = 12;
    /// Group 0: `Lobe`s of the environment.
    BIND_LOBES = 13;
    /// Group 0: threshold maps, masks and other tables, words.
    BIND_TABLES = 14;
    /// Group 0: the driver's acceleration structure, or the nodes of our tree.
    BIND_ACCEL = 15;
    /// Group 0: the triangles of the driver's structure, or the blocks of our tree.
    BIND_ACCEL_TRIANGLES = 16;
    /// Group 0: the panorama of the surroundings, levels below a table of them.
    BIND_ENVIRONMENT_MAP = 17;

    /// Group 1: `PixelRecord`s.
    BIND_PIXELS = 0;
    /// Group 1: the words of `Counts`.
    BIND_COUNTERS = 1;
    /// Group 1: `ShadowLight`s.
    BIND_SHADOW_LIGHTS = 2;
    /// Group 1: `ShadowFace`s.
    BIND_SHADOW_FACES = 3;
    /// Group 1: the texels of all shadow maps, floats.
    BIND_SHADOW_MAP = 4;
    /// Group 1: the one fragment of each pixel that is shaded, for methods that have one.
    BIND_SURFACES = 5;
    /// Group 1: `LayersRecord`s, where they are asked for.
    BIND_LAYERS = 6;

    /// Group 1, where the caller has drawn what is opaque: the `OpaqueUniform`.
    BIND_INPUT = 7;
    /// Group 1, where the caller has drawn what is opaque: its colours, linear and premultiplied.
    BIND_INPUT_COLOUR = 8;
    /// Group 1, where the caller has drawn what is opaque: its depths, as the caller's projection has them.
    BIND_INPUT_DEPTH = 9;
    /// Group 1, where the caller has drawn what is opaque: its motion.
    BIND_INPUT_MOTION = 10;

    /// Group 2 of all raster techniques but visibility: the nearest opaque surface of each pixel.
    BIND_OPAQUE_SURFACES = 0;

    /// Group 2 of visibility: the surface that the depth test has left.
    BIND_VISIBLE_SURFACES = 0;
    /// Group 2 of visibility: the words of `Tested`.
    BIND_TESTED = 1;

    /// Group 2 of lists: the first node of each pixel.
    BIND_LIST_HEADS = 1;
    /// Group 2 of lists: `ListNode`s.
    BIND_LIST_NODES = 2;
    /// Group 2 of lists and of the k-buffer: radiance times alpha, and alpha, of the fragments that no memory
    /// was left for.
    BIND_TAIL_SUMS = Binding::TAIL_SUMS.number;
    /// Group 2 of lists and of the k-buffer: the product of their transmittances.
    BIND_TAIL_TRANSMITTANCE = Binding::TAIL_TRANSMITTANCE.number;

    /// Group 2 of stochastic transparency: the `Round`.
    BIND_ROUND = 1;
    /// Group 2 of stochastic transparency: the words of `FragmentStats`.
    BIND_FRAGMENT_STATS = 2;
    /// Group 2 of stochastic transparency: depths that chance has left in each sample.
    BIND_DEPTH_MAP = 3;
    /// Group 2 of stochastic transparency: sums of light in each sample.
    BIND_ROUND_TARGETS = 4;
    /// Group 2 of stochastic transparency: what is seen through all fragments, in each sample.
    BIND_TOTAL_TRANSMITTANCE = 5;
    /// Group 2 of stochastic transparency: `RoundSums` of the rounds that have ended.
    BIND_ENDED_ROUNDS = 6;

    /// Group 0 of passes that add frames up: their uniform.
    BIND_TEMPORAL = 0;
    /// Group 0 of passes that add frames up: the `PixelRecord`s of the frame.
    BIND_NEW_PIXELS = 1;
    /// Group 0 of passes that add frames up: the history so far.
    BIND_HISTORY = 2;
    /// Group 0 of passes that add frames up: the history with the frame.
    BIND_NEXT_HISTORY = 3;
    /// Group 0 of passes that add layers up: the `LayersRecord`s of the frame.
    BIND_NEW_LAYERS = 4;
    /// Group 0 of passes that add layers up: the `KeptLayers` so far.
    BIND_KEPT = 5;
    /// Group 0 of passes that add layers up: the same, moved to where they are in the frame.
    BIND_MOVED = 6;
    /// Group 0 of passes that add layers up: the `KeptLayers` with the frame.
    BIND_NEXT_KEPT = 7;

    /// Group 1 of tests' shaders: what they are asked.
    BIND_PROBE_IN = 0;
    /// Group 1 of tests' shaders: what they answer.
    BIND_PROBE_OUT = 1;
}
