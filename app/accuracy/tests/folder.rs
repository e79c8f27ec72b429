//! A report as files.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use relievo_accuracy::write::{PAGE, to_folder};
use relievo_accuracy::{
    Chart, Content, Curve, Figure, Machine, Picture, Point, Report, Suite, SuiteError, Table,
};

const SUITE: Suite = Suite {
    name: "example",
    sentence: "What <tags> & quotes become.",
    run: |_| Err(SuiteError::Cancelled),
};

fn report() -> Report {
    let curve = Curve {
        name: "a, \"quoted\" name".to_owned(),
        points: vec![
            Point::new("slow", 20.0, 1e-7),
            Point::new("fast", 2.0, 1e-3),
            Point::new("useless", 30.0, 1e-3),
            Point::new("broken", 1.0, f64::INFINITY),
        ],
        joined: true,
    };
    let chart = Chart::trade("ns per sample", "error", "m", vec![curve]);
    let table = Table {
        head: vec!["what".to_owned(), "how far, m".to_owned()],
        rows: vec![vec!["a row".into(), (1.0 / 3.0).into()]],
    };
    let picture = Picture::from_rgba8(2, 1, &[0, 0, 0, 255, 255, 255, 255, 255], "A pixel & one");
    Report {
        summary: vec!["Plain words.".to_owned()],
        figures: vec![
            Figure::new("trade", "A trade", "Said once.", Content::Chart(chart)),
            Figure::new("rows", "Rows", "", Content::Table(table)),
            Figure::new("seen", "Seen", "", Content::Picture(picture.unwrap())),
        ],
    }
}

#[test]
fn each_figure_has_its_files_and_the_page_needs_none_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("made/when/missing");
    let machine = Machine::here(None);
    let paths = to_folder(&inner, &[(&SUITE, report())], &machine).unwrap();
    let names: Vec<&str> = paths
        .iter()
        .map(|path| path.file_name().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            PAGE,
            "fronts.csv",
            "example-trade.csv",
            "example-trade.svg",
            "example-rows.csv",
            "example-seen.png"
        ]
    );
    let page = std::fs::read_to_string(&paths[0]).unwrap();
    assert!(page.contains("What &lt;tags&gt; &amp; quotes become."));
    assert!(page.contains("data:image/png;base64,") && page.contains("alt=\"A pixel &amp; one\""));
    assert!(page.contains("<svg role=\"img\"") && page.contains("prefers-color-scheme: dark"));
    assert!(!page.contains("<script") && !page.contains("<link") && !page.contains("@import"));
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http"), "no network");
    assert_eq!(page.matches(&machine.commit).count(), 4, "each caption");
}

#[test]
fn tables_keep_every_digit_and_name_the_front() {
    let folder = tempfile::tempdir().unwrap();
    let machine = Machine::here(None);
    to_folder(folder.path(), &[(&SUITE, report())], &machine).unwrap();
    let csv = std::fs::read_to_string(folder.path().join("example-trade.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[2].contains(&machine.commit));
    assert!(lines[3].starts_with("curve,setting,\"run time, ns per sample\",\"error, m\""));
    assert_eq!(lines[4], "\"a, \"\"quoted\"\" name\",slow,20.0,1e-7,,,1");
    let fronts: Vec<char> = lines[4..].iter().filter_map(|l| l.chars().last()).collect();
    assert_eq!(fronts, ['1', '1', '0', '0']);
    let fronts = std::fs::read_to_string(folder.path().join("fronts.csv")).unwrap();
    assert_eq!(fronts.lines().count(), 4 + 2, "{fronts}");
    let rows = std::fs::read_to_string(folder.path().join("example-rows.csv")).unwrap();
    assert!(rows.ends_with("what,\"how far, m\"\na row,0.3333333333333333\n"));
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let error = to_folder(&file.join("inside"), &[], &Machine::here(None)).unwrap_err();
    assert!(error.to_string().contains("inside"), "{error}");
}
