//! Walks over a Draco stream without decoding it, to find counts that its decoder would believe.
//!
//! The decoder allocates by three numbers before it has seen the data behind them: topology splits, sizes of
//! symbol alphabets, and orientations of texture coordinates. An allocation that fails ends the program, so
//! the numbers are held against what can be. Section numbers are those of the Draco bitstream specification.

use draco_oxide_core::bit_coder::Reader;
use draco_oxide_decoder::{
    connectivity::{Connectivity, decode_connectivity},
    entropy::rans::RansSymbolDecoder,
    header::decode_header,
};

/// No alphabet is larger: frequencies add up to 2²⁰ at most.
const MAX_SYMBOLS: usize = 1 << 20;
/// Attributes that one stream may hold: glTF needs a handful, and each costs memory for all vertices.
const MAX_ATTRIBUTES: usize = 32;
/// Contexts of valence traversal: valences 2 to 7.
const VALENCE_CONTEXTS: usize = 6;
/// Contexts of the constrained multi-parallelogram prediction.
const CREASE_CONTEXTS: usize = 4;
/// Precision of the alphabet of bit lengths.
const TAG_PRECISION: usize = 12;

/// A cursor in a stream. All methods give `None` where the stream is cut short or states the impossible.
pub(super) struct Walk<'a>(pub &'a [u8]);

/// An attribute as it is listed.
struct Listed {
    components: usize,
    component_bytes: usize,
    values: usize,
    encoding: u8,
}

/// Kinds of attribute encoding.
const RAW: u8 = 0;
const INTEGERS: u8 = 1;
const QUANTISED: u8 = 2;
const OCTAHEDRAL: u8 = 3;

/// Checks a whole stream.
pub(super) fn check(stream: &[u8]) -> Option<()> {
    let mut reader = Reader::new(stream);
    let header = decode_header(&mut reader).ok()?;
    let mut walk = Walk(&stream[stream.len() - reader.remaining()..]);
    let is_edgebreaker = stream.get(8) == Some(&1);
    let connected = if is_edgebreaker { walk.edgebreaker() } else { walk.sequential() };
    connected?;
    let connectivity = decode_connectivity(&mut reader, header.encoder_method).ok()?;
    Walk(&stream[stream.len() - reader.remaining()..]).attributes(&connectivity)
}

impl<'a> Walk<'a> {
    pub(super) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    pub(super) fn byte(&mut self) -> Option<u8> {
        Some(self.take(1)?[0])
    }

