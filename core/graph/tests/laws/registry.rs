//! Every node with sample parameters.

use std::sync::Arc;

use relievo_earthwork::{Element, Prepared, Profile, Section, Shape, Side, Surface, Vertex};
use relievo_graph::ImageNode;
use relievo_graph::nodes::{
    AddHeights, Adjust, AdjustParams, AlphaMask, BlendMode, ColourDetail, ColourDetailParams,
    ColourDetailSource, Constant, ContourLines, ContourStyle, Detail, DetailMethod, DetailParams,
    DiscMask, Earthwork, EdgeDistances, ExampleAt, HeightDifference, MaskProduct, Memory, Noise,
    NoiseParams, Normals, Overlay, OverlayHeights, PlacedElement, PolygonMask, RangeMask,
    SeamBlend, SlopeAngle, Stop, Tint, Vector,
};
use relievo_planet::{Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_raster::{Bands, Block};
use relievo_vector::style::Length;
use relievo_vector::{Builder, Drawing, Style};

use crate::fill;
use crate::flat::Flat;

/// A node with sample parameters, and the bands that it reads.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    pub(crate) node: Arc<dyn ImageNode>,
    pub(crate) inputs: &'static [Bands],
}

pub(crate) fn noise_params(seed: u64, ridged: bool) -> NoiseParams {
    NoiseParams {
        seed,
        amplitude_m: 800.0,
        wavelength_m: 2e6,
        octaves: 4,
        lacunarity: 2.1,
        gain: 0.5,
        ridged,
    }
}

pub(crate) fn adjust(change: impl FnOnce(&mut AdjustParams)) -> Arc<Adjust> {
    let mut params = AdjustParams::default();
    change(&mut params);
    Arc::new(Adjust::new(&params))
}

pub(crate) fn tint(smooth: bool) -> Arc<Tint> {
    let stops = [
        (-800.0, [0.0, 0.1, 0.5, 1.0]),
        (0.0, [0.9, 0.9, 0.6, 0.5]),
        (900.0, [1.0, 1.0, 1.0, 1.0]),
    ]
    .map(|(height_m, rgba)| Stop { height_m, rgba });
    Arc::new(Tint::new(&stops, smooth).expect("stops that rise"))
}

fn contour_lines(index_every: u32) -> Arc<ContourLines> {
    let style = ContourStyle {
        interval_m: Some(40_000.0),
        base_m: 100.0,
        index_every,
        rgb: [0.4, 0.2, 0.1],
        width: 1.2,
        index_width: 2.5,
    };
    Arc::new(ContourLines::new(Planet::EARTH, style).expect("a style"))
}

pub(crate) fn memory() -> Arc<Memory> {
    let grid = Grid::new(
        Arc::new(LevelKey::new(1, 0).lattice()),
        SampleRect::at(500, -3, 30, 40),
    );
    let mut samples = Block::new(Bands::Colour, 30, 40);
    fill(&mut samples, 5);
    Arc::new(Memory::new(&grid, samples))
}

/// Detail on all levels but the coarsest, after two examples as large as continents.
pub(crate) fn colour_detail(seed: u64, masked: bool) -> Arc<ColourDetail> {
    let params = ColourDetailParams {
        seed,
        coarse_spacing_m: 80_000.0,
        tolerance: 1.0,
        ..ColourDetailParams::default()
    };
    let example = |lon_deg: f64| {
        let centre = MapPoint::from_degrees(lon_deg, 10.0);
        ExampleAt::around(&Planet::EARTH, centre, 15_000.0, [96, 80])
    };
    let examples = vec![example(20.0), example(170.0)];
    Arc::new(ColourDetail::new(Planet::EARTH, &params, examples, masked))
}

/// Detail by noise on all levels but the coarsest.
pub(crate) fn colour_noise(seed: u64, masked: bool) -> Arc<ColourDetail> {
    let params = ColourDetailParams {
        by: ColourDetailSource::Noise,
        seed,
        coarse_spacing_m: 80_000.0,
        ..ColourDetailParams::default()
    };
    Arc::new(ColourDetail::new(
        Planet::EARTH,
        &params,
        Vec::new(),
        masked,
    ))
}

/// Seams on a lattice of one halving more than that of the laws, or on their own.
pub(crate) fn seam_blend(reach_m: f64, masked: bool) -> Arc<SeamBlend> {
    Arc::new(SeamBlend::new(Planet::EARTH, reach_m, masked))
}

/// A polygon around the antimeridian and a line, in pixels or metres.
pub(crate) fn vector(width: Length) -> Arc<Vector> {
    let mut features = Builder::degrees();
    let ring = [
        [150.0, -40.0],
        [-140.0, -30.0],
        [-150.0, 50.0],
        [160.0, 30.0],
    ];
    features.ring(ring, false).expect("a ring");
    features.feature().expect("few features");
    let line = [[-100.0, 80.0], [0.0, -20.0], [40.0, 45.0]];
    features.line(line).expect("a line");
    let features = features.finish().expect("places on the planet");
    let style = Style {
        fill: Some([0.2, 0.8, 0.1, 0.6]),
        stroke: Some([0.9, 0.1, 0.1, 1.0]),
        stroke_width: Some(width),
        dash: vec![9.0, 4.0],
        ..Style::default()
    };
    let drawing = Drawing::new(Arc::new(features), style, Planet::EARTH);
    Arc::new(Vector::new(Arc::new(drawing)))
}

