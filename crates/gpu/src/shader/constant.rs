//! Constants as WGSL text.
//!
//! A float is written with as few decimal digits as read back the same bits.

use std::fmt;

/// A value that WGSL has a literal for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    /// `bool`.
    Bool(bool),
    /// `u32`.
    U32(u32),
    /// `i32`.
    I32(i32),
    /// `f32`; finite.
    F32(f32),
    /// `vec2f`; finite.
    Vec2F([f32; 2]),
    /// `vec4f`; finite.
    Vec4F([f32; 4]),
    /// `vec2u`, the low word first: shaders have no numbers of 64 bits.
    U64(u64),
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<u64> for Value {
    fn from(value: u64) -> Self {
        Self::U64(value)
    }
}

impl From<u32> for Value {
    fn from(value: u32) -> Self {
        Self::U32(value)
    }
}

impl From<[f32; 2]> for Value {
    fn from(values: [f32; 2]) -> Self {
        Self::Vec2F(values)
    }
}

impl From<[f32; 4]> for Value {
    fn from(values: [f32; 4]) -> Self {
        Self::Vec4F(values)
    }
}

impl From<f32> for Value {
    fn from(value: f32) -> Self {
        Self::F32(value)
    }
}

/// A constant of a shader.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Constant {
    pub(super) name: String,
    pub(super) value: Value,
}

impl Constant {
    /// A constant; a float has to be finite, WGSL has no other literals.
    pub(crate) fn new(name: impl Into<String>, value: impl Into<Value>) -> Self {
        Self { name: name.into(), value: value.into() }
    }
}

impl fmt::Display for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = &self.name;
        match self.value {
            Value::Bool(value) => writeln!(f, "const {name}: bool = {value};"),
            Value::U32(value) => writeln!(f, "const {name}: u32 = {value}u;"),
            Value::I32(value) => writeln!(f, "const {name}: i32 = {value}i;"),
            Value::F32(value) => writeln!(f, "const {name}: f32 = {value:?}f;"),
            Value::U64(value) => {
                writeln!(f, "const {name}: vec2u = vec2u({}u, {}u);", value as u32, value >> 32)
            }
            Value::Vec2F([x, y]) => writeln!(f, "const {name}: vec2f = vec2f({x:?}f, {y:?}f);"),
            Value::Vec4F([x, y, z, w]) => {
                writeln!(f, "const {name}: vec4f = vec4f({x:?}f, {y:?}f, {z:?}f, {w:?}f);")
            }
        }
    }
}

/// The constants as text, a line each.
pub(crate) fn text(constants: &[Constant]) -> String {
    constants.iter().map(Constant::to_string).collect()
}
