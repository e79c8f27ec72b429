//! What the documentation promises about the code.

use std::collections::BTreeSet;

use cargo_metadata::MetadataCommand;
use relievo_tests::{files, text, workspace};

#[test]
fn every_crate_has_its_row_with_an_invariant() {
    let page = text("docs/ARCHITECTURE.md");
    let manifest = workspace().join("Cargo.toml");
    let metadata = MetadataCommand::new()
        .manifest_path(manifest)
        .no_deps()
        .exec()
        .unwrap();
    let head = "| folder | crate | job | **Invariant** | deliberately absent |";
    let rows: Vec<&str> = page
        .lines()
        .skip_while(|line| *line != head)
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .collect();
    for package in &metadata.packages {
        let folder = package
            .manifest_path
            .parent()
            .unwrap()
            .strip_prefix(&metadata.workspace_root)
            .unwrap();
        let start = format!(
            "| `{}/` | `{}` |",
            folder.as_str().replace('\\', "/"),
            package.name
        );
        let row = rows.iter().find(|row| row.starts_with(&start));
        let row = row
            .unwrap_or_else(|| panic!("docs/ARCHITECTURE.md has no row that starts with {start}"));
        let cells = row.trim_matches('|').split('|').map(str::trim);
        assert!(
            cells.clone().count() == 5 && cells.clone().all(|cell| !cell.is_empty()),
            "an empty cell: {row}"
        );
    }
}

/// Keys of sources, such as CH06, in the comments of a text: up to six letters, two digits, in
/// brackets.
fn source_keys(text: &str) -> BTreeSet<String> {
    let comments = text
        .lines()
        .filter_map(|line| line.split_once("//").map(|(_, comment)| comment));
    comments
        .flat_map(|comment| comment.split('[').skip(1))
        // Doc comments escape brackets, which would be links to code.
        .filter_map(|rest| {
            rest.split_once(']')
                .map(|(key, _)| key.trim_end_matches('\\'))
        })
        .filter(|key| {
            let letters = key.trim_end_matches(|c: char| c.is_ascii_digit());
            let starts_high = key.starts_with(|c: char| c.is_ascii_uppercase());
            starts_high
                && (2..=6).contains(&letters.len())
                && key.len() == letters.len() + 2
                && letters.chars().all(|c| c.is_ascii_alphabetic())
        })
        .map(str::to_owned)
        .collect()
}

#[test]
fn keys_are_found_in_comments_only() {
    let code = "let a = b[AB12]; // see [CH06] 4.1 and \\[Cra07\\], [`Type12`], [u32]\n/// [W3] no";
    assert_eq!(
        source_keys(code).into_iter().collect::<Vec<_>>(),
        ["CH06", "Cra07"]
    );
}

#[test]
fn every_source_that_code_names_is_listed() {
    let sources = text("docs/SOURCES.md");
    for path in files("", &["rs", "wgsl"])
        .iter()
        .filter(|path| *path != "tests/tests/docs.rs")
    {
        for key in source_keys(&text(path)) {
            assert!(
                sources.contains(&format!("**[{key}]**")),
                "{path} names [{key}], docs/SOURCES.md does not"
            );
        }
    }
}

#[test]
fn every_sample_project_is_in_the_readme_and_every_data_file_is_credited() {
    let readme = text("README.md");
    for path in files("projects", &["relievo"]) {
        assert!(readme.contains(&path), "README.md does not name {path}");
    }
    let credits = text("projects/data/CREDITS.md");
    for path in files("projects/data", &["tif", "jpg", "png", "exr", "geojson"]) {
        let name = path.rsplit('/').next().unwrap_or_default();
        assert!(
            credits.contains(&format!("| `{name}` |")),
            "CREDITS.md does not name {name}"
        );
    }
}

/// Targets of the links of a Markdown text that point into the repository.
fn links(markdown: &str) -> impl Iterator<Item = &str> {
    let targets = markdown
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
    targets.filter(|target| !target.contains("://") && !target.starts_with('#'))
}

#[test]
fn links_between_pages_lead_somewhere() {
    for page in files("", &["md"]) {
        let whole = workspace().join(&page);
        let folder = whole.parent().unwrap();
        for link in links(&text(&page)) {
            let target = link.split('#').next().unwrap_or_default();
            // Pictures are made by the program, from a build of these very files.
            if target.starts_with("docs/pictures/") {
                continue;
            }
            assert!(
                folder.join(target).exists(),
                "{page} links to {link}, which is not there"
            );
        }
    }
}

#[test]
fn every_decision_says_why_at_what_cost_and_what_would_reverse_it() {
    let pages = files("docs/decisions", &["md"]);
    for (index, page) in pages.iter().enumerate() {
        let name = page.rsplit('/').next().unwrap_or_default();
        assert!(
            name.starts_with(&format!("{:04}-", index + 1)),
            "decisions are numbered without gaps: {name}"
        );
        let body = text(page);
        for part in [
            "**Context.**",
            "**Choice.**",
            "**Cost.**",
            "**What would reverse it.**",
        ] {
            assert!(body.contains(part), "{page} lacks {part}");
        }
    }
}

#[test]
fn no_file_names_a_folder_of_somebodys_machine() {
    // Put together here, so that this file does not name them either.
    let folders = ["work", "root", "Users"].map(|folder| format!("/{folder}/"));
    let kinds = ["rs", "wgsl", "toml", "md", "relievo", "json", "snap"];
    for path in files("", &kinds) {
        let content = text(&path);
        for folder in &folders {
            let line = content
                .lines()
                .position(|line| line.contains(folder.as_str()));
            assert!(
                line.is_none(),
                "{path}:{} names {folder}",
                line.unwrap_or_default() + 1
            );
        }
    }
}