    /// Seven bits a byte, lowest first; 32 bits at most.
    pub(super) fn varint(&mut self) -> Option<usize> {
        let mut value = 0_u64;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return u32::try_from(value).ok().map(|value| value as usize);
            }
        }
        None
    }

    /// Bytes behind their number.
    fn block(&mut self) -> Option<()> {
        let length = self.varint()?;
        self.take(length).map(|_| ())
    }

    /// A stream of single bits: their probability, then a block.
    fn bits(&mut self) -> Option<()> {
        self.byte()?;
        self.block()
    }

    /// Section 5: sequential connectivity. Triangles stored one by one are counted by the decoder.
    fn sequential(&mut self) -> Option<()> {
        let (triangles, _points) = (self.varint()?, self.varint()?);
        if self.byte()? == 0 { self.symbols(3 * triangles, 1) } else { Some(()) }
    }

    /// Section 6: edgebreaker connectivity.
    fn edgebreaker(&mut self) -> Option<()> {
        let traversal = self.byte()?;
        let (_vertices, triangles) = (self.varint()?, self.varint()?);
        let attribute_data = self.byte()?;
        let (_symbols, _split_symbols) = (self.varint()?, self.varint()?);
        let splits = self.varint()?;
        if splits > triangles {
            return None;
        }
        for _ in 0..2 * splits {
            self.varint()?;
        }
        self.take(splits.div_ceil(8))?;
        // Only valence traversal has symbols in an alphabet.
        if traversal == 2 {
            for _ in 0..=attribute_data {
                self.bits()?;
            }
            for _ in 0..VALENCE_CONTEXTS {
                let count = self.varint()?;
                if count > triangles {
                    return None;
                }
                if count > 0 {
                    self.symbols(count, 1)?;
                }
            }
        }
        Some(())
    }

    /// Section 7: the attributes.
    fn attributes(&mut self, connectivity: &Connectivity) -> Option<()> {
        // The head of each decoder says to which corners or vertices its attributes belong.
        let decoders = usize::from(self.byte()?);
        let heads = match connectivity {
            Connectivity::Edgebreaker(_) => self.take(3 * decoders)?,
            Connectivity::Sequential(_) => &[],
        };
        let vertex_count = match connectivity {
            Connectivity::Edgebreaker(edgebreaker) => edgebreaker.position_faces().1,
            Connectivity::Sequential(sequential) => sequential.num_points,
        };
        // All descriptions of attributes come before all values: first the types of a decoder's attributes,
        // then how each is encoded.
        let mut lists = Vec::new();
        let mut attribute_count = 0;
        for decoder in 0..decoders {
            let values = value_count(connectivity, vertex_count, heads.get(3 * decoder..3 * decoder + 3))?;
            let count = self.varint()?;
            attribute_count += count;
            if attribute_count > MAX_ATTRIBUTES {
                return None;
            }
            let mut list = Vec::with_capacity(count);
            for _ in 0..count {
                let head = self.take(4)?;
                self.varint()?;
                let component_bytes = match head[1] {
                    1 | 2 => 1,
                    3 | 4 => 2,
                    5 | 6 | 9 => 4,
                    _ => return None,
                };
                list.push(Listed {
                    components: usize::from(head[2]),
                    component_bytes,
                    values,
                    encoding: RAW,
                });
            }
            for listed in &mut list {
                listed.encoding = self.byte()?;
                if listed.encoding == OCTAHEDRAL {
                    listed.components = 2;
                }
                if listed.encoding > OCTAHEDRAL || !(1..=4).contains(&listed.components) {
                    return None;
                }
            }
            lists.push(list);
        }
        // The values of a decoder's attributes, then what takes them back to floats.
        for list in &lists {
            for listed in list {
                self.values(listed)?;
            }
            for listed in list {
                let transform_bytes = match listed.encoding {
                    QUANTISED => 4 * listed.components + 5,
                    OCTAHEDRAL => 1,
                    _ => 0,
                };
                self.take(transform_bytes)?;
            }
        }
        Some(())
    }

    /// The values of one attribute, and what their prediction needs.
    fn values(&mut self, listed: &Listed) -> Option<()> {
        let count = listed.values.checked_mul(listed.components)?;
        if listed.encoding == RAW {
            return self.take(count.checked_mul(listed.component_bytes)?).map(|_| ());
        }
        debug_assert!(
            (INTEGERS..=OCTAHEDRAL).contains(&listed.encoding),
            "encodings are checked when listed"
        );
        let scheme = self.byte()?;
        // 0xFE is "no prediction", which has no transform.
        let transform = if scheme == 0xFE { None } else { Some(self.byte()?) };
        if self.byte()? != 0 {
            self.symbols(count, listed.components)?;
        } else {
            self.take(count.checked_mul(4)?)?;
        }
        let Some(transform) = transform else { return Some(()) };
        match scheme {
            4 => {
                for _ in 0..CREASE_CONTEXTS {
                    if self.varint()? > 0 {
                        self.bits()?;
                    }
                }
                self.transform(transform)
            }
            5 => {
                let orientations = u32::from_le_bytes(self.take(4)?.try_into().ok()?);
                if orientations as usize > listed.values {
                    return None;
                }
                self.bits()?;
                self.transform(transform)
            }
            6 => {
                self.transform(transform)?;
                self.bits()
            }
            _ => self.transform(transform),
        }
    }

    /// Parameters of a prediction transform.
    fn transform(&mut self, transform: u8) -> Option<()> {
        match transform {
            0 | 0xFF => Some(()),
            1 | 3 => self.take(8).map(|_| ()),
            _ => None,
        }
    }

    /// A stream of `count` symbols, `components` a value.
    fn symbols(&mut self, count: usize, components: usize) -> Option<()> {
        match self.byte()? {
            // Tagged: a bit length for each value, in an alphabet of its own, then the bits.
            0 => {
                let mut alphabet = Walk(self.0);
                alphabet.alphabet()?;
                let mut reader = Reader::new(self.0);
                let tags = count.div_ceil(components);
                let mut decoder = RansSymbolDecoder::new(&mut reader, tags, TAG_PRECISION).ok()?;
                self.0 = &self.0[self.0.len() - reader.remaining()..];
                let bits: usize = (0..tags).map(|_| decoder.decode().min(32) * components).sum();
                self.take(bits.div_ceil(8)).map(|_| ())
            }
            1 => {
                self.byte()?;
                self.alphabet()
            }
            _ => None,
        }
    }

    /// Frequencies of an alphabet, then the block coded with them.
    fn alphabet(&mut self) -> Option<()> {
        let symbols = self.varint()?;
        if symbols > MAX_SYMBOLS {
            return None;
        }
        let mut symbol = 0;
        while symbol < symbols {
            let first = self.byte()?;
            match first & 3 {
                // A run of symbols that do not occur.
                3 => symbol += usize::from(first >> 2),
                extra => {
                    self.take(usize::from(extra))?;
                }
            }
            symbol += 1;
        }
        self.block()
    }
}

/// How many values the attributes of a decoder have; `head` is its seam stream, domain and traversal.
fn value_count(connectivity: &Connectivity, vertex_count: usize, head: Option<&[u8]>) -> Option<usize> {
    let Connectivity::Edgebreaker(edgebreaker) = connectivity else { return Some(vertex_count) };
    let &[stream, domain, _traversal] = head? else { return None };
    // Domain 1 is corners; stream 255 follows the positions.
    if domain == 1 && stream != u8::MAX {
        let seams = edgebreaker.seam_stats.get(usize::from(stream))?;
        if seams.has_interior {
            return (seams.starts + vertex_count).checked_sub(seams.fans_with_starts);
        }
    }
    Some(vertex_count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_after_32_bits() {
        assert_eq!(Walk(&[0xFF, 0xFF, 0xFF, 0xFF, 0x0F]).varint(), Some(u32::MAX as usize));
        assert_eq!(Walk(&[0xFF, 0xFF, 0xFF, 0xFF, 0x1F]).varint(), None);
        assert_eq!(Walk(&[0x80; 6]).varint(), None);
    }

    #[test]
    fn alphabets_are_bounded() {
        // Two symbols, one with an extra byte; a block of one byte.
        let mut walk = Walk(&[2, 1 << 2, 1 << 2 | 1, 9, 1, 7, 42]);
        assert_eq!((walk.alphabet(), walk.0), (Some(()), &[42][..]));
        // A thousand million symbols.
        assert_eq!(Walk(&[0x80, 0x94, 0xEB, 0xDC, 0x03, 0xFF, 0xFF]).alphabet(), None);
    }
}
