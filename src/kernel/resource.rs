//! Resources that kernels bind, by their names in WGSL.

macro_rules! resources {
    ($($(#[$doc:meta])* $resource:ident = $name:literal,)*) => {
        /// A resource, by its name in WGSL.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(crate) enum Resource { $($(#[$doc])* $resource,)* }

        impl Resource {
            pub(crate) const ALL: &[Self] = &[$(Self::$resource,)*];

            /// Returns the resource of this name. Every kernel's resources are known, which a test verifies.
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
    /// Uniform of a view.
    Frame = "frame",
    /// Pixels of the current view.
    View = "view",
    /// Pixels of its source.
    Source = "source",
    /// The parts of a view's pixels that the host reads back.
    Packed = "packed",
    /// Linear colour of the current view, RGB and 1.
    Linear = "linear_color",
    /// Linear colour of its source.
    SourceLinear = "source_linear",
    /// Search depth of each tile of the current view.
    Bounds = "bounds",
    /// Counters of each of its rows, followed by the cost map and the masks of soft light.
    Counters = "counters",
    /// Counters of its source.
    SourceCounters = "source_counters",
    /// Lists of pixels or tiles, with indirect heads, followed by the results of `search_tiles`.
    Lists = "lists",
    /// The 3D buffer.
    Slots = "slots",
    /// Samples of the view, for views that are made from it.
    KeptSamples = "kept_samples",
    /// Samples of its source.
    SourceSamples = "source_samples",
    /// Samples of a second source.
    SecondSamples = "second_samples",
    /// Mask of the wanted pixels.
    Wanted = "wanted_pixels",
    /// Two words a pixel: the nearest t so far, and its primitive (`shaders/shared/t_buffer.wgsl`).
    TBuffer = "t_buffer",
    /// Lists of primitives to draw into it, with indirect heads.
    Drawing = "drawing",
    /// Finished texels of a shadow-buffer.
    Texels = "texels",
    /// Shadow-buffers of all lights.
    ShadowBuffers = "shadow_buffers",
    /// The texture that shows a view.
    Picture = "picture",
    /// Number of threads of an encoded frame that did not finish.
    Unfinished = "unfinished",
    /// State of work in steps (`src/frame/lanes.rs`).
    Steps = "steps",
    /// The caller's rays.
    RayList = "ray_list",
    /// Their hits.
    Found = "found",
    /// Uniform of the BVH.
    Bvh = "bvh",
    /// Nodes and primitives.
    Geometry = "geometry",
    /// The shading table.
    Table = "table",
    /// Objects of the primitives.
    ObjectTable = "object_table",
}
