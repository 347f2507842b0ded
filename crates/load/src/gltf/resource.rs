//! Bytes: the two containers, files beside the file, and data URIs.

use std::{
    borrow::Cow,
    io,
    path::{Component, Path, PathBuf},
};

use sheer_core::text::quoted;
use sheer_image::read_whole;

use crate::{LoadError, LoadOptions};

/// `glTF` in little endian (glTF 2.0, 4.4.2).
const GLB_MAGIC: [u8; 4] = *b"glTF";
const GLB_CHUNK_JSON: [u8; 4] = *b"JSON";
const GLB_CHUNK_BIN: [u8; 4] = *b"BIN\0";

/// Reads a regular file of at most `most_bytes`; a device or pipe, which may never end, is refused.
pub(crate) fn read_file(path: &Path, most_bytes: u64) -> Result<Vec<u8>, LoadError> {
    read_whole(path, most_bytes).map_err(|source| LoadError::Read { path: path.to_owned(), source })
}

/// Whether the bytes are a GLB container.
pub(super) fn is_container(bytes: &[u8]) -> bool {
    bytes.starts_with(&GLB_MAGIC)
}

/// The JSON text and the binary chunk, if there is one.
pub(super) fn split_container(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !is_container(bytes) {
        return Ok((bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), None));
    }
    let word =
        |at: usize| bytes.get(at..at + 4).and_then(|word| word.try_into().ok()).map(u32::from_le_bytes);
    let cut_short = || "the file is cut short; copy or export it again".to_owned();
    let version = word(4).ok_or_else(cut_short)?;
    if version != 2 {
        return Err(format!("this is a GLB container of version {version}; export the file as glTF 2.0"));
    }
    let length = word(8).ok_or_else(cut_short)? as usize;
    let bytes = bytes.get(..length).ok_or_else(cut_short)?;

    let mut chunks = Vec::new();
    let mut at = 12;
    // Two chunks have a meaning; unknown ones may follow (glTF 2.0, 4.4.3).
    while at < bytes.len() && chunks.len() < 2 {
        let length = word(at).ok_or_else(cut_short)? as usize;
        let start = at + 8;
        let end = start.checked_add(length).ok_or_else(cut_short)?;
        let kind = bytes.get(at + 4..start).ok_or_else(cut_short)?;
        chunks.push((kind, bytes.get(start..end).ok_or_else(cut_short)?));
        // Chunks begin at multiples of four bytes, but some writers forget to pad them.
        let aligned = end.next_multiple_of(4);
        at = if !begins_chunk(bytes, aligned) && begins_chunk(bytes, end) { end } else { aligned };
    }
    match chunks[..] {
        [(kind, json), ref rest @ ..] if kind == GLB_CHUNK_JSON => {
            let binary = rest.first().filter(|(kind, _)| *kind == GLB_CHUNK_BIN).map(|(_, data)| *data);
            Ok((json, binary))
        }
        _ => Err("the first chunk of the GLB container is not JSON; export the file again".to_owned()),
    }
}

/// Whether a binary chunk that fits stands at an offset.
fn begins_chunk(bytes: &[u8], at: usize) -> bool {
    let Some((length, rest)) = bytes.get(at..).and_then(|rest| rest.split_first_chunk::<4>()) else {
        return false;
    };
    rest.strip_prefix(&GLB_CHUNK_BIN).is_some_and(|data| data.len() >= u32::from_le_bytes(*length) as usize)
}

/// Whether a URI holds its data itself.
pub(super) fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// The bytes a URI stands for: inline data, or a file below `folder` or one of the `allowed` folders. The
/// error says what is wrong and what to do.
pub(super) fn read_uri(
    uri: &str,
    folder: &Path,
    allowed: &[PathBuf],
    most_bytes: u64,
) -> Result<Vec<u8>, UriError> {
    if is_data(uri) {
        return decode_data_uri(&uri[5..]).map_err(UriError::Refused);
    }
    let path = path_of(uri, folder, allowed).map_err(UriError::Refused)?;
    match read_file(&path, most_bytes) {
        Err(LoadError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
            // Some exporters write names with a literal percent sign.
            let literal = path_of(&uri.replace('%', "%25"), folder, allowed).map_err(UriError::Refused)?;
            read_file(&literal, most_bytes)
                .map_err(|_| UriError::Unreadable(LoadError::Read { path, source }))
        }
        result => result.map_err(UriError::Unreadable),
    }
}

/// The file that a URI means; none for inline data, or if it may not be read.
pub(super) fn file_of(uri: &str, folder: &Path, allowed: &[PathBuf]) -> Option<PathBuf> {
    (!is_data(uri)).then(|| path_of(uri, folder, allowed).ok()).flatten()
}

