//! From a project to a graph: one pass over the layers, bottom to top.
//!
//! Heights first, then colours, which may read them. What a scene does not use is not compiled:
//! hidden layers, layers whose file is missing, identity adjustments.

mod difference;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

use parking_lot::Mutex;
use relievo_graph::nodes::{
    AddHeights, Adjust, AdjustParams, BlendMode, Constant, EdgeFade, FileSource, Noise,
    NoiseParams, Normals, Overlay, OverlayHeights, Stop, Tint, Vector,
};
use relievo_graph::{Graph, GraphBuilder, ImageNode, NodeIndex};
use relievo_planet::{LevelKey, Planet};
use relievo_project::{
    Adjust as ProjectAdjust, Blend, Layer, LayerId, LayerKind, NoiseMode, Project, Resampling,
    Source, TintInterpolation, VectorLayer,
};
use relievo_raster::kernel::Kernel;
use relievo_raster::warp::Warp;
use relievo_raster::{RasterFile, SampleType};
use relievo_vector::Drawing;

use self::difference::Shown;
use crate::difference::HeightDifference;
use crate::element_colours;
use crate::elements::ElementCache;
use crate::message::{Message, Severity};
use crate::scene::{Detail, Elements, Roots, Scene};
use crate::sources::{SourceState, Sources};
use crate::vectors;

/// Finest level of any source: 4.7 mm on Earth.
const FINEST: u8 = 24;

/// Nodes that are dear to prepare (edge distances, coverage of tiles), kept from revision to
/// revision while a layer uses them.
#[derive(Default)]
pub(crate) struct NodeCache {
    nodes: Mutex<HashMap<String, Arc<dyn ImageNode>>>,
    warps: Mutex<HashMap<String, Arc<Warp>>>,
    elements: ElementCache,
}

impl NodeCache {
    /// Number of nodes and geometries that are kept.
    pub(crate) fn len(&self) -> usize {
        self.nodes.lock().len() + self.warps.lock().len() + self.elements.len()
    }

    fn get(
        &self,
        used: &mut BTreeMap<String, Arc<dyn ImageNode>>,
        name: String,
        make: impl FnOnce() -> Arc<dyn ImageNode>,
    ) -> Arc<dyn ImageNode> {
        let kept = self.nodes.lock().get(&name).cloned();
        let node = kept.unwrap_or_else(make);
        used.insert(name, Arc::clone(&node));
        node
    }
}

/// A compiled project and what went wrong on the way.
pub(crate) struct Compiled {
    graph: Graph,
    roots: Roots,
    elements: Elements,
    layers: HashMap<NodeIndex, LayerId>,
    details: Vec<Detail>,
    pub(crate) problems: Vec<Message>,
    /// What the compiled graph leaves out, and why, for statistics.
    pub(crate) left_out: Vec<(LayerId, &'static str)>,
}

impl Compiled {
    pub(crate) fn into_scene(self, revision: u64) -> Scene {
        Scene::new(
            revision,
            Arc::new(self.graph),
            self.roots,
            self.elements,
            self.layers,
            self.details,
            self.left_out,
        )
    }
}

/// What a graph shall serve, besides what the project says.
#[derive(Default)]
pub(crate) struct Wish<'a> {
    /// The layer that is being edited: what lies below it is kept.
    pub(crate) pinned: Option<&'a LayerId>,
    /// Colours over all others that say how the ground differs from that of another project.
    pub(crate) difference: Option<(&'a Project, HeightDifference)>,
}

/// Compiles a project. Files that are not open yet are left out; a project that is compiled again
/// when they are gets them.
pub(crate) fn compile(
    project: &Project,
    folder: &Path,
    sources: &Sources,
    nodes: &NodeCache,
    wish: &Wish<'_>,
) -> Compiled {
    let mut compiler = Compiler {
        builder: GraphBuilder::default(),
        planet: project.planet.body.figure(),
        folder,
        sources,
        nodes,
        used: BTreeMap::new(),
        warps: HashMap::new(),
        layers: HashMap::new(),
        details: Vec::new(),
        problems: Vec::new(),
        left_out: Vec::new(),
    };
    compiler.builder.keep_artefacts(nodes.elements.artefacts());
    let ground = compiler.heights(project);
    let (height, elements) = compiler.elements(project, ground);
    let normal = compiler.normals(height);
    let colours = compiler.colours(project, height, wish.pinned);
    let colour = match &wish.difference {
        Some((other, difference)) => {
            let shown = Shown {
                project,
                ground,
                height,
                elements: &elements,
            };
            Some(compiler.difference(&shown, other, *difference, colours))
        }
        None => colours,
    };
    if let Some(root) = colour {
        compiler.builder.cut(root, SampleType::Rgba8);
    }
    *nodes.nodes.lock() = compiler.used.into_iter().collect();
    *nodes.warps.lock() = compiler.warps;
    Compiled {
        graph: compiler.builder.build(),
        roots: Roots {
            ground,
            height,
            colour,
            normal,
        },
        elements,
        layers: compiler.layers,
        details: compiler.details,
        problems: compiler.problems,
        left_out: compiler.left_out,
    }
}

struct Compiler<'a> {
    builder: GraphBuilder,
    planet: Planet,
    folder: &'a Path,
    sources: &'a Sources,
    nodes: &'a NodeCache,
    used: BTreeMap<String, Arc<dyn ImageNode>>,
    warps: HashMap<String, Arc<Warp>>,
    layers: HashMap<NodeIndex, LayerId>,
    details: Vec<Detail>,
    problems: Vec<Message>,
    left_out: Vec<(LayerId, &'static str)>,
}

impl Compiler<'_> {
    fn add(&mut self, layer: &Layer, node: Arc<dyn ImageNode>, inputs: &[NodeIndex]) -> NodeIndex {
        let index = self.builder.add(node, inputs);
        self.layers.insert(index, layer.id.clone());
        index
    }

