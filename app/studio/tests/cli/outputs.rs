//! Where results go: never over what is read, never half, and a refusal in one line.

use std::path::PathBuf;

use crate::shared::{good, relievo_into, sample_file};

/// The line of a run that must end with a code.
fn line(arguments: &[&str], expected: u8) -> String {
    let (code, err) = relievo_into(arguments, &mut Vec::new());
    assert_eq!(code, expected, "{arguments:?}: {err}");
    assert_eq!(err.lines().count(), 1, "{arguments:?}: {err}");
    err
}

/// A folder with a source, a project of it and edits; their texts.
struct Desk {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().to_owned();
        std::fs::copy(sample_file("data/wasatch-dem.tif"), path.join("dem.tif")).unwrap();
        let project = r#"{"version": 1, "layers": [
            {"id": "dem", "kind": "height", "path": "dem.tif"},
            {"id": "hidden", "kind": "height", "path": "hidden.tif", "visible": false}]}"#;
        std::fs::write(path.join("p.relievo"), project).unwrap();
        std::fs::copy(sample_file("data/wasatch-dem.tif"), path.join("hidden.tif")).unwrap();
        std::fs::write(path.join("e.json"), "[]").unwrap();
        Self {
            _folder: folder,
            path,
        }
    }

    fn at(&self, name: &str) -> String {
        self.path.join(name).to_str().unwrap().to_owned()
    }

    /// All names and contents.
    fn all(&self) -> Vec<(PathBuf, Option<Vec<u8>>)> {
        let mut all: Vec<_> = std::fs::read_dir(&self.path)
            .unwrap()
            .map(|e| e.unwrap().path())
            .map(|p| (p.clone(), p.is_file().then(|| std::fs::read(p).unwrap())))
            .collect();
        all.sort();
        all
    }

    fn bake(&self, output: &str, code: u8) -> String {
        let project = self.at("p.relievo");
        let bounds = [
            "--bounds",
            "-111.7,40.2,-111.6,40.3",
            "--resolution",
            "0.01",
        ];
        let bake = ["bake", &project, "-o", output, "--output", "height"];
        line(&[&bake[..], &bounds[..]].concat(), code)
    }
}

#[test]
fn nothing_that_is_read_is_written_over() {
    let desk = Desk::new();
    let before = desk.all();
    for name in ["dem.tif", "hidden.tif"] {
        let told = desk.bake(&desk.at(name), 2);
        assert!(told.contains("inputs") && told.contains(name), "{told}");
        let (project, edits, output) = (desk.at("p.relievo"), desk.at("e.json"), desk.at(name));
        let told = line(&["apply", &project, &edits, "-o", &output], 2);
        assert!(told.contains("inputs") && told.contains(name), "{told}");
    }
    let (project, edits) = (desk.at("p.relievo"), desk.at("e.json"));
    line(&["apply", &project, &edits, "-o", &edits], 2);
    let source = desk.at("dem.tif");
    line(&["new", &source, "--source", &source], 2);
    // By another name it is the same file.
    let around = desk.at("../").trim_end_matches("../").to_owned() + "./dem.tif";
    desk.bake(&around, 2);
    assert_eq!(desk.all(), before);
}

#[test]
fn a_folder_or_a_socket_in_the_place_of_an_output_stays() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path.join("folder.tif")).unwrap();
    std::fs::create_dir(desk.path.join("folder.relievo")).unwrap();
    let before = desk.all();
    let told = desk.bake(&desk.at("folder.tif"), 2);
    assert!(told.contains("found a folder"), "{told}");
    let (project, edits) = (desk.at("p.relievo"), desk.at("e.json"));
    let folder = desk.at("folder.relievo");
    line(&["apply", &project, &edits, "-o", &folder], 2);
    assert_eq!(desk.all(), before);
    #[cfg(unix)]
    {
        let name = desk.at("socket.tif");
        let _listener = std::os::unix::net::UnixListener::bind(&name).unwrap();
        let told = desk.bake(&name, 2);
        assert!(
            told.contains("device") && told.contains("socket.tif"),
            "{told}"
        );
        line(&["apply", &project, &edits, "-o", &name], 1);
        let kind = std::fs::metadata(&name).unwrap().file_type();
        assert!(!kind.is_file(), "the socket is still there");
        assert_eq!(desk.all().len(), before.len() + 1, "nothing else is left");
    }
}

