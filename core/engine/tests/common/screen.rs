//! What a front-end has on its textures.

use std::collections::{BTreeMap, HashMap};
use std::time::Duration;

use glam::I64Vec2;
use relievo_engine::planet::{SampleRect, TileKey};
use relievo_engine::raster::Sample;
use relievo_engine::{ClipKind, Engine, Frame, Upload};

/// Texels along a side of every window that these tests have.
const SIDE: usize = 256;

/// The part of a tile that lies in its window: which samples, and their texels by rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) rect: SampleRect,
    pub(crate) texels: Vec<[u8; 4]>,
}

/// The textures of a front-end.
#[derive(Default)]
struct Textures(HashMap<(ClipKind, u32), Vec<[u8; 4]>>);

impl Textures {
    fn store(&mut self, upload: &Upload) {
        let layer = self
            .0
            .entry((upload.clipmap, upload.layer))
            .or_insert_with(|| vec![[0; 4]; SIDE * SIDE]);
        for y in 0..upload.size[1] {
            for x in 0..upload.size[0] {
                let at = [upload.source[0] + x, upload.source[1] + y];
                let texel = match upload.tile.bytes() {
                    Some(bytes) => {
                        let first = 4 * (at[1] * 256 + at[0]) as usize;
                        [
                            bytes[first],
                            bytes[first + 1],
                            bytes[first + 2],
                            bytes[first + 3],
                        ]
                    }
                    None => match upload.tile.sample(0, 0) {
                        Sample::Height(h) => h.to_le_bytes(),
                        Sample::Rgba8(rgba) => rgba,
                        Sample::Normal([east, north]) => {
                            let ([a, b], [c, d]) = (east.to_le_bytes(), north.to_le_bytes());
                            [a, b, c, d]
                        }
                        other @ (Sample::Rgba16F(_)
                        | Sample::Rgba32F(_)
                        | Sample::Mask(_)
                        | Sample::Mask32F(_)) => {
                            panic!("no clipmap stores {other:?}")
                        }
                    },
                };
                let (x, y) = (upload.storage[0] + x, upload.storage[1] + y);
                layer[y as usize * SIDE + x as usize] = texel;
            }
        }
    }

    /// The texels of the tiles that a frame's picture reads.
    fn read_by(&self, frame: &Frame) -> BTreeMap<(ClipKind, TileKey), Part> {
        let mut tiles = BTreeMap::new();
        let stacks = [
            (ClipKind::Height, &frame.heights, &frame.plan.heights),
            (ClipKind::Colour, &frame.colours, &frame.plan.colours),
            (ClipKind::Normal, &frame.normals, &frame.plan.colours),
        ];
        for (kind, views, plans) in stacks {
            for (view, plan) in views.iter().zip(plans) {
                assert_eq!(view.window, plan.window, "windows have their final shape");
                for key in plan.wanted_tiles() {
                    let rect = plan.window.tile_rect(key).unwrap();
                    let rect = rect.intersection(&plan.window.rect);
                    let layer = &self.0[&(kind, view.layer)];
                    let mut texels = Vec::new();
                    for y in rect.min.y..rect.max.y {
                        for x in rect.min.x..rect.max.x {
                            let at = plan.window.storage_of(I64Vec2::new(x, y));
                            let row = at.y as usize * plan.window.size as usize;
                            texels.push(layer[row + at.x as usize]);
                        }
                    }
                    tiles.insert((kind, key), Part { rect, texels });
                }
            }
        }
        tiles
    }
}

/// All tiles of the picture as a front-end has them that lost its device and got everything again.
pub(crate) fn picture(engine: &mut Engine) -> BTreeMap<(ClipKind, TileKey), Part> {
    let mut textures = Textures::default();
    engine.forget_uploads();
    for _ in 0..20_000 {
        let frame = engine.drain(f32::INFINITY).unwrap();
        for upload in &frame.uploads {
            textures.store(upload);
        }
        if frame.is_converged() && frame.uploads.is_empty() && frame.plan.settled {
            return textures.read_by(&frame);
        }
        engine.wait(Duration::from_millis(20));
    }
    panic!("does not converge: {:?}", engine.stats());
}