    /// Whether a layer can have any effect; notes why not.
    fn takes_part(&mut self, layer: &Layer) -> bool {
        let reason = if !layer.visible {
            "hidden"
        } else if layer.opacity <= 0.0 {
            "opacity 0"
        } else if matches!(layer.kind, LayerKind::Unknown { .. }) {
            "unknown kind"
        } else {
            return true;
        };
        self.left_out.push((layer.id.clone(), reason));
        false
    }

    fn heights(&mut self, project: &Project) -> NodeIndex {
        // Where no source has a height the ground is at the datum, so that there is no hole in it.
        let mut below = self.builder.add(Arc::new(Constant::height(0.0)), &[]);
        for layer in &project.layers {
            let is_height = matches!(layer.kind, LayerKind::Height(_) | LayerKind::Noise(_));
            if !is_height || !self.takes_part(layer) {
                continue;
            }
            if let Some(over) = self.height_layer(layer, below) {
                below = over;
            }
        }
        self.builder.cut(below, SampleType::Height);
        below
    }

    /// What the planning elements of the shown scenario make of the ground.
    fn elements(&mut self, project: &Project, ground: NodeIndex) -> (NodeIndex, Elements) {
        let elements = project.elements_in(project.scenario.as_ref());
        let plan = self.nodes.elements.plan(self.planet, &elements);
        for (element, text) in &plan.warnings {
            self.problems.push(Message {
                severity: Severity::Warning,
                layer: None,
                element: Some(element.clone()),
                text: text.clone(),
            });
        }
        let Some(node) = plan.node(self.planet) else {
            return (ground, Elements::default());
        };
        let planned = self
            .builder
            .add(Arc::clone(&node) as Arc<dyn ImageNode>, &[ground]);
        self.builder.cut(planned, SampleType::Height);
        if let Some(detail_m) = plan.detail_m() {
            self.details.push(Detail {
                node: planned,
                finest: level_of_step(detail_m / self.planet.radius_m),
                within: Some(Arc::clone(&node)),
            });
        }
        let elements = Elements {
            node: Some(node),
            ids: plan.placed.into_iter().map(|(id, _)| id).collect(),
        };
        (planned, elements)
    }

