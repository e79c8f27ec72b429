//! From a project to a graph: one pass over the layers, bottom to top.
//!
//! Heights first, then colours, which may read them. What a scene does not use is not compiled:
//! hidden layers, layers whose file is missing, identity adjustments.

mod adjust;
mod colours;
mod detail;
mod difference;
mod heights;
mod imagery;
mod marks;
mod mask;
mod relief;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

use parking_lot::Mutex;
use relievo_graph::nodes::{EdgeDistances, FileSource, RangeMask};
use relievo_graph::{Graph, GraphBuilder, ImageNode, NodeIndex};
use relievo_planet::{LevelKey, Planet};
use relievo_project::{Layer, LayerId, LayerKind, NoiseMode, Project, Resampling, Source};
use relievo_raster::kernel::Kernel;
use relievo_raster::warp::Warp;
use relievo_raster::{RasterFile, SampleType};

pub(crate) use self::adjust::adjustment;
use self::difference::Shown;
use crate::difference::HeightDifference;
use crate::element_colours::PaintedCache;
use crate::elements::ElementCache;
use crate::marks::Mark;
use crate::message::{Message, Severity};
use crate::scene::{Detail, Elements, LayerNodes, Roots, Scene};
use crate::sources::{SourceState, Sources};

/// Finest level of any source: 4.7 mm on Earth.
const FINEST: u8 = 24;

/// Nodes that are dear to prepare (edge distances, coverage of tiles), kept from revision to
/// revision while a layer uses them.
#[derive(Default)]
pub(crate) struct NodeCache {
    nodes: Mutex<HashMap<String, Arc<dyn ImageNode>>>,
    warps: Mutex<HashMap<String, Arc<Warp>>>,
    elements: ElementCache,
    painted: PaintedCache,
}

impl NodeCache {
    /// Keeps what a shown revision uses, and nothing else. Questions keep nothing: they would push out what
    /// the next revision has in common with the shown one.
    pub(crate) fn keep(&self, compiled: &mut Compiled) {
        let nodes = std::mem::take(&mut compiled.used);
        *self.nodes.lock() = nodes.into_iter().collect();
        *self.warps.lock() = std::mem::take(&mut compiled.warps);
    }

    /// Number of nodes and geometries that are kept.
    pub(crate) fn len(&self) -> usize {
        self.nodes.lock().len() + self.warps.lock().len() + self.elements.len() + self.painted.len()
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
    layers: LayerNodes,
    details: Vec<Detail>,
    /// What [`NodeCache`] may keep of it.
    used: BTreeMap<String, Arc<dyn ImageNode>>,
    warps: HashMap<String, Arc<Warp>>,
    pub(crate) problems: Vec<Message>,
    /// What the compiled graph leaves out, and why, for statistics.
    pub(crate) left_out: Vec<(LayerId, &'static str)>,
    pub(crate) mixed_apart: bool,
}

impl Compiled {
    /// The scene; names that `last` knows and that are the same are not found out again.
    pub(crate) fn into_scene(self, revision: u64, last: Option<&Scene>) -> Scene {
        let mixed_apart = self.mixed_apart;
        let mut scene = Scene::new(
            (revision, last),
            Arc::new(self.graph),
            self.roots,
            self.elements,
            self.layers,
            self.details,
            self.left_out,
        );
        scene.mixed_apart = mixed_apart;
        scene
    }
}

/// The layers that are being edited.
#[derive(Clone, Copy)]
pub(crate) struct Pinned<'a> {
    pub(crate) lowest: &'a LayerId,
    pub(crate) topmost: &'a LayerId,
    /// Whether they change from moment to moment: what lies above them is then kept too, put together by
    /// itself, which rounds otherwise than layer by layer.
    pub(crate) dragged: bool,
}

/// What a graph shall serve, besides what the project says.
#[derive(Default)]
pub(crate) struct Wish<'a> {
    /// The layers that are being edited: what lies around them is kept.
    pub(crate) pinned: Option<Pinned<'a>>,
    /// Colours over all others that say how the ground differs from that of another project.
    pub(crate) difference: Option<(&'a Project, HeightDifference)>,
    /// Colours over all others where heights or colours are synthesised.
    pub(crate) synthesised: bool,
    /// What lies over all colours, the first at the bottom.
    pub(crate) marks: &'a [Mark],
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
        layers: LayerNodes::default(),
        details: Vec::new(),
        problems: Vec::new(),
        left_out: Vec::new(),
        mixed_apart: false,
    };
    compiler.builder.keep_artefacts(nodes.elements.artefacts());
    let ground = compiler.heights(project);
    let (height, elements) = compiler.elements(project, ground);
    let normal = compiler.normals(height);
    let colours = compiler.colours(project, Ground { height, normal }, wish.pinned);
    let colour = match &wish.difference {
        Some((other, difference)) => {
            let shown = Shown {
                project,
                ground,
                height,
                elements: &elements,
            };
            compiler.difference(&shown, other, *difference, colours)
        }
        None => colours,
    };
    let colour = if wish.synthesised {
        compiler.synthesised(project, Ground { height, normal }, colour)
    } else {
        colour
    };
    let colour = compiler.marks(wish.marks, colour);
    if let Some(root) = colour {
        compiler.builder.cut(root, SampleType::Rgba8);
    }
    Compiled {
        used: compiler.used,
        warps: compiler.warps,
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
        mixed_apart: compiler.mixed_apart,
    }
}

