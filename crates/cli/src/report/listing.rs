//! Lists of what there is: one line each, the name first.

/// Something that can be asked for by name.
#[derive(Debug)]
pub(crate) struct Entry {
    /// The word on the command line.
    pub(crate) name: &'static str,
    /// A line on what it is.
    pub(crate) title: &'static str,
    /// Paper and place in it.
    pub(crate) source: &'static str,
    /// What can be set.
    pub(crate) parameters: Vec<Parameter>,
    /// Further things to know, with their titles.
    pub(crate) remarks: Vec<(&'static str, String)>,
}

/// A parameter of an entry, set as `name:key=value`.
#[derive(Debug)]
pub(crate) struct Parameter {
    /// The word before the `=`.
    pub(crate) key: &'static str,
    /// Its value where none is given.
    pub(crate) default: &'static str,
    /// What it may be.
    pub(crate) range: String,
    /// What it does.
    pub(crate) what: &'static str,
}

/// One line an entry; with `long` what else there is to know beneath it, indented.
pub(crate) fn listing(entries: &[Entry], long: bool) -> String {
    let width = entries.iter().map(|entry| entry.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for entry in entries {
        text += &format!("{:width$}  {} ({})\n", entry.name, entry.title, entry.source);
        if !long {
            continue;
        }
        for (title, remark) in &entry.remarks {
            text += &format!("    {title}: {remark}\n");
        }
        for Parameter { key, default, range, what } in &entry.parameters {
            text += &format!("    {key}={default}  {what} ({range})\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_begins_with_the_name_and_parameters_are_indented() {
        let parameter =
            Parameter { key: "count", default: "8", range: "1..=64".to_owned(), what: "how many" };
        let entry = Entry {
            name: "layers",
            title: "sheets",
            source: "ST 3.1",
            parameters: vec![parameter],
            remarks: Vec::new(),
        };
        assert_eq!(listing(std::slice::from_ref(&entry), false), "layers  sheets (ST 3.1)\n");
        assert_eq!(listing(&[entry], true), "layers  sheets (ST 3.1)\n    count=8  how many (1..=64)\n");
    }
}
