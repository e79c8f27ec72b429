//! Makes samples: runs of pointwise nodes strip by strip, from what they read to where the result is
//! kept; everything else as a whole.

use std::collections::HashMap;
use std::sync::Arc;

use relievo_planet::SampleRect;
use relievo_raster::{Bands, Block, Cancel, SampleType, Tile, TileBuilder};

use super::resolve::{Resolver, Source};
use super::{NodeIndex, TileInputs, artefacts, round};
use crate::{Job, RenderError};

/// Samples of a strip: 4 rows of a tile, so that the planes of two or three nodes, 16 KiB each for
/// colours, stay in the nearest cache.
const STRIP_SAMPLES: usize = 4 * 256;

/// Where the samples of cut points come from.
#[derive(Clone, Copy)]
pub(super) enum Reader<'a> {
    /// Finished tiles.
    Tiles(&'a TileInputs<'a>),
    /// They are made on the spot and rounded.
    Evaluate,
    /// The same, and kept beside artefacts.
    Keep,
}

/// Stored samples of one place.
#[derive(Clone)]
enum Stored {
    Tile(Arc<Tile>),
    Block(Arc<Block>),
}

/// Something a run computes or reads, strip by strip.
enum Step {
    Uniform([f32; 4]),
    Stored(Stored),
    /// Samples that were made for the whole rectangle at once.
    Whole(Block),
    /// A pointwise node over earlier steps.
    Node(NodeIndex, Vec<usize>),
}

/// Makes samples of one lattice.
pub(super) struct Maker<'a> {
    resolver: Resolver<'a>,
    reader: Reader<'a>,
    cancel: &'a Cancel,
    evaluated: HashMap<(NodeIndex, SampleRect), Arc<Block>>,
}

impl<'a> Maker<'a> {
    pub(super) fn new(resolver: Resolver<'a>, reader: Reader<'a>, cancel: &'a Cancel) -> Self {
        Self {
            resolver,
            reader,
            cancel,
            evaluated: HashMap::new(),
        }
    }

    /// The tile of `source` on a place of a tile's size, stored as `to`.
    pub(super) fn make_tile(
        &mut self,
        source: Source,
        to: SampleType,
        at: usize,
    ) -> Result<Tile, RenderError> {
        if let Source::Raw(root) = source
            && !self.is_made_whole(root)
        {
            let mut builder = TileBuilder::new(to);
            self.run(root, at, |_, strip| {
                round::before_storing(strip, to);
                builder.push(strip);
            })?;
            return Ok(builder.finish());
        }
        let mut block = self.make(source, to.bands(), at)?;
        round::before_storing(&mut block, to);
        Ok(Tile::from_block(&block, to))
    }

    /// The samples of `source` on a place.
    pub(super) fn make(
        &mut self,
        source: Source,
        bands: Bands,
        at: usize,
    ) -> Result<Block, RenderError> {
        if self.cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        match source {
            Source::Uniform(value) => {
                let (width, height) = size(&self.resolver.rect(at));
                Ok(Block::filled(
                    bands,
                    width,
                    height,
                    &value[..bands.planes()],
                ))
            }
            Source::Cut(node) => {
                let stored = self.stored(node, at)?;
                let (width, height) = size(&self.resolver.rect(at));
                Ok(match stored {
                    Stored::Tile(tile) => {
                        let mut block = Block::new(bands, width, height);
                        tile.copy_to((0, 0), &mut block, (0, 0), (width, height));
                        block
                    }
                    Stored::Block(block) => Arc::unwrap_or_clone(block),
                })
            }
            Source::Raw(root) if self.is_made_whole(root) => self.render_whole(root, at),
            Source::Raw(root) => {
                let (width, height) = size(&self.resolver.rect(at));
                let mut out = Block::new(bands, width, height);
                self.run(root, at, |first, strip| {
                    let all = (strip.width(), strip.height());
                    out.copy_from(strip, (0, 0), (0, first), all);
                })?;
                Ok(out)
            }
        }
    }

