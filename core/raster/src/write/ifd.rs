//! TIFF directories, in classic and big form, little-endian.

/// Values of a field.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Short(Vec<u16>),
    Long(Vec<u32>),
    /// Offsets and sizes: 8 bytes in a big file, else 4.
    Offset(Vec<u64>),
    Double(Vec<f64>),
    /// Without the final zero.
    Ascii(String),
}

/// A field of a directory.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    tag: u16,
    value: Value,
}

impl Field {
    pub(super) fn new(tag: u16, value: Value) -> Self {
        Self { tag, value }
    }

    /// Type, number of values, bytes.
    fn encode(&self, big: bool) -> (u16, u64, Vec<u8>) {
        match &self.value {
            Value::Short(v) => (
                3,
                v.len() as u64,
                v.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Value::Long(v) => (
                4,
                v.len() as u64,
                v.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Value::Offset(v) if big => (
                16,
                v.len() as u64,
                v.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Value::Offset(v) => (
                4,
                v.len() as u64,
                v.iter().flat_map(|v| (*v as u32).to_le_bytes()).collect(),
            ),
            Value::Double(v) => (
                12,
                v.len() as u64,
                v.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Value::Ascii(v) => (2, v.len() as u64 + 1, v.bytes().chain([0]).collect()),
        }
    }
}

/// The header and directories of a file, one after another from its beginning; the first is the
/// main image. Their length depends on the numbers of values alone.
pub(super) fn encode(directories: &[Vec<Field>], big: bool) -> Vec<u8> {
    let word = |v: u64| {
        if big {
            v.to_le_bytes().to_vec()
        } else {
            (v as u32).to_le_bytes().to_vec()
        }
    };
    let mut out = b"II".to_vec();
    if big {
        out.extend([43, 0, 8, 0, 0, 0]);
    } else {
        out.extend([42, 0]);
    }
    let inline = if big { 8 } else { 4 };
    let first = out.len() + inline;
    out.extend(word(first as u64));
    for (i, fields) in directories.iter().enumerate() {
        let mut fields: Vec<&Field> = fields.iter().collect();
        fields.sort_by_key(|f| f.tag);
        let (count_size, entry_size) = if big { (8, 20) } else { (2, 12) };
        let table = count_size + entry_size * fields.len() + inline;
        let mut extra_at = out.len() + table;
        let mut extra = Vec::new();
        if big {
            out.extend((fields.len() as u64).to_le_bytes());
        } else {
            out.extend((fields.len() as u16).to_le_bytes());
        }
        for field in fields {
            let (kind, count, mut bytes) = field.encode(big);
            out.extend(field.tag.to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend(word(count));
            if bytes.len() <= inline {
                bytes.resize(inline, 0);
                out.extend(bytes);
            } else {
                out.extend(word(extra_at as u64));
                bytes.resize(bytes.len().next_multiple_of(8), 0);
                extra_at += bytes.len();
                extra.extend(bytes);
            }
        }
        // Word boundaries: tables of a classic file may end in the middle of one.
        let is_last = i + 1 == directories.len();
        let next = extra_at.next_multiple_of(2);
        out.extend(word(if is_last { 0 } else { next as u64 }));
        out.extend(extra);
        out.resize(next, 0);
    }
    out
}
