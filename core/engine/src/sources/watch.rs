//! When a file has to be opened again: what looks at its path find, and what they add up to.
//!
//! Knows no threads and no clock: time passes from look to look.

use std::io::ErrorKind;
use std::path::Path;
use std::time::SystemTime;

/// So many attempts at the same content of a file that was fine before may fail until it counts as
/// broken: programs pause while they write.
const PATIENCE: u32 = 3;

/// What a look at a path finds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// A file, as far as can be seen without reading it.
    File {
        length: u64,
        /// Systems without times of change have the length alone.
        modified: Option<SystemTime>,
    },
    /// None that could be read: one line that says why.
    Nothing(String),
}

impl Found {
    /// Looks at a path. May take long where a network does not answer.
    pub(super) fn at(path: &Path) -> Self {
        match std::fs::metadata(path) {
            Ok(metadata) => Self::File {
                length: metadata.len(),
                modified: metadata.modified().ok(),
            },
            Err(error) if error.kind() == ErrorKind::NotFound => {
                let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
                Self::Nothing(if folder.is_none_or(Path::exists) {
                    format!("expected a file, found nothing there: {path:?}")
                } else {
                    format!(
                        "expected a file, found not even its folder (is a disk missing?): {path:?}"
                    )
                })
            }
            Err(error) => Self::Nothing(format!("cannot read the file: {error}: {path:?}")),
        }
    }
}

/// What to do after a look.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Nothing, or not yet.
    Wait,
    /// The file has another content and nobody is writing to it any more.
    Reopen,
    /// The file is gone: one line.
    Lost(String),
}

/// How opening a file ended.
pub(super) struct Attempt {
    /// What was there before.
    pub(super) before: Found,
    /// What was there afterwards.
    pub(super) after: Found,
    /// Whether it is open.
    pub(super) opened: bool,
    /// Whether there is an open file to go on with meanwhile, and looks go on.
    pub(super) patient: bool,
}

/// What is known of a file's path.
#[derive(Clone, Debug, Default)]
pub(super) struct Watch {
    /// What was there when the file was last opened, or refused for good. `None`: it cannot be
    /// trusted, so that whatever is there is opened again.
    known: Option<Found>,
    /// Something else that the latest look found. It counts once two looks agree.
    other: Option<Found>,
    /// Attempts to open `other` that failed.
    failures: u32,
}

impl Watch {
    /// Takes in what a look found.
    pub(super) fn look(&mut self, found: Found) -> Step {
        if self.known.as_ref() == Some(&found) {
            (self.other, self.failures) = (None, 0);
            return Step::Wait;
        }
        if self.other.as_ref() != Some(&found) {
            (self.other, self.failures) = (Some(found), 0);
            return Step::Wait;
        }
        match &found {
            Found::File { .. } => Step::Reopen,
            Found::Nothing(reason) => {
                let lost = Step::Lost(reason.clone());
                (self.known, self.other) = (Some(found), None);
                lost
            }
        }
    }

    /// Takes in how opening the file ended. Says whether that is the last word; if not, later looks
    /// lead to another attempt.
    pub(super) fn tried(&mut self, attempt: Attempt) -> bool {
        let Attempt {
            before,
            after,
            opened,
            patient,
        } = attempt;
        if patient && before != after {
            (self.other, self.failures) = (Some(after), 0);
            return false;
        }
        if !opened && patient {
            self.failures += 1;
            if self.failures < PATIENCE {
                self.other = Some(after);
                return false;
            }
        }
        // Where it changed meanwhile, the next look finds another one than was opened.
        (self.known, self.other, self.failures) = (Some(before), None, 0);
        true
    }