    /// The samples of a node on a rectangle anywhere, put together from its pieces.
    pub(super) fn gather(
        &mut self,
        node: NodeIndex,
        rect: &SampleRect,
    ) -> Result<Block, RenderError> {
        let bands = self.resolver.graph.entry(node).node.output();
        let regions = self.resolver.regions(rect);
        if let [only] = &regions[..]
            && only.is_whole(rect)
        {
            let at = self.resolver.place(only.piece);
            let source = self.resolver.resolve(node, at).source;
            return self.make(source, bands, at);
        }
        let (width, height) = size(rect);
        let mut out = Block::new(bands, width, height);
        for region in regions {
            let at = self.resolver.place(region.piece);
            match self.resolver.resolve(node, at).source {
                Source::Uniform(value) => region.fill(value, &mut out),
                Source::Cut(cut) => match self.stored(cut, at)? {
                    Stored::Tile(tile) => region.copy_tile(&tile, &mut out),
                    Stored::Block(block) => region.copy_block(&block, &mut out),
                },
                source @ Source::Raw(_) => {
                    region.copy_block(&self.make(source, bands, at)?, &mut out);
                }
            }
        }
        Ok(out)
    }

    /// What a cut point stores at a place.
    fn stored(&mut self, cut: NodeIndex, at: usize) -> Result<Stored, RenderError> {
        if let Reader::Tiles(inputs) = self.reader {
            return Ok(Stored::Tile(inputs(cut, self.resolver.tile(at))));
        }
        let key = (cut, self.resolver.rect(at));
        if let Some(block) = self.evaluated.get(&key) {
            return Ok(Stored::Block(Arc::clone(block)));
        }
        let block = if let Reader::Keep = self.reader {
            let graph = self.resolver.graph;
            let name = self.resolver.name(Source::Cut(cut), at);
            let planes = graph.entry(cut).node.output().planes();
            let bytes = key.1.area() as usize * planes * size_of::<f32>();
            graph
                .artefacts
                .samples(name, bytes, || self.evaluate(cut, at))?
        } else {
            Arc::new(self.evaluate(cut, at)?)
        };
        self.evaluated.insert(key, Arc::clone(&block));
        Ok(Stored::Block(block))
    }

    /// What a cut point stores at a place, made from what it reads.
    fn evaluate(&mut self, cut: NodeIndex, at: usize) -> Result<Block, RenderError> {
        let entry = self.resolver.graph.entry(cut);
        let raw = self.resolver.raw(cut, at).source;
        let mut block = self.make(raw, entry.node.output(), at)?;
        round::block(&mut block, entry.cut.expect("a cut point"));
        Ok(block)
    }

    /// Nodes that read around a sample, and sources, which pay for every call.
    fn is_made_whole(&self, node: NodeIndex) -> bool {
        let entry = self.resolver.graph.entry(node);
        entry.inputs.is_empty() || !entry.node.is_pointwise()
    }

    fn render_whole(&mut self, node: NodeIndex, at: usize) -> Result<Block, RenderError> {
        let entry = self.resolver.graph.entry(node);
        let rect = self.resolver.rect(at);
        let mut inputs = Vec::with_capacity(entry.inputs.len());
        for (k, input) in entry.inputs.iter().enumerate() {
            inputs.push(self.gather(*input, &entry.node.required(k, rect))?);
        }
        let (width, height) = size(&rect);
        let mut out = Block::new(entry.node.output(), width, height);
        let grid = self.resolver.grid(at);
        let inputs: Vec<&Block> = inputs.iter().collect();
        let made = artefacts::all(self.resolver.graph, node, &grid, self.cancel)?;
        entry.node.render_from(
            &Job {
                grid: &grid,
                cancel: self.cancel,
            },
            &made,
            &inputs,
            &mut out,
        )?;
        Ok(out)
    }

