//! `sheer methods`: the transparency methods.

use sheer_render::method::METHODS;

use crate::{
    args::ListArguments,
    output,
    report::listing::{Entry, Parameter, listing},
};

pub(crate) fn run(arguments: &ListArguments) -> anyhow::Result<()> {
    let entries = METHODS.iter().map(|info| Entry {
        name: info.id,
        title: info.title,
        source: info.paper,
        parameters: (info.parameters.iter())
            .map(|known| Parameter {
                key: known.key,
                default: known.default,
                range: known.range.to_string(),
                what: known.what,
            })
            .collect(),
        remarks: vec![("bias", info.bias)],
    });
    output::print(&listing(&entries.collect::<Vec<_>>(), arguments.long))
}
