//! Lines, words and numbers of text formats, with what to say of a wrong one.

use std::{borrow::Cow, str::FromStr};

use sheer_core::text::quoted;

/// A line and its number, from 1.
#[derive(Clone, Debug)]
pub(super) struct Line<'a> {
    pub(super) number: usize,
    pub(super) text: Cow<'a, [u8]>,
}

impl Line<'_> {
    /// The line in messages.
    pub(super) fn place(&self) -> String {
        format!("line {}", self.number)
    }

    /// Its words up to a comment: a word that begins with `#`.
    pub(super) fn words(&self) -> impl Iterator<Item = &[u8]> {
        words(&self.text).take_while(|word| !word.starts_with(b"#"))
    }

    /// What follows its first word, as a name that may contain blanks.
    pub(super) fn rest(&self) -> String {
        let text = self.text.trim_ascii();
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        String::from_utf8_lossy(text[end..].trim_ascii()).into_owned()
    }
}

/// The lines of a text, whatever ends them; one that ends with a backslash goes on in the next, unless it is
/// a comment, which may end with the name of a folder.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    // Of \r\n the second character ends an empty line, which no format minds; \r alone ends old ones.
    let mut rest = Some(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes));
    let mut number = 0;
    std::iter::from_fn(move || {
        let mut next = || {
            let bytes = rest?;
            let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let (line, after) = match end {
                Some(end) => {
                    let length = if bytes[end..].starts_with(b"\r\n") { 2 } else { 1 };
                    (&bytes[..end], Some(&bytes[end + length..]))
                }
                None => (bytes, None),
            };
            rest = after;
            number += 1;
            Some((number, line))
        };
        let (number, line) = next()?;
        let mut text = Cow::Borrowed(line);
        let is_comment = line.trim_ascii_start().starts_with(b"#");
        while !is_comment && text.ends_with(b"\\") {
            let joined = text.to_mut();
            joined.pop();
            joined.push(b' ');
            joined.extend_from_slice(next().map_or(&b""[..], |(_, line)| line));
        }
        Some(Line { number, text })
    })
}

/// What stands between blanks.
pub(super) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A number, or what is wrong with the word.
pub(super) fn number<T: FromStr>(word: &[u8]) -> Result<T, String> {
    let parsed = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    parsed.ok_or_else(|| format!("'{}' is not a number; correct it or export the file again", shown(word)))
}

/// The next word as a number, or what is wrong.
pub(super) fn next_number<'w, T: FromStr>(words: &mut impl Iterator<Item = &'w [u8]>) -> Result<T, String> {
    number(words.next().ok_or("a number is missing; the line is cut short, export the file again")?)
}

/// A word of a file as messages quote it.
pub(super) fn shown(word: &[u8]) -> String {
    quoted(&String::from_utf8_lossy(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_numbers_whatever_ends_them() {
        let text = b"\xEF\xBB\xBFa 1\r\nb\rc \\\nd # e\n\nf";
        let lines: Vec<Line<'_>> = lines(text).collect();
        let numbers: Vec<usize> = lines.iter().map(|line| line.number).collect();
        assert_eq!(numbers, [1, 2, 3, 5, 6]);
        let words: Vec<&[u8]> = lines[2].words().collect();
        assert_eq!(words, [&b"c"[..], b"d"]);
        assert_eq!(lines[0].rest(), "1");
        assert_eq!((lines[3].words().count(), lines[4].place().as_str()), (0, "line 6"));
    }

    #[test]
    fn a_comment_ends_with_its_line_and_many_joined_lines_take_no_longer_than_others() {
        let text = b"  # exported from C:\\models\\\nv 1\n";
        let all: Vec<Line<'_>> = lines(text).collect();
        assert_eq!(all[1].words().count(), 2);
        let endless = b"\\\n".repeat(500_000);
        let joined: Vec<Line<'_>> = lines(&endless).collect();
        assert_eq!((joined.len(), joined[0].words().count()), (1, 0));
    }

    #[test]
    fn a_word_that_is_no_number_is_named_and_cannot_reach_the_terminal() {
        assert_eq!(number::<f32>(b"-1.5e2"), Ok(-150.0));
        let problem = number::<f32>(b"1\x1b[31m").unwrap_err();
        assert!(problem.starts_with("'1\\u{1b}[31m' is not a number"), "{problem}");
        let long = number::<f32>(&[b'x'; 10_000]).unwrap_err();
        assert!(long.len() < 200, "{long}");
    }
}
