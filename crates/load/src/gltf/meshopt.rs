//! Decoder for `EXT_meshopt_compression` and `KHR_meshopt_compression`, written from the latter's
//! specification (appendix A: bitstream, appendix B: filters; the former is its version 0).
//!
//! The caller has bounded `count · stride`, so nothing here allocates more than that.

use super::schema::Meshopt;

/// Elements of a delta group.
const GROUP: usize = 16;
/// Bytes that a block of attribute elements may take.
const BLOCK_BYTES: usize = 8192;
/// Elements that a block may hold.
const BLOCK_ELEMENTS: usize = 256;
/// Entries of the queues of recent edges and vertices.
const QUEUE: usize = 16;

/// Decodes one buffer view to `count · byteStride` bytes. The error says what is wrong with the stream.
pub(super) fn decode(view: &Meshopt, data: &[u8]) -> Result<Vec<u8>, &'static str> {
    let (count, stride) = (view.count, view.byte_stride);
    let mut out = match view.mode.as_str() {
        "ATTRIBUTES" => decode_attributes(data, count, stride)?,
        "TRIANGLES" => narrow(decode_triangles(data, count)?, stride)?,
        "INDICES" => narrow(decode_indices(data, count)?, stride)?,
        _ => return Err("its mode is not ATTRIBUTES, TRIANGLES or INDICES"),
    };
    match view.filter.as_str() {
        "" | "NONE" => {}
        "OCTAHEDRAL" => filter_components(&mut out, stride, octahedral_8, octahedral_16)?,
        "QUATERNION" if stride == 8 => each_element(&mut out, quaternion),
        "EXPONENTIAL" if stride.is_multiple_of(4) => each_element(&mut out, exponential),
        "COLOR" => filter_components(&mut out, stride, colour_8, colour_16)?,
        _ => return Err("its filter is unknown or does not go with its stride"),
    }
    Ok(out)
}

/// Bytes taken one after another.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], &'static str> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("the compressed data is cut short")?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, &'static str> {
        Ok(self.take(1)?[0])
    }

    /// Seven bits a byte, lowest first, the top bit set on all but the last.
    fn varint(&mut self) -> Result<u32, &'static str> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err("a number has more than five bytes")
    }
}

/// Undoes the folding of signs into the lowest bit.
macro_rules! unzigzag {
    ($value:expr) => {
        if $value & 1 != 0 { !($value >> 1) } else { $value >> 1 }
    };
}

/// Mode 0: attributes of vertices, byte by byte as differences.
fn decode_attributes(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, &'static str> {
    if stride == 0 || stride > BLOCK_ELEMENTS || !stride.is_multiple_of(4) {
        return Err("its stride is not a multiple of 4 from 4 to 256");
    }
    let channels = stride / 4;
    let (newer, tail_bytes) = match data.first() {
        Some(0xA0) => (false, stride.max(32)),
        Some(0xA1) => (true, (stride + channels).max(24)),
        _ => return Err("its first byte is not that of an attribute stream"),
    };
    let body = data
        .len()
        .checked_sub(tail_bytes)
        .filter(|&end| end >= 1)
        .ok_or("the compressed data is cut short")?;
    let mut cursor = Cursor(&data[1..body]);
    let tail = &data[data.len() - stride - if newer { channels } else { 0 }..];
    let (baseline, modes) = tail.split_at(stride);
    let mut last = baseline.to_vec();

    let mut out = Vec::with_capacity(count * stride);
    let block_elements = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(BLOCK_ELEMENTS);
    let mut deltas = vec![0_u8; stride * block_elements];
    let mut left = count;
    while left > 0 {
        let elements = left.min(block_elements);
        let groups = elements.div_ceil(GROUP);
        let controls = if newer { cursor.take(channels)? } else { &[] };
        for (position, lane) in deltas.chunks_exact_mut(block_elements).enumerate() {
            let control = controls.get(position / 4).map(|byte| byte >> (position % 4 * 2) & 3);
            decode_lane(&mut cursor, control, &mut lane[..groups * GROUP], elements)?;
        }
        for element in 0..elements {
            for channel in 0..channels {
                let at = channel * 4;
                let delta = std::array::from_fn(|byte| deltas[(at + byte) * block_elements + element]);
                let before = [last[at], last[at + 1], last[at + 2], last[at + 3]];
                let value = undo_delta(modes.get(channel).copied().unwrap_or(0), before, delta)?;
                last[at..at + 4].copy_from_slice(&value);
            }
            out.extend_from_slice(&last);
        }
        left -= elements;
    }
    if cursor.0.is_empty() { Ok(out) } else { Err("bytes are left over after the last element") }
}

