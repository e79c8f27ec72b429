//! Every entry point of every specialisation is valid, without a GPU.

use naga::back::PipelineConstants;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use relievo_planet::transform::forms::Form;
use relievo_shaders::{Entry, compose};

/// The overrides that a pass sets, all combinations.
fn specialisations(entry: Entry) -> Vec<PipelineConstants> {
    if entry == Entry::Forms {
        let number = |k| PipelineConstants::from_iter([("FORM".to_owned(), f64::from(k))]);
        return (0..Form::ALL.len() as u32).map(number).collect();
    }
    let switches: &[&str] = match entry {
        Entry::Terrain => &["HAS_COLOUR", "HAS_NORMALS", "HAS_HAZE"],
        Entry::Sky | Entry::Masses => &["HAS_HAZE"],
        Entry::Blit => &["TARGET_ENCODES"],
        Entry::Displace | Entry::Measure | Entry::Forms => &[],
    };
    (0..1_u32 << switches.len())
        .map(|bits| {
            let mut constants = PipelineConstants::default();
            for (k, name) in switches.iter().enumerate() {
                constants.insert((*name).to_owned(), f64::from(bits >> k & 1));
            }
            if entry == Entry::Terrain {
                constants.insert("MAX_TAPS".to_owned(), 4.0);
            }
            constants
        })
        .collect()
}

#[test]
fn every_entry_point_of_every_specialisation_is_valid() {
    for entry in Entry::ALL {
        let source = compose(entry);
        let module = naga::front::wgsl::parse_str(&source)
            .unwrap_or_else(|e| panic!("{}: {}", entry.name(), e.emit_to_string(&source)));
        assert!(!module.entry_points.is_empty());
        // No capabilities: nothing beyond what every adapter has.
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}: {}", entry.name(), e.emit_to_string(&source)));
        for constants in specialisations(entry) {
            for point in &module.entry_points {
                let selected = Some((point.stage, point.name.as_str()));
                let resolved = naga::back::pipeline_constants::process_overrides(
                    &module, &info, selected, &constants,
                );
                let (module, _) =
                    resolved.unwrap_or_else(|e| panic!("{} {constants:?}: {e:?}", point.name));
                // What the back end gets is valid once more, with every switch decided.
                Validator::new(ValidationFlags::all(), Capabilities::empty())
                    .validate(&module)
                    .unwrap_or_else(|e| panic!("{} {constants:?}: {e:?}", point.name));
            }
        }
    }
}
