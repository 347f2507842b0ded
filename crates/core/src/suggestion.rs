//! What someone may have meant who typed a name that there is not.

use strsim::osa_distance;

/// Bytes of a name that is looked at, on either side: strangers write what they like, and so do files.
const LONGEST_BYTES: usize = 64;
/// From so many characters on, the beginning of a name stands for it: `smoke` for `smoke-square`.
const SHORTEST_BEGINNING: usize = 3;

/// The known name that an unknown one is nearest to, in upper or lower case: one slip in three characters
/// (a letter too many, too few, another, or two exchanged), or its beginning. The first of those that are as
/// near; none where nothing is near.
///
/// ```
/// use sheer_core::suggestion::nearest;
///
/// assert_eq!(nearest("sdt", ["roulette", "std"]), Some("std"));
/// assert_eq!(nearest("fxaa", ["none", "taa"]), None);
/// ```
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > LONGEST_BYTES {
        return None;
    }
    let name = name.to_lowercase();
    let length = name.chars().count();
    let most_slips = (length / 3).max(1);
    let slips = |word: &str| {
        let word = word.to_lowercase();
        let begins = length >= SHORTEST_BEGINNING && word.starts_with(&name);
        if begins { 1 } else { osa_distance(&name, &word) }
    };
    let known = known.into_iter().filter(|word| word.len() <= LONGEST_BYTES);
    let near = known.map(|word| (slips(word), word));
    // Two names without a character in common are not near, short as they may be.
    let near = near.filter(|&(slips, word)| slips <= most_slips && slips < length.min(word.chars().count()));
    near.min_by_key(|(slips, _)| *slips).map(|(_, word)| word)
}

/// The end of a message about an unknown name: `; the nearest is 'std'`, or nothing.
pub fn suggestion<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(name, known).map_or_else(String::new, |nearest| format!("; the nearest is '{nearest}'"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [&str; 6] = ["roulette", "std", "dtaa", "dtaa-unique", "smoke-square", "gpu:ray"];

    #[test]
    fn slips_of_the_finger_and_beginnings_are_understood() {
        for (typed, meant) in [
            ("sdt", "std"),
            ("STD", "std"),
            ("roulete", "roulette"),
            ("roullette", "roulette"),
            ("dtaa-uniqe", "dtaa-unique"),
            ("smoke", "smoke-square"),
            ("smok-sqare", "smoke-square"),
            ("gpu:rya", "gpu:ray"),
        ] {
            assert_eq!(nearest(typed, KNOWN), Some(meant), "{typed}");
        }
        assert_eq!(suggestion("sdt", KNOWN), "; the nearest is 'std'");
    }

    #[test]
    fn what_is_like_nothing_suggests_nothing() {
        let long = "std".repeat(1_000_000);
        for typed in ["", "x", "zz", "weighted", "sm", "fxaa", long.as_str()] {
            assert_eq!(nearest(typed, KNOWN), None, "{}", &typed[..typed.len().min(20)]);
        }
        assert_eq!(suggestion("weighted", KNOWN), "");
        assert_eq!(nearest("std", [long.as_str()]), None, "its beginning is the name");
    }
}
