//! Finds out what is missing on this machine and installs it where that is allowed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::packages::{self, Display, Installer, Plan, Requirement};

/// How a window can reach the user of this process.
pub(crate) fn display() -> Display {
    let variable = |name| std::env::var(name).ok();
    Display::detect(
        std::env::consts::OS,
        variable("DISPLAY").as_deref(),
        variable("WAYLAND_DISPLAY").as_deref(),
    )
}

/// Sets up what a task needs, announcing each installation.
///
/// # Errors
/// If something is missing and may not be, or could not be, installed; the message says what and
/// how to get it.
pub(crate) fn ensure(gpu: bool, window: Display) -> Result<()> {
    // Other systems bring graphics themselves, and Rust's installer asks for a linker there.
    if std::env::consts::OS != "linux" {
        return Ok(());
    }
    let missing = missing(gpu, window);
    match packages::plan(
        &missing,
        if missing.is_empty() {
            Installer::None
        } else {
            installer()
        },
    ) {
        Plan::Ready => Ok(()),
        Plan::Tell(text) => bail!(text),
        Plan::Install { notice, commands } => {
            eprintln!("xtask: {notice}");
            for command in &commands {
                install(command)?;
            }
            let still = self::missing(gpu, window);
            if still.is_empty() {
                return Ok(());
            }
            let names: Vec<_> = still.iter().map(|item| item.what()).collect();
            bail!("still missing after the installation: {}", names.join(", "))
        }
    }
}

/// The requirements that this machine does not meet.
fn missing(gpu: bool, window: Display) -> Vec<Requirement> {
    let listing = ldconfig();
    let has_library = |soname: &str| {
        packages::ldconfig_lists(&listing, soname)
            || library_folders().any(|f| f.join(soname).exists())
    };
    let mut missing = packages::requirements(gpu, window);
    missing.retain(|item| match item {
        Requirement::CCompiler => !runs("cc", &["--version"]),
        Requirement::VulkanLoader => !has_library("libvulkan.so.1"),
        Requirement::VulkanDriver => !has_vulkan_driver(),
        Requirement::Library(library) => !has_library(library.soname()),
        Requirement::VirtualDisplay => !runs("Xvfb", &["-help"]),
    });
    missing
}

/// What the dynamic linker knows; empty where it cannot be asked.
fn ldconfig() -> String {
    // Users other than root often lack the sbin folders in their path.
    ["ldconfig", "/sbin/ldconfig", "/usr/sbin/ldconfig"]
        .iter()
        .find_map(|program| {
            Command::new(program)
                .arg("-p")
                .stderr(Stdio::null())
                .output()
                .ok()
        })
        .map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
        .unwrap_or_default()
}

/// Folders searched for libraries that `ldconfig` does not list.
fn library_folders() -> impl Iterator<Item = PathBuf> {
    let named = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let named: Vec<PathBuf> = std::env::split_paths(&named)
        .filter(|p| p.is_absolute())
        .collect();
    let known = [
        "/usr/lib64",
        "/usr/lib",
        "/usr/local/lib",
        "/run/opengl-driver/lib",
    ]
    .map(PathBuf::from);
    named.into_iter().chain(known)
}

/// Whether some Vulkan driver is registered, by file or by environment.
fn has_vulkan_driver() -> bool {
    let named = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"]
        .iter()
        .filter_map(std::env::var_os)
        .any(|files| std::env::split_paths(&files).any(|file| file.is_file()));
    let folders = [
        "/usr/share/vulkan/icd.d",
        "/usr/local/share/vulkan/icd.d",
        "/etc/vulkan/icd.d",
        "/run/opengl-driver/share/vulkan/icd.d",
    ];
    named || folders.iter().any(|folder| holds_json(Path::new(folder)))
}

fn holds_json(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|entries| {
        entries
            .flatten()
            .any(|e| e.path().extension().is_some_and(|x| x == "json"))
    })
}

/// How packages may be installed here.
fn installer() -> Installer {
    let os_release = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
    if !packages::is_debian_family(&os_release) || !runs("apt-get", &["--version"]) {
        return Installer::None;
    }
    let user = Command::new("id")
        .arg("-u")
        .output()
        .map(|o| o.stdout)
        .unwrap_or_default();
    if user.trim_ascii() == b"0" {
        Installer::Apt
    } else if runs("sudo", &["-n", "true"]) {
        Installer::SudoApt
    } else {
        Installer::AptForbidden
    }
}

/// Whether a program exists and ends well.
pub(crate) fn runs(program: &str, arguments: &[&str]) -> bool {
    Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

fn install(command: &[String]) -> Result<()> {
    let line = command.join(" ");
    eprintln!("xtask: {line}");
    let (program, arguments) = command
        .split_first()
        .context("a plan's commands name a program")?;
    let status = Command::new(program)
        .args(arguments)
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null())
        .status()
        .with_context(|| format!("cannot start `{line}`"))?;
    if !status.success() {
        bail!("`{line}` ended with {status}");
    }
    Ok(())
}
