//! WGSL and Rust agree on where every field lies.

use core::mem::offset_of;

use relievo_shaders::layout::{
    DisplaceRange, FormsInput, FrameUniform, LevelUniform, MassPlace, MeasureInput,
};
use relievo_shaders::{Entry, compose};

type Members = (Vec<(String, usize)>, usize);

fn naga_members(entry: Entry, name: &str) -> Members {
    let module = naga::front::wgsl::parse_str(&compose(entry)).expect("valid WGSL");
    let found = module.types.iter().find_map(|(_, ty)| {
        let naga::TypeInner::Struct { members, span } = &ty.inner else {
            return None;
        };
        let offset = |m: &naga::StructMember| {
            (
                m.name.clone().expect("members have names"),
                m.offset as usize,
            )
        };
        let named = ty.name.as_deref() == Some(name);
        named.then(|| (members.iter().map(offset).collect(), *span as usize))
    });
    found.unwrap_or_else(|| panic!("{entry:?} has no struct {name}"))
}

macro_rules! members {
    ($ty:ty { $($field:ident),* $(,)? }) => {
        (vec![$((stringify!($field).to_owned(), offset_of!($ty, $field))),*], size_of::<$ty>())
    };
}

#[test]
fn the_frame_uniform_has_the_offsets_wgsl_gives_it() {
    let rust: Members = members!(FrameUniform {
        clip_from_eye,
        ray_forward,
        exaggeration,
        ray_right,
        radius_m,
        ray_up,
        pixel_rad,
        focus_from_eye_m,
        altitude_m,
        eye_up_in_focus,
        ambient,
        sun_in_focus,
        haze,
        sin_cos_colat,
        scale_height_m,
        height_levels,
        colour_levels,
        normal_levels,
        colour_window,
        first_height_ring,
        reference_height_m,
        reference_drawn_m,
    });
    for entry in [Entry::Displace, Entry::Terrain, Entry::Sky, Entry::Masses] {
        assert_eq!(naga_members(entry, "Frame"), rust);
    }
}

#[test]
fn the_level_uniform_has_the_offsets_wgsl_gives_it() {
    let rust: Members = members!(LevelUniform {
        focus_in_storage,
        samples_per_rad,
        valid_min,
        valid_max,
        settled_min,
        settled_max,
        tap_rows,
        period,
        fade,
        edge_band,
        texel_rad,
        layer,
    });
    assert_eq!(naga_members(Entry::Displace, "LevelView"), rust);
    assert_eq!(naga_members(Entry::Terrain, "LevelView"), rust);
    assert_eq!(rust.1 % 16, 0, "the stride of an array in a uniform");
}

#[test]
fn the_small_uniforms_have_the_offsets_wgsl_gives_them() {
    assert_eq!(
        naga_members(Entry::Displace, "DisplaceRange"),
        members!(DisplaceRange { first, count })
    );
    let rust: Members = members!(MeasureInput {
        sin_cos_colat,
        count,
        levels
    });
    assert_eq!(naga_members(Entry::Measure, "MeasureInput"), rust);
    // The focus is a struct of its own there.
    let focus: Members = (
        members!(FormsInput {
            sin_cos_colat,
            colat_rad,
            distortion
        })
        .0,
        offset_of!(FormsInput, count),
    );
    assert_eq!(naga_members(Entry::Forms, "ClassicFocus"), focus);
    let (rest, size): Members = members!(FormsInput {
        count,
        repeats,
        zero,
        padding
    });
    let (wgsl, wgsl_size) = naga_members(Entry::Forms, "FormsInput");
    assert_eq!((&wgsl[1..], wgsl_size), (&rest[..], size));
    let rust: Members = members!(MassPlace {
        focus_from_world_x,
        focus_from_world_y,
        focus_from_world_z,
        origin_from_eye_m,
        up_in_focus,
        origin_height_m
    });
    assert_eq!(naga_members(Entry::Masses, "MassPlace"), rust);
}
