//! Pictures of one ground at different times.

use super::{Twin, filled};
use crate::Dated;
use crate::stored::fault::{At, Fault};
use crate::stored::range;
use crate::stored::series::{self as stored, StoredDate};
use crate::stored::value::With;

impl Twin for Dated {
    type Stored = With<stored::Dated>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let series = filled(
            fields.series,
            range::LONGEST_NAME,
            &At::Member(at, "series"),
        )?;
        Ok(Self {
            series,
            date: fields.date.0,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::Dated {
                series: self.series.clone(),
                date: StoredDate(self.date),
            },
            extra: self.extra.clone(),
        }
    }
}
