//! Where numbers are in the text.

use super::header::Header;
use crate::fault::{Fault, damaged};
use crate::file::Cancel;
use crate::geotiff::Bytes;

/// Numbers between two that are noted, and of a run that is decoded at once.
pub(super) const RUN: u64 = 1 << 16;
/// Bytes read at once.
const PIECE_BYTES: u64 = 256 << 10;
/// Longest text of a number.
const MAX_TOKEN_BYTES: usize = 400;

/// Where every [`RUN`]th number begins.
#[derive(Debug)]
pub(super) struct Index {
    starts: Vec<u64>,
}

impl Index {
    /// Looks at all of the text once; `None` where work was cancelled.
    pub(super) fn make(
        bytes: &Bytes,
        header: &Header,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Fault> {
        let wanted = header.samples();
        let mut starts = Vec::new();
        let mut count = 0;
        let mut inside = false;
        let mut at = header.data_at;
        while at < bytes.length() && count < wanted {
            if cancel.is_cancelled() {
                return Ok(None);
            }
            let piece = bytes.vec_at(at, PIECE_BYTES.min(bytes.length() - at))?;
            for (i, byte) in piece.iter().enumerate() {
                let blank = is_blank(*byte);
                if !blank && !inside {
                    if count.is_multiple_of(RUN) && count < wanted {
                        starts.push(at + i as u64);
                    }
                    count += 1;
                }
                inside = !blank;
            }
            at += piece.len() as u64;
        }
        if count < wanted {
            return damaged(format!("expected {wanted} numbers, found {count}"));
        }
        Ok(Some(Self { starts }))
    }

    /// Where a run begins.
    pub(super) fn start_of(&self, run: u64) -> u64 {
        self.starts[run as usize]
    }
}

fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0
}

/// Words of the text one after another; holds one piece of it at a time.
pub(super) struct Tokens<'a> {
    bytes: &'a Bytes,
    piece: Vec<u8>,
    /// Where the piece begins in the file.
    piece_at: u64,
    /// Next byte within the piece.
    next: usize,
    token: Vec<u8>,
    token_at: u64,
}

impl<'a> Tokens<'a> {
    /// From a position on.
    pub(super) fn new(bytes: &'a Bytes, at: u64) -> Self {
        Self {
            bytes,
            piece: Vec::new(),
            piece_at: at,
            next: 0,
            token: Vec::new(),
            token_at: at,
        }
    }

    /// Where the last word began.
    pub(super) fn start(&self) -> u64 {
        self.token_at
    }

    fn byte(&mut self) -> Result<Option<u8>, Fault> {
        if self.next == self.piece.len() {
            self.piece_at += self.piece.len() as u64;
            let left = self.bytes.length().saturating_sub(self.piece_at);
            self.piece = self.bytes.vec_at(self.piece_at, PIECE_BYTES.min(left))?;
            self.next = 0;
        }
        let byte = self.piece.get(self.next).copied();
        self.next += usize::from(byte.is_some());
        Ok(byte)
    }

    /// The next word; an error at the end of the text.
    pub(super) fn next(&mut self) -> Result<&[u8], Fault> {
        self.token.clear();
        while let Some(byte) = self.byte()? {
            if is_blank(byte) {
                if self.token.is_empty() {
                    continue;
                }
                break;
            }
            if self.token.is_empty() {
                self.token_at = self.piece_at + self.next as u64 - 1;
            }
            if self.token.len() == MAX_TOKEN_BYTES {
                return damaged(format!(
                    "expected numbers of at most {MAX_TOKEN_BYTES} characters, found more"
                ));
            }
            self.token.push(byte);
        }
        if self.token.is_empty() {
            return damaged("expected a number, found the end of the file");
        }
        Ok(&self.token)
    }
}
