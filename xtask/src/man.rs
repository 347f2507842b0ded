//! `cargo xtask man`: the manual pages of the program.

use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;

use crate::workspace::{call, release_binary, target};

/// Write the manual pages.
#[derive(Args)]
pub(crate) struct Man {
    /// Where they go; target/man if not given. `man -l target/man/sheer-render.1` shows one.
    folder: Option<PathBuf>,
}

impl Man {
    /// The parser is the program's own, so the program writes them.
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        call("cargo", &["build", "--release", "--package", "sheer"])?;
        let folder = self.folder.clone().unwrap_or_else(|| target().join("man"));
        let [program, folder] = [release_binary(), folder].map(|path| path.into_os_string().into_string());
        let not_unicode = |_| anyhow::anyhow!("paths have to be Unicode");
        call(&program.map_err(not_unicode)?, &["man", &folder.map_err(not_unicode)?])
            .context("the pages are written by `sheer man`")
    }
}