/// The deltas of one byte position in a block.
fn decode_lane(
    cursor: &mut Cursor<'_>,
    control: Option<u8>,
    lane: &mut [u8],
    elements: usize,
) -> Result<(), &'static str> {
    // Bits a delta for each group mode; 8 stores whole bytes.
    let widths = match control {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => {
            lane.fill(0);
            return Ok(());
        }
        Some(_) => {
            lane[..elements].copy_from_slice(cursor.take(elements)?);
            return Ok(());
        }
    };
    let group_count = lane.len() / GROUP;
    let header = cursor.take(group_count.div_ceil(4))?;
    for (number, group) in lane.chunks_exact_mut(GROUP).enumerate() {
        let width = widths[usize::from(header[number / 4] >> (number % 4 * 2) & 3)];
        decode_group(cursor, width, group)?;
    }
    Ok(())
}

/// Sixteen deltas of `width` bits; one with all bits set is an escape to a whole byte further on.
fn decode_group(cursor: &mut Cursor<'_>, width: usize, group: &mut [u8]) -> Result<(), &'static str> {
    match width {
        0 => group.fill(0),
        8 => group.copy_from_slice(cursor.take(GROUP)?),
        _ => {
            let packed = cursor.take(GROUP * width / 8)?;
            let escape = (1_u8 << width) - 1;
            let per_byte = 8 / width;
            for (at, delta) in group.iter_mut().enumerate() {
                // Single bits stand lowest first, wider ones highest first.
                let slot = if width == 1 { at % per_byte } else { per_byte - 1 - at % per_byte };
                let bits = packed[at / per_byte] >> (slot * width) & escape;
                *delta = if bits == escape { cursor.byte()? } else { bits };
            }
        }
    }
    Ok(())
}

/// The four bytes of a channel from those of the element before.
fn undo_delta(mode: u8, before: [u8; 4], delta: [u8; 4]) -> Result<[u8; 4], &'static str> {
    match (mode & 15, mode >> 4) {
        (0, 0) => Ok(std::array::from_fn(|byte| before[byte].wrapping_add(unzigzag!(delta[byte])))),
        (1, 0) => {
            let half = |bytes: [u8; 4], at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
            let sum = |at: usize| half(before, at).wrapping_add(unzigzag!(half(delta, at))).to_le_bytes();
            let (low, high) = (sum(0), sum(2));
            Ok([low[0], low[1], high[0], high[1]])
        }
        (2, turn) => {
            let delta = u32::from_le_bytes(delta).rotate_left(u32::from(turn));
            Ok((u32::from_le_bytes(before) ^ delta).to_le_bytes())
        }
        _ => Err("a channel mode is unknown"),
    }
}

/// The most recent entries, newest first.
struct Queue<T> {
    entries: [Option<T>; QUEUE],
    newest: usize,
}

impl<T: Copy> Queue<T> {
    fn new() -> Self {
        Self { entries: [None; QUEUE], newest: 0 }
    }

    fn push(&mut self, entry: T) {
        self.newest = (self.newest + 1) % QUEUE;
        self.entries[self.newest] = Some(entry);
    }

    fn get(&self, age: u8) -> Result<T, &'static str> {
        self.entries[(self.newest + QUEUE - usize::from(age)) % QUEUE]
            .ok_or("it refers to a vertex or edge not yet seen")
    }
}

/// State of a triangle decoder.
struct Triangles<'a> {
    data: Cursor<'a>,
    next: u32,
    last: u32,
    edges: Queue<(u32, u32)>,
    vertices: Queue<u32>,
}

