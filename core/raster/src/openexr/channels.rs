//! What the channels of a part mean.

use exr::meta::attribute::SampleType;
use exr::meta::header::Header;

use super::block::{Channel, RawBlock};
use super::part::Exr;
use crate::open::OpenOptions;
use crate::{Bands, colour};

/// Names of channels that hold heights, the likeliest first; compared without case and without the
/// names of layers before the last point.
const HEIGHT_NAMES: [&str; 7] = ["height", "elevation", "displacement", "h", "z", "y", "r"];

/// Brightest light that is kept: the largest half float.
const BRIGHTEST: f32 = 65504.0;

/// How samples become heights or colours.
pub(super) enum Meaning {
    Height {
        channel: Channel,
        name: String,
        nodata: Option<f32>,
    },
    Colour(Colours),
}

/// How samples become colours.
pub(super) struct Colours {
    pub(super) rgb: [Channel; 3],
    alpha: Option<Channel>,
    names: String,
    /// Linear light shown as 0 and 1; as it is where `None`.
    pub(super) range: Option<(f64, f64)>,
    nodata: Option<f32>,
}

impl Meaning {
    /// Chooses channels by the options, else by their names; an error says what was expected and
    /// found.
    pub(super) fn of(header: &Header, options: &OpenOptions) -> Result<Self, String> {
        let list = &header.channels.list;
        let names: Vec<String> = list.iter().map(|c| c.name.to_string()).collect();
        let pixel = header.channels.bytes_per_pixel;
        let mut before = 0;
        let channels: Vec<Channel> = list
            .iter()
            .map(|c| {
                let channel = Channel {
                    before,
                    pixel,
                    kind: c.sample_type,
                };
                before += c.sample_type.bytes_per_sample();
                channel
            })
            .collect();
        let find = |name: &str| {
            names
                .iter()
                .position(|n| n.rsplit('.').next().unwrap_or(n).eq_ignore_ascii_case(name))
        };
        let rgb = [find("R"), find("G"), find("B")];
        let bands = options.as_bands.unwrap_or(match rgb {
            [Some(_), Some(_), Some(_)] => Bands::Colour,
            _ => Bands::Height,
        });
        let nodata = options.nodata.map(|v| v as f32);
        let selected = match &options.select {
            Some(select) => Some(checked(select, list.len(), bands)?),
            None => None,
        };
        match bands {
            Bands::Height => {
                let only = || (list.len() == 1).then_some(0);
                let index = selected
                    .map(|s| s[0])
                    .or_else(|| HEIGHT_NAMES.iter().find_map(|n| find(n)))
                    .or_else(only)
                    .ok_or_else(|| {
                        format!(
                            "expected a channel called height, Y, H, Z or R or a chosen band, found {}",
                            names.join(", ")
                        )
                    })?;
                Ok(Self::Height {
                    channel: channels[index],
                    name: names[index].clone(),
                    nodata,
                })
            }
            Bands::Colour => {
                let alpha = find("A");
                let chosen = match (selected, rgb) {
                    (Some(s), _) if s.len() >= 3 => [s[0], s[1], s[2]],
                    (Some(s), _) => [s[0]; 3],
                    (None, [Some(r), Some(g), Some(b)]) => [r, g, b],
                    (None, _) => {
                        let grey = find("Y").or((0..list.len()).find(|i| Some(*i) != alpha));
                        let grey = grey.ok_or_else(|| {
                            format!("expected channels R, G and B, found {}", names.join(", "))
                        })?;
                        [grey; 3]
                    }
                };
                let shown = if chosen[0] == chosen[1] {
                    names[chosen[0]].clone()
                } else {
                    chosen.map(|i| names[i].as_str()).join(", ")
                };
                Ok(Self::Colour(Colours {
                    rgb: chosen.map(|i| channels[i]),
                    alpha: alpha.filter(|a| !chosen.contains(a)).map(|a| channels[a]),
                    names: shown,
                    range: None,
                    nodata,
                }))
            }
            other @ (Bands::Mask | Bands::Normal) => Err(format!(
                "OpenEXR files hold heights or colours, {other:?} was asked for"
            )),
        }
    }

    pub(super) fn bands(&self) -> Bands {
        match self {
            Self::Height { .. } => Bands::Height,
            Self::Colour(_) => Bands::Colour,
        }
    }

    /// Type, channels and part for people.
    pub(super) fn sample_type(&self, exr: &Exr) -> String {
        let (kind, names) = match self {
            Self::Height { channel, name, .. } => (channel.kind, name),
            Self::Colour(colours) => (colours.rgb[0].kind, &colours.names),
        };
        let kind = match kind {
            SampleType::F16 => "float16",
            SampleType::F32 => "float32",
            SampleType::U32 => "uint32",
        };
        let part = exr
            .part_name()
            .map(|name| format!(" of part {name:?}"))
            .unwrap_or_default();
        format!("{kind} ({names}{part})")
    }

    /// Heights, or four interleaved channels of straight, display-referred colour.
    pub(super) fn convert(&self, raw: &RawBlock) -> Vec<f32> {
        match self {
            Self::Height {
                channel, nodata, ..
            } => raw
                .samples(*channel)
                .map(|h| {
                    if h.is_finite() && Some(h) != *nodata {
                        h
                    } else {
                        f32::NAN
                    }
                })
                .collect(),
            Self::Colour(colours) => colours.convert(raw),
        }
    }
}

/// Chosen bands as indices of channels.
fn checked(select: &[u16], count: usize, bands: Bands) -> Result<Vec<usize>, String> {
    let wanted: &[usize] = if bands == Bands::Height {
        &[1]
    } else {
        &[1, 3, 4]
    };
    if !wanted.contains(&select.len()) {
        return Err(format!(
            "expected {} band, found {}",
            if bands == Bands::Height {
                "1"
            } else {
                "1 or 3"
            },
            select.len()
        ));
    }
    if let Some(beyond) = select.iter().find(|b| usize::from(**b) >= count) {
        return Err(format!(
            "expected bands 1 to {count}, found {}",
            u32::from(*beyond) + 1
        ));
    }
    Ok(select.iter().map(|b| usize::from(*b)).collect())
}

impl Colours {
    fn convert(&self, raw: &RawBlock) -> Vec<f32> {
        let (low, scale) = self.range.map_or((0.0, 1.0), |(low, high)| {
            let span = if high == low { 1.0 } else { high - low };
            (low as f32, (1.0 / span) as f32)
        });
        let mut out = vec![0.0; raw.width * raw.height * 4];
        let [r, g, b] = self.rgb.map(|c| raw.samples(c));
        let mut alpha = self.alpha.map(|c| raw.samples(c));
        for (pixel, ((r, g), b)) in out.as_chunks_mut::<4>().0.iter_mut().zip(r.zip(g).zip(b)) {
            let a = alpha.as_mut().map_or(1.0, |a| a.next().unwrap_or(0.0));
            let light = [r, g, b];
            let hole = light.iter().any(|v| v.is_nan())
                || a.is_nan()
                || a <= 0.0
                || self.nodata.is_some_and(|n| light == [n; 3]);
            if hole {
                continue;
            }
            let a = a.min(1.0);
            for (value, v) in pixel.iter_mut().zip(light) {
                let mut v = (v.clamp(-BRIGHTEST, BRIGHTEST) / a - low) * scale;
                if self.range.is_some() {
                    v = v.clamp(0.0, 1.0);
                }
                *value = colour::srgb_from_linear(v.clamp(0.0, BRIGHTEST));
            }
            pixel[3] = a;
        }
        out
    }
}
