//! Blocks: working samples between nodes, planar f32.

/// What the planes of a block mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Bands {
    /// One plane: height in metres, NaN is nodata.
    Height,
    /// Four planes: red, green, blue, alpha; straight (not premultiplied), display-referred (sRGB
    /// encoded) values, 0 to 1 for ordinary imagery. Where alpha is 0 the colour is 0 too.
    Colour,
    /// One plane: weight 0 to 1.
    Mask,
    /// Two planes: stereographic coordinates of the unit surface normal towards east and north, see
    /// [`normal`](crate::normal).
    Normal,
}

impl Bands {
    /// Number of planes.
    pub const fn planes(self) -> usize {
        match self {
            Self::Height | Self::Mask => 1,
            Self::Normal => 2,
            Self::Colour => 4,
        }
    }
}

/// A rectangle of f32 samples, one plane after another, rows from north, no padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    bands: Bands,
    width: usize,
    height: usize,
    samples: Vec<f32>,
}

impl Block {
    /// A block of zeros (a transparent colour, height 0).
    pub fn new(bands: Bands, width: usize, height: usize) -> Self {
        Self {
            bands,
            width,
            height,
            samples: vec![0.0; bands.planes() * width * height],
        }
    }

    /// A block in which every sample has the same value per plane; `value` has one entry a plane.
    ///
    /// # Panics
    /// If `value` has not as many entries as there are planes.
    pub fn filled(bands: Bands, width: usize, height: usize, value: &[f32]) -> Self {
        assert_eq!(value.len(), bands.planes(), "one value a plane");
        let mut block = Self::new(bands, width, height);
        for (plane, v) in value.iter().enumerate() {
            block.plane_mut(plane).fill(*v);
        }
        block
    }

    /// What its planes mean.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Samples of one plane, row by row.
    pub fn plane(&self, plane: usize) -> &[f32] {
        let n = self.width * self.height;
        &self.samples[plane * n..(plane + 1) * n]
    }

    /// Samples of one plane, row by row.
    pub fn plane_mut(&mut self, plane: usize) -> &mut [f32] {
        let n = self.width * self.height;
        &mut self.samples[plane * n..(plane + 1) * n]
    }

    /// All planes at once, for functions that write several together.
    ///
    /// # Panics
    /// If there are not `N` planes.
    pub fn planes_mut<const N: usize>(&mut self) -> [&mut [f32]; N] {
        assert_eq!(N, self.bands.planes(), "one slice a plane");
        let n = (self.width * self.height).max(1);
        let mut chunks = self.samples.chunks_exact_mut(n);
        core::array::from_fn(|_| chunks.next().unwrap_or_default())
    }

    /// All samples, plane after plane.
    pub fn samples(&self) -> &[f32] {
        &self.samples
    }

    /// All samples, plane after plane.
    pub fn samples_mut(&mut self) -> &mut [f32] {
        &mut self.samples
    }

    /// Makes it hold other bands and another size, keeping its memory; contents are unspecified.
    pub fn reshape(&mut self, bands: Bands, width: usize, height: usize) {
        self.bands = bands;
        self.width = width;
        self.height = height;
        self.samples.resize(bands.planes() * width * height, 0.0);
    }

    /// Copies the rectangle `size` at `from` of `source` to `to`.
    ///
    /// # Panics
    /// If the bands differ or a rectangle does not fit.
    pub fn copy_from(
        &mut self,
        source: &Self,
        from: (usize, usize),
        to: (usize, usize),
        size: (usize, usize),
    ) {
        assert_eq!(self.bands, source.bands, "blocks of the same bands");
        assert!(
            from.0 + size.0 <= source.width
                && from.1 + size.1 <= source.height
                && to.0 + size.0 <= self.width
                && to.1 + size.1 <= self.height,
            "rectangles inside their blocks"
        );
        for plane in 0..self.bands.planes() {
            let width = self.width;
            let (src, dst) = (source.plane(plane), self.plane_mut(plane));
            for y in 0..size.1 {
                let s = (from.1 + y) * source.width + from.0;
                let d = (to.1 + y) * width + to.0;
                dst[d..d + size.0].copy_from_slice(&src[s..s + size.0]);
            }
        }
    }
}
