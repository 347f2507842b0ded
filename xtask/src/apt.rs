//! Debian's package manager, and the rights that it takes.

use std::process::Command;

use anyhow::ensure;

/// Runs apt-get without questions, with the rights that it takes.
pub(crate) fn apt_get(arguments: &[&str]) -> anyhow::Result<()> {
    eprintln!("$ apt-get {}", arguments.join(" "));
    let mut command = as_root("env")?;
    let status = command.args(["DEBIAN_FRONTEND=noninteractive", "apt-get"]).args(arguments).status()?;
    ensure!(status.success(), "apt-get {} failed", arguments.join(" "));
    Ok(())
}

/// Lets sudo ask for a password now and remember it.
pub(crate) fn authorise() -> anyhow::Result<()> {
    if !is_root()? {
        let status = Command::new("sudo").arg("--validate").status()?;
        ensure!(status.success(), "installing packages takes the rights of the administrator");
    }
    Ok(())
}

/// A program with the rights of the administrator.
pub(crate) fn as_root(program: &str) -> anyhow::Result<Command> {
    if is_root()? {
        return Ok(Command::new(program));
    }
    let mut command = Command::new("sudo");
    command.arg(program);
    Ok(command)
}

fn is_root() -> anyhow::Result<bool> {
    Ok(Command::new("id").arg("-u").output()?.stdout == b"0\n")
}
