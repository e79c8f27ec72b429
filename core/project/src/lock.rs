//! One program at a time: a file beside the project that says who has it open.
//!
//! The system's own file lock decides, since it goes when its program goes, however that ends. The
//! text in the file only names the other. Where the system has no such locks, the text decides, as far
//! as this computer can tell whether the program it names still runs.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

/// Who has a project open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// The computer; empty where it is not known.
    pub host: String,
    /// The number of its process there.
    pub process: u32,
    /// The user; empty where they are not known.
    pub user: String,
}

impl core::fmt::Display for Holder {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "process {}", self.process)?;
        if !self.user.is_empty() {
            write!(f, " of {}", self.user)?;
        }
        if !self.host.is_empty() {
            write!(f, " on {}", self.host)?;
        }
        Ok(())
    }
}

/// Why a project's lock cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another program has the project open.
    #[error("the project is open elsewhere, by {}: {path:?}", .holder.as_ref().map_or_else(|| "a program that does not say which".to_owned(), ToString::to_string))]
    Held {
        /// Who, where they say so.
        holder: Option<Holder>,
        /// The project.
        path: PathBuf,
    },
    /// The lock's file cannot be made: a folder that is read-only, mostly.
    #[error("cannot mark the project as open: {source}: {path:?}")]
    Failed {
        /// What the system said.
        source: io::Error,
        /// The lock's file.
        path: PathBuf,
    },
}

/// Holds a project for this program until it is dropped.
#[derive(Debug)]
pub struct ProjectLock {
    file: File,
    path: PathBuf,
}

impl ProjectLock {
    /// Takes the lock of the project at `project`, which need not exist. What a program left behind
    /// that ended without giving its lock back counts for nothing.
    ///
    /// # Errors
    /// [`LockError::Held`] where another program has the project, or this one a second time.
    pub fn take(project: &Path) -> Result<Self, LockError> {
        let path = lock_path(project);
        let failed = |source| LockError::Failed {
            source,
            path: path.clone(),
        };
        loop {
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path)
                .map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Held {
                        holder: read_holder(&mut file),
                        path: project.to_owned(),
                    });
                }
                Err(TryLockError::Error(_no_locks_here)) => {
                    if let Some(holder) = read_holder(&mut file).filter(may_run) {
                        return Err(LockError::Held {
                            holder: Some(holder),
                            path: project.to_owned(),
                        });
                    }
                }
            }
            // Whoever had it may have removed the file between opening and locking.
            if !is_still(&file, &path) {
                continue;
            }
            let text = describe_self().to_string();
            file.set_len(0)
                .and_then(|()| file.rewind())
                .and_then(|()| file.write_all(text.as_bytes()))
                .map_err(failed)?;
            return Ok(Self { file, path });
        }
    }

    /// The lock's file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for ProjectLock {
    fn drop(&mut self) {
        // Before the lock goes, so that nobody holds a file that is then removed.
        drop(fs::remove_file(&self.path));
        drop(self.file.unlock());
    }
}

fn lock_path(project: &Path) -> PathBuf {
    let mut name = project.as_os_str().to_owned();
    name.push(".lock");
    PathBuf::from(name)
}

#[cfg(unix)]
fn is_still(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let (Ok(ours), Ok(there)) = (file.metadata(), fs::metadata(path)) else {
        return false;
    };
    (ours.dev(), ours.ino()) == (there.dev(), there.ino())
}

/// Other systems do not remove files that are open.
#[cfg(not(unix))]
fn is_still(_: &File, _: &Path) -> bool {
    true
}

fn read_holder(file: &mut File) -> Option<Holder> {
    let mut text = String::new();
    file.rewind().ok()?;
    file.take(4096).read_to_string(&mut text).ok()?;
    let value: Value = serde_json::from_str(&text).ok()?;
    let text = |name: &str| value[name].as_str().unwrap_or_default().to_owned();
    Some(Holder {
        host: text("host"),
        process: u32::try_from(value["process"].as_u64()?).ok()?,
        user: text("user"),
    })
}

fn describe_self() -> Value {
    json!({
        "program": concat!("relievo ", env!("CARGO_PKG_VERSION")),
        "host": host(),
        "process": std::process::id(),
        "user": std::env::var("USER").or_else(|_| std::env::var("USERNAME")).unwrap_or_default(),
    })
}

fn host() -> String {
    fs::read_to_string("/proc/sys/kernel/hostname")
        .ok()
        .or_else(|| std::env::var("COMPUTERNAME").ok())
        .or_else(|| std::env::var("HOSTNAME").ok())
        .map(|host| host.trim().to_owned())
        .unwrap_or_default()
}

/// Whether the program that a text names may still run: certainly not where it was on this computer
/// and the system knows no such process.
fn may_run(holder: &Holder) -> bool {
    let is_here = !holder.host.is_empty() && holder.host == host();
    let processes = Path::new("/proc/self");
    !(is_here && processes.exists() && !Path::new(&format!("/proc/{}", holder.process)).exists())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_program_is_told_who_has_the_project_until_it_is_given_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let project = folder.path().join("a.relievo");
        let lock = ProjectLock::take(&project).expect("free");
        let message = ProjectLock::take(&project).expect_err("held").to_string();
        let process = format!("process {}", std::process::id());
        assert!(message.contains(&process), "{message}");
        drop(lock);
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 0);
        drop(ProjectLock::take(&project).expect("free again"));
    }

    #[test]
    fn what_a_killed_program_left_behind_does_not_lock() {
        let folder = tempfile::tempdir().expect("a folder");
        let project = folder.path().join("a.relievo");
        let text = json!({ "host": host(), "process": 1, "user": "somebody" });
        fs::write(lock_path(&project), text.to_string()).expect("written");
        assert!(ProjectLock::take(&project).is_ok());
        fs::write(lock_path(&project), "no JSON").expect("written");
        assert!(ProjectLock::take(&project).is_ok());
    }
}