    fn height_layer(&mut self, layer: &Layer, below: NodeIndex) -> Option<NodeIndex> {
        let opacity = layer.opacity as f32;
        match &layer.kind {
            LayerKind::Height(height) => {
                let file = self.open(layer)?;
                let finest =
                    level_of_step(self.warp(layer, &file, &height.source)?.finest_step_rad());
                let (scale, offset) = (height.vertical_scale, height.offset_m);
                let top = self.file_node(layer, &file, &height.source, (scale, offset))?;
                self.builder.cut(top, SampleType::Height);
                self.details.push(Detail::everywhere(top, finest));
                let (inputs, masked) = self.with_fade(layer, &file, &height.source, below, top)?;
                Some(self.add(
                    layer,
                    Arc::new(OverlayHeights::new(opacity, masked)),
                    &inputs,
                ))
            }
            LayerKind::Noise(noise) => {
                let params = &noise.noise;
                // Noise that adds is scaled by its opacity, so that half of it is half as high.
                let share = if params.mode == NoiseMode::Add {
                    layer.opacity
                } else {
                    1.0
                };
                let node = Noise::new(
                    self.planet,
                    &NoiseParams {
                        seed: u64::from(params.seed),
                        amplitude_m: params.amplitude_m * share,
                        wavelength_m: params.wavelength_m,
                        octaves: params.octaves,
                        lacunarity: params.lacunarity,
                        gain: params.gain,
                        ridged: params.ridged,
                    },
                );
                let mut top = self.add(layer, Arc::new(node), &[]);
                self.builder.cut(top, SampleType::Height);
                let shortest_m = params.wavelength_m
                    / params
                        .lacunarity
                        .powi(params.octaves.saturating_sub(1) as i32);
                let step_rad = shortest_m / (4.0 * self.planet.radius_m);
                self.details
                    .push(Detail::everywhere(top, level_of_step(step_rad)));
                if params.offset_m != 0.0 {
                    let offset = Constant::height((params.offset_m * share) as f32);
                    let offset = self.add(layer, Arc::new(offset), &[]);
                    top = self.add(layer, Arc::new(AddHeights), &[top, offset]);
                }
                Some(match params.mode {
                    NoiseMode::Replace => self.add(
                        layer,
                        Arc::new(OverlayHeights::new(opacity, false)),
                        &[below, top],
                    ),
                    NoiseMode::Add => self.add(layer, Arc::new(AddHeights), &[below, top]),
                })
            }
            LayerKind::Imagery(_)
            | LayerKind::Tint(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. } => None,
        }
    }

    /// Normals of the ground as it is; front-ends steepen them with the heights they draw.
    fn normals(&mut self, height: NodeIndex) -> Option<NodeIndex> {
        if self.details.is_empty() {
            return None;
        }
        let node = self
            .builder
            .add(Arc::new(Normals::new(self.planet, 1.0)), &[height]);
        self.builder.cut(node, SampleType::Normal);
        Some(node)
    }

    fn colours(
        &mut self,
        project: &Project,
        height: NodeIndex,
        pinned: Option<&LayerId>,
    ) -> Option<NodeIndex> {
        let mut below: Option<NodeIndex> = None;
        for layer in &project.layers {
            let is_colour = matches!(
                layer.kind,
                LayerKind::Imagery(_) | LayerKind::Tint(_) | LayerKind::Vector(_)
            );
            if !is_colour || !self.takes_part(layer) {
                continue;
            }
            if let (true, Some(below)) = (pinned == Some(&layer.id), below) {
                // What lies below the layer that is being edited is kept as exact f32, so that a
                // slider never evaluates it again. Exact, so no byte of the result changes.
                self.pin(below);
            }
            let base = match below {
                Some(below) => below,
                None => self.builder.add(Arc::new(Constant::colour([0.0; 4])), &[]),
            };
            if let Some(over) = self.colour_layer(layer, base, height) {
                below = Some(over);
            }
        }
        self.element_colours(project, below)
    }

    /// Planning elements' own colours over all layers.
    fn element_colours(
        &mut self,
        project: &Project,
        mut below: Option<NodeIndex>,
    ) -> Option<NodeIndex> {
        let elements = project.elements_in(project.scenario.as_ref());
        for run in element_colours::painted(&elements) {
            let planet = self.planet;
            let name = format!("{} {planet:?}", run.name());
            let kept = self.nodes.nodes.lock().get(&name).cloned();
            let made = kept.map_or_else(|| run.node(planet), Ok);
            let node = match made {
                Ok(node) => node,
                Err(text) => {
                    self.problems.push(Message {
                        severity: Severity::Warning,
                        layer: None,
                        element: None,
                        text: format!("colours of planning elements: {text}"),
                    });
                    continue;
                }
            };
            self.used.insert(name, Arc::clone(&node));
            let top = self.builder.add(node, &[]);
            self.builder.cut(top, SampleType::Rgba8);
            let finest = level_of_step(vectors::FINEST_M / planet.radius_m);
            self.details.push(Detail::everywhere(top, finest));
            let base = match below {
                Some(below) => below,
                None => self.builder.add(Arc::new(Constant::colour([0.0; 4])), &[]),
            };
            let overlay = Overlay::new(BlendMode::Normal, 1.0, false);
            below = Some(self.builder.add(Arc::new(overlay), &[base, top]));
        }
        below
    }

