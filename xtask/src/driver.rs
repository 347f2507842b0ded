//! A Vulkan driver that traces rays, for machines without one: Mesa's software driver, lavapipe.

use std::{
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use anyhow::{Context as _, bail, ensure};

use crate::apt::{apt_get, as_root};

/// Where drivers tell the Vulkan loader of themselves.
const DRIVER_FOLDERS: [&str; 2] = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
/// How the files of Mesa's drivers begin; another vendor's trace rays or have no better version in a package.
const MESA_DRIVERS: [&str; 10] = [
    "asahi",
    "broadcom",
    "freedreno",
    "gfxstream",
    "intel",
    "lvp",
    "nouveau",
    "panfrost",
    "radeon",
    "virtio",
];
/// The loader and the drivers.
const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];
/// The release of Debian whose own Mesa, 22.3, knows no ray query.
const OLD_RELEASE: &str = "bookworm";
/// Its suite with Mesa 25.
const BACKPORTS: &str = "bookworm-backports";
/// The first Mesa that is known to be right.
const LEAST_MESA: u32 = 25;
/// Where the suite is written to.
const BACKPORTS_FILE: &str = "/etc/apt/sources.list.d/bookworm-backports.sources";

/// Installs the driver if there is none that traces rays, and returns whether it did. For systems with apt.
pub(crate) fn install() -> anyhow::Result<bool> {
    if is_there() {
        return Ok(false);
    }
    let is_old_release = is_old_release();
    let mut arguments = vec!["install", "--yes", "--no-install-recommends"];
    if is_old_release {
        add_backports()?;
        arguments.extend(["--target-release", BACKPORTS]);
    }
    apt_get(&["update"])?;
    apt_get(&[arguments.as_slice(), &PACKAGES].concat())?;
    Ok(true)
}

/// Whether there is one.
pub(crate) fn is_there() -> bool {
    let is_old_release = is_old_release();
    has_driver(&driver_files(), is_old_release.then(mesa_version).flatten().as_deref(), is_old_release)
}

fn is_old_release() -> bool {
    fs::read_to_string("/etc/os-release").is_ok_and(|text| is_bookworm(&text))
}

/// Whether a driver is there that is new enough. `mesa`: the version of Mesa's package.
fn has_driver(files: &[String], mesa: Option<&str>, is_old_release: bool) -> bool {
    let is_mesa = |file: &&String| MESA_DRIVERS.iter().any(|driver| file.starts_with(driver));
    let has_other = files.iter().any(|file| !is_mesa(&file));
    let is_new = || mesa.and_then(major).is_some_and(|version| version >= LEAST_MESA);
    has_other || (!files.is_empty() && (!is_old_release || is_new()))
}

/// Names of the files that describe drivers.
fn driver_files() -> Vec<String> {
    let folders = DRIVER_FOLDERS.iter().filter_map(|folder| fs::read_dir(folder).ok());
    let names = folders.flatten().flatten().filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| name.ends_with(".json")).collect()
}

/// The version of Mesa's Vulkan drivers as the package manager has it.
fn mesa_version() -> Option<String> {
    let query = Command::new("dpkg-query").args(["--show", "--showformat=${Version}", PACKAGES[0]]).output();
    query.ok().and_then(|output| String::from_utf8(output.stdout).ok())
}

/// The number before the first dot of a package's version, an epoch aside.
fn major(version: &str) -> Option<u32> {
    let version = version.split_once(':').map_or(version, |(_, version)| version);
    version.split('.').next()?.trim().parse().ok()
}

fn is_bookworm(os_release: &str) -> bool {
    let value = |key: &str| {
        let mut values = os_release.lines().filter_map(|line| line.strip_prefix(key)?.strip_prefix('='));
        values.next().map(|value| value.trim_matches('"'))
    };
    value("ID") == Some("debian") && value("VERSION_CODENAME") == Some(OLD_RELEASE)
}

/// Packages from one place, as apt knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Source {
    uri: String,
    suites: Vec<String>,
    components: Vec<String>,
    /// A key's file or the key itself, as it is written there.
    signed_by: Option<String>,
}

impl Source {
    fn has_suite(&self, suite: &str) -> bool {
        self.suites.iter().any(|known| known == suite)
    }
}

