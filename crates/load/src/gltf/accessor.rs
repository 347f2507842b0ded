//! Typed elements from bytes: every component type, normalised or not, strided, sparse (glTF 2.0, 3.6.2).

use super::{
    document::Document,
    schema::{Accessor, Index},
};
use crate::LoadError;

/// The type of a component (glTF 2.0, 3.6.2.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    #[cfg(feature = "draco")]
    pub(super) fn from_draco(kind: draco_oxide_core::attribute::ComponentDataType) -> Option<Self> {
        use draco_oxide_core::attribute::ComponentDataType as Draco;
        Some(match kind {
            Draco::I8 => Self::I8,
            Draco::U8 => Self::U8,
            Draco::I16 => Self::I16,
            Draco::U16 => Self::U16,
            Draco::U32 => Self::U32,
            Draco::F32 => Self::F32,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// A component as a number; normalised integers by the equations of glTF 2.0, 3.11.
    pub(super) fn float(self, bytes: &[u8], normalised: bool) -> f32 {
        let scaled =
            |value: f32, greatest: f32| if normalised { (value / greatest).max(-1.0) } else { value };
        match self {
            Self::I8 => scaled(f32::from(bytes[0] as i8), 127.0),
            Self::U8 => scaled(f32::from(bytes[0]), 255.0),
            Self::I16 => scaled(f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
            Self::U16 => scaled(f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
            Self::U32 => {
                scaled(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32, u32::MAX as f32)
            }
            Self::F32 => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }

    /// An unsigned component; the caller has refused the other types.
    pub(super) fn unsigned(self, bytes: &[u8]) -> u32 {
        match self {
            Self::U16 | Self::I16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U32 | Self::F32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            Self::U8 | Self::I8 => u32::from(bytes[0]),
        }
    }

    pub(super) fn is_unsigned(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }
}

/// Where in an element its components lie: matrices of small components have columns padded to four bytes
/// (glTF 2.0, 3.6.2.4).
struct Shape {
    columns: usize,
    rows: usize,
}

impl Shape {
    fn from_name(name: &str) -> Option<Self> {
        let (columns, rows) = match name {
            "SCALAR" => (1, 1),
            "VEC2" => (1, 2),
            "VEC3" => (1, 3),
            "VEC4" => (1, 4),
            "MAT2" => (2, 2),
            "MAT3" => (3, 3),
            "MAT4" => (4, 4),
            _ => return None,
        };
        Some(Self { columns, rows })
    }

    fn column_bytes(&self, component: Component) -> usize {
        let bytes = self.rows * component.size();
        if self.columns > 1 { bytes.next_multiple_of(4) } else { bytes }
    }
}

impl Accessor {
    /// How many components an element has; 0 of an unknown type.
    pub(super) fn component_count(&self) -> usize {
        Shape::from_name(&self.kind).map_or(0, |shape| shape.columns * shape.rows)
    }
}

/// An accessor whose bytes have been found and measured.
struct Source<'d> {
    accessor: &'d Accessor,
    component: Component,
    shape: Shape,
    /// The bytes of all elements; without any, every component is zero.
    bytes: Option<&'d [u8]>,
    stride: usize,
    place: String,
}

impl Document<'_> {
    /// Elements of `N` components as numbers, row by column for matrices as stored. `place` says whose they
    /// are.
    pub(super) fn floats<const N: usize>(
        &self,
        index: Index,
        place: &str,
    ) -> Result<Vec<[f32; N]>, LoadError> {
        let source = self.source(index, N, place)?;
        let (component, normalised) = (source.component, source.accessor.normalized);
        self.elements(&source, [0.0; N], |bytes| component.float(bytes, normalised))
    }

    /// Elements of `N` unsigned integers.
    pub(super) fn integers<const N: usize>(
        &self,
        index: Index,
        place: &str,
    ) -> Result<Vec<[u32; N]>, LoadError> {
        let source = self.source(index, N, place)?;
        if !source.component.is_unsigned() {
            let problem = format!(
                "{} must hold unsigned integers, but its component type is {}; export the file again",
                source.place, source.accessor.component_type
            );
            return Err(self.fault(place, problem));
        }
        self.elements(&source, [0; N], |bytes| source.component.unsigned(bytes))
    }

    /// Numbers of any shape in one row.
    pub(super) fn scalars(&self, index: Index, place: &str) -> Result<Vec<f32>, LoadError> {
        Ok(self.floats::<1>(index, place)?.into_iter().map(|[value]| value).collect())
    }

    /// Finds the bytes of an accessor and checks that all elements lie in them.
    fn source(&self, index: Index, wanted: usize, place: &str) -> Result<Source<'_>, LoadError> {
        let accessor = self.get(&self.root.accessors, index, "accessor", place)?;
        let source_place = format!("accessors[{index}]");
        let fault = |problem: String| self.fault(place, format!("{source_place} {problem}"));
        let component = Component::from_code(accessor.component_type).ok_or_else(|| {
            fault(format!(
                "has the unknown component type {}; export the file again",
                accessor.component_type
            ))
        })?;
        let shape = Shape::from_name(&accessor.kind).filter(|shape| shape.columns * shape.rows == wanted);
        let shape = shape.ok_or_else(|| {
            fault(format!(
                "has elements of type '{}', but {wanted} components are needed; export the file again",
                accessor.kind
            ))
        })?;
        let element_bytes = shape.columns * shape.column_bytes(component);
        let mut stride = element_bytes;
        let mut bytes = None;
        if let Some(view) = accessor.buffer_view {
            let (view_bytes, view_stride) = self.view(view, place)?;
            stride = view_stride.unwrap_or(element_bytes);
            if stride < element_bytes {
                return Err(fault(format!(
                    "has a stride of {stride} bytes for elements of {element_bytes}; export the file again"
                )));
            }
            let found = strided(view_bytes, accessor.byte_offset, stride, element_bytes, accessor.count);
            bytes = Some(found.ok_or_else(|| {
                fault(format!(
                    "asks for {} elements from byte {} on, but bufferViews[{view}] has only {} bytes; the data is cut short, export the file again",
                    accessor.count,
                    accessor.byte_offset,
                    view_bytes.len()
                ))
            })?);
        }
        Ok(Source { accessor, component, shape, bytes, stride, place: source_place })
    }

    fn elements<T: Copy, const N: usize>(
        &self,
        source: &Source<'_>,
        zero: [T; N],
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>, LoadError> {
        let count = source.accessor.count;
        self.charge(count, size_of::<[T; N]>(), &source.place)?;
        let size = source.component.size();
        let column_bytes = source.shape.column_bytes(source.component);
        let element = |bytes: &[u8]| {
            std::array::from_fn(|at| {
                convert(&bytes[at / source.shape.rows * column_bytes + at % source.shape.rows * size..])
            })
        };
        let mut elements: Vec<[T; N]> = match source.bytes {
            Some(bytes) => (0..count).map(|index| element(&bytes[index * source.stride..])).collect(),
            None => vec![zero; count],
        };

        // Sparse elements replace some of them.
        if let Some(sparse) = &source.accessor.sparse {
            let fault = |problem: String| {
                self.fault(&source.place, format!("sparse: {problem}; export the file again"))
            };
            let indices = &sparse.indices;
            let index_component =
                Component::from_code(indices.component_type).filter(|component| component.is_unsigned());
            let index_component =
                index_component.ok_or_else(|| fault("its indices are not unsigned integers".to_owned()))?;
            let index_size = index_component.size();
            let (index_bytes, _) = self.view(indices.buffer_view, &source.place)?;
            let index_bytes = strided(index_bytes, indices.byte_offset, index_size, index_size, sparse.count)
                .ok_or_else(|| {
                    fault(format!("{} indices do not fit into their buffer view", sparse.count))
                })?;
            let (value_bytes, _) = self.view(sparse.values.buffer_view, &source.place)?;
            let value_size = source.shape.columns * column_bytes;
            let value_bytes =
                strided(value_bytes, sparse.values.byte_offset, value_size, value_size, sparse.count)
                    .ok_or_else(|| {
                        fault(format!("{} values do not fit into their buffer view", sparse.count))
                    })?;
            for number in 0..sparse.count {
                let index = index_component.unsigned(&index_bytes[number * index_size..]);
                let target = elements.get_mut(index as usize);
                *target.ok_or_else(|| fault(format!("index {index} is not below the count, {count}")))? =
                    element(&value_bytes[number * value_size..]);
            }
        }
        Ok(elements)
    }
}

/// The bytes from `offset` on, if `count` elements lie in them.
fn strided(bytes: &[u8], offset: usize, stride: usize, element_bytes: usize, count: usize) -> Option<&[u8]> {
    let bytes = bytes.get(offset..)?;
    let Some(last) = count.checked_sub(1) else { return Some(bytes) };
    let end = last.checked_mul(stride)?.checked_add(element_bytes)?;
    (end <= bytes.len()).then_some(bytes)
}
