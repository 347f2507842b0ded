//! A method's row in lists, help and docs, and what a GPU needs to run it.

use sheer_core::{bibliography::Work, parameter::ParameterInfo};

/// What is known of a method without its parameters.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// The word on the command line; the module and the shader are called the same, with `_` for `-`.
    pub id: &'static str,
    /// A line on what it does.
    pub title: &'static str,
    /// Paper and section that describe it.
    pub paper: &'static str,
    /// The bibliography's entries for [`Self::paper`]; none for what has no publication.
    pub works: &'static [&'static Work],
    /// What its result is biased in, in words.
    pub bias: &'static str,
    /// Keys it takes, those of its family left out.
    pub parameters: &'static [ParameterInfo],
    /// Motion vectors are aligned to multiples of this many pixels (STD section 3.3.1); 1: not at all.
    pub alignment_px: u32,
    /// Constants of its shader, beside its parameters and what all shaders have.
    pub constants: &'static [ShaderConstant],
    /// Tables that its shader reads, beside the threshold maps and the blue noise that all have.
    pub tables: &'static [ShaderTable],
}

/// A constant under the name that a shader knows it by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaderConstant {
    /// In capitals, as WGSL constants are written.
    pub name: &'static str,
    /// What it is to the bit, on every device.
    pub value: ShaderValue,
}

/// A value that WGSL has a literal for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShaderValue {
    /// An unsigned whole number, `u32`.
    U32(u32),
    /// A signed whole number, `i32`.
    I32(i32),
    /// A finite number, `f32`.
    F32(f32),
    /// Four finite numbers, `vec4f`.
    Vec4F([f32; 4]),
}

impl ShaderConstant {
    /// A constant of type `u32`.
    #[must_use]
    pub const fn count(name: &'static str, value: u32) -> Self {
        Self { name, value: ShaderValue::U32(value) }
    }

    /// A constant of type `f32`; it has to be finite.
    #[must_use]
    pub const fn real(name: &'static str, value: f32) -> Self {
        Self { name, value: ShaderValue::F32(value) }
    }
}

/// A table of 32-bit words, made once and read by a shader.
#[derive(Clone, Copy, Debug)]
pub struct ShaderTable {
    /// Name of the constant that holds the index of its first word among all tables.
    pub name: &'static str,
    /// Makes the words of the table, the same ones each time.
    pub words: fn() -> Vec<u32>,
}
