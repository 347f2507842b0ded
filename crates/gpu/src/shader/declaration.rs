//! Structs that Rust writes and shaders read: declared in Rust once, written out as WGSL.
//!
//! [`shader_struct`] declares a `#[repr(C)]` struct whose members are of types that WGSL knows by another
//! name ([`ShaderType`]), and keeps what it takes to write the same struct in WGSL, comments included. A
//! piece imports it as `struct/<Name>`. Paddings are members on both sides, since Rust hides no bytes of a
//! struct that is sent to a device; that WGSL lays all members out alike is not promised by this but checked,
//! struct by struct, by a test through naga.
//!
//! The alternative, a crate such as `encase`, writes each struct member by member into a buffer of its own
//! and declares nothing in WGSL; here what lies in memory is sent as it is.

use std::fmt::Write as _;

use glam::{UVec2, UVec4, Vec2, Vec3, Vec4};

/// A type that lies in a shader's buffer as it lies in memory, but for its alignment.
pub(crate) trait ShaderType {
    /// What WGSL calls it.
    fn name() -> String;

    /// The declaration of the struct that it is or consists of.
    fn declaration() -> Option<Declaration> {
        None
    }
}

macro_rules! shader_types {
    ($($rust:ty => $wgsl:literal),+ $(,)?) => {
        $(impl ShaderType for $rust {
            fn name() -> String {
                $wgsl.to_owned()
            }
        })+
    };
}

shader_types! {
    f32 => "f32",
    u32 => "u32",
    Vec2 => "vec2f",
    Vec3 => "vec3f",
    Vec4 => "vec4f",
    UVec2 => "vec2u",
    UVec4 => "vec4u",
}

impl<T: ShaderType, const N: usize> ShaderType for [T; N] {
    fn name() -> String {
        format!("array<{}, {N}>", T::name())
    }

    fn declaration() -> Option<Declaration> {
        T::declaration()
    }
}

/// A member of a struct.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    pub(crate) name: &'static str,
    /// Lines of its documentation.
    pub(crate) docs: &'static [&'static str],
    /// What WGSL calls its type.
    pub(crate) type_name: String,
    /// Bytes from the beginning of the struct, in Rust.
    pub(crate) offset: usize,
    /// The struct that it is made of, if it is.
    pub(crate) inner: Option<Box<Declaration>>,
}

/// A struct as Rust has it.
#[derive(Clone, Debug)]
pub(crate) struct Declaration {
    pub(crate) name: &'static str,
    /// Lines of its documentation.
    pub(crate) docs: &'static [&'static str],
    /// Bytes, in Rust.
    pub(crate) size: usize,
    pub(crate) members: Vec<Member>,
}

impl Declaration {
    /// The struct as a piece of WGSL that imports the structs it is made of.
    pub(crate) fn wgsl(&self) -> String {
        let mut text = String::new();
        for inner in self.members.iter().filter_map(|member| member.inner.as_ref()) {
            writeln!(text, "#import struct/{}", inner.name).expect("a string takes any text");
        }
        let comment = |indent: &str, docs: &[&str]| {
            docs.iter().map(|line| format!("{indent}//{line}\n")).collect::<String>()
        };
        text += &comment("", self.docs);
        writeln!(text, "struct {} {{", self.name).expect("a string takes any text");
        for Member { name, docs, type_name, .. } in &self.members {
            text += &comment("    ", docs);
            writeln!(text, "    {name}: {type_name},").expect("a string takes any text");
        }
        text + "}\n"
    }

    /// Name and index of each member of a struct of words, as shaders name them that see an array of words:
    /// `PREFIX_MEMBER`.
    pub(crate) fn word_indices(&self, prefix: &str) -> Vec<(String, u32)> {
        let index = |member: &Member| {
            (format!("{prefix}_{}", member.name.to_ascii_uppercase()), member.offset as u32 / 4)
        };
        self.members.iter().map(index).collect()
    }
}

/// Declares a struct for Rust and for WGSL, or tells WGSL of a `#[repr(C)]` struct that another crate
/// declares. A member whose Rust type has another alignment than the one of WGSL says what it is there:
/// `colour: [f32; 4] => "vec4f"`.
macro_rules! shader_struct {
    (
        $(#[doc = $doc:literal])*
        struct $name:ident {
            $($(#[doc = $member_doc:literal])* $member:ident: $type:ty $(=> $wgsl:literal)?),+ $(,)?
        }
    ) => {
        $(#[doc = $doc])*
        #[allow(dead_code, reason = "some are written and read by shaders alone")]
        #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        #[repr(C)]
        pub(crate) struct $name {
            $($(#[doc = $member_doc])* pub(crate) $member: $type),+
        }

        $crate::shader::declaration::shader_struct! {
            $(#[doc = $doc])*
            struct $name = $name {
                $($(#[doc = $member_doc])* $member: $type $(=> $wgsl)?),+
            }
        }
    };
    (
        $(#[doc = $doc:literal])*
        struct $name:ident = $rust:ty {
            $($(#[doc = $member_doc:literal])* $member:ident: $type:ty $(=> $wgsl:literal)?),+ $(,)?
        }
    ) => {
        impl $crate::shader::declaration::ShaderType for $rust {
            fn name() -> String {
                stringify!($name).to_owned()
            }

            fn declaration() -> Option<$crate::shader::declaration::Declaration> {
                use $crate::shader::declaration::{Declaration, Member, ShaderType};
                // Never called: it holds the types that are written here against those of the struct.
                let _ = |value: &$rust| {
                    $(let _: &$type = &value.$member;)+
                };
                Some(Declaration {
                    name: stringify!($name),
                    docs: &[$($doc),*],
                    size: size_of::<$rust>(),
                    members: vec![$(Member {
                        name: stringify!($member),
                        docs: &[$($member_doc),*],
                        type_name: $crate::shader::declaration::shader_struct!(@name $type $(=> $wgsl)?),
                        offset: std::mem::offset_of!($rust, $member),
                        inner: <$type as ShaderType>::declaration().map(Box::new),
                    }),+],
                })
            }
        }
    };
    (@name $type:ty) => { <$type as $crate::shader::declaration::ShaderType>::name() };
    (@name $type:ty => $wgsl:literal) => { $wgsl.to_owned() };
}
pub(crate) use shader_struct;
