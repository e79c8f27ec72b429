//! Between stored and runtime edits.

mod read;
mod write;

use super::StoredEdit;
use crate::Edit;
use crate::stored::convert::Twin;
use crate::stored::fault::{At, Fault};

impl Twin for Edit {
    type Stored = StoredEdit;

    fn from_stored(stored: StoredEdit, at: &At<'_>) -> Result<Self, Fault> {
        read::edit(stored, at)
    }

    fn to_stored(&self) -> StoredEdit {
        write::edit(self)
    }
}
