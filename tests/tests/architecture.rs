//! The dependency table of docs/ARCHITECTURE.md against what Cargo builds.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use relievo_tests::{text, workspace};

/// Graphics and window crates, which nothing in core may reach.
const FORBIDDEN_IN_CORE: [&str; 5] = ["wgpu", "naga", "winit", "egui", "eframe"];

/// Rooms outside the table: nothing may depend on them.
const OUTSIDE: [&str; 2] = ["tests", "xtask"];

type Table = BTreeMap<String, BTreeSet<String>>;

/// Rows of the table with the head `| room | may depend on |`.
fn allowed() -> Table {
    let page = text("docs/ARCHITECTURE.md");
    let rows = page
        .lines()
        .skip_while(|line| *line != "| room | may depend on |")
        .skip(2);
    let table: Table = rows
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            let [room, others] = cells[..] else {
                panic!("two cells expected: {line}")
            };
            let others = others
                .split(',')
                .map(str::trim)
                .filter(|other| !other.is_empty());
            (room.to_owned(), others.map(str::to_owned).collect())
        })
        .collect();
    assert!(
        !table.is_empty(),
        "docs/ARCHITECTURE.md has lost its dependency table"
    );
    table
}

fn members() -> Metadata {
    let manifest = workspace().join("Cargo.toml");
    MetadataCommand::new()
        .manifest_path(manifest)
        .no_deps()
        .exec()
        .expect("cargo metadata reads the workspace")
}

/// A member's room: the name of its folder.
fn room(package: &Package) -> String {
    let folder = package
        .manifest_path
        .parent()
        .and_then(|folder| folder.file_name());
    folder.expect("a member lies in a folder").to_owned()
}

/// What each room's packages name as ordinary or build dependencies among the members.
fn actual(metadata: &Metadata) -> Table {
    let rooms: BTreeMap<String, String> = metadata
        .packages
        .iter()
        .map(|package| (package.name.to_string(), room(package)))
        .collect();
    metadata
        .packages
        .iter()
        .map(|package| {
            let named = package
                .dependencies
                .iter()
                .filter(|d| d.kind != DependencyKind::Development);
            (
                room(package),
                named.filter_map(|d| rooms.get(&d.name).cloned()).collect(),
            )
        })
        .collect()
}

/// A room's row and, transitively, the rows of those in it.
fn closure(table: &Table, room: &str) -> BTreeSet<String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![room.to_owned()];
    while let Some(next) = open.pop() {
        for other in table.get(&next).into_iter().flatten() {
            if reached.insert(other.clone()) {
                open.push(other.clone());
            }
        }
    }
    reached
}

#[test]
fn every_dependency_between_rooms_is_allowed_by_the_table() {
    let allowed = allowed();
    for (room, named) in actual(&members()) {
        if OUTSIDE.contains(&room.as_str()) {
            continue;
        }
        assert!(
            allowed.contains_key(&room),
            "{room} has no row in docs/ARCHITECTURE.md"
        );
        let may = closure(&allowed, &room);
        let extra: Vec<_> = named.difference(&may).collect();
        assert!(extra.is_empty(), "{room} may not depend on {extra:?}");
    }
}

#[test]
fn every_entry_of_the_table_is_a_dependency() {
    let actual = actual(&members());
    for (room, named) in allowed() {
        let used = actual
            .get(&room)
            .unwrap_or_else(|| panic!("the table names {room}, which is no member"));
        let stale: Vec<_> = named.difference(used).collect();
        assert!(
            stale.is_empty(),
            "docs/ARCHITECTURE.md says that {room} depends on {stale:?}: it does not"
        );
    }
}

#[test]
fn the_table_has_no_cycle() {
    let table = allowed();
    for room in table.keys() {
        assert!(
            !closure(&table, room).contains(room),
            "{room} reaches itself"
        );
    }
}

/// Names that each package of the lock file depends on, tests of members included. The lock file
/// covers all platforms and features, so it can only name too many.
fn locked() -> Table {
    let lock = text("Cargo.lock");
    let mut table = Table::new();
    for package in lock.split("[[package]]").skip(1) {
        let mut name = None;
        let mut dependencies = BTreeSet::new();
        for line in package.lines() {
            if let Some(value) = line.strip_prefix("name = ") {
                name = Some(value.trim_matches('"').to_owned());
            } else if line.starts_with(" \"") {
                // A name, followed by a version where there are several.
                let entry = line.trim_matches([' ', '"', ',']);
                dependencies.extend(entry.split(' ').next().map(str::to_owned));
            }
        }
        table
            .entry(name.expect("a locked package has a name"))
            .or_default()
            .extend(dependencies);
    }
    table
}

#[test]
fn core_reaches_no_graphics_and_no_window_crate_not_even_in_tests() {
    let locked = locked();
    let metadata = members();
    let core: Vec<_> = metadata
        .packages
        .iter()
        .filter(|p| {
            p.manifest_path
                .as_str()
                .replace('\\', "/")
                .contains("/core/")
        })
        .collect();
    assert!(core.len() >= 6, "core has six crates, found {}", core.len());
    for package in core {
        let reached = closure(&locked, &package.name);
        assert!(
            !reached.is_empty(),
            "{} is missing in Cargo.lock",
            package.name
        );
        for forbidden in FORBIDDEN_IN_CORE {
            assert!(
                !reached.contains(forbidden),
                "{} reaches {forbidden}",
                package.name
            );
        }
    }
}

#[test]
fn nothing_depends_on_tests_or_tasks() {
    for (room, named) in actual(&members()) {
        assert!(
            OUTSIDE.iter().all(|outside| !named.contains(*outside)),
            "{room} depends on {named:?}"
        );
    }
}