    /// A run of pointwise nodes that ends in `root`: gives strip after strip, each with its first
    /// row, to `take`.
    fn run(
        &mut self,
        root: NodeIndex,
        at: usize,
        mut take: impl FnMut(usize, &mut Block),
    ) -> Result<(), RenderError> {
        let (steps, bands) = self.plan(root, at)?;
        let registers = Registers::assign(&steps);
        let grid = self.resolver.grid(at);
        let (width, height) = size(&grid.rect);
        let mut blocks: Vec<Block> = (0..registers.count)
            .map(|_| Block::new(Bands::Height, 0, 0))
            .collect();
        let strip_rows = (STRIP_SAMPLES / width.max(1)).max(1);
        for first in (0..height).step_by(strip_rows) {
            if self.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let rows = strip_rows.min(height - first);
            let strip = grid.with_rect(SampleRect::at(
                grid.rect.min.x,
                grid.rect.min.y + first as i64,
                width as i64,
                rows as i64,
            ));
            for (i, step) in steps.iter().enumerate() {
                let mut block = core::mem::replace(
                    &mut blocks[registers.of[i]],
                    Block::new(Bands::Height, 0, 0),
                );
                block.reshape(bands[i], width, rows);
                match step {
                    Step::Uniform(value) => {
                        for (plane, v) in value.iter().enumerate().take(bands[i].planes()) {
                            block.plane_mut(plane).fill(*v);
                        }
                    }
                    Step::Whole(whole) => block.copy_from(whole, (0, first), (0, 0), (width, rows)),
                    Step::Stored(Stored::Block(whole)) => {
                        block.copy_from(whole, (0, first), (0, 0), (width, rows));
                    }
                    Step::Stored(Stored::Tile(tile)) => {
                        tile.copy_to((0, first), &mut block, (0, 0), (width, rows));
                    }
                    Step::Node(node, reads) => {
                        let inputs: Vec<&Block> =
                            reads.iter().map(|k| &blocks[registers.of[*k]]).collect();
                        let job = Job {
                            grid: &strip,
                            cancel: self.cancel,
                        };
                        self.resolver
                            .graph
                            .entry(*node)
                            .node
                            .render(&job, &inputs, &mut block)?;
                    }
                }
                blocks[registers.of[i]] = block;
            }
            let last = registers.of[steps.len() - 1];
            take(first, &mut blocks[last]);
        }
        Ok(())
    }

    /// Steps of a run, inputs first and each once, and their bands.
    fn plan(&mut self, root: NodeIndex, at: usize) -> Result<(Vec<Step>, Vec<Bands>), RenderError> {
        let graph = self.resolver.graph;
        let mut steps = Vec::new();
        let mut bands = Vec::new();
        let mut made: HashMap<NodeIndex, usize> = HashMap::new();
        let mut read: HashMap<NodeIndex, usize> = HashMap::new();
        for node in self.resolver.run_of(Source::Raw(root), at) {
            let entry = graph.entry(node);
            let step = if self.is_made_whole(node) {
                Step::Whole(self.render_whole(node, at)?)
            } else {
                let mut reads = Vec::with_capacity(entry.inputs.len());
                for input in &entry.inputs {
                    let leaf = match self.resolver.resolve(*input, at).source {
                        Source::Raw(raw) => {
                            reads.push(made[&raw]);
                            continue;
                        }
                        Source::Cut(cut) => {
                            if let Some(k) = read.get(&cut) {
                                reads.push(*k);
                                continue;
                            }
                            read.insert(cut, steps.len());
                            Step::Stored(self.stored(cut, at)?)
                        }
                        Source::Uniform(value) => Step::Uniform(value),
                    };
                    reads.push(steps.len());
                    steps.push(leaf);
                    bands.push(graph.entry(*input).node.output());
                }
                Step::Node(node, reads)
            };
            made.insert(node, steps.len());
            steps.push(step);
            bands.push(entry.node.output());
        }
        Ok((steps, bands))
    }
}

/// Scratch blocks of a run: a step's block is used again once nobody reads it any more.
struct Registers {
    of: Vec<usize>,
    count: usize,
}

impl Registers {
    fn assign(steps: &[Step]) -> Self {
        let mut last_read: Vec<usize> = (0..steps.len()).collect();
        for (i, step) in steps.iter().enumerate() {
            if let Step::Node(_, reads) = step {
                for k in reads {
                    last_read[*k] = i;
                }
            }
        }
        let mut of: Vec<usize> = Vec::with_capacity(steps.len());
        let mut free: Vec<usize> = Vec::new();
        let mut count = 0;
        for (i, step) in steps.iter().enumerate() {
            let register = free.pop().unwrap_or_else(|| {
                count += 1;
                count - 1
            });
            of.push(register);
            if let Step::Node(_, reads) = step {
                for k in reads {
                    if last_read[*k] == i && !free.contains(&of[*k]) {
                        free.push(of[*k]);
                    }
                }
            }
        }
        Self { of, count }
    }
}

fn size(rect: &SampleRect) -> (usize, usize) {
    (rect.width() as usize, rect.height() as usize)
}
