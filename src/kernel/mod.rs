//! Kernels: a WGSL file and a role each. Variants choose what is linked into their texts.

pub(crate) mod layout;
mod resource;
mod role;
pub(crate) mod traversal;
pub(crate) mod variant;
pub(crate) mod wgsl;

use std::{
    collections::HashMap,
    sync::{Arc, Mutex},
};

pub(crate) use resource::Resource;
pub(crate) use role::{Canvas, Dispatches, Does, Hits, Role, SampleUse, Shading, Visible};

use crate::{
    gpu::{Built, Gpu, Pipelines, Program, lock},
    kernel::variant::Variant,
    kernel::wgsl::{Linked, Part},
};

/// A compute kernel. Its text has one entry point.
#[derive(Clone, Copy)]
pub(crate) struct Kernel {
    /// Its name in times and messages.
    pub(crate) name: &'static str,
    pub(crate) role: Role,
    /// Its file. The definitions that it uses of `shaders/shared/` are added (`src/kernel/wgsl.rs`).
    pub(crate) main: Part,
}

macro_rules! kernel {
    ($folder:literal, $name:literal, $role:expr) => {{
        let main = $crate::kernel::wgsl::part!(concat!($folder, "/", $name, ".wgsl"));
        $crate::kernel::Kernel { name: $name, role: $role, main }
    }};
}
pub(crate) use kernel;

impl std::fmt::Debug for Kernel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Kernel {
    /// Returns the side of a thread's block, in pixels.
    pub(crate) fn block(&self, with: &Variant) -> u32 {
        if self.role.reads_tree() { with.of_role(self.role).traversal.rays.block() } else { 1 }
    }
}

/// A kernel's identity in a variant: kernels that differ in their names alone are the same.
type Key = (&'static str, Role, Variant);

/// The kernels used so far: what they bind, and their pipelines.
#[derive(Debug, Default)]
pub(crate) struct Kernels {
    linked: Mutex<HashMap<Key, Arc<Linked>>>,
    built: Pipelines<Key>,
}

impl Kernels {
    /// Returns the resources that a kernel binds, in the order of their bindings.
    pub(crate) fn bound(&self, kernel: &Kernel, with: Variant) -> Vec<Resource> {
        self.linked(kernel, with).bindings.iter().map(|binding| binding.resource).collect()
    }

    /// Returns the pipeline of a kernel, built at its first use.
    pub(crate) fn get(&self, gpu: &Gpu, kernel: &Kernel, with: Variant) -> Built {
        let with = with.of_role(kernel.role);
        self.built.get(gpu, key(kernel, with), || program(kernel, &with, &self.linked(kernel, with)))
    }

    fn linked(&self, kernel: &Kernel, with: Variant) -> Arc<Linked> {
        let with = with.of_role(kernel.role);
        lock(&self.linked).entry(key(kernel, with)).or_insert_with(|| Arc::new(kernel.linked(&with))).clone()
    }
}

fn key(kernel: &Kernel, with: Variant) -> Key {
    (kernel.main.file, kernel.role, with)
}

fn program(kernel: &Kernel, with: &Variant, linked: &Linked) -> Program {
    let counting = [("COUNT", with.count), ("COST_MAP", with.cost_map)];
    let counting = counting.into_iter().filter(|(name, _)| linked.text.contains(&format!("override {name}:")));
    Program {
        label: kernel.name,
        constants: counting.map(|(name, on)| (name, f64::from(u8::from(on)))).collect(),
        bindings: linked.bindings.iter().map(|binding| binding.ty).collect(),
        text: linked.text.clone(),
    }
}

#[cfg(test)]
mod tests;
