//! What the tasks need from the system, and what to do about each thing that is missing.
//!
//! Pure: facts come in, a plan goes out; `setup` gathers the one and carries out the other.

/// Something a task needs that Cargo does not bring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Requirement {
    /// `cc`, which links every program and compiles the ZSTD library.
    CCompiler,
    /// The Vulkan loader.
    VulkanLoader,
    /// At least one Vulkan driver; the software one serves where there is no GPU.
    VulkanDriver,
    /// A shared library that a window opens at run time.
    Library(Library),
    /// `Xvfb`, a display in memory, in which tests open the real window.
    VirtualDisplay,
}

/// Shared libraries that a window opens at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Library {
    X11,
    X11Xcb,
    Xcursor,
    Xi,
    XkbcommonX11,
    WaylandClient,
    Xkbcommon,
}

/// Libraries of a window on X11.
const X11_WINDOW: [Library; 5] = [
    Library::X11,
    Library::X11Xcb,
    Library::Xcursor,
    Library::Xi,
    Library::XkbcommonX11,
];

/// Libraries of a window on Wayland.
const WAYLAND_WINDOW: [Library; 2] = [Library::WaylandClient, Library::Xkbcommon];

impl Library {
    /// Name under which the dynamic linker knows it.
    pub(crate) const fn soname(self) -> &'static str {
        match self {
            Self::X11 => "libX11.so.6",
            Self::X11Xcb => "libX11-xcb.so.1",
            Self::Xcursor => "libXcursor.so.1",
            Self::Xi => "libXi.so.6",
            Self::XkbcommonX11 => "libxkbcommon-x11.so.0",
            Self::WaylandClient => "libwayland-client.so.0",
            Self::Xkbcommon => "libxkbcommon.so.0",
        }
    }
}

impl Requirement {
    /// What is missing, for people.
    pub(crate) const fn what(self) -> &'static str {
        match self {
            Self::CCompiler => "a C compiler and linker (cc)",
            Self::VulkanLoader => "the Vulkan loader (libvulkan.so.1)",
            Self::VulkanDriver => "a Vulkan driver (no .json file in any vulkan/icd.d folder)",
            Self::Library(library) => library.soname(),
            Self::VirtualDisplay => "a display in memory (Xvfb)",
        }
    }

    /// Why it is needed, for people.
    pub(crate) const fn why(self) -> &'static str {
        match self {
            Self::CCompiler => "links every program, compiles the ZSTD decoder",
            Self::VulkanLoader => "finds the graphics driver",
            Self::VulkanDriver => "draws; the software driver serves where there is no GPU",
            Self::Library(Library::WaylandClient | Library::Xkbcommon) => {
                "opens the window on Wayland"
            }
            Self::Library(_) => "opens the window on X11",
            Self::VirtualDisplay => "holds the window that a test opens",
        }
    }

    /// Debian packages that bring it.
    pub(crate) const fn debian(self) -> &'static [&'static str] {
        match self {
            Self::CCompiler => &["gcc", "libc6-dev"],
            Self::VulkanLoader => &["libvulkan1"],
            Self::VulkanDriver => &["mesa-vulkan-drivers"],
            Self::Library(library) => match library {
                Library::X11 => &["libx11-6"],
                Library::X11Xcb => &["libx11-xcb1"],
                Library::Xcursor => &["libxcursor1"],
                Library::Xi => &["libxi6"],
                Library::XkbcommonX11 => &["libxkbcommon-x11-0"],
                Library::WaylandClient => &["libwayland-client0"],
                Library::Xkbcommon => &["libxkbcommon0"],
            },
            Self::VirtualDisplay => &["xvfb"],
        }
    }
}

/// How a window can reach the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Display {
    None,
    X11,
    Wayland,
    /// X11 in memory, which a test starts itself.
    Virtual,
    /// The system always has one (macOS, Windows).
    Native,
}

