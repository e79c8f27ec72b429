//! Corridors: an axis with heights, cut into frames.

use glam::DVec2;
use relievo_planet::{MapPoint, Planet};

use crate::check;
use crate::element::{Corridor, Profile, Section, Side};
use crate::envelope::{Envelope, Segment};
use crate::footprint::Footprint;
use crate::frame::Frame;
use crate::prepared::GroundNeed;
use crate::solid::{Interior, Part, Solid};
use crate::strip::{Axis, Strip, half_turn, half_width_m, mean_above_edge_m};
use crate::warning::{WarningKind, Warnings};

/// A frame holds no more of a corridor than this, but for single longer segments.
const FRAME_M: f64 = 20_000.0;

/// A frame holds no more segments than this.
const FRAME_SEGMENTS: usize = 2_000;

/// Places where the ground is read along an axis, at most.
const MOST_STATIONS: f64 = 20_000.0;

/// A corner of the axis: where, how far along, and its height.
#[derive(Clone, Copy, Debug)]
struct Station {
    place: MapPoint,
    along_m: f64,
    height_m: Option<f64>,
}

/// A corridor that waits for heights of the ground.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    planet: Planet,
    stations: Vec<Station>,
    profile: Profile,
    section: Section,
    side: Side,
    spacing_m: f64,
}

impl Draft {
    /// Checks a corridor; `None` if there is nothing to draw.
    pub(crate) fn new(
        planet: Planet,
        corridor: &Corridor,
        side: &Side,
        warnings: &mut Warnings,
    ) -> Option<Self> {
        let mut stations: Vec<Station> = Vec::new();
        for v in &corridor.line {
            if !check::place(v.place, warnings) {
                continue;
            }
            let height_m = check::height(v.height_m, warnings);
            let place = v.place.normalised();
            let mut along_m = 0.0;
            if let Some(last) = stations.last_mut() {
                let length = Frame::new(planet, last.place).from_map(place).length();
                if length <= 1e-3 {
                    warnings.add(WarningKind::DuplicateVertex, Some(place));
                    last.height_m = last.height_m.or(height_m);
                    continue;
                }
                along_m = last.along_m + length;
            }
            stations.push(Station {
                place,
                along_m,
                height_m,
            });
        }
        if stations.len() < 2 {
            warnings.add(WarningKind::NoExtent, stations.first().map(|s| s.place));
            return None;
        }
        let section = check::section(&corridor.section, warnings);
        let side = check::side(side, warnings);
        let length = stations[stations.len() - 1].along_m;
        let mut spacing_m = half_width_m(&section).max(0.1);
        let profile = match corridor.profile {
            Profile::Heights => Profile::Heights,
            Profile::Follow { offset_m, smooth_m } => {
                let smooth_m = check::number(smooth_m, &(0.0..=1e6), 0.0, warnings);
                spacing_m = spacing_m.max(smooth_m / 8.0);
                if length / spacing_m > MOST_STATIONS {
                    spacing_m = length / MOST_STATIONS;
                    warnings.add(WarningKind::CoarseGround, None);
                }
                Profile::Follow {
                    offset_m: check::number(offset_m, &check::HEIGHTS_M, 0.0, warnings),
                    smooth_m,
                }
            }
        };
        let mut draft = Self {
            planet,
            stations,
            profile,
            section,
            side,
            spacing_m,
        };
        if let Profile::Follow { .. } = draft.profile {
            draft.refine();
        } else {
            draft.interpolate();
        }
        Some(draft)
    }

    /// Adds stations where the ground is to be read.
    fn refine(&mut self) {
        let mut fine = vec![self.stations[0]];
        for pair in self.stations.windows(2) {
            let length = pair[1].along_m - pair[0].along_m;
            let (frame, a, b) = segment_frame(self.planet, pair[0].place, pair[1].place);
            let parts = (length / self.spacing_m).ceil().clamp(1.0, MOST_STATIONS);
            for k in 1..parts as usize {
                let share = k as f64 / parts;
                fine.push(Station {
                    place: frame.to_map(a + (b - a) * share),
                    along_m: pair[0].along_m + share * length,
                    height_m: None,
                });
            }
            fine.push(pair[1]);
        }
        self.stations = fine;
    }

