//! Names for files.

/// Letters, digits, dots and underscores of a text, which no shell or file system minds; runs of anything
/// else become one dash.
#[must_use]
pub fn file_name_from(text: &str) -> String {
    let keep = |c: char| c.is_ascii_alphanumeric() || c == '.' || c == '_';
    let words = text.split(|c| !keep(c)).filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("-");
    if name.is_empty() { "scene".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_keep_what_every_file_system_takes() {
        assert_eq!(file_name_from("std:hash=mcguire"), "std-hash-mcguire");
        assert_eq!(file_name_from("Flügel & Tür"), "Fl-gel-T-r");
        assert_eq!(file_name_from("…"), "scene");
    }
}