/// Which edge distances are measured to, and how many metres are enough.
#[derive(Clone, Copy, Debug)]
enum ToEdge {
    /// Outline and holes.
    Any(f64),
    /// The outline alone.
    Outline(f64),
}

/// The shown ground.
#[derive(Clone, Copy)]
struct Ground {
    height: NodeIndex,
    /// `None` where no layer gives heights.
    normal: Option<NodeIndex>,
}

struct Compiler<'a> {
    builder: GraphBuilder,
    planet: Planet,
    folder: &'a Path,
    sources: &'a Sources,
    nodes: &'a NodeCache,
    used: BTreeMap<String, Arc<dyn ImageNode>>,
    warps: HashMap<String, Arc<Warp>>,
    layers: LayerNodes,
    details: Vec<Detail>,
    problems: Vec<Message>,
    left_out: Vec<(LayerId, &'static str)>,
    mixed_apart: bool,
}

impl Compiler<'_> {
    fn add(&mut self, layer: &Layer, node: Arc<dyn ImageNode>, inputs: &[NodeIndex]) -> NodeIndex {
        let index = self.builder.add(node, inputs);
        self.layers.of.insert(index, layer.id.clone());
        index
    }

    /// A node that is dear to name: that of the last revision if `name`, which says all of it, is the same.
    /// Tiles of what is the same from revision to revision are named once.
    fn same<N: ImageNode + 'static>(
        &mut self,
        name: String,
        make: impl FnOnce() -> N,
    ) -> Arc<dyn ImageNode> {
        self.nodes.get(&mut self.used, name, || Arc::new(make()))
    }

    /// Whether a layer can have any effect; notes why not.
    fn takes_part(&mut self, project: &Project, layer: &Layer) -> bool {
        let reason = if !layer.visible {
            "hidden"
        } else if layer.is_superseded(&project.layers, project.date) {
            "another date is shown"
        } else if layer.opacity <= 0.0 {
            "opacity 0"
        } else if matches!(layer.kind, LayerKind::Unknown { .. }) {
            "unknown kind"
        } else if let Some(reason) = layer
            .mask
            .as_ref()
            .and_then(|mask| self.hides_all(mask, project))
        {
            reason
        } else if let Some(reason) = without_effect(&layer.kind) {
            reason
        } else {
            return true;
        };
        self.left_out.push((layer.id.clone(), reason));
        false
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
            Arc::new(FileSource::new(warp, scale, offset_m))
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
    ) -> Option<Vec<NodeIndex>> {
        if source.edge_fade_m <= 0.0 {
            return Some(vec![base, top]);
        }
        let width_m = source.edge_fade_m;
        // A slider that widens the fade rarely asks for distances anew.
        let most_m = 2.0_f64.powi(width_m.log2().ceil() as i32).max(width_m);
        // Holes that are filled are no edges.
        let filled = matches!(&layer.kind, LayerKind::Imagery(i) if i.missing.is_some());
        let to = if filled {
            ToEdge::Outline(most_m)
        } else {
            ToEdge::Any(most_m)
        };
        let distances = self.edge_distances(layer, file, source, to)?;
        let fade = self.same(format!("fade {width_m}"), || {
            RangeMask::new(width_m, f64::NAN, width_m)
        });
        let mask = self.add(layer, fade, &[distances]);
        Some(vec![base, top, mask])
    }

    /// Metres to where a file's data end, kept: places are dear, and no slider changes them.
    fn edge_distances(
        &mut self,
        layer: &Layer,
        file: &Arc<dyn RasterFile>,
        source: &Source,
        to: ToEdge,
    ) -> Option<NodeIndex> {
        let warp = self.warp(layer, file, source)?;
        let (file, kernel) = (address(file), source.resampling);
        let name = format!("edge {to:?} {file} {kernel:?} {:?}", self.planet);
        let node = self.same(name, || match to {
            ToEdge::Any(most_m) => EdgeDistances::new(warp, most_m),
            ToEdge::Outline(most_m) => EdgeDistances::to_outline(warp, most_m),
        });
        let distances = self.add(layer, node, &[]);
        self.builder.cut(distances, SampleType::Height);
        Some(distances)
    }
}