/// Detail of a source whose samples are as large as those of a coarse level.
pub(crate) fn detail(method: DetailMethod) -> Arc<Detail> {
    let params = DetailParams {
        seed: 3,
        strength: 1.0,
        method,
        slope: 0.5,
        heights_m: [-500.0, 5000.0],
        fade_m: 100.0,
        shortest_m: 1000.0,
        spacing_m: 40_000.0,
    };
    Arc::new(Detail::new(Planet::EARTH, &params))
}

/// A platform as large as a continent, and a road finer than the samples.
fn earthwork(height_m: f64) -> Arc<Earthwork> {
    let vertex = |(lon_rad, colat_rad, height_m): &(f64, f64, Option<f64>)| Vertex {
        place: MapPoint::new(*lon_rad, *colat_rad),
        height_m: *height_m,
    };
    let ring = [
        (-1.0, 1.9),
        (-0.4, 2.0),
        (-0.5, 2.5),
        (-0.8, 2.1),
        (-1.1, 2.6),
    ];
    let platform = Shape::Polygon(relievo_earthwork::Polygon {
        outline: ring.iter().map(|(x, y)| vertex(&(*x, *y, None))).collect(),
        holes: Vec::new(),
        breaklines: Vec::new(),
        surface: Surface::Platform { height_m },
    });
    let line = [
        (-1.2, 2.2, Some(100.0)),
        (-0.2, 2.3, None),
        (3.3, 2.9, Some(900.0)),
    ];
    let road = Shape::Corridor(relievo_earthwork::Corridor {
        line: line.iter().map(vertex).collect(),
        profile: Profile::Heights,
        section: Section::Road {
            width_m: 30_000.0,
            crossfall_percent: 0.0,
        },
    });
    let side = Side {
        max_reach_m: 90_000.0,
        cut_slope: 0.02,
        fill_slope: 0.01,
        wall: false,
    };
    let elements = [platform, road].map(|shape| {
        let element = Arc::new(Element { shape, side });
        Arc::new(PlacedElement::new(Arc::new(Prepared::new(
            Planet::EARTH,
            element,
        ))))
    });
    Arc::new(Earthwork::new(Planet::EARTH, elements.into()))
}

/// Every node of the crate that needs no file.
pub(crate) fn registry() -> Vec<Entry> {
    let mut all = of_heights();
    all.extend(of_masks());
    all.extend(of_colours());
    all.extend(of_colour_detail());
    all
}

fn entry(name: &'static str, node: Arc<dyn ImageNode>, inputs: &'static [Bands]) -> Entry {
    Entry { name, node, inputs }
}

fn of_heights() -> Vec<Entry> {
    const HEIGHT: &[Bands] = &[Bands::Height];
    const HEIGHTS: &[Bands] = &[Bands::Height, Bands::Height];
    vec![
        entry("constant", Arc::new(Constant::height(12.5)), &[]),
        entry(
            "noise",
            Arc::new(Noise::new(Planet::EARTH, &noise_params(1, false))),
            &[],
        ),
        entry(
            "ridges",
            Arc::new(Noise::new(Planet::EARTH, &noise_params(1, true))),
            &[],
        ),
        entry(
            "other seed",
            Arc::new(Noise::new(Planet::EARTH, &noise_params(2, false))),
            &[],
        ),
        entry("add heights", Arc::new(AddHeights), HEIGHTS),
        entry(
            "overlay heights",
            Arc::new(OverlayHeights::new(0.7, false)),
            HEIGHTS,
        ),
        entry(
            "masked heights",
            Arc::new(OverlayHeights::new(1.0, true)),
            &[Bands::Height, Bands::Height, Bands::Mask],
        ),
        entry(
            "normals",
            Arc::new(Normals::new(Planet::EARTH, 1.0)),
            HEIGHT,
        ),
        entry("detail", detail(DetailMethod::Simplex), HEIGHT),
        entry("spectral detail", detail(DetailMethod::Spectral), HEIGHT),
        entry(
            "amount of detail",
            Arc::new((*detail(DetailMethod::Simplex)).clone().amount()),
            HEIGHT,
        ),
        entry("earthwork", earthwork(500.0), HEIGHT),
        entry("other earthwork", earthwork(501.0), HEIGHT),
        entry(
            "steep normals",
            Arc::new(Normals::new(Planet::EARTH, 50.0)),
            HEIGHT,
        ),
        entry(
            "height difference",
            Arc::new(HeightDifference::new()),
            HEIGHTS,
        ),
        entry("slope angle", Arc::new(SlopeAngle), &[Bands::Normal]),
    ]
}

