//! Kernels. Each consists of a WGSL file and a role. A variant selects the definitions that are linked into its text.

pub(crate) mod layout;
mod resource;
mod role;
#[cfg_attr(not(any(test, feature = "testing")), allow(unreachable_pub, dead_code, reason = "tests choose a traversal"))]
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
    Error,
    gpu::{Built, Gpu, Program, lock},
    kernel::variant::Variant,
    kernel::wgsl::{Linked, Part},
};

/// A compute kernel. Its text has one entry point.
#[derive(Clone, Copy)]
pub(crate) struct Kernel {
    /// Name in timings and messages.
    pub(crate) name: &'static str,
    pub(crate) role: Role,
    /// File of the entry point. The linker (`src/kernel/wgsl.rs`) adds the definitions of `shaders/shared/` that it
    /// uses.
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
    /// Returns the side of the block of pixels that a thread computes, in pixels.
    pub(crate) fn block(&self, with: &Variant) -> u32 {
        if self.role.reads_tree() { with.of_role(self.role).traversal.rays.block() } else { 1 }
    }
}

/// Identity of a linked kernel: its file, role and variant. Kernels that differ only in their names are the same.
type Key = (&'static str, Role, Variant);

fn key(kernel: &Kernel, with: Variant) -> Key {
    (kernel.main.file, kernel.role, with)
}

/// Cache of the kernels that have been used.
#[derive(Debug, Default)]
pub(crate) struct Kernels(Mutex<HashMap<Key, Known>>);

/// A kernel that was linked for a variant.
#[derive(Debug)]
struct Known {
    /// Resources that the kernel binds, in the order of their bindings.
    bound: Arc<[Resource]>,
    /// Linked text; `None` after the pipeline is built.
    linked: Option<Linked>,
    built: Option<Built>,
}

/// A kernel that is ready to run: its pipeline, and the resources that it binds, in the order of their bindings.
pub(crate) struct Ready {
    pub(crate) pipeline: Built,
    pub(crate) bound: Arc<[Resource]>,
}

impl Kernels {
    /// Returns the resources that a kernel binds, in the order of their bindings.
    pub(crate) fn bound(&self, kernel: &Kernel, with: Variant) -> Arc<[Resource]> {
        self.known(kernel, with, |known, _| known.bound.clone())
    }

    /// Returns a kernel with its pipeline, which is built at its first use.
    pub(crate) fn get(&self, gpu: &Gpu, kernel: &Kernel, with: Variant) -> Ready {
        self.known(kernel, with, |known, with| {
            let Known { built, linked, .. } = known;
            let build = || gpu.pipeline(program(kernel, with, linked.take().expect("kept until it is built")));
            let pipeline = built.get_or_insert_with(build).clone();
            Ready { pipeline, bound: known.bound.clone() }
        })
    }

    /// Builds the pipelines of these kernels, several at a time, since drivers compile for tens of milliseconds each.
    ///
    /// # Errors
    /// Those of the driver.
    pub(crate) async fn prepare(
        &self,
        gpu: &Gpu,
        kernels: impl Iterator<Item = &'static Kernel>,
        with: Variant,
    ) -> Result<(), Error> {
        let mut programs = HashMap::new();
        for kernel in kernels {
            let with = with.of_role(kernel.role);
            let linked = self.known(kernel, with, |known, _| known.linked.clone());
            programs.extend(linked.map(|linked| (key(kernel, with), (kernel, program(kernel, &with, linked)))));
        }
        // A thread that needs one of the pipelines meanwhile waits for it in `Gpu::pipeline`.
        let build = |(kernel, program)| (kernel, gpu.checked(|| Ok(gpu.pipeline(program))));
        let programs: Vec<_> = programs.into_values().collect();
        #[cfg(not(target_arch = "wasm32"))]
        let built = in_parallel(compile_threads(gpu), programs, build);
        #[cfg(target_arch = "wasm32")]
        let built: Vec<_> = programs.into_iter().map(build).collect();
        for (kernel, pipeline) in built {
            let pipeline = pipeline.await?;
            self.known(kernel, with, |known, _| {
                known.linked = None;
                known.built.get_or_insert(pipeline);
            });
        }
        Ok(())
    }

    /// Applies a function to a kernel and its reduced variant. The kernel is linked at its first use.
    fn known<T>(&self, kernel: &Kernel, with: Variant, apply: impl FnOnce(&mut Known, &Variant) -> T) -> T {
        let with = with.of_role(kernel.role);
        let link = || {
            let linked = kernel.linked(&with);
            let bound = linked.bindings.iter().map(|binding| binding.resource).collect();
            Known { bound, linked: Some(linked), built: None }
        };
        apply(lock(&self.0).entry(key(kernel, with)).or_insert_with(link), &with)
    }
}

/// Returns the number of threads that build pipelines. OpenGL has one context, for which threads would wait.
#[cfg(not(target_arch = "wasm32"))]
fn compile_threads(gpu: &Gpu) -> usize {
    match gpu.adapter_info().backend {
        wgpu::Backend::Gl => 1,
        _ => std::thread::available_parallelism().map_or(1, |threads| threads.get()),
    }
}

/// Does work for all items, on up to this many threads, in any order. They are no threads of a pool: those take other
/// work while they wait, and a caller may hold a lock that this work needs.
#[cfg(not(target_arch = "wasm32"))]
fn in_parallel<T: Send, R: Send>(threads: usize, items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let threads = threads.min(items.len());
    let (next, done) = (Mutex::new(items.into_iter()), Mutex::new(Vec::new()));
    let run = || {
        loop {
            let Some(item) = lock(&next).next() else { return };
            let result = work(item);
            lock(&done).push(result);
        }
    };
    if threads <= 1 {
        run();
    } else {
        std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(run))));
    }
    done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
}

fn program(kernel: &Kernel, with: &Variant, Linked { text, bindings }: Linked) -> Program {
    let counting = [("COUNT", with.count), ("COST_MAP", with.cost_map)];
    let counting = counting.into_iter().filter(|(name, _)| text.contains(&format!("override {name}:")));
    Program {
        label: kernel.name,
        constants: counting.map(|(name, on)| (name, f64::from(u8::from(on)))).collect(),
        bindings: bindings.iter().map(|binding| binding.ty).collect(),
        text,
    }
}

#[cfg(test)]
mod tests;