impl Display {
    /// From the operating system and the values of `DISPLAY` and `WAYLAND_DISPLAY`, of which an
    /// empty one counts as unset.
    pub(crate) fn detect(os: &str, x11: Option<&str>, wayland: Option<&str>) -> Self {
        let set = |value: Option<&str>| value.is_some_and(|v| !v.is_empty());
        if matches!(os, "macos" | "windows") {
            Self::Native
        } else if set(wayland) {
            Self::Wayland
        } else if set(x11) {
            Self::X11
        } else {
            Self::None
        }
    }
}

/// What a task needs.
pub(crate) fn requirements(gpu: bool, window: Display) -> Vec<Requirement> {
    let mut all = vec![Requirement::CCompiler];
    if gpu {
        all.extend([Requirement::VulkanLoader, Requirement::VulkanDriver]);
    }
    let libraries: &[Library] = match window {
        Display::None | Display::Native => &[],
        Display::X11 | Display::Virtual => &X11_WINDOW,
        Display::Wayland => &WAYLAND_WINDOW,
    };
    all.extend(libraries.iter().copied().map(Requirement::Library));
    if window == Display::Virtual {
        all.push(Requirement::VirtualDisplay);
    }
    all
}

/// How this process may install packages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Installer {
    /// `apt-get`, as root.
    Apt,
    /// `sudo -n apt-get`: sudo asks for no password.
    SudoApt,
    /// `apt-get` exists, but only somebody else may run it.
    AptForbidden,
    /// Another system.
    None,
}

/// What to do about missing requirements.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// Nothing is missing.
    Ready,
    /// Run these commands in this order, after `notice`.
    Install {
        notice: String,
        commands: Vec<Vec<String>>,
    },
    /// Nothing can be installed: say so.
    Tell(String),
}

/// Decides what to do about `missing`.
pub(crate) fn plan(missing: &[Requirement], installer: Installer) -> Plan {
    if missing.is_empty() {
        return Plan::Ready;
    }
    let list: String = missing
        .iter()
        .flat_map(|item| ["  ", item.what(), ": ", item.why(), "\n"])
        .collect();
    let mut packages: Vec<String> = Vec::new();
    for package in missing.iter().flat_map(|item| item.debian()) {
        if !packages.iter().any(|p| p == package) {
            packages.push((*package).to_owned());
        }
    }
    let names = packages.join(" ");
    let apt = |prefix: &[&str]| -> Vec<Vec<String>> {
        let command = |arguments: &[&str]| -> Vec<String> {
            prefix
                .iter()
                .chain(&["apt-get"])
                .chain(arguments)
                .map(|s| (*s).to_owned())
                .collect()
        };
        let mut install = command(&["install", "-y", "--no-install-recommends"]);
        install.extend(packages.iter().cloned());
        vec![command(&["update"]), install]
    };
    let notice = format!("this system lacks\n{list}installing with apt-get: {names}");
    match installer {
        Installer::Apt => Plan::Install {
            notice,
            commands: apt(&[]),
        },
        Installer::SudoApt => Plan::Install {
            notice,
            commands: apt(&["sudo", "-n"]),
        },
        Installer::AptForbidden => Plan::Tell(format!(
            "this system lacks\n{list}install it, then run this again:\n  \
             sudo apt-get install --no-install-recommends {names}"
        )),
        Installer::None => Plan::Tell(format!(
            "this system lacks\n{list}install it with the system's package manager, then run this again \
             (Debian's names: {names})"
        )),
    }
}

/// Whether an `os-release` file describes Debian or a system made from it.
pub(crate) fn is_debian_family(os_release: &str) -> bool {
    os_release
        .lines()
        .filter_map(|line| {
            line.strip_prefix("ID=")
                .or_else(|| line.strip_prefix("ID_LIKE="))
        })
        .flat_map(|value| value.trim_matches(['"', '\'']).split_whitespace())
        .any(|id| matches!(id, "debian" | "ubuntu"))
}

