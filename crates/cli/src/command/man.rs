//! `sheer man`: the manual pages, for those who package the program.

use std::{fmt::Write as _, iter};

use clap_mangen::Man;

use crate::{
    args::ManArguments,
    help::{self, Example},
    output,
};

pub(crate) fn run(arguments: &ManArguments) -> anyhow::Result<()> {
    output::open_folder(&arguments.folder)?;
    let mut parser = help::parser().disable_help_subcommand(true);
    // Names the pages of commands after the program: sheer-render.1.
    parser.build();
    let commands = parser.get_subcommands().filter(|command| !command.is_hide_set());
    for command in iter::once(&parser).chain(commands) {
        let examples = help::examples(command.get_name());
        let command = match examples {
            [] => command.clone(),
            // Below the options, where they would be set as text, with gaps in their lines.
            _ => command.clone().after_long_help(None::<&str>),
        };
        let man = Man::new(command);
        let mut page = Vec::new();
        man.render(&mut page)?;
        page.extend(section(examples).into_bytes());
        output::write_file(&arguments.folder.join(man.get_filename()), &page)?;
    }
    Ok(())
}

/// The examples in the language of manual pages, line by line as they are typed; nothing without any.
fn section(examples: &[Example]) -> String {
    // Hyphens and tildes that can be copied, not those of text.
    let typed = |text: &str| text.replace('\\', "\\e").replace('-', "\\-").replace('~', "\\(ti");
    let heading = if examples.is_empty() { "" } else { ".SH EXAMPLES\n" };
    examples.iter().fold(heading.to_owned(), |mut section, Example { what, line }| {
        let _ = write!(section, ".TP\n{}:\n.nf\n{}\n.fi\n", typed(what), typed(line));
        section
    })
}
