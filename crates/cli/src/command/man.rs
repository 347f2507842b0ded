//! `sheer man`: the manual pages, for those who package the program.

use std::iter;

use clap_mangen::Man;

use crate::{args::ManArguments, help, output};

pub(crate) fn run(arguments: &ManArguments) -> anyhow::Result<()> {
    output::open_folder(&arguments.folder)?;
    let mut parser = help::parser().disable_help_subcommand(true);
    // Names the pages of commands after the program: sheer-render.1.
    parser.build();
    let commands = parser.get_subcommands().filter(|command| !command.is_hide_set());
    for command in iter::once(&parser).chain(commands) {
        let man = Man::new(command.clone());
        let mut page = Vec::new();
        man.render(&mut page)?;
        output::write_file(&arguments.folder.join(man.get_filename()), &page)?;
    }
    Ok(())
}