/// Adds the suite with new drivers, from where the machine's own packages come.
fn add_backports() -> anyhow::Result<()> {
    let sources = machine_sources()?;
    if sources.iter().any(|source| source.has_suite(BACKPORTS)) {
        return Ok(());
    }
    let Some(own) = own_source(&sources) else {
        bail!("no apt source has the suite {OLD_RELEASE}; install {} 25 or newer by hand", PACKAGES[0]);
    };
    eprintln!("$ write {BACKPORTS_FILE}");
    let mut tee = as_root("tee")?.arg(BACKPORTS_FILE).stdin(Stdio::piped()).stdout(Stdio::null()).spawn()?;
    tee.stdin.take().context("tee reads nothing")?.write_all(backports(own).as_bytes())?;
    ensure!(tee.wait()?.success(), "cannot write {BACKPORTS_FILE}");
    Ok(())
}

/// The release's own source. Others use its name for a suite as well, but none has its updates.
fn own_source(sources: &[Source]) -> Option<&Source> {
    let updates = format!("{OLD_RELEASE}-updates");
    let has_updates =
        |uri: &str| sources.iter().any(|source| source.uri == uri && source.has_suite(&updates));
    let is_main = |source: &&Source| {
        source.has_suite(OLD_RELEASE) && source.components.iter().any(|component| component == "main")
    };
    let mut own = sources.iter().filter(is_main);
    own.clone().find(|source| has_updates(&source.uri)).or_else(|| own.next())
}

/// The text of a source file for the suite beside a source.
fn backports(own: &Source) -> String {
    let uri = &own.uri;
    let mut text = format!("Types: deb\nURIs: {uri}\nSuites: {BACKPORTS}\nComponents: main\n");
    if let Some(key) = &own.signed_by {
        text += &format!("Signed-By:{}{key}\n", if key.starts_with('\n') { "" } else { " " });
    }
    text
}

/// What apt takes packages from.
fn machine_sources() -> anyhow::Result<Vec<Source>> {
    let mut files = vec![PathBuf::from("/etc/apt/sources.list")];
    if let Ok(folder) = fs::read_dir("/etc/apt/sources.list.d") {
        files.extend(folder.flatten().map(|entry| entry.path()));
    }
    files.sort();
    let mut sources = Vec::new();
    for file in files.iter().filter(|file| file.is_file()) {
        let read = || fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()));
        match Path::new(file).extension().and_then(|extension| extension.to_str()) {
            Some("list") => sources.extend(read()?.lines().filter_map(from_line)),
            Some("sources") => sources.extend(from_stanzas(&read()?)),
            _ => {}
        }
    }
    Ok(sources)
}

/// A line of the one-line style, `deb [option=value …] uri suite component …` (sources.list(5)).
fn from_line(line: &str) -> Option<Source> {
    let line = line.split('#').next()?.trim().strip_prefix("deb")?;
    let line = line.strip_prefix([' ', '\t'])?.trim_start();
    let (options, rest) = match line.strip_prefix('[') {
        Some(line) => line.split_once(']')?,
        None => ("", line),
    };
    let key = options.split_whitespace().find_map(|option| option.strip_prefix("signed-by="));
    let mut words = rest.split_whitespace().map(str::to_owned);
    Some(Source {
        uri: words.next()?,
        suites: vec![words.next()?],
        components: words.collect(),
        signed_by: key.map(str::to_owned),
    })
}

/// The stanzas of the deb822 style, one source for each address (sources.list(5)).
fn from_stanzas(text: &str) -> Vec<Source> {
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    lines.split(|line| line.trim().is_empty()).flat_map(from_stanza).collect()
}