    /// What was read of the file does not fit what was known of it.
    pub(super) fn distrust(&mut self) {
        self.known = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(length: u64) -> Found {
        Found::File {
            length,
            modified: None,
        }
    }

    fn attempt(before: u64, after: u64) -> Attempt {
        Attempt {
            before: file(before),
            after: file(after),
            opened: true,
            patient: true,
        }
    }

    fn nothing() -> Found {
        Found::Nothing("gone".to_owned())
    }

    fn opened(length: u64) -> Watch {
        let mut watch = Watch::default();
        assert!(watch.tried(attempt(length, length)));
        watch
    }

    #[test]
    fn a_file_that_stays_is_never_opened_again() {
        let mut watch = opened(1);
        for _ in 0..5 {
            assert_eq!(watch.look(file(1)), Step::Wait);
        }
    }

    #[test]
    fn a_file_that_is_being_written_is_left_alone_until_two_looks_agree() {
        let mut watch = opened(1);
        for length in 2..9 {
            assert_eq!(watch.look(file(length)), Step::Wait);
        }
        assert_eq!(watch.look(file(8)), Step::Reopen);
        assert!(watch.tried(attempt(8, 8)));
        assert_eq!(watch.look(file(8)), Step::Wait);
    }

    #[test]
    fn a_short_absence_is_overlooked_a_longer_one_is_a_loss_and_the_return_heals() {
        let mut watch = opened(1);
        assert_eq!(watch.look(nothing()), Step::Wait);
        assert_eq!(watch.look(file(1)), Step::Wait);
        assert_eq!(watch.look(nothing()), Step::Wait);
        assert_eq!(watch.look(nothing()), Step::Lost("gone".to_owned()));
        assert_eq!(watch.look(nothing()), Step::Wait, "told once");
        assert_eq!(watch.look(file(1)), Step::Wait);
        assert_eq!(watch.look(file(1)), Step::Reopen);
    }

    #[test]
    fn a_file_that_does_not_open_at_first_gets_some_more_attempts_but_not_for_ever() {
        let mut watch = opened(1);
        assert_eq!(watch.look(file(2)), Step::Wait);
        let mut attempts = 0;
        loop {
            assert_eq!(watch.look(file(2)), Step::Reopen);
            attempts += 1;
            if watch.tried(Attempt {
                opened: false,
                ..attempt(2, 2)
            }) {
                break;
            }
        }
        assert_eq!(attempts, PATIENCE);
        assert_eq!(watch.look(file(2)), Step::Wait, "broken, and told so");
        assert_eq!(watch.look(file(3)), Step::Wait);
        assert_eq!(watch.look(file(3)), Step::Reopen, "until it changes");
    }

    #[test]
    fn a_file_that_changes_while_it_is_opened_is_opened_once_more() {
        let mut watch = opened(1);
        assert_eq!(watch.look(file(2)), Step::Wait);
        assert_eq!(watch.look(file(2)), Step::Reopen);
        assert!(!watch.tried(attempt(2, 3)));
        assert_eq!(watch.look(file(3)), Step::Reopen);
        assert!(watch.tried(attempt(3, 3)));
        // Without anything to go on with it is taken as it is, and looked at again.
        let mut first = Watch::default();
        assert!(first.tried(Attempt {
            patient: false,
            ..attempt(2, 3)
        }));
        assert_eq!(first.look(file(3)), Step::Wait);
        assert_eq!(first.look(file(3)), Step::Reopen);
    }

    #[test]
    fn a_distrusted_file_is_opened_again_even_if_it_looks_the_same() {
        let mut watch = opened(1);
        watch.distrust();
        assert_eq!(watch.look(file(1)), Step::Wait);
        assert_eq!(watch.look(file(1)), Step::Reopen);
    }

    #[test]
    fn what_is_missing_is_told_with_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let reason = |path: &Path| match Found::at(path) {
            Found::Nothing(reason) => reason,
            found @ Found::File { .. } => panic!("{found:?}"),
        };
        let missing = reason(&folder.path().join("x.tif"));
        assert!(missing.contains("found nothing there"), "{missing}");
        let missing = reason(&folder.path().join("disk/x.tif"));
        assert!(missing.contains("not even its folder"), "{missing}");
    }
}
