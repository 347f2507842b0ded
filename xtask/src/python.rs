//! Python packages for tests and measurements, in environments below the target folder.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use anyhow::Context as _;

use crate::workspace::call;

/// Whether there is a Python that makes environments; Debian's lacks it where `python3-venv` is not
/// installed.
pub(crate) fn is_there() -> bool {
    let mut command = Command::new("python3");
    command.args(["-c", "import ensurepip, venv"]).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// The Python of an environment with the packages of a file of requirements, which are installed if they are
/// not there.
pub(crate) fn with_packages(environment: &Path, requirements: &Path) -> anyhow::Result<PathBuf> {
    let python = environment.join("bin/python");
    let wanted = fs::read(requirements).with_context(|| requirements.display().to_string())?;
    let installed = environment.join("requirements.txt");
    if fs::read(&installed).is_ok_and(|there| there == wanted) {
        return Ok(python);
    }
    call("python3", &["-m", "venv", &environment.display().to_string()])?;
    let file = requirements.display().to_string();
    call(&python.display().to_string(), &["-m", "pip", "install", "--quiet", "--requirement", &file])?;
    // Last, so that what was interrupted is done again.
    fs::write(installed, wanted)?;
    Ok(python)
}
