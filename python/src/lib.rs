//! The Python package `stereotrace`: classes over the library's, with `NumPy` arrays. Parts that need neither a device
//! nor Rust are in the package's Python files. `_stereotrace.pyi` has the types. The `///` comments of exported items
//! are the Python docstrings.

mod camera;
mod correspondence;
mod dataset;
mod errors;
mod flow;
mod layers;
mod light;
mod material;
mod options;
mod pair;
mod passes;
mod pickled;
mod picture;
mod renderer;
mod scene;
mod statistics;
mod values;

use pyo3::prelude::*;

/// The part of the package `stereotrace` that is written in Rust.
#[pymodule]
mod _stereotrace {
    #[pymodule_export]
    use super::{
        camera::Camera,
        correspondence::{Correspondence, EyeMatches},
        dataset::{DataSetSpec, PairMaker},
        errors::{AdapterError, DeviceLostError, LimitError},
        flow::{EyeFlow, Flow},
        layers::{EyeLayers, Layers},
        light::Light,
        material::Material,
        options::check_options,
        pair::{StereoPair, View, Views},
        passes::Passes,
        pickled::restored,
        picture::{decode_png, encode_png},
        renderer::Renderer,
        scene::Scene,
    };
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // The library logs to Python's logger `stereotrace`, unless another Rust logger is installed already.
        drop(pyo3_log::try_init());
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("MISS", stereotrace::MISS)?;
        module.add("METHODS", super::values::names(stereotrace::Method::ALL))?;
        module.add("BUILTINS", super::values::names(stereotrace::Builtin::ALL))?;
        module.add("LAYOUTS", super::values::names(stereotrace::dataset::Layout::ALL))?;
        module.add("ANAGLYPHS", super::values::names(stereotrace::output::Anaglyph::ALL))?;
        module.add("PACKINGS", super::values::names(stereotrace::output::Packing::ALL))?;
        module.add("OPTIONS", stereotrace::Setting::ALL.iter().map(|setting| setting.name).collect::<Vec<_>>())?;
        module.add("OUTPUTS", super::values::names(stereotrace::Channel::ALL))
    }
}
