//! Resources that kernels bind, by their names in WGSL.

macro_rules! resources {
    ($($(#[$doc:meta])* $resource:ident = $name:literal,)*) => {
        /// A resource, by its name in WGSL.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(crate) enum Resource { $($(#[$doc])* $resource,)* }

        impl Resource {
            pub(crate) const ALL: &[Self] = &[$(Self::$resource,)*];

            /// Returns the resource of this name. A test verifies that the names of all kernels' resources are known.
            pub(crate) fn named(name: &str) -> Self {
                match name {
                    $($name => Self::$resource,)*
                    other => unreachable!("no resource is named {other}"),
                }
            }
        }
    };
}

resources! {
    /// Uniform buffer of a view.
    Frame = "frame",
    /// Pixels of the current view.
    View = "view",
    /// Pixels of the source view.
    Source = "source",
    /// Parts of a view's pixels that the host reads back, packed.
    Packed = "packed",
    /// Linear colour of the current view: RGB and 1.
    Linear = "linear_color",
    /// Linear colour of the source view.
    SourceLinear = "source_linear",
    /// Search bound and busy lights of each tile of the current view.
    Bounds = "bounds",
    /// Samples of an earlier frame's view, and search bounds by them for each tile of the whole current view.
    History = "history",
    HistoryBounds = "history_bounds",
    /// Light that paths brought to an earlier frame's view, and room for that of the current view.
    EarlierLight = "earlier_light",
    KeptLight = "kept_light",
    /// Counters of each row of the current view, followed by its cost map and its masks of soft light.
    Counters = "counters",
    /// Counters of the source view.
    SourceCounters = "source_counters",
    /// Lists of pixels or tiles with heads for indirect dispatches, followed by the results of `search_tiles`.
    Lists = "lists",
    /// Pixels of the current view that show mirrors, glass or veils, and the rays that these surfaces send on.
    Bounced = "bounced",
    /// Paths of light of the current view.
    Paths = "paths",
    /// Light that is proposed to the vertices of paths of the current view.
    Proposed = "proposed",
    /// Light that the paths of the current view brought.
    Brought = "brought",
    /// Light that the paths of the source view brought.
    SourceBrought = "source_brought",
    /// Light of the current view's pixels in parts.
    LightParts = "light_parts",
    /// Light of a strip of a picture before and after a pass of denoising, and the surfaces there.
    NoisyLight = "noisy_light",
    SmoothLight = "smooth_light",
    Guides = "guides",
    /// The 3D buffer.
    Slots = "slots",
    /// Samples of the current view, for views that are made from it.
    KeptSamples = "kept_samples",
    /// Samples of the source view.
    SourceSamples = "source_samples",
    /// Samples of a second source.
    SecondSamples = "second_samples",
    /// Mask of the wanted pixels.
    Wanted = "wanted_pixels",
    /// T-buffer with two words per pixel: the nearest t so far, and its primitive (`shaders/shared/t_buffer.wgsl`).
    TBuffer = "t_buffer",
    /// Lists of primitives to draw into the T-buffer, with heads for indirect dispatches.
    Drawing = "drawing",
    /// Finished texels of a shadow-buffer.
    Texels = "texels",
    /// Shadow-buffers of all lights.
    ShadowBuffers = "shadow_buffers",
    /// Texture to which a view, or all of its samples, are written for display.
    Picture = "picture",
    /// Texture of the linear colour of all samples.
    Samples = "samples",
    /// Uniform buffer, and both eyes' pictures, of the kernel that makes one picture of them.
    Combining = "combining",
    LeftPicture = "left_picture",
    RightPicture = "right_picture",
    /// Number of threads of an encoded frame that did not finish.
    Unfinished = "unfinished",
    /// State of work in steps (`src/frame/lanes.rs`).
    Steps = "steps",
    /// The caller's rays.
    RayList = "ray_list",
    /// Hits of the caller's rays.
    Found = "found",
    /// The scene's acceleration structure on the device, for ray queries.
    Acceleration = "acceleration",
    /// Uniform buffer of the BVH.
    Bvh = "bvh",
    /// Nodes and primitives of the BVH.
    Geometry = "geometry",
    /// The shading table.
    Table = "table",
    /// Object that each primitive belongs to.
    ObjectTable = "object_table",
}
