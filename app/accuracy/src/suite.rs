//! What a suite is and what it finds.

use crate::{Chart, Context};

/// A set of measurements that answer one question.
#[derive(Clone, Copy)]
pub struct Suite {
    /// What `--suite` calls it: a word in small letters.
    pub name: &'static str,
    /// What it measures, in a sentence.
    pub sentence: &'static str,
    /// Measures.
    pub run: fn(&Context) -> Result<Report, SuiteError>,
}

impl core::fmt::Debug for Suite {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Suite")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// Why a suite has no report. What one adapter or machine merely lacks is told in the report instead.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SuiteError {
    /// Somebody asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The project or a file of it cannot be used: one line that names it.
    #[error("{0}")]
    Input(String),
    /// The system or the device failed: one line.
    #[error("{0}")]
    System(String),
}

/// What a suite found.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Report {
    /// What was found, in plain words, a paragraph each: what to expect at which cost.
    pub summary: Vec<String>,
    /// Charts, tables and pictures, in the order of their telling.
    pub figures: Vec<Figure>,
}

/// Something to look at.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// A word for file names, unique in its report: `ground-error`.
    pub name: String,
    /// A heading.
    pub title: String,
    /// What is seen and how it was measured: the metric, the truth, the sample.
    pub caption: String,
    /// The figure itself.
    pub content: Content,
}

impl Figure {
    /// A figure.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        content: Content,
    ) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            caption: caption.into(),
            content,
        }
    }
}

/// What a figure shows.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Curves.
    Chart(Chart),
    /// Rows.
    Table(Table),
    /// A picture.
    Picture(Picture),
}

/// Rows under a head.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Table {
    /// Heads of the columns, with units.
    pub head: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number: exact in the file, rounded on the page.
    Number(f64),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// A picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// The file.
    pub png: Vec<u8>,
    /// What is seen, for who cannot see it.
    pub description: String,
}

impl Picture {
    /// A picture of `width` × `height` pixels of four bytes (sRGB, straight alpha), row by row.
    ///
    /// # Errors
    /// If the bytes are not as many.
    pub fn from_rgba8(
        width: u32,
        height: u32,
        rgba: &[u8],
        description: impl Into<String>,
    ) -> Result<Self, SuiteError> {
        let write = || -> Result<Vec<u8>, png::EncodingError> {
            let mut png = Vec::new();
            let mut encoder = png::Encoder::new(&mut png, width, height);
            encoder.set_color(png::ColorType::Rgba);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(rgba)?;
            writer.finish()?;
            Ok(png)
        };
        let png = write()
            .map_err(|error| SuiteError::System(format!("cannot make a picture: {error}")))?;
        Ok(Self {
            png,
            description: description.into(),
        })
    }
}