impl Triangles<'_> {
    /// The next vertex never seen before.
    fn fresh(&mut self) -> u32 {
        let vertex = self.next;
        self.next = self.next.wrapping_add(1);
        vertex
    }

    /// A vertex stored as the distance from the last one stored so.
    fn stored(&mut self) -> Result<u32, &'static str> {
        let delta = self.data.varint()?;
        self.last = self.last.wrapping_add(unzigzag!(delta));
        Ok(self.last)
    }

    /// A vertex by a four-bit code, and whether it goes into the queue.
    fn coded(&mut self, code: u8) -> Result<(u32, bool), &'static str> {
        match code {
            0 => Ok((self.fresh(), true)),
            15 => Ok((self.stored()?, true)),
            _ => Ok((self.vertices.get(code - 1)?, false)),
        }
    }

    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], &'static str> {
        let (high, low) = (code >> 4, code & 15);
        if high < 15 {
            // A recent edge and one more vertex.
            let (a, b) = self.edges.get(high)?;
            let (c, queued) = match low {
                0 => (self.fresh(), true),
                1..=12 => (self.vertices.get(low)?, false),
                13 | 14 => {
                    self.last = if low == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                    (self.last, true)
                }
                _ => (self.stored()?, true),
            };
            self.edges.push((c, b));
            self.edges.push((a, c));
            if queued {
                self.vertices.push(c);
            }
            return Ok([a, b, c]);
        }

        // None of the edges is known: three vertices are given.
        let (first, codes) = if low < 14 {
            (self.fresh(), table[usize::from(low)])
        } else {
            let codes = self.data.byte()?;
            if codes == 0 {
                self.next = 0;
            }
            (if low == 14 { self.fresh() } else { self.stored()? }, codes)
        };
        let (second, second_queued) = self.coded(codes >> 4)?;
        let (third, third_queued) = self.coded(codes & 15)?;
        self.edges.push((second, first));
        self.edges.push((third, second));
        self.edges.push((first, third));
        self.vertices.push(first);
        if second_queued {
            self.vertices.push(second);
        }
        if third_queued {
            self.vertices.push(third);
        }
        Ok([first, second, third])
    }
}

/// Mode 1: indices of triangles, which mostly share an edge with one before.
fn decode_triangles(data: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    if data.first() != Some(&0xE1) {
        return Err("its first byte is not that of a triangle stream");
    }
    if !count.is_multiple_of(3) {
        return Err("its count is not a multiple of three");
    }
    let mut rest = Cursor(&data[1..]);
    let codes = rest.take(count / 3)?;
    let (data, table) = rest.0.split_last_chunk::<16>().ok_or("the compressed data is cut short")?;
    if table.iter().any(|entry| entry >> 4 == 15 || entry & 15 == 15) {
        return Err("its table of codes is not valid");
    }
    let mut decoder =
        Triangles { data: Cursor(data), next: 0, last: 0, edges: Queue::new(), vertices: Queue::new() };
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        out.extend(decoder.triangle(code, table)?);
    }
    if decoder.data.0.is_empty() { Ok(out) } else { Err("bytes are left over after the last triangle") }
}

/// Mode 2: indices of any kind, as differences to the last or the one before.
fn decode_indices(data: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    if data.first() != Some(&0xD1) {
        return Err("its first byte is not that of an index stream");
    }
    let (body, _) = data[1..].split_last_chunk::<4>().ok_or("the compressed data is cut short")?;
    // Each index takes a byte at least.
    if count > body.len() {
        return Err("the compressed data is cut short");
    }
    let mut cursor = Cursor(body);
    let mut last = [0_u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let value = cursor.varint()?;
        let baseline = &mut last[(value & 1) as usize];
        *baseline = baseline.wrapping_add(unzigzag!(value >> 1));
        out.push(*baseline);
    }
    if cursor.0.is_empty() { Ok(out) } else { Err("bytes are left over after the last index") }
}

/// Indices as 16 or 32 bits.
fn narrow(indices: Vec<u32>, stride: usize) -> Result<Vec<u8>, &'static str> {
    match stride {
        2 => Ok(indices.into_iter().flat_map(|index| (index as u16).to_le_bytes()).collect()),
        4 => Ok(indices.into_iter().flat_map(u32::to_le_bytes).collect()),
        _ => Err("its stride is not 2 or 4"),
    }
}

