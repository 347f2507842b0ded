//! Texts for messages: what strangers wrote, made fit to be shown, and amounts of memory.

use std::{borrow::Cow, fmt, str::FromStr};

/// Characters that a message quotes of a text at most.
pub const LONGEST_QUOTE: usize = 80;

/// A text without what acts on a terminal or hides something from its reader: control characters, line
/// separators, and marks that turn the direction of writing stand there as `\u{1b}`.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if acts(character) {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    Cow::Owned(shown)
}

/// The beginning of a text, [`LONGEST_QUOTE`] characters and an ellipsis at most, [`printable`].
#[must_use]
pub fn quoted(text: &str) -> String {
    beginning(text, LONGEST_QUOTE)
}

/// The beginning of a text, so many characters and an ellipsis at most, [`printable`].
#[must_use]
pub fn beginning(text: &str, most_characters: usize) -> String {
    match text.char_indices().nth(most_characters) {
        Some((end, _)) => format!("{}…", printable(&text[..end])),
        None => printable(text).into_owned(),
    }
}

/// Whether a character does something instead of showing something. The marks of direction are those by which
/// texts are disguised (Boucher and Anderson 2021, *Trojan Source*).
fn acts(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}' | '\u{202a}'
                ..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}'
        )
}

/// An amount of memory. It is written in decimal units, `1.5 GB`, and read in decimal ones or in powers of
/// 1024: `1500000000`, `1.5GB`, `1.4GiB`, `1.4G`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MemorySize(pub u64);

impl fmt::Display for MemorySize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = self.0 as f64;
        for (unit, name) in [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")] {
            // What would be rounded up to a thousand of a unit is one of the next.
            if bytes >= 0.9995 * unit {
                let amount = bytes / unit;
                let decimals = if amount < 99.95 { 1 } else { 0 };
                return write!(f, "{amount:.decimals$} {name}");
            }
        }
        write!(f, "{} bytes", self.0)
    }
}

impl FromStr for MemorySize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let described = || "give an amount of memory as in 800MB, 2GB or 1.5GiB".to_owned();
        let (number, unit) =
            text.split_at(text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len()));
        let scale = match unit.to_ascii_lowercase().as_str() {
            "" | "b" => 1.0,
            "kb" => 1e3,
            "mb" => 1e6,
            "gb" => 1e9,
            "tb" => 1e12,
            "k" | "kib" => f64::from(1 << 10),
            "m" | "mib" => f64::from(1 << 20),
            "g" | "gib" => f64::from(1 << 30),
            "t" | "tib" => f64::from(1 << 20) * f64::from(1 << 20),
            _ => return Err(described()),
        };
        let is_number = |c: char| c.is_ascii_digit() || c == '.';
        let amount = number.trim_end();
        let amount: Option<f64> = amount.chars().all(is_number).then(|| amount.parse().ok()).flatten();
        amount.map(|amount| Self((amount * scale) as u64)).ok_or_else(described)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_of_memory_are_read_and_written() {
        for (text, bytes) in [
            ("0", 0),
            ("720", 720),
            ("1kB", 1000),
            ("2K", 2048),
            ("800MB", 800_000_000),
            ("1GB", 1_000_000_000),
            ("1.5 GiB", 3 << 29),
            ("4g", 4 << 30),
            ("1t", 1 << 40),
        ] {
            assert_eq!(text.parse(), Ok(MemorySize(bytes)), "{text}");
        }
        for wrong in ["", "GB", "-1", "1e3", "nan", "1 XB", "1.2.3", "1GB2", "five"] {
            assert!(wrong.parse::<MemorySize>().is_err(), "{wrong} passed");
        }
        for (bytes, text) in [
            (0, "0 bytes"),
            (999, "999 bytes"),
            (1000, "1.0 kB"),
            (999_950, "1.0 MB"),
            (268_435_456, "268 MB"),
            (12_340_000_000, "12.3 GB"),
            (u64::MAX, "18446744 TB"),
        ] {
            assert_eq!(MemorySize(bytes).to_string(), text);
        }
    }

    #[test]
    fn what_acts_on_a_terminal_is_spelt_out() {
        assert_eq!(printable("a\x1b[2Jb\u{9b}1m\x7f"), "a\\u{1b}[2Jb\\u{9b}1m\\u{7f}");
        assert_eq!(printable("two\nlines\u{2028}and\tmore"), "two\\nlines\\u{2028}and\\tmore");
        assert_eq!(printable("gpj.\u{202e}exe"), "gpj.\\u{202e}exe");
        for plain in ["", "Körper 'ß' \\ 🦊", "日本語", "<b>&amp;</b>"] {
            assert!(matches!(printable(plain), Cow::Borrowed(text) if text == plain));
        }
    }

    #[test]
    fn a_quotation_is_cut_between_characters() {
        assert_eq!(quoted("short"), "short");
        let long = "ü".repeat(1_000_000);
        assert_eq!(quoted(&long), format!("{}…", "ü".repeat(LONGEST_QUOTE)));
        assert_eq!(quoted(&"x".repeat(LONGEST_QUOTE)), "x".repeat(LONGEST_QUOTE));
        assert_eq!(beginning("\x1bß-", 2), "\\u{1b}ß…");
    }
}
