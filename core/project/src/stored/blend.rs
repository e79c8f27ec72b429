//! How a layer's colours meet what lies below as it lies in version 1 of the file.

names! {
    /// How a colour meets what lies below.
    Blend for crate::Blend {
        /// Covers.
        Normal = "normal",
        /// Product: darkens.
        Multiply = "multiply",
        /// Sum: lightens.
        Add = "add",
        /// Inverted product of the inverses: lightens gently.
        Screen = "screen",
        /// Multiply in shadows, screen in lights.
        Overlay = "overlay",
        /// Less the layer: darkens.
        Subtract = "subtract",
        /// How far the two are apart.
        Difference = "difference",
        /// Like the difference, with less contrast.
        Exclusion = "exclusion",
        /// The darker of each channel.
        Darken = "darken",
        /// The lighter of each channel.
        Lighten = "lighten",
        /// What lies below is lightened to reflect the layer.
        ColourDodge = "colour_dodge",
        /// What lies below is darkened to reflect the layer.
        ColourBurn = "colour_burn",
        /// Multiply where the layer is dark, screen where it is light.
        HardLight = "hard_light",
        /// Darkens or lightens gently, as the layer says.
        SoftLight = "soft_light",
        /// The layer's hue alone.
        Hue = "hue",
        /// The layer's saturation alone.
        Saturation = "saturation",
        /// The layer's hue and saturation.
        Colour = "colour",
        /// The layer's luminosity alone.
        Luminosity = "luminosity",
    }
}