/// Applies a filter to each `N` bytes.
fn each_element<const N: usize>(bytes: &mut [u8], filter: impl Fn([u8; N]) -> [u8; N]) {
    for element in bytes.as_chunks_mut::<N>().0 {
        *element = filter(*element);
    }
}

/// Applies a filter to elements of four components of 8 or 16 bits.
fn filter_components(
    bytes: &mut [u8],
    stride: usize,
    narrow: impl Fn([u8; 4]) -> [u8; 4],
    wide: impl Fn([u16; 4]) -> [u16; 4],
) -> Result<(), &'static str> {
    match stride {
        4 => each_element(bytes, narrow),
        8 => each_element(bytes, |element| from_halves(wide(to_halves(element)))),
        _ => return Err("its filter needs a stride of 4 or 8"),
    }
    Ok(())
}

fn to_halves(bytes: [u8; 8]) -> [u16; 4] {
    std::array::from_fn(|at| u16::from_le_bytes([bytes[2 * at], bytes[2 * at + 1]]))
}

fn from_halves(halves: [u16; 4]) -> [u8; 8] {
    std::array::from_fn(|at| halves[at / 2].to_le_bytes()[at % 2])
}

/// Unit vector from its octahedral coordinates; `one` is how 1.0 is stored. Filter 1.
fn octahedral(x: f32, y: f32, one: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded over the edges.
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

fn octahedral_8([x, y, one, passed]: [u8; 4]) -> [u8; 4] {
    let signed = |value: u8| f32::from(value as i8);
    let [x, y, z] =
        octahedral(signed(x), signed(y), signed(one)).map(|value| (value * 127.0).round() as i8 as u8);
    [x, y, z, passed]
}

fn octahedral_16([x, y, one, passed]: [u16; 4]) -> [u16; 4] {
    let signed = |value: u16| f32::from(value as i16);
    let [x, y, z] =
        octahedral(signed(x), signed(y), signed(one)).map(|value| (value * 32767.0).round() as i16 as u16);
    [x, y, z, passed]
}

/// Unit quaternion from its three smaller components. Filter 2.
fn quaternion(bytes: [u8; 8]) -> [u8; 8] {
    let stored = to_halves(bytes).map(|half| half as i16);
    let one = f32::from(stored[3] | 3);
    let [x, y, z] = [0, 1, 2].map(|at| f32::from(stored[at]) / one * std::f32::consts::FRAC_1_SQRT_2);
    let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut out = [0; 4];
    let position = (stored[3] & 3) as usize;
    for (offset, value) in [largest, x, y, z].into_iter().enumerate() {
        out[(position + offset) % 4] = (value * 32767.0).round() as i16 as u16;
    }
    from_halves(out)
}

/// Float from 8 bits of exponent over 24 bits of mantissa, both signed. Filter 3.
fn exponential(bytes: [u8; 4]) -> [u8; 4] {
    let stored = i32::from_le_bytes(bytes);
    // The range that the specification allows, so that the power is a normal number.
    let exponent = (stored >> 24).clamp(-100, 100);
    let mantissa = (stored << 8) >> 8;
    let power = f32::from_bits(((exponent + 127) as u32) << 23);
    (power * mantissa as f32).to_le_bytes()
}

/// RGBA from luma, two chroma components and alpha, whose top bit tells the precision. Filter 4.
fn colour([y, co, cg]: [i32; 3], alpha: u32, greatest: f32) -> [f32; 4] {
    let scale = alpha.checked_ilog2().map_or(1, |top| (2_i32 << top) - 1);
    let kept = alpha as i32 & (scale >> 1);
    let alpha = kept << 1 | kept & 1;
    [y + co - cg, y + cg, y - co - cg, alpha].map(|value| (value as f32 * (greatest / scale as f32)).round())
}

fn colour_8([y, co, cg, alpha]: [u8; 4]) -> [u8; 4] {
    let chroma = |value: u8| i32::from(value as i8);
    colour([i32::from(y), chroma(co), chroma(cg)], u32::from(alpha), 255.0).map(|value| value as u8)
}

fn colour_16([y, co, cg, alpha]: [u16; 4]) -> [u16; 4] {
    let chroma = |value: u16| i32::from(value as i16);
    colour([i32::from(y), chroma(co), chroma(cg)], u32::from(alpha), 65535.0).map(|value| value as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_specification_decodes() {
        let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut group = [0; GROUP];
        decode_group(&mut Cursor(&packed), 4, &mut group).unwrap();
        let deltas = group.map(|delta| unzigzag!(delta) as i8);
        assert_eq!(deltas, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
    }

    #[test]
    fn variable_length_numbers_decode() {
        for (bytes, value) in [(&[0x7F][..], 0x7F), (&[0x81, 0x04], 0x201), (&[0xFF, 0xA0, 0x05], 0x1_507F)] {
            assert_eq!(Cursor(bytes).varint(), Ok(value));
        }
        assert!(Cursor(&[0x80; 6]).varint().is_err());
    }

    #[test]
    fn both_versions_of_the_attribute_codec_decode_bytes_deltas_and_literals() {
        // Version 0, stride 4, 2 elements: lane 0 as whole bytes, the others zero; the baseline is 10 20 30
        // 40.
        let mut old = vec![0xA0, 3, 2, 1];
        old.extend([0; 14]);
        old.extend([0, 0, 0]);
        old.extend([0; 28]);
        old.extend([10, 20, 30, 40]);
        assert_eq!(decode_attributes(&old, 2, 4).unwrap(), [11, 20, 30, 40, 10, 20, 30, 40]);
        // Version 1: lane 0 literal (control 3), the others absent (control 2); channel mode 1 adds 16 bits.
        let mut new = vec![0xA1, 0b1010_1011, 2, 2];
        new.extend([0; 19]);
        new.extend([255, 0, 30, 40]);
        new.push(1);
        assert_eq!(decode_attributes(&new, 2, 4).unwrap(), [0, 1, 30, 40, 1, 1, 30, 40]);
        // Channel mode 2 exchanges bits, turned here by 8.
        *new.last_mut().unwrap() = 0x82;
        assert_eq!(decode_attributes(&new, 2, 4).unwrap(), [255, 2, 30, 40, 255, 0, 30, 40]);
        *new.last_mut().unwrap() = 3;
        assert!(decode_attributes(&new, 2, 4).is_err());
        assert!(decode_attributes(&old[..30], 2, 4).is_err());
        assert!(decode_attributes(&old, 200, 4).is_err());
    }

    #[test]
    fn triangles_decode_from_edges_and_fresh_vertices() {
        // 0xF0 with table entry 0: three fresh vertices. 0x00: newest edge (a, c) and a fresh vertex.
        let mut stream = vec![0xE1, 0xF0, 0x00];
        stream.extend([0; 16]);
        assert_eq!(decode_triangles(&stream, 6).unwrap(), [0, 1, 2, 0, 2, 3]);
        // An edge that was never seen.
        stream[1] = 0x10;
        assert!(decode_triangles(&stream, 6).is_err());
    }

    #[test]
    fn index_sequences_follow_two_baselines() {
        // +5 on baseline 0, +3 on baseline 1, -1 on baseline 0.
        let stream = [0xD1, 5 << 2, 3 << 2 | 1, 2, 0, 0, 0, 0];
        assert_eq!(decode_indices(&stream, 3).unwrap(), [5, 3, 4]);
        assert!(decode_indices(&stream, 4).is_err() && decode_indices(&stream, 2).is_err());
    }

    #[test]
    fn filters_give_unit_vectors_and_the_colours_that_went_in() {
        assert_eq!(octahedral_8([0, 0, 127, 9]), [0, 0, 127, 9]);
        assert_eq!(octahedral_8([127, 127, 127, 9]), [0, 0, (-127_i8) as u8, 9]);
        assert_eq!(to_halves(quaternion(from_halves([0, 0, 0, 0x7FFF]))), [0, 0, 0, 32767]);
        assert_eq!(f32::from_le_bytes(exponential((-3_i32 << 24 | 5).to_le_bytes())), 0.625);
        // Full precision: white and opaque, K = 8.
        assert_eq!(colour_8([255, 0, 0, 255]), [255; 4]);
    }
}
