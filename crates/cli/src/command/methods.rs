//! `sheer methods`: the transparency methods; with `--long` the anti-aliasing and shadow techniques, too.

use sheer_core::parameter::ParameterInfo;
use sheer_render::{
    contract::{Memory, MethodInfo},
    method::{METHODS, Method, MethodError},
    shadow::SHADOWS,
    temporal::ANTIALIASINGS,
};

use crate::{
    args::ListArguments,
    output,
    report::listing::{Entry, Parameter, listing},
};

pub(crate) fn run(arguments: &ListArguments) -> anyhow::Result<()> {
    let entry = |info: &MethodInfo| {
        let method = info.id.parse::<Method>()?;
        let remarks = vec![("bias", info.bias.to_owned()), ("memory", in_words(method.memory()))];
        Ok(described(info.id, info.title, info.paper, remarks, &method.parameters()))
    };
    let entries = METHODS.iter().map(entry).collect::<Result<Vec<_>, MethodError>>()?;
    let mut text = listing(&entries, arguments.long);
    if arguments.long {
        let shadow = SHADOWS.iter().map(|info| {
            let remarks = vec![("bias", info.bias.to_owned())];
            described(info.id, info.title, info.paper, remarks, info.parameters)
        });
        let antialiasing = ANTIALIASINGS.iter().map(|info| {
            let remarks = vec![("keeps of a pixel", info.stores.to_owned())];
            described(info.id, info.title, info.paper, remarks, info.parameters)
        });
        text += "\nAnti-aliasing, set with -a:\n\n";
        text += &listing(&antialiasing.collect::<Vec<_>>(), true);
        text += "\nShadow techniques, set with --shadow:\n\n";
        text += &listing(&shadow.collect::<Vec<_>>(), true);
    }
    output::print(&text)
}

fn described(
    name: &'static str,
    title: &'static str,
    source: &'static str,
    remarks: Vec<(&'static str, String)>,
    parameters: &[ParameterInfo],
) -> Entry {
    let parameters = parameters.iter().map(|known| Parameter {
        key: known.key,
        default: known.default,
        range: known.range.to_string(),
        what: known.what,
    });
    Entry { name, title, source, parameters: parameters.collect(), remarks }
}

/// What a method stores with the parameters that it has by default.
fn in_words(memory: Memory) -> String {
    match memory {
        Memory::Bounded(0) => "none beyond colour and depth".to_owned(),
        Memory::Bounded(bytes) => format!("{bytes} bytes a pixel"),
        Memory::PerFragment(bytes) => format!("{bytes} bytes a fragment, without bound"),
    }
}