/// The bytes of a file that another one at `path` refers to by its plain name, under the rules for URIs. The
/// error says what is wrong and what to do.
pub(crate) fn read_beside(name: &str, path: &Path, options: &LoadOptions) -> Result<Vec<u8>, String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    // In a plain name a percent sign is one.
    let most_bytes = options.memory_limit.map_or(u64::MAX, |limit| limit.0);
    let bytes = read_uri(&name.replace('%', "%25"), folder, &options.allowed_folders, most_bytes);
    bytes.map_err(|error| match error {
        UriError::Refused(problem) => problem,
        UriError::Unreadable(error) => error.to_string(),
    })
}

/// The file that such a name means; none if it may not be read.
pub(crate) fn path_beside(name: &str, path: &Path, options: &LoadOptions) -> Option<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    file_of(&name.replace('%', "%25"), folder, &options.allowed_folders)
}

/// How a file below the folder of another one is really spelt that is named in other cases of letters, as
/// systems let people do that do not tell them apart.
pub(crate) fn spelt_otherwise(name: &str, path: &Path, options: &LoadOptions) -> Option<String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let wanted = path_beside(name, path, options)?;
    let mut found = PathBuf::new();
    for component in wanted.strip_prefix(folder).ok()?.components() {
        let wanted = component.as_os_str();
        if folder.join(&found).join(wanted).exists() {
            found.push(wanted);
            continue;
        }
        let inside = folder.join(&found);
        // The folder of a file without a path is the current one.
        let inside = if inside.as_os_str().is_empty() { Path::new(".") } else { &inside };
        let mut names: Vec<_> = inside.read_dir().ok()?.flatten().map(|entry| entry.file_name()).collect();
        names.sort_unstable();
        let wanted = wanted.to_str()?.to_lowercase();
        found.push(
            names.into_iter().find(|name| name.to_str().is_some_and(|name| name.to_lowercase() == wanted))?,
        );
    }
    found.to_str().map(str::to_owned)
}

/// Why a URI gives no bytes.
pub(super) enum UriError {
    /// What is wrong with it and what to do.
    Refused(String),
    /// The system would not read the file.
    Unreadable(LoadError),
}

/// The file that a relative or absolute URI means, if it may be read.
fn path_of(uri: &str, folder: &Path, allowed: &[PathBuf]) -> Result<PathBuf, String> {
    let shown = quoted(uri);
    let local = uri.strip_prefix("file://").unwrap_or(uri);
    let has_scheme = local.split_once(':').is_some_and(|(scheme, _)| {
        scheme.chars().all(|letter| letter.is_ascii_alphanumeric() || "+-.".contains(letter))
    });
    if has_scheme {
        return Err(format!(
            "'{shown}' is not beside the file; fetch it, put it there, and refer to it by name"
        ));
    }
    let decoded = decode_percent(local.as_bytes());
    let text = String::from_utf8(decoded.into_owned())
        .map_err(|_| format!("'{shown}' is not a file name in UTF-8"))?;
    if text.is_empty() || text.contains('\0') {
        return Err(format!("'{shown}' is no file name; correct it and export the file again"));
    }
    // Windows exporters write backslashes.
    let text = text.replace('\\', "/");
    if let Some(inside) = inside_path(Path::new(&text)) {
        return Ok(folder.join(inside));
    }
    let outside = without_detours(&folder.join(&text));
    if allowed.iter().any(|allowed| lies_in(&outside, allowed)) {
        return Ok(outside);
    }
    let home = outside.parent().unwrap_or(&outside).display();
    Err(format!(
        "'{shown}' lies outside the folder of the file; move it there and refer to it by a relative name, or allow \
         its folder with --allow-folder '{home}'"
    ))
}

/// A relative path without `.` and `..`; none if it is empty, absolute, or leaves the folder on its way.
fn inside_path(path: &Path) -> Option<PathBuf> {
    let mut inside = PathBuf::new();
    for component in path.components() {
        match component {
            Component::Normal(name) => inside.push(name),
            Component::CurDir => {}
            Component::ParentDir => inside.pop().then_some(())?,
            Component::Prefix(_) | Component::RootDir => return None,
        }
    }
    (!inside.as_os_str().is_empty()).then_some(inside)
}

/// An absolute path without `.` and `..`, by its text alone, so that what is opened is what was checked.
fn without_detours(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut plain = PathBuf::new();
    for component in absolute.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    plain
}

/// Whether a file lies in a folder, by their names or by where the file system says they are.
fn lies_in(file: &Path, folder: &Path) -> bool {
    let by_name = file.starts_with(without_detours(folder));
    by_name
        || match (file.canonicalize(), folder.canonicalize()) {
            (Ok(file), Ok(folder)) => file.starts_with(folder),
            _ => false,
        }
}

/// `mediatype;base64,data` or `mediatype,percent-encoded` (RFC 2397).
fn decode_data_uri(rest: &str) -> Result<Vec<u8>, String> {
    let (header, data) = rest.split_once(',').ok_or("the data URI has no comma; export the file again")?;
    if header.ends_with(";base64") {
        decode_base64(data.as_bytes())
            .ok_or_else(|| "the data URI is not valid base64; export the file again".to_owned())
    } else {
        Ok(decode_percent(data.as_bytes()).into_owned())
    }
}

