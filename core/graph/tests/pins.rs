//! A pin (an exact cut point put below a node that is being edited) changes nothing above it.

use std::sync::Arc;

use proptest::prelude::*;
use relievo_graph::nodes::{
    Adjust, AdjustParams, BlendMode, Constant, Noise, NoiseParams, Overlay, Stop, Tint,
};
use relievo_graph::{Graph, GraphBuilder, ImageNode, NodeIndex};
use relievo_planet::{LevelKey, Planet, TileKey};
use relievo_raster::{Cancel, SampleType, Tile};

fn noise(seed: u64) -> Arc<Noise> {
    Arc::new(Noise::new(
        Planet::EARTH,
        &NoiseParams {
            seed,
            amplitude_m: 800.0,
            wavelength_m: 3e6,
            octaves: 2,
            lacunarity: 2.0,
            gain: 0.5,
            ridged: false,
        },
    ))
}

fn tint(high: f32) -> Arc<Tint> {
    let stops = [
        (-500.0, [0.0, 0.1, 0.5, 1.0]),
        (0.0, [0.9, 0.9, 0.6, 0.3]),
        (500.0, [1.0, high, 0.0, 1.0]),
    ]
    .map(|(height_m, rgba)| Stop { height_m, rgba });
    Arc::new(Tint::new(&stops, true).expect("stops that rise"))
}

fn adjust(gamma: f64, gain: f64) -> Arc<Adjust> {
    Arc::new(Adjust::new(&AdjustParams {
        gamma,
        gain: [gain; 3],
        ..AdjustParams::default()
    }))
}

/// What lies where the pin is set.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Below {
    /// A node that makes samples.
    Samples,
    /// A node that changes nothing, over an 8-bit cut point.
    CutPoint,
    /// A hidden layer over an 8-bit cut point.
    HiddenLayer,
    /// One value.
    Uniform,
    /// One value with zeros of either sign.
    UniformZeros,
}

const BELOW: [Below; 5] = [
    Below::Samples,
    Below::CutPoint,
    Below::HiddenLayer,
    Below::Uniform,
    Below::UniformZeros,
];

/// What is below, the pin on its end, the edited node over it and what reads that; the cut points
/// above the pin.
fn graph(below: Below, pinned: bool, gamma: f64) -> (Graph, NodeIndex, Vec<NodeIndex>) {
    let mut b = GraphBuilder::default();
    let add =
        |b: &mut GraphBuilder, node: Arc<dyn ImageNode>, inputs: &[NodeIndex]| b.add(node, inputs);
    let heights = add(&mut b, noise(1), &[]);
    b.cut(heights, SampleType::Height);
    let colours = add(&mut b, tint(0.7), &[heights]);
    let end = match below {
        Below::Samples => add(&mut b, adjust(1.3, 1.0), &[colours]),
        Below::CutPoint => {
            b.cut(colours, SampleType::Rgba8);
            add(&mut b, adjust(1.0, 1.0), &[colours])
        }
        Below::HiddenLayer => {
            b.cut(colours, SampleType::Rgba8);
            let top = add(&mut b, tint(0.1), &[heights]);
            add(
                &mut b,
                Arc::new(Overlay::new(BlendMode::Screen, 0.0, false)),
                &[colours, top],
            )
        }
        Below::Uniform => add(
            &mut b,
            Arc::new(Constant::colour([0.2, 0.4, 0.9, 1.0])),
            &[],
        ),
        Below::UniformZeros => {
            let black = add(
                &mut b,
                Arc::new(Constant::colour([0.0, 0.5, 0.0, 1.0])),
                &[],
            );
            add(&mut b, adjust(0.8, -1.0), &[black])
        }
    };
    if pinned {
        b.cut(end, SampleType::Rgba32F);
    }
    let edited = add(&mut b, adjust(gamma, 1.1), &[end]);
    let other = add(&mut b, noise(2), &[]);
    let other = add(&mut b, tint(0.2), &[other]);
    let over = add(
        &mut b,
        Arc::new(Overlay::new(BlendMode::Overlay, 0.6, false)),
        &[edited, other],
    );
    b.cut(over, SampleType::Rgba16F);
    // Reads the pin a second time, and a cut point above it.
    let both = add(
        &mut b,
        Arc::new(Overlay::new(BlendMode::Multiply, 0.5, false)),
        &[over, end],
    );
    b.cut(both, SampleType::Rgba8);
    (b.build(), end, vec![over, both])
}

fn make(graph: &Graph, node: NodeIndex, key: TileKey) -> Tile {
    let read = |input, key| Arc::new(make(graph, input, key));
    graph
        .make(node, key, &read, &Cancel::default())
        .expect("no errors")
}

#[test]
fn a_pin_leaves_ids_and_bytes_of_everything_above_as_they_were() {
    for below in BELOW {
        let (plain, _, cuts) = graph(below, false, 1.4);
        let (pinned, pin, _) = graph(below, true, 1.4);
        for (m, n, column, row) in [(0, 0, 0, 0), (2, 1, 3, 1)] {
            let key = TileKey::new(LevelKey::new(m, n), column, row).unwrap();
            for node in &cuts {
                let ids = [&plain, &pinned].map(|graph| graph.content_id(*node, key));
                assert_eq!(ids[0], ids[1], "{below:?} {node:?} {key}");
                let [a, b] = [&plain, &pinned].map(|graph| make(graph, *node, key));
                assert!(a.bytes() == b.bytes(), "{below:?} {node:?} {key}");
                assert_eq!(a.as_uniform(), b.as_uniform(), "{below:?} {node:?} {key}");
            }
            let reads_pin = pinned
                .dependencies(cuts[0], key)
                .iter()
                .any(|(node, _)| *node == pin);
            assert_eq!(reads_pin, below == Below::Samples, "{below:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn edits_above_a_pin_keep_the_name_of_what_is_pinned(
        first in 0.3..3.0_f64, second in 0.3..3.0_f64, below in 0..BELOW.len(), column in 0..8_i64, row in 0..4_i64,
    ) {
        prop_assume!(first != second);
        let key = TileKey::new(LevelKey::new(3, 2), column, row).unwrap();
        let (before, pin, cuts) = graph(BELOW[below], true, first);
        let (after, _, _) = graph(BELOW[below], true, second);
        prop_assert_eq!(before.content_id(pin, key), after.content_id(pin, key));
        prop_assert_ne!(before.content_id(cuts[0], key), after.content_id(cuts[0], key));
    }
}