#[test]
fn a_folder_that_is_not_there_or_takes_nothing_is_told() {
    let desk = Desk::new();
    let before = desk.all();
    let told = desk.bake(&desk.at("nowhere/out.tif"), 1);
    assert!(told.contains("nowhere"), "{told}");
    let (project, edits) = (desk.at("p.relievo"), desk.at("e.json"));
    let output = desk.at("nowhere/out.relievo");
    line(&["apply", &project, &edits, "-o", &output], 1);
    // Nobody, not even the administrator, makes files there.
    if cfg!(target_os = "linux") {
        let told = desk.bake("/proc/out.tif", 1);
        assert!(told.contains("/proc/out.tif"), "{told}");
        line(&["apply", &project, &edits, "-o", "/proc/out.relievo"], 1);
    }
    assert_eq!(desk.all(), before);
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_do_not_fit_on_the_disk_are_told() {
    let desk = Desk::new();
    let project = desk.at("p.relievo");
    let source = desk.at("dem.tif");
    for arguments in [
        &["schema"][..],
        &["info", &source],
        &["info", &source, "--json"],
        &["info", &project],
        &["check", &project],
        &["check", &project, "--json"],
        &["sample", &project, "--at", "-111.65,40.25"],
        &["--help"],
    ] {
        let mut full = std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let (code, err) = relievo_into(arguments, &mut full);
        assert_eq!(code, 1, "{arguments:?}: {err}");
        assert!(
            err.contains("cannot write the result") && err.lines().count() == 1,
            "{err}"
        );
    }
}

#[cfg(unix)]
#[test]
fn a_file_without_permission_is_told() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::new();
    let none = std::fs::Permissions::from_mode(0o000);
    for name in ["dem.tif", "p.relievo", "e.json"] {
        std::fs::set_permissions(desk.path.join(name), none.clone()).unwrap();
    }
    if std::fs::File::open(desk.path.join("dem.tif")).is_ok() {
        // The administrator reads everything: there is nothing to be seen.
        return;
    }
    let told = line(&["info", &desk.at("dem.tif")], 2);
    assert!(told.contains("dem.tif"), "{told}");
    line(&["check", &desk.at("p.relievo")], 2);
}

#[test]
fn what_is_synthesised_is_left_out_of_a_bake_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let layers = |detail: &str| {
        let dem = sample_file("data/wasatch-dem.tif");
        format!(
            r#"{{"version": 1, "layers": [
                {{"id": "dem", "kind": "height", "path": {dem:?}}}{detail}]}}"#
        )
    };
    let detail = r#", {"id": "finer", "kind": "detail"}"#;
    std::fs::write(path("finer.relievo"), layers(detail)).unwrap();
    std::fs::write(path("plain.relievo"), layers("")).unwrap();
    let bake = |project: &str, out: &str, more: &[&str]| {
        let (project, out) = (path(project), path(out));
        let fixed = [
            "bake",
            &project,
            "-o",
            &out,
            "--output",
            "height",
            "--bounds=-111.60,40.30,-111.59,40.31",
            "--resolution=0.0001",
        ];
        good(&[&fixed[..], more].concat());
        std::fs::read(out).unwrap()
    };
    let plain = bake("plain.relievo", "plain.tif", &[]);
    let finer = bake("finer.relievo", "finer.tif", &[]);
    let measured = bake("finer.relievo", "measured.tif", &["--without-detail"]);
    assert!(measured == plain, "the data alone");
    assert!(finer != plain, "detail is there without the flag");
}