    /// Leaves out missing heights between given ones.
    fn interpolate(&mut self) {
        let known: Vec<(f64, f64)> = self
            .stations
            .iter()
            .filter_map(|s| Some((s.along_m, s.height_m?)))
            .collect();
        for s in &mut self.stations {
            let after = known.partition_point(|k| k.0 <= s.along_m);
            if s.height_m.is_none() && after > 0 && after < known.len() {
                let (a, b) = (known[after - 1], known[after]);
                let share = (s.along_m - a.0) / (b.0 - a.0);
                s.height_m = Some(a.1 + share * (b.1 - a.1));
            }
        }
    }

    fn half_m(&self) -> f64 {
        half_width_m(&self.section)
    }

    fn reach_m(&self) -> f64 {
        if self.side.wall {
            0.0
        } else {
            self.side.max_reach_m
        }
    }

    /// Area within the reach, about.
    pub(crate) fn area_m2(&self) -> f64 {
        let around = 2.0 * (self.half_m() + self.reach_m());
        around * (self.stations[self.stations.len() - 1].along_m + around)
    }

    /// Runs of stations that share a frame: first and last.
    fn runs(&self) -> Vec<(usize, usize)> {
        let mut runs = Vec::new();
        let mut first = 0;
        for i in 1..self.stations.len() {
            let long = self.stations[i].along_m - self.stations[first].along_m > FRAME_M;
            if i - first > 1 && (long || i - first > FRAME_SEGMENTS) {
                runs.push((first, i - 1));
                first = i - 1;
            }
        }
        runs.push((first, self.stations.len() - 1));
        runs
    }

    fn frame_of(&self, (first, last): (usize, usize)) -> Frame {
        if last - first == 1 {
            return segment_frame(
                self.planet,
                self.stations[first].place,
                self.stations[last].place,
            )
            .0;
        }
        let places = self.stations[first..=last].iter().map(|s| s.place);
        check::frame_amid(self.planet, places)
            .unwrap_or_else(|| Frame::new(self.planet, self.stations[first].place))
    }

    pub(crate) fn footprint(&self) -> Footprint {
        let parts = self
            .runs()
            .into_iter()
            .map(|run| {
                let frame = self.frame_of(run);
                let points: Vec<DVec2> = self.stations[run.0..=run.1]
                    .iter()
                    .map(|s| frame.from_map(s.place))
                    .collect();
                (frame, points.windows(2).map(|p| (p[0], p[1])).collect())
            })
            .collect();
        Footprint::new(parts, None, self.reach_m() + self.half_m() * 1.001)
    }

    /// Stations whose heights come from the ground.
    fn stations_on_ground(&self) -> Vec<usize> {
        match self.profile {
            Profile::Follow { .. } => (0..self.stations.len()).collect(),
            Profile::Heights => {
                let ends = [0, self.stations.len() - 1];
                let missing = |i: &usize| self.stations[*i].height_m.is_none();
                // Beyond the outermost given heights the ground is read at the ends only.
                ends.into_iter().filter(missing).collect()
            }
        }
    }

    /// Heights of the ground that decide it.
    pub(crate) fn need(&self) -> Option<GroundNeed> {
        let wanted = self.stations_on_ground();
        (!wanted.is_empty()).then(|| GroundNeed {
            places: wanted.iter().map(|i| self.stations[*i].place).collect(),
            spacing_m: self.spacing_m,
        })
    }

    /// The corridor; `ground_m` are the heights that [`Self::need`] asks for, all finite.
    pub(crate) fn shape(&self, ground_m: &[f64], warnings: &mut Warnings) -> Solid {
        let mut with_heights = self.clone();
        for (i, h) in self.stations_on_ground().into_iter().zip(ground_m) {
            with_heights.stations[i].height_m = Some(*h);
        }
        with_heights.interpolate();
        let mut heights: Vec<f64> = with_heights
            .stations
            .iter()
            .map(|s| s.height_m.unwrap_or(0.0))
            .collect();
        if let Profile::Follow { offset_m, smooth_m } = self.profile {
            heights = averaged(&self.stations, &heights, smooth_m);
            for h in &mut heights {
                *h += offset_m;
            }
        }
        self.solid(&heights, warnings)
    }