/// Masks, and what they are made of.
fn of_masks() -> Vec<Entry> {
    const HEIGHT: &[Bands] = &[Bands::Height];
    vec![
        entry(
            "range mask",
            Arc::new(RangeMask::new(-0.5, 0.5, 0.3)),
            HEIGHT,
        ),
        entry(
            "disc mask",
            Arc::new(DiscMask::new(
                &Planet::EARTH,
                MapPoint::from_degrees(10.0, 50.0),
                2e6,
                1e6,
            )),
            &[],
        ),
        entry(
            "polygon mask",
            Arc::new(PolygonMask::new(
                &Planet::EARTH,
                MapPoint::from_degrees(10.0, 50.0),
                &[[-2e6, -1e6], [2.5e6, -1.5e6], [0.0, 0.5e6], [1e6, 2e6]],
                1e6,
            )),
            &[],
        ),
        entry(
            "mask product",
            Arc::new(MaskProduct::new(2, true)),
            &[Bands::Mask, Bands::Mask],
        ),
        entry("alpha mask", Arc::new(AlphaMask), &[Bands::Colour]),
        entry(
            "edge distances",
            Arc::new(EdgeDistances::new(
                Flat::warp(true, Planet::EARTH),
                150_000.0,
            )),
            &[],
        ),
        entry(
            "distances to an outline",
            Arc::new(EdgeDistances::to_outline(
                Flat::warp(true, Planet::EARTH),
                150_000.0,
            )),
            &[],
        ),
    ]
}

fn of_colours() -> Vec<Entry> {
    const COLOURS: &[Bands] = &[Bands::Colour, Bands::Colour];
    const MASKED: &[Bands] = &[Bands::Colour, Bands::Colour, Bands::Mask];
    const HEIGHT: &[Bands] = &[Bands::Height];
    const CONTOURED: &[Bands] = &[Bands::Height, Bands::Normal];
    vec![
        entry(
            "other constant",
            Arc::new(Constant::colour([0.1, 0.2, 0.3, 0.4])),
            &[],
        ),
        entry("memory", memory(), &[]),
        entry("vector", vector(Length::Pixels(3.0)), &[]),
        entry("wide vector", vector(Length::Metres(200_000.0)), &[]),
        entry(
            "overlay",
            Arc::new(Overlay::new(BlendMode::Normal, 0.6, false)),
            COLOURS,
        ),
        entry(
            "masked overlay",
            Arc::new(Overlay::new(BlendMode::Normal, 1.0, true)),
            MASKED,
        ),
        entry(
            "multiply",
            Arc::new(Overlay::new(BlendMode::Multiply, 1.0, false)),
            COLOURS,
        ),
        entry(
            "screen",
            Arc::new(Overlay::new(BlendMode::Screen, 0.5, true)),
            MASKED,
        ),
        entry(
            "soft overlay",
            Arc::new(Overlay::new(BlendMode::Overlay, 0.9, false)),
            COLOURS,
        ),
        entry(
            "add",
            Arc::new(Overlay::new(BlendMode::Add, 1.0, false)),
            COLOURS,
        ),
        entry(
            "brightness",
            adjust(|p| p.brightness = 1.3),
            &[Bands::Colour],
        ),
        entry("gamma", adjust(|p| p.gamma = 1.7), &[Bands::Colour]),
        entry("hue", adjust(|p| p.hue_deg = 70.0), &[Bands::Colour]),
        entry("tint", tint(true), HEIGHT),
        entry("steps", tint(false), HEIGHT),
        entry(
            "soft light",
            Arc::new(Overlay::new(BlendMode::SoftLight, 0.7, true)),
            MASKED,
        ),
        entry(
            "colour of",
            Arc::new(Overlay::new(BlendMode::Colour, 1.0, false)),
            COLOURS,
        ),
        entry("seam blend", seam_blend(3e6, false), COLOURS),
        entry("masked seam blend", seam_blend(3e6, true), MASKED),
        entry("narrow seam blend", seam_blend(200_000.0, false), COLOURS),
        entry("contour lines", contour_lines(0), CONTOURED),
        entry("index contours", contour_lines(5), CONTOURED),
    ]
}

fn of_colour_detail() -> Vec<Entry> {
    const COLOUR: &[Bands] = &[Bands::Colour];
    const EXAMPLES: &[Bands] = &[Bands::Colour; 3];
    vec![
        entry("colour detail", colour_detail(1, false), EXAMPLES),
        entry("other colour detail", colour_detail(2, false), EXAMPLES),
        entry(
            "masked colour detail",
            colour_detail(1, true),
            &[Bands::Colour, Bands::Mask, Bands::Colour, Bands::Colour],
        ),
        entry("colour detail by noise", colour_noise(1, false), COLOUR),
        entry("other noise", colour_noise(2, false), COLOUR),
        entry(
            "masked noise",
            colour_noise(1, true),
            &[Bands::Colour, Bands::Mask],
        ),
    ]
}