fn from_stanza(lines: &[&str]) -> Vec<Source> {
    // A line that begins with a blank goes on with the field above it.
    let mut fields: Vec<(String, String)> = Vec::new();
    for line in lines {
        if line.starts_with([' ', '\t']) {
            if let Some((_, value)) = fields.last_mut() {
                *value += &format!("\n{line}");
            }
        } else if let Some((name, value)) = line.split_once(':') {
            fields.push((name.to_ascii_lowercase(), value.trim().to_owned()));
        }
    }
    let field = |name: &str| fields.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str());
    let words = |name: &str| {
        let words = field(name).unwrap_or_default().split_whitespace();
        words.map(str::to_owned).collect::<Vec<_>>()
    };
    let is_off = field("enabled").is_some_and(|value| matches!(value, "no" | "false" | "off" | "0"));
    if is_off || !words("types").iter().any(|kind| kind == "deb") {
        return Vec::new();
    }
    let source = |uri: String| Source {
        uri,
        suites: words("suites"),
        components: words("components"),
        signed_by: field("signed-by").map(str::to_owned),
    };
    words("uris").into_iter().map(source).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STANZAS: &str = "Types: deb\n# an older state: http://old.example/debian\nURIs: http://mirror.example/debian\n\
        Suites: bookworm bookworm-updates\nComponents: main\nSigned-By: /usr/share/keyrings/a.gpg\n\n\
        Types: deb-src\nURIs: http://sources.example/debian\nSuites: bookworm\nComponents: main\n\n\
        Enabled: no\nTypes: deb\nURIs: http://off.example/debian\nSuites: bookworm\nComponents: main\n";

    #[test]
    fn a_stanza_is_read_and_what_is_off_or_without_binaries_is_not() {
        let sources = from_stanzas(STANZAS);
        assert_eq!(sources.len(), 1, "{sources:?}");
        assert_eq!(sources[0].uri, "http://mirror.example/debian");
        assert_eq!(sources[0].suites, ["bookworm", "bookworm-updates"]);
        assert_eq!(sources[0].signed_by.as_deref(), Some("/usr/share/keyrings/a.gpg"));
    }

    #[test]
    fn a_line_is_read_with_its_options() {
        let source = from_line(
            "deb [arch=amd64 signed-by=/a.gpg] http://mirror.example/debian bookworm main contrib # own",
        );
        let source = source.unwrap();
        assert_eq!(
            (source.uri.as_str(), source.suites[0].as_str()),
            ("http://mirror.example/debian", "bookworm")
        );
        assert_eq!(source.components, ["main", "contrib"]);
        assert_eq!(source.signed_by.as_deref(), Some("/a.gpg"));
        for line in
            ["", "# deb http://a.example b main", "deb-src http://a.example b main", "deb http://a.example"]
        {
            assert_eq!(from_line(line), None, "{line}");
        }
    }

    #[test]
    fn the_suite_comes_from_where_the_release_itself_comes() {
        let mut sources = vec![from_line("deb http://vendor.example/tools bookworm main").unwrap()];
        assert_eq!(own_source(&sources), Some(&sources[0]));
        sources.extend(from_stanzas(STANZAS));
        let text = backports(own_source(&sources).unwrap());
        assert_eq!(
            text,
            "Types: deb\nURIs: http://mirror.example/debian\nSuites: bookworm-backports\nComponents: main\n\
             Signed-By: /usr/share/keyrings/a.gpg\n"
        );
        // What is written is read again.
        assert!(from_stanzas(&text)[0].has_suite(BACKPORTS));
        assert_eq!(own_source(&[]), None);
    }

    #[test]
    fn a_key_within_the_file_survives() {
        let text = "Types: deb\nURIs: http://a.example\nSuites: bookworm\nComponents: main\nSigned-By:\n -----BEGIN\n .\n abc\n";
        let source = &from_stanzas(text)[0];
        assert!(backports(source).ends_with("Signed-By:\n -----BEGIN\n .\n abc\n"), "{}", backports(source));
    }

    #[test]
    fn only_an_old_or_missing_driver_is_replaced() {
        let files = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let mesa = files(&["lvp_icd.x86_64.json", "intel_icd.json"]);
        assert!(!has_driver(&[], None, false) && !has_driver(&[], Some("25.0.7-2~bpo12+1"), true));
        assert!(has_driver(&mesa, None, false));
        assert!(has_driver(&mesa, Some("25.0.7-2~bpo12+1"), true));
        assert!(!has_driver(&mesa, Some("22.3.6-1+deb12u1"), true) && !has_driver(&mesa, None, true));
        assert!(has_driver(&files(&["nvidia_icd.json"]), None, true));
        assert_eq!((major("1:26.1"), major("")), (Some(26), None));
    }

    #[test]
    fn the_release_is_known_by_name_and_maker() {
        assert!(is_bookworm("ID=debian\nVERSION_CODENAME=bookworm\n"));
        assert!(is_bookworm("VERSION_CODENAME=\"bookworm\"\nID=\"debian\"\n"));
        assert!(!is_bookworm("ID=debian\nVERSION_CODENAME=trixie\n") && !is_bookworm("ID=ubuntu\n"));
    }
}