    fn solid(&self, heights: &[f64], warnings: &mut Warnings) -> Solid {
        let slopes = (!self.side.wall).then_some((self.side.cut_slope, self.side.fill_slope));
        let mut parts = Vec::new();
        for run in self.runs() {
            let frame = self.frame_of(run);
            let at = |i: usize| frame.from_map(self.stations[i].place);
            let turn = |i: usize| {
                if i == 0 || i + 1 == self.stations.len() {
                    0.0
                } else {
                    half_turn(at(i) - at(i - 1), at(i + 1) - at(i))
                }
            };
            let axis = |i: usize| Axis {
                from: at(i),
                to: at(i + 1),
                from_m: heights[i],
                to_m: heights[i + 1],
                turn_from: turn(i),
                turn_to: turn(i + 1),
                first: i == 0,
                last: i + 2 == self.stations.len(),
            };
            let strip = Strip::new((run.0..run.1).map(axis).collect(), self.section);
            let before = (run.0 > 0).then(|| axis(run.0 - 1));
            let segments: Vec<Segment> = strip.boundary(before.as_ref());
            if let Some((cut, fill)) = slopes {
                for s in segments.iter().filter(|s| s.grade() >= cut.min(fill)) {
                    let place = frame.to_map((s.from + s.to) * 0.5);
                    warnings.add(WarningKind::SteeperThanSide, Some(place));
                }
            }
            parts.push(Part {
                frame,
                envelope: Envelope::new(&segments, slopes),
                interior: Interior::Strip(strip),
            });
        }
        Solid {
            parts,
            slopes,
            reach_m: self.reach_m(),
            raises: !matches!(self.section, Section::Trench { .. }),
            lowers: !matches!(self.section, Section::Dam { .. }),
            on_ground: false,
            width_m: 2.0 * self.half_m(),
            length_m: self.stations[self.stations.len() - 1].along_m,
            mean_above_edge_m: mean_above_edge_m(&self.section),
        }
    }
}

/// A frame in the middle of a segment, where straight is geodesic, and the segment's ends.
fn segment_frame(planet: Planet, a: MapPoint, b: MapPoint) -> (Frame, DVec2, DVec2) {
    let here = Frame::new(planet, a);
    let middle = here.to_map(here.from_map(b) * 0.5);
    let frame = Frame::new(planet, middle);
    (frame, frame.from_map(a), frame.from_map(b))
}

/// Heights averaged over `window_m` along the axis (the integral of what is linear between stations),
/// less towards the ends so that these keep their heights.
fn averaged(stations: &[Station], heights: &[f64], window_m: f64) -> Vec<f64> {
    if window_m <= 0.0 {
        return heights.to_vec();
    }
    // Integral of the profile from the start.
    let mut sums = vec![0.0];
    for i in 1..stations.len() {
        let length = stations[i].along_m - stations[i - 1].along_m;
        sums.push(sums[i - 1] + length * f64::midpoint(heights[i - 1], heights[i]));
    }
    let integral = |s: f64| {
        let i = stations
            .partition_point(|x| x.along_m <= s)
            .clamp(1, stations.len() - 1);
        let (a, b) = (stations[i - 1].along_m, stations[i].along_m);
        let t = ((s - a) / (b - a)).clamp(0.0, 1.0);
        let (ha, hb) = (heights[i - 1], heights[i]);
        sums[i - 1] + (b - a) * t * (ha + 0.5 * t * (hb - ha))
    };
    let end = stations[stations.len() - 1].along_m;
    stations
        .iter()
        .zip(heights)
        .map(|(s, h)| {
            let half = (window_m / 2.0).min(s.along_m).min(end - s.along_m);
            if half > 1e-6 {
                (integral(s.along_m + half) - integral(s.along_m - half)) / (2.0 * half)
            } else {
                *h
            }
        })
        .collect()
}