/// `%20` and the like (RFC 3986, 2.1); a percent sign that starts no escape stands for itself.
fn decode_percent(text: &[u8]) -> Cow<'_, [u8]> {
    if !text.contains(&b'%') {
        return Cow::Borrowed(text);
    }
    let digit = |at: usize| text.get(at).and_then(|&letter| char::from(letter).to_digit(16));
    let mut out = Vec::with_capacity(text.len());
    let mut at = 0;
    while let Some(&letter) = text.get(at) {
        match (letter, digit(at + 1), digit(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                at += 3;
            }
            _ => {
                out.push(letter);
                at += 1;
            }
        }
    }
    Cow::Owned(out)
}

/// Standard or URL-safe alphabet, padded or not, white space skipped (RFC 4648).
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut bit_count) = (0_u32, 0);
    let data = text.iter().filter(|letter| !letter.is_ascii_whitespace());
    for &letter in data.take_while(|&&letter| letter != b'=') {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        bit_count += 6;
        if bit_count >= 8 {
            bit_count -= 8;
            out.push((bits >> bit_count) as u8);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_follows_the_rfc() {
        let cases = [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYmFy", "foobar"),
            ("Zm9vYg", "foob"),
        ];
        for (text, plain) in cases {
            assert_eq!(decode_base64(text.as_bytes()).unwrap(), plain.as_bytes());
        }
        assert_eq!(decode_base64(b"+/-_").unwrap(), [0xFB, 0xFF, 0xBF]);
        assert_eq!(decode_base64(b"Zm9v!"), None);
    }

    #[test]
    fn data_uris_come_in_both_encodings() {
        assert_eq!(decode_data_uri("text/plain,a%20b%2").unwrap(), b"a b%2");
        assert_eq!(decode_data_uri("application/octet-stream;base64,AAEC").unwrap(), [0, 1, 2]);
        assert!(decode_data_uri("application/octet-stream;base64").is_err());
    }

    #[test]
    fn files_stay_below_the_folder() {
        let folder = Path::new("scenes");
        let path = |uri| path_of(uri, folder, &[]);
        assert_eq!(path("Normal%20Map.png").unwrap(), Path::new("scenes/Normal Map.png"));
        assert_eq!(path("./textures\\a.png").unwrap(), Path::new("scenes/textures/a.png"));
        assert_eq!(path("sub/../a.png").unwrap(), Path::new("scenes/a.png"));
        for outside in [
            "../a.bin",
            "a/../../b",
            "a/..",
            ".",
            "/etc/passwd",
            "http://x/y.bin",
            "%2e%2e/a",
            "..\\a",
            "file:a",
            "file:///etc/passwd",
            "a%00b",
            "",
        ] {
            assert!(path(outside).is_err(), "{outside}");
        }
    }

    #[test]
    fn other_folders_are_read_where_they_are_allowed() {
        let folder = Path::new("/models/lamp");
        let allowed = [PathBuf::from("/models/../textures/./glass")];
        let path = |uri| path_of(uri, folder, &allowed);
        let red = Path::new("/textures/glass/red.png");
        for uri in
            ["../../textures/glass/red.png", "/textures/glass/red.png", "file:///textures/glass/x/../red.png"]
        {
            assert_eq!(path(uri).unwrap(), red, "{uri}");
        }
        assert_eq!(path("own.png").unwrap(), Path::new("/models/lamp/own.png"));
        for outside in ["../../textures/glassy/a.png", "/textures/glass/../a.png", "../a.png", "http://x/y"] {
            assert!(path(outside).is_err(), "{outside}");
        }
        let problem = path("../other/a.png").unwrap_err();
        assert!(problem.ends_with("--allow-folder '/models/other'"), "{problem}");
    }

    #[test]
    fn a_glb_is_split_into_its_chunks() {
        let mut glb = b"glTF\x02\0\0\0\0\0\0\0\x04\0\0\0JSON{}  \x04\0\0\0BIN\0data".to_vec();
        glb[8] = glb.len() as u8;
        assert_eq!(split_container(&glb).unwrap(), (&b"{}  "[..], Some(&b"data"[..])));
        for length in 4..glb.len() {
            assert!(split_container(&glb[..length]).is_err(), "{length}");
        }
        // The chunk after JSON of three bytes stands where it ends, or where it is padded to.
        for padding in [&b""[..], b" "] {
            let mut glb = b"glTF\x02\0\0\0\0\0\0\0\x03\0\0\0JSON{} ".to_vec();
            glb.extend_from_slice(padding);
            glb.extend_from_slice(b"\x04\0\0\0BIN\0data");
            glb[8] = glb.len() as u8;
            assert_eq!(split_container(&glb).unwrap(), (&b"{} "[..], Some(&b"data"[..])), "{padding:?}");
        }
        glb[4] = 1;
        assert!(split_container(&glb).unwrap_err().contains("version 1"));
        assert_eq!(split_container(b"\xEF\xBB\xBF{}").unwrap(), (&b"{}"[..], None));
    }
}
