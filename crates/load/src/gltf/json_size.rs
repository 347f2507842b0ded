//! What the JSON of a file will take in memory, counted from its bytes before it is parsed.

/// What JSON takes when it is parsed.
pub(super) fn parsed_bytes(json: &[u8]) -> u64 {
    // An object may become the largest struct of the schema, in a list that doubles as it grows.
    json_bytes(json, 1400, 32)
}

/// What JSON takes as a tree of values.
pub(super) fn tree_bytes(json: &[u8]) -> u64 {
    // A node of a map has room for eleven keys and values; lists double as they grow.
    json_bytes(json, 700, 64)
}

/// What JSON takes of which each object and each value in a list or an object takes so much, and texts what
/// they are long.
fn json_bytes(json: &[u8], object_bytes: u64, value_bytes: u64) -> u64 {
    let (mut objects, mut values) = (0_u64, 0_u64);
    let (mut in_text, mut escaped) = (false, false);
    for &byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = in_text,
            b'"' => in_text = !in_text,
            b'{' if !in_text => objects += 1,
            b',' | b'[' if !in_text => values += 1,
            _ => {}
        }
    }
    json.len() as u64 + objects * object_bytes + values * value_bytes
}
