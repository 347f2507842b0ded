//! `sheer methods`: the transparency methods; with `--long` the shadow techniques, too.

use sheer_core::parameter::ParameterInfo;
use sheer_render::{
    contract::MethodInfo,
    method::{METHODS, Method, MethodError},
    shadow::SHADOWS,
};

use crate::{
    args::ListArguments,
    output,
    report::listing::{Entry, Parameter, listing},
};

pub(crate) fn run(arguments: &ListArguments) -> anyhow::Result<()> {
    let entry = |info: &MethodInfo| {
        let parameters = info.id.parse::<Method>()?.parameters();
        Ok(described(info.id, info.title, info.paper, info.bias, &parameters))
    };
    let entries = METHODS.iter().map(entry).collect::<Result<Vec<_>, MethodError>>()?;
    let mut text = listing(&entries, arguments.long);
    if arguments.long {
        let shadow =
            SHADOWS.iter().map(|info| described(info.id, info.title, info.paper, info.bias, info.parameters));
        text += "\nShadow techniques, set with --shadow:\n\n";
        text += &listing(&shadow.collect::<Vec<_>>(), true);
    }
    output::print(&text)
}

fn described(
    name: &'static str,
    title: &'static str,
    source: &'static str,
    bias: &'static str,
    parameters: &[ParameterInfo],
) -> Entry {
    let parameters = parameters.iter().map(|known| Parameter {
        key: known.key,
        default: known.default,
        range: known.range.to_string(),
        what: known.what,
    });
    Entry { name, title, source, parameters: parameters.collect(), remarks: vec![("bias", bias)] }
}
