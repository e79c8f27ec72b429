// blit.wgsl: vertex entry `blit_vertex` (one triangle over the viewport, no buffers), fragment
// entry `blit_fragment`.
// Copies the finished picture into another target, such as a window's.

// Whether the target encodes sRGB itself, so that the encoded picture has to be decoded first.
override TARGET_ENCODES: bool = false;

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var stretched: sampler;

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
}

@vertex
fn blit_vertex(@builtin(vertex_index) index: u32) -> Varyings {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Varyings(vec4f(corner * 2.0 - 1.0, 0.0, 1.0), vec2f(corner.x, 1.0 - corner.y));
}

@fragment
fn blit_fragment(in: Varyings) -> @location(0) vec4f {
    let pixel = textureSampleLevel(picture, stretched, in.uv, 0.0);
    if (TARGET_ENCODES) {
        let low = pixel.rgb / 12.92;
        let high = pow((pixel.rgb + 0.055) / 1.055, vec3f(2.4));
        return vec4f(select(high, low, pixel.rgb <= vec3f(0.04045)), pixel.a);
    }
    return pixel;
}