    fn pin(&mut self, node: NodeIndex) {
        self.builder.cut(node, SampleType::Rgba32F);
    }

    fn colour_layer(
        &mut self,
        layer: &Layer,
        base: NodeIndex,
        height: NodeIndex,
    ) -> Option<NodeIndex> {
        let opacity = layer.opacity as f32;
        match &layer.kind {
            LayerKind::Imagery(imagery) => {
                let file = self.open(layer)?;
                let finest =
                    level_of_step(self.warp(layer, &file, &imagery.source)?.finest_step_rad());
                let top = self.file_node(layer, &file, &imagery.source, (1.0, 0.0))?;
                let deep = file.info().deep_colour;
                self.builder.cut(
                    top,
                    if deep {
                        SampleType::Rgba16F
                    } else {
                        SampleType::Rgba8
                    },
                );
                self.details.push(Detail::everywhere(top, finest));
                let adjusted = self.adjusted(layer, &imagery.adjust, top);
                let (inputs, masked) =
                    self.with_fade(layer, &file, &imagery.source, base, adjusted)?;
                let overlay = Overlay::new(blend_mode(imagery.blend), opacity, masked);
                Some(self.add(layer, Arc::new(overlay), &inputs))
            }
            LayerKind::Tint(tint) => {
                let stops: Vec<Stop> = tint
                    .tint
                    .stops
                    .iter()
                    .map(|s| {
                        let [r, g, b] = s.colour.map(relievo_raster::colour::from_u8);
                        Stop {
                            height_m: s.height_m as f32,
                            rgba: [r, g, b, 1.0],
                        }
                    })
                    .collect();
                let smooth = tint.tint.interpolation == TintInterpolation::Smooth;
                let node = Tint::new(&stops, smooth).map_err(|e| e.to_string());
                let node = self.keep(layer, node)?;
                let top = self.add(layer, node, &[height]);
                let adjusted = self.adjusted(layer, &tint.adjust, top);
                let overlay = Overlay::new(blend_mode(tint.blend), opacity, false);
                Some(self.add(layer, Arc::new(overlay), &[base, adjusted]))
            }
            LayerKind::Vector(vector) => {
                let top = self.vector_node(layer, vector)?;
                self.builder.cut(top, SampleType::Rgba8);
                let finest = level_of_step(vectors::FINEST_M / self.planet.radius_m);
                self.details.push(Detail::everywhere(top, finest));
                let overlay = Overlay::new(BlendMode::Normal, opacity, false);
                Some(self.add(layer, Arc::new(overlay), &[base, top]))
            }
            LayerKind::Height(_) | LayerKind::Noise(_) | LayerKind::Unknown { .. } => None,
        }
    }

    fn adjusted(&mut self, layer: &Layer, adjust: &ProjectAdjust, top: NodeIndex) -> NodeIndex {
        if adjust.is_identity() {
            return top;
        }
        let params = AdjustParams {
            gain: adjust.gain,
            // The project's brightness is a sum, as users of image editors know it.
            offset: adjust.offset.map(|o| o + adjust.brightness),
            contrast: adjust.contrast,
            hue_deg: adjust.hue_deg,
            saturation: adjust.saturation,
            gamma: adjust.gamma,
            ..AdjustParams::default()
        };
        self.add(layer, Arc::new(Adjust::new(&params)), &[top])
    }

    /// A vector layer's features in its style; kept while neither changes.
    fn vector_node(&mut self, layer: &Layer, vector: &VectorLayer) -> Option<NodeIndex> {
        let SourceState::Features(open) = self.ready(layer)? else {
            return None;
        };
        let features = Arc::clone(&open.features);
        let style = vectors::style(&vector.style);
        let address = Arc::as_ptr(&features).addr();
        let planet = self.planet;
        let name = format!("vector {address} {style:?} {planet:?}");
        let node = self.nodes.get(&mut self.used, name, || {
            Arc::new(Vector::new(Arc::new(Drawing::new(features, style, planet))))
        });
        Some(self.add(layer, node, &[]))
    }

    /// The layer's open file; notes why there is none.
    fn open(&mut self, layer: &Layer) -> Option<Arc<dyn RasterFile>> {
        match self.ready(layer)? {
            SourceState::Open(file) => Some(file),
            SourceState::Opening(_) | SourceState::Features(_) | SourceState::Failed(_) => None,
        }
    }

