//! `sheer inspect`: what a file or a built-in scene holds and what becomes of it.

use crate::{
    args::InspectArguments,
    output::{self, TextOutput},
    report::{inspection::Inspection, json},
};

pub(crate) fn run(arguments: &InspectArguments) -> anyhow::Result<()> {
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let loaded = sheer_gallery::open_with(&arguments.text, &arguments.load.options())?;
    let inspection = Inspection::of(&arguments.text, &loaded);
    if let Some(output) = &json {
        output.write(&json::text(&inspection)?)?;
        if output.is_stdout() {
            return Ok(());
        }
    }
    output::print(&inspection.text())
}