/// Whether `ldconfig -p` lists the library.
pub(crate) fn ldconfig_lists(output: &str, soname: &str) -> bool {
    output
        .lines()
        .any(|line| line.split_whitespace().next() == Some(soname))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_missing_needs_nothing_whoever_asks() {
        for installer in [
            Installer::Apt,
            Installer::SudoApt,
            Installer::AptForbidden,
            Installer::None,
        ] {
            assert_eq!(plan(&[], installer), Plan::Ready);
        }
    }

    #[test]
    fn root_on_debian_installs_only_what_is_missing_and_says_why_first() {
        let missing = [Requirement::VulkanDriver, Requirement::Library(Library::Xi)];
        let Plan::Install { notice, commands } = plan(&missing, Installer::Apt) else {
            panic!("root may install");
        };
        assert!(
            notice.contains("software driver") && notice.contains("libXi.so.6"),
            "{notice}"
        );
        assert_eq!(commands[0], ["apt-get", "update"]);
        assert_eq!(
            commands[1],
            [
                "apt-get",
                "install",
                "-y",
                "--no-install-recommends",
                "mesa-vulkan-drivers",
                "libxi6"
            ]
        );
    }

    #[test]
    fn sudo_never_stops_to_ask_for_a_password() {
        let Plan::Install { commands, .. } = plan(&[Requirement::CCompiler], Installer::SudoApt)
        else {
            panic!("sudo may install");
        };
        assert!(commands.iter().all(|c| c[..3] == ["sudo", "-n", "apt-get"]));
    }

    #[test]
    fn who_may_not_install_is_told_every_missing_thing_and_the_command() {
        let missing = requirements(true, Display::X11);
        let Plan::Tell(text) = plan(&missing, Installer::AptForbidden) else {
            panic!("nothing to install with");
        };
        assert!(
            missing.iter().all(|item| text.contains(item.what())),
            "{text}"
        );
        assert!(text.contains(
            "apt-get install --no-install-recommends gcc libc6-dev libvulkan1 mesa-vulkan-drivers libx11-6 \
             libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0"
        ));
        assert!(matches!(plan(&missing, Installer::None), Plan::Tell(_)));
    }

    #[test]
    fn tests_without_a_gpu_need_a_compiler_only() {
        assert_eq!(requirements(false, Display::None), [Requirement::CCompiler]);
    }

    #[test]
    fn only_a_window_needs_the_libraries_of_its_display() {
        let libraries = |display| {
            requirements(true, display)
                .iter()
                .filter(|r| matches!(r, Requirement::Library(_)))
                .count()
        };
        assert_eq!(libraries(Display::None), 0);
        assert_eq!(libraries(Display::X11), X11_WINDOW.len());
        assert_eq!(libraries(Display::Wayland), WAYLAND_WINDOW.len());
        assert_eq!(libraries(Display::Virtual), X11_WINDOW.len());
        let has_server = |d| requirements(true, d).contains(&Requirement::VirtualDisplay);
        assert!(has_server(Display::Virtual) && !has_server(Display::X11));
    }

    #[test]
    fn an_empty_display_variable_is_no_display() {
        assert_eq!(Display::detect("linux", Some(""), None), Display::None);
        assert_eq!(Display::detect("linux", Some(":0"), None), Display::X11);
        assert_eq!(
            Display::detect("linux", Some(":0"), Some("wayland-0")),
            Display::Wayland
        );
        assert_eq!(Display::detect("macos", None, None), Display::Native);
    }

    #[test]
    fn debian_ubuntu_and_their_children_are_recognised() {
        assert!(is_debian_family("NAME=x\nID=debian\n"));
        assert!(is_debian_family(
            "ID=linuxmint\nID_LIKE=\"ubuntu debian\"\n"
        ));
        assert!(!is_debian_family("ID=fedora\nVARIANT_ID=debian\n"));
    }

    #[test]
    fn a_library_is_found_by_its_whole_name() {
        let listing = "\tlibX11-xcb.so.1 (libc6,x86-64) => /lib/x86_64-linux-gnu/libX11-xcb.so.1\n";
        assert!(ldconfig_lists(listing, "libX11-xcb.so.1"));
        assert!(!ldconfig_lists(listing, "libX11.so.6"));
    }
}