    /// What the layer's file was opened as; notes why it is not.
    fn ready(&mut self, layer: &Layer) -> Option<SourceState> {
        match self.sources.state(&layer.kind, self.folder)? {
            open @ (SourceState::Open(_) | SourceState::Features(_)) => return Some(open),
            SourceState::Opening(_) => self
                .left_out
                .push((layer.id.clone(), "file is being opened")),
            SourceState::Failed(reason) => {
                self.left_out
                    .push((layer.id.clone(), "file cannot be opened"));
                self.complain(layer, reason);
            }
        }
        None
    }

    fn complain(&mut self, layer: &Layer, text: String) {
        self.problems.push(Message {
            severity: Severity::Error,
            layer: Some(layer.id.clone()),
            element: None,
            text,
        });
    }

    /// The node, or `None` and a complaint.
    fn keep<N: ImageNode + 'static>(
        &mut self,
        layer: &Layer,
        node: Result<N, String>,
    ) -> Option<Arc<dyn ImageNode>> {
        match node {
            Ok(node) => Some(Arc::new(node)),
            Err(reason) => {
                self.complain(layer, reason);
                None
            }
        }
    }

    fn file_node(
        &mut self,
        layer: &Layer,
        file: &Arc<dyn RasterFile>,
        source: &Source,
        (scale, offset_m): (f64, f64),
    ) -> Option<NodeIndex> {
        let kernel = kernel(source.resampling);
        let warp = self.warp(layer, file, source)?;
        let name = format!(
            "file {} {kernel:?} {scale} {offset_m} {:?}",
            address(file),
            self.planet
        );
        let node = self.nodes.get(&mut self.used, name, || {
            Arc::new(FileSource::new(warp, kernel, scale, offset_m))
        });
        Some(self.add(layer, node, &[]))
    }

    /// How the file is brought onto grids; complains where it cannot be.
    fn warp(
        &mut self,
        layer: &Layer,
        file: &Arc<dyn RasterFile>,
        source: &Source,
    ) -> Option<Arc<Warp>> {
        let kernel = kernel(source.resampling);
        let name = format!("{} {kernel:?} {:?}", address(file), self.planet);
        if let Some(warp) = self.nodes.warps.lock().get(&name) {
            self.warps.insert(name, Arc::clone(warp));
            return Some(Arc::clone(warp));
        }
        match Warp::new(Arc::clone(file), self.planet, kernel) {
            Ok(warp) => {
                let warp = Arc::new(warp);
                self.warps.insert(name, Arc::clone(&warp));
                Some(warp)
            }
            Err(error) => {
                self.complain(layer, error.to_string());
                None
            }
        }
    }

    /// Inputs of an overlay: base, top and, if the source fades at its edge, the mask.
    fn with_fade(
        &mut self,
        layer: &Layer,
        file: &Arc<dyn RasterFile>,
        source: &Source,
        base: NodeIndex,
        top: NodeIndex,
    ) -> Option<(Vec<NodeIndex>, bool)> {
        if source.edge_fade_m <= 0.0 {
            return Some((vec![base, top], false));
        }
        let width_m = source.edge_fade_m;
        let warp = self.warp(layer, file, source)?;
        let name = format!("fade {} {width_m} {:?}", address(file), self.planet);
        let node = self.nodes.get(&mut self.used, name, || {
            Arc::new(EdgeFade::new(warp, width_m))
        });
        let mask = self.add(layer, node, &[]);
        // Places are dear, and no slider changes them.
        self.builder.cut(mask, SampleType::Mask32F);
        Some((vec![base, top, mask], true))
    }
}

/// Names an open file for as long as it is open.
fn address(file: &Arc<dyn RasterFile>) -> usize {
    Arc::as_ptr(file).cast::<()>().addr()
}

fn blend_mode(blend: Blend) -> BlendMode {
    match blend {
        Blend::Normal => BlendMode::Normal,
        Blend::Multiply => BlendMode::Multiply,
        Blend::Add => BlendMode::Add,
        Blend::Screen => BlendMode::Screen,
        Blend::Overlay => BlendMode::Overlay,
    }
}

fn kernel(resampling: Resampling) -> Kernel {
    match resampling {
        Resampling::Nearest => Kernel::Nearest,
        Resampling::Bilinear => Kernel::Bilinear,
        Resampling::Bicubic => Kernel::Bicubic,
    }
}

/// The coarsest level whose samples are no longer than `step_rad` of colatitude.
fn level_of_step(step_rad: f64) -> u8 {
    (0..FINEST)
        .find(|n| LevelKey::new(0, *n).step_rad().y <= step_rad * 1.01)
        .unwrap_or(FINEST)
}
