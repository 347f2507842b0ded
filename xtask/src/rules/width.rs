//! Comments are as wide as code may be. rustfmt breaks code alone; comments are left to their writers.

/// Numbers of the lines whose comment goes beyond `width` columns. A single word that does not fit, such as
/// an address, is let through.
pub(super) fn too_wide(text: &str, width: usize) -> Vec<usize> {
    let is_too_wide = |line: &str| {
        line.chars().count() > width
            && comment(line).is_some_and(|comment| comment.split_whitespace().count() > 1)
    };
    let numbered = text.lines().enumerate();
    numbered.filter(|(_, line)| is_too_wide(line)).map(|(index, _)| index + 1).collect()
}

/// What follows `//` in a line, unless that is within a string.
fn comment(line: &str) -> Option<&str> {
    let (code, comment) = line.split_once("//")?;
    code.matches('"').count().is_multiple_of(2).then(|| comment.trim_start_matches(['/', '!']))
}

/// The width that rustfmt is set to.
pub(super) fn set_width(rustfmt: &str) -> Option<usize> {
    let value =
        |line: &str| line.strip_prefix("max_width")?.trim_start().strip_prefix('=')?.trim().parse().ok();
    rustfmt.lines().find_map(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_comment_is_found_wherever_it_begins() {
        let text = "// is short\n    /// is one that goes on\nlet a = 1; // goes on as well\nlet wide_code = is_left_to_rustfmt;\n";
        assert_eq!(too_wide(text, 20), [2, 3]);
        assert_eq!(too_wide(text, 40), [0; 0]);
    }

    #[test]
    fn an_address_is_no_comment_within_a_string_and_may_be_wide() {
        assert_eq!(
            too_wide("let a = \"https://a.example and on\";\n// https://a.example/with/a/path\n", 20),
            [0; 0]
        );
    }

    #[test]
    fn the_width_is_that_of_rustfmt() {
        assert_eq!(set_width("edition = \"2024\"\nmax_width = 110\n"), Some(110));
        assert_eq!(set_width("edition = \"2024\"\n"), None);
    }
}
