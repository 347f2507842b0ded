//! What a file holds besides the scene that was made of it: what there is to choose from, and what becomes of
//! its extensions.

use sheer_core::{suggestion::suggestion, text::quoted};

/// What a file holds; all empty for formats that have no such things.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// The format in words; empty for a built-in scene.
    pub format: String,
    /// The extensions that the file names, in its order.
    pub extensions: Vec<Extension>,
    /// Names of the scenes; one without a name is empty.
    pub scenes: Vec<String>,
    /// The scene that was made, if the file has any.
    pub shown_scene: Option<usize>,
    /// The animations.
    pub clips: Vec<Clip>,
    /// Names of the variants of materials (`KHR_materials_variants`).
    pub variants: Vec<String>,
    /// The variant that was chosen.
    pub shown_variant: Option<usize>,
}

/// An extension of a format.
#[derive(Clone, Debug, PartialEq)]
pub struct Extension {
    /// As the file spells it.
    pub name: String,
    /// The file says that it cannot be understood without.
    pub required: bool,
    /// Whether it has an effect here.
    pub has_effect: bool,
}

/// An animation of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Its name; may be empty.
    pub name: String,
    /// Time of its last key, seconds; 0 where that is not known because it is not played.
    pub duration_secs: f32,
    /// Whether it plays.
    pub plays: bool,
}

/// Which of several named things is meant by a word of the user: the first of that name, or the one of that
/// number, from 0. The error lists what there is.
pub(super) fn chosen(wanted: &str, names: &[&str]) -> Result<usize, String> {
    let by_name = names.iter().position(|name| *name == wanted && !name.is_empty());
    let by_number = || wanted.parse().ok().filter(|&number: &usize| number < names.len());
    by_name.or_else(by_number).ok_or_else(|| listed(names) + &suggestion(wanted, names.iter().copied()))
}

/// What there is, for messages: numbers and names.
pub(super) fn listed(names: &[&str]) -> String {
    const MOST: usize = 30;
    if names.is_empty() {
        return "it has none".to_owned();
    }
    let each = names.iter().enumerate().take(MOST).map(|(number, name)| match *name {
        "" => number.to_string(),
        name => format!("{number} '{}'", quoted(name)),
    });
    let more = if names.len() > MOST { format!(" and {} more", names.len() - MOST) } else { String::new() };
    format!("it has {}{more}", each.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_wins_over_a_number_and_what_is_not_there_is_told() {
        let names = ["Walk", "", "0", "Walk"];
        assert_eq!(chosen("Walk", &names), Ok(0));
        assert_eq!(chosen("0", &names), Ok(2), "it is a name");
        assert_eq!(chosen("1", &names), Ok(1));
        assert_eq!(chosen("4", &names), Err("it has 0 'Walk', 1, 2 '0', 3 'Walk'".to_owned()));
        let slip = "it has 0 'Walk', 1, 2 '0', 3 'Walk'; the nearest is 'Walk'".to_owned();
        assert_eq!(chosen("wlak", &names), Err(slip));
        assert_eq!(chosen("", &[""]), Err("it has 0".to_owned()));
        assert_eq!(chosen("Walk", &[]), Err("it has none".to_owned()));
        let many = vec!["x"; 50];
        assert!(chosen("y", &many).unwrap_err().ends_with("29 'x' and 20 more"));
    }
}