/// The project as measurements see it: without detail beyond the data.
pub(crate) fn without_detail(project: &Project) -> Project {
    let mut bare = project.clone();
    bare.layers
        .retain(|layer| !matches!(layer.kind, LayerKind::Detail(_)));
    for layer in &mut bare.layers {
        if let LayerKind::Imagery(imagery) = &mut layer.kind {
            imagery.detail.clear();
        }
    }
    bare
}

/// Why a layer of this kind cannot change any sample, if so.
fn without_effect(kind: &LayerKind) -> Option<&'static str> {
    match kind {
        LayerKind::Noise(layer) => {
            let noise = &layer.noise;
            let adds = noise.mode == NoiseMode::Add;
            (adds && noise.amplitude_m == 0.0 && noise.offset_m == 0.0).then_some("adds nothing")
        }
        LayerKind::Detail(detail) => (detail.detail.strength == 0.0).then_some("adds nothing"),
        LayerKind::Slope(slope) => (slope.stops.iter().all(|s| s.opacity <= 0.0))
            .then_some("all of its colours are transparent"),
        LayerKind::Contours(lines) => {
            let no_index = lines.index_every == 0 || lines.index_width_px <= 0.0;
            (lines.width_px <= 0.0 && no_index).then_some("its lines have no width")
        }
        LayerKind::Height(_)
        | LayerKind::Imagery(_)
        | LayerKind::Tint(_)
        | LayerKind::Vector(_)
        | LayerKind::Unknown { .. } => None,
    }
}

/// Names an open file for as long as it is open.
fn address(file: &Arc<dyn RasterFile>) -> usize {
    Arc::as_ptr(file).cast::<()>().addr()
}

fn kernel(resampling: Resampling) -> Kernel {
    match resampling {
        Resampling::Nearest => Kernel::Nearest,
        Resampling::Bilinear => Kernel::Bilinear,
        Resampling::Bicubic => Kernel::Bicubic,
    }
}

/// The coarsest level whose samples are no longer than `step_rad` of colatitude.
pub(crate) fn level_of_step(step_rad: f64) -> u8 {
    (0..FINEST)
        .find(|n| LevelKey::new(0, *n).step_rad().y <= step_rad * 1.01)
        .unwrap_or(FINEST)
}
