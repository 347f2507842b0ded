//! `sheer devices`: the GPUs of this machine and what they can run.

use sheer_gpu::{AdapterReport, GpuError, GpuPath, GpuPathChoice, adapters};

use crate::{
    args::DevicesArguments,
    graphics,
    output::{self, TextOutput},
    report::{
        json::{self, Device, Devices},
        table::Table,
    },
    version::{COMMIT, VERSION},
};

pub(crate) fn run(arguments: &DevicesArguments) -> anyhow::Result<()> {
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let adapters = graphics::guarded(graphics::LISTING, || Ok(adapters()))?;
    let devices: Vec<Device> = adapters.into_iter().enumerate().map(device).collect();
    if devices.is_empty() {
        return Err(GpuError::NoAdapter { problem: "no adapter was found".to_owned() }.into());
    }
    let report = Devices { version: VERSION, commit: COMMIT, devices };
    if let Some(output) = &json {
        output.write(&json::text(&report)?)?;
        if output.is_stdout() {
            return Ok(());
        }
    }
    output::print(&table(&report.devices).text())
}

fn device((index, report): (usize, AdapterReport)) -> Device {
    let supported = GpuPath::supported_by(&report);
    let AdapterReport { name, kind, driver, api, ray_query, timestamps, msaa, max_storage_bytes, .. } =
        report;
    // Without ray query, rays go through our own tree, and by themselves methods are drawn.
    let preferred = if ray_query { GpuPath::Ray } else { GpuPath::Raster };
    let automatic = supported.iter().copied().find(|path| *path == preferred).map(word);
    let paths: Vec<_> = supported.into_iter().map(word).collect();
    Device {
        index,
        name,
        kind,
        driver,
        api,
        ray_query,
        timestamps,
        msaa,
        max_storage_bytes,
        paths,
        automatic,
    }
}

fn table(devices: &[Device]) -> Table {
    let titles = ["#", "name", "type", "api", "driver", "ray query", "timestamps", "MSAA", "--backend gpu"];
    let mut table = Table::new(&titles);
    let yes_or_no = |is_so: bool| if is_so { "yes" } else { "no" }.to_owned();
    for device in devices {
        let msaa: Vec<String> = device.msaa.iter().map(|samples| format!("×{samples}")).collect();
        table.add(vec![
            device.index.to_string(),
            device.name.clone(),
            device.kind.to_owned(),
            device.api.clone(),
            device.driver.clone(),
            yes_or_no(device.ray_query),
            yes_or_no(device.timestamps),
            if msaa.is_empty() { "–".to_owned() } else { msaa.join(" ") },
            backends(device),
        ]);
    }
    table
}

/// The word of `--backend`.
fn word(path: GpuPath) -> &'static str {
    match path {
        GpuPath::Ray => GpuPathChoice::Ray.name(),
        GpuPath::Raster => GpuPathChoice::Raster.name(),
    }
}

/// What `--backend gpu` is, and what is to be had by asking for it.
fn backends(device: &Device) -> String {
    let others = device.paths.iter().filter(|path| Some(**path) != device.automatic);
    let others: Vec<_> = others.map(|path| format!("{path} too")).collect();
    match (device.automatic, others.as_slice()) {
        (None, []) => "none".to_owned(),
        (None, _) => others.join(", "),
        (Some(automatic), []) => automatic.to_owned(),
        (Some(automatic), _) => format!("{automatic} ({})", others.join(", ")),
    }
}
