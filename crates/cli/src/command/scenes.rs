//! `sheer scenes`: the built-in scenes.

use sheer_gallery::catalogue;

use crate::{
    args::ListArguments,
    output,
    report::listing::{Entry, Parameter, listing},
};

pub(crate) fn run(arguments: &ListArguments) -> anyhow::Result<()> {
    let entries = catalogue().iter().map(|info| Entry {
        name: info.name,
        title: info.title,
        source: info.source,
        parameters: (info.parameters.iter())
            .map(|known| Parameter {
                key: known.key,
                default: known.default,
                range: known.range.to_string(),
                what: known.what,
            })
            .collect(),
        remarks: Vec::new(),
    });
    output::print(&listing(&entries.collect::<Vec<_>>(), arguments.long))
}
