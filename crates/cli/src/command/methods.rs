//! `sheer methods`: the transparency methods.

use sheer_render::{
    contract::MethodInfo,
    method::{METHODS, Method, MethodError},
};

use crate::{
    args::ListArguments,
    output,
    report::listing::{Entry, Parameter, listing},
};

pub(crate) fn run(arguments: &ListArguments) -> anyhow::Result<()> {
    let entry = |info: &MethodInfo| {
        let parameters = info.id.parse::<Method>()?.parameters();
        let parameters = parameters.into_iter().map(|known| Parameter {
            key: known.key,
            default: known.default,
            range: known.range.to_string(),
            what: known.what,
        });
        Ok(Entry {
            name: info.id,
            title: info.title,
            source: info.paper,
            parameters: parameters.collect(),
            remarks: vec![("bias", info.bias)],
        })
    };
    let entries = METHODS.iter().map(entry).collect::<Result<Vec<_>, MethodError>>()?;
    output::print(&listing(&entries, arguments.long))
}
