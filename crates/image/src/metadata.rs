//! What a file says of how its picture was made.

use crate::error::ImageError;

/// How a picture was made: texts by key, stored in PNG and EXR files under `sheer.KEY`, in the order given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata {
    entries: Vec<(String, String)>,
}

impl Metadata {
    /// The same with one more text, or with another text for a key that is there already.
    #[must_use]
    pub fn with(mut self, key: &str, text: impl ToString) -> Self {
        let text = text.to_string();
        match self.entries.iter_mut().find(|(known, _)| known == key) {
            Some(entry) => entry.1 = text,
            None => self.entries.push((key.to_owned(), text)),
        }
        self
    }

    /// The same without one of its texts, if it is there.
    #[must_use]
    pub fn without(mut self, key: &str) -> Self {
        self.entries.retain(|(known, _)| known != key);
        self
    }

    /// The text of a key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries().find_map(|(known, text)| (known == key).then_some(text))
    }

    /// Keys, without the prefix, and texts.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().map(|(key, text)| (key.as_str(), text.as_str()))
    }

    /// Keys as they stand in files, and texts.
    ///
    /// # Errors
    /// [`ImageError::MetadataKey`] for a key or text that PNG or EXR cannot hold.
    pub(crate) fn stored(&self) -> Result<Vec<(String, &str)>, ImageError> {
        // PNG ends a keyword after 79 bytes, EXR ends texts at NUL.
        const LONGEST_KEY_BYTES: usize = 60;
        let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
        self.entries()
            .map(|(key, text)| {
                let storable = !key.is_empty()
                    && key.len() <= LONGEST_KEY_BYTES
                    && key.chars().all(plain)
                    && !text.contains('\0');
                if storable {
                    Ok((format!("{PREFIX}{key}"), text))
                } else {
                    Err(ImageError::MetadataKey { key: key.to_owned() })
                }
            })
            .collect()
    }
}

/// What stands before the keys in files.
pub(crate) const PREFIX: &str = "sheer.";

/// The program and version that files name as their origin.
pub(crate) const SOFTWARE: &str = concat!("Sheer ", env!("CARGO_PKG_VERSION"));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_keys_that_files_cannot_hold_are_named() {
        let refused = |key: &str, text: &str| Metadata::default().with(key, text).stored().is_err();
        assert!(!refused("commit", "19f26a5, plain or ünïcödé"));
        assert!(refused("", "x") && refused("a b", "x") && refused("ü", "x"));
        assert!(refused(&"k".repeat(61), "x") && refused("key", "a\0b"));
    }

    #[test]
    fn a_key_given_twice_keeps_its_place_and_takes_the_new_text() {
        let metadata = Metadata::default().with("seed", 1).with("scene", "pane").with("seed", 2);
        assert_eq!(metadata.entries().collect::<Vec<_>>(), [("seed", "2"), ("scene", "pane")]);
        assert_eq!((metadata.get("scene"), metadata.get("method")), (Some("pane"), None));
        assert_eq!(metadata.without("seed"), Metadata::default().with("scene", "pane"));
    }
}
