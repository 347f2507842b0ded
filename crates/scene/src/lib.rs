//! Validated scenes: glTF files, built-in scenes, animation.
