//! SQLite databases from strangers: opened so that nothing is written and no question is endless.
//!
//! A database may hold views that never end or values that never fit. It is opened as immutable (nothing
//! is written beside it, no lock is taken), every question has a budget of steps, and values have a
//! largest size.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags};

/// Steps of the database's machine between two looks at the budget.
const STEPS_AT_ONCE: i32 = 10_000;

/// What a question of a database may cost.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Bytes of a value at most.
    pub value_bytes: i32,
    /// Looks at the budget, 10,000 steps apart, after which a question is interrupted.
    pub looks: u64,
}

/// Why a database could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Its path leads nowhere.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// It is no database, or the system refuses it.
    #[error(transparent)]
    Database(#[from] rusqlite::Error),
}

/// The budget of the question that is asked now.
#[derive(Debug)]
pub struct Budget(Arc<AtomicU64>);

impl Budget {
    /// Starts anew, for the next question or the next row.
    pub fn refill(&self) {
        self.0.store(0, Ordering::Relaxed);
    }
}

/// Opens a database for reading. A question that goes beyond its budget ends with
/// `OperationInterrupted`.
///
/// # Errors
/// [`OpenError`]; what is wrong with the content shows with the first question.
pub fn open(path: &Path, limits: Limits) -> Result<(Connection, Budget), OpenError> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY
        | OpenFlags::SQLITE_OPEN_URI
        | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let mut connection = Connection::open_with_flags(uri(path)?, flags)?;
    let looks = Arc::new(AtomicU64::new(0));
    let counter = Arc::clone(&looks);
    connection.progress_handler(
        STEPS_AT_ONCE,
        Some(move || counter.fetch_add(1, Ordering::Relaxed) >= limits.looks),
    )?;
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, limits.value_bytes)?;
    connection.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;")?;
    Ok((connection, Budget(looks)))
}

/// The path as SQLite's URI of a file that nobody changes.
fn uri(path: &Path) -> std::io::Result<String> {
    let path = std::path::absolute(path)?;
    let mut uri = String::from("file:");
    if cfg!(windows) {
        uri.push('/');
    }
    for byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'\\' if cfg!(windows) => uri.push('/'),
            b'/' | b'.' | b'-' | b'_' | b'~' | b':' => uri.push(char::from(*byte)),
            byte if byte.is_ascii_alphanumeric() => uri.push(char::from(*byte)),
            byte => {
                let digits = b"0123456789ABCDEF";
                uri.push('%');
                uri.push(char::from(digits[usize::from(byte >> 4)]));
                uri.push(char::from(digits[usize::from(byte & 15)]));
            }
        }
    }
    uri.push_str("?immutable=1");
    Ok(uri)
}
