//! What a slider pays for a colour tile, on one thread: a pinned layer, adjusted, over a pinned base, stored
//! as 8 bits: `cargo bench -p relievo-graph --bench slider`.

use std::cell::LazyCell;
use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use relievo_graph::nodes::{Adjust, AdjustParams, BlendMode, Constant, Memory, Overlay};
use relievo_graph::{Graph, GraphBuilder, NodeIndex};
use relievo_planet::{Grid, LevelKey, TileKey};
use relievo_raster::{Bands, Block, Cancel, SampleType, Tile};

/// Samples along a side of a tile.
const SIDE: usize = 256;

/// The key of the tile that is made.
fn key() -> TileKey {
    TileKey::new(LevelKey::new(8, 7), 100, 50).expect("inside the level")
}

/// Something like a photograph: smooth with a little noise, `darkest` to 0.95. `holes` says which
/// columns have alpha below 1.
fn photograph(grid: &Grid, darkest: f32, holes: bool) -> (Memory, Block) {
    let mut block = Block::new(Bands::Colour, SIDE, SIDE);
    for plane in 0..3 {
        for (i, v) in block.plane_mut(plane).iter_mut().enumerate() {
            let (x, y) = ((i % SIDE) as f32, (i / SIDE) as f32);
            let wave = (x * 0.031 + plane as f32).sin() * (y * 0.023).cos() * 0.5 + 0.5;
            let grain = (i.wrapping_mul(2_654_435_761) >> 7 & 31) as f32 / 31.0;
            *v = darkest + (0.9 * wave + 0.1 * grain) * (0.95 - darkest);
        }
    }
    for (i, a) in block.plane_mut(3).iter_mut().enumerate() {
        let x = i % SIDE;
        *a = if holes && x < 64 {
            x as f32 / 64.0
        } else {
            1.0
        };
    }
    if holes {
        for plane in 0..3 {
            for row in block.plane_mut(plane).chunks_mut(SIDE) {
                row[0] = 0.0;
            }
        }
    }
    (Memory::new(grid, block.clone()), block)
}

/// A layer stored as `layer`, adjusted by `params`, over a base at an opacity, stored as 8 bits.
struct Chain {
    graph: Graph,
    top: (NodeIndex, Arc<Tile>),
    base: Option<(NodeIndex, Arc<Tile>)>,
    last: NodeIndex,
}

impl Chain {
    #[expect(
        clippy::fn_params_excessive_bools,
        reason = "a row of the table of cases"
    )]
    fn new(
        layer: SampleType,
        holes: bool,
        params: &AdjustParams,
        opacity: f32,
        pinned: bool,
    ) -> Self {
        let grid = key().grid();
        let mut b = GraphBuilder::default();
        let (node, block) = photograph(&grid, 0.02, holes);
        let top = b.add(Arc::new(node), &[]);
        b.cut(top, layer);
        let adjusted = b.add(Arc::new(Adjust::new(params)), &[top]);
        let base = if pinned {
            let (node, block) = photograph(&grid, 0.1, false);
            let base = b.add(Arc::new(node), &[]);
            b.cut(base, SampleType::Rgba32F);
            Some((
                base,
                Arc::new(Tile::from_block(&block, SampleType::Rgba32F)),
            ))
        } else {
            None
        };
        let below = base.as_ref().map_or_else(
            || b.add(Arc::new(Constant::colour([0.0; 4])), &[]),
            |base| base.0,
        );
        let overlay = Overlay::new(BlendMode::Normal, opacity, false);
        let last = b.add(Arc::new(overlay), &[below, adjusted]);
        b.cut(last, SampleType::Rgba8);
        Self {
            graph: b.build(),
            top: (top, Arc::new(Tile::from_block(&block, layer))),
            base,
            last,
        }
    }

    fn make(&self) -> Tile {
        let tile = |node: NodeIndex, _| match &self.base {
            Some((base, tile)) if *base == node => Arc::clone(tile),
            _ => Arc::clone(&self.top.1),
        };
        self.graph
            .make(self.last, black_box(key()), &tile, &Cancel::default())
            .expect("no errors")
    }
}

fn slider(c: &mut Criterion) {
    let gamma = AdjustParams {
        brightness: 0.1,
        contrast: 1.2,
        hue_deg: 20.0,
        saturation: 0.8,
        gamma: 1.3,
        ..AdjustParams::default()
    };
    let plain = AdjustParams {
        gamma: 1.0,
        ..gamma.clone()
    };
    let cases = [
        (
            "adjust of 8 bits",
            SampleType::Rgba8,
            false,
            plain.clone(),
            1.0,
            false,
        ),
        (
            "adjust with gamma of 8 bits",
            SampleType::Rgba8,
            false,
            gamma.clone(),
            1.0,
            false,
        ),
        (
            "8 bits at opacity 0.8 over f32",
            SampleType::Rgba8,
            false,
            plain.clone(),
            0.8,
            true,
        ),
        (
            "8 bits with gamma at opacity 0.8 over f32",
            SampleType::Rgba8,
            false,
            gamma.clone(),
            0.8,
            true,
        ),
        (
            "f32 with gamma at opacity 0.8 over f32",
            SampleType::Rgba32F,
            false,
            gamma.clone(),
            0.8,
            true,
        ),
        (
            "8 bits with holes over f32",
            SampleType::Rgba8,
            true,
            plain.clone(),
            1.0,
            true,
        ),
    ];
    for (name, layer, holes, params, opacity, pinned) in cases {
        // Made only if it is asked for.
        let chain = LazyCell::new(|| Chain::new(layer, holes, &params, opacity, pinned));
        c.bench_function(&format!("slider: {name}"), |b| {
            let chain = &*chain;
            b.iter(|| chain.make());
        });
    }
}

criterion_group!(benches, slider);
criterion_main!(benches);
