//! Primitives that are drawn, the sizes of their lists, and the size of the dispatch over them.

use crate::{
    gpu::Gpu,
    kernel::{layout::LIST_WORKGROUP, variant::Variant},
};

/// Offset of the entries in `Drawing`, in bytes. `shaders/shared/t_buffer.wgsl` determines this and the following
/// constants.
pub(crate) const DRAWING_HEAD: u64 = 56;
/// Size of a primitive's entries and size of a further part, in bytes.
const ENTRIES: u64 = 12;
const PART: u64 = 8;
/// Number of entries for further parts of primitives.
const FURTHER_PARTS: u32 = 65536;
/// Maximum number of primitives that are drawn. With more, their parts, up to 64 each, would overflow a counter.
const MOST_PRIMITIVES: u32 = 1 << 26;
/// Number of parts per row of workgroups.
const PARTS_IN_ROW: u32 = 512;
/// Number of workgroups in a row of the dispatch over primitives.
const PROJECTED_ACROSS: u32 = 1024;

/// Number of primitives of a scene that are drawn: all except planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Drawn(u32);

impl Drawn {
    /// Returns `None` if the primitives' lists do not fit one binding, or if the scene has no tree.
    pub(crate) fn of(primitives: u32, with: &Variant, gpu: &Gpu) -> Option<Self> {
        let drawn = Self(primitives - with.planes);
        let most = u64::from(PARTS_IN_ROW) * u64::from(gpu.limits.max_compute_workgroups_per_dimension);
        let fits = drawn.0 <= MOST_PRIMITIVES
            && drawn.list_bytes() <= gpu.binding_limit()
            && u64::from(drawn.0 + FURTHER_PARTS) <= most;
        if !fits {
            log::info!("{} primitives are too many for a T-buffer's lists: falling back to rays", drawn.0);
        }
        (fits && with.has_tree()).then_some(drawn)
    }

    /// Returns the size of the lists in bytes.
    pub(crate) fn list_bytes(self) -> u64 {
        DRAWING_HEAD + ENTRIES * u64::from(self.0) + PART * u64::from(FURTHER_PARTS)
    }

    /// Returns the workgroups of a dispatch with one thread per primitive.
    pub(crate) fn workgroups(self) -> [u32; 3] {
        let all = self.0.div_ceil(LIST_WORKGROUP);
        [all.min(PROJECTED_ACROSS), all.div_ceil(PROJECTED_ACROSS), 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn host_and_wgsl_have_the_same_numbers() {
        let text = crate::kernel::wgsl::part!("shared/t_buffer.wgsl").text;
        for (name, value) in [
            ("FURTHER_PARTS", FURTHER_PARTS),
            ("GROUP", 8),
            ("PARTS_ACROSS", PARTS_IN_ROW * 8 / LIST_WORKGROUP),
            ("PROJECTED_ACROSS", PROJECTED_ACROSS),
        ] {
            assert!(text.contains(&format!("const {name}: u32 = {value}u;")), "{name}");
        }
    }

    #[test]
    fn each_primitive_gets_a_thread() {
        for primitives in [1, 64, 65, 65_535, 65_536, 65_537, 1_000_000, 34_000_000] {
            let [x, y, z] = Drawn(primitives).workgroups();
            let threads = u64::from(x) * u64::from(y) * u64::from(z) * u64::from(LIST_WORKGROUP);
            let more = threads - u64::from(primitives);
            assert!(
                more < u64::from(PROJECTED_ACROSS * LIST_WORKGROUP) && x.max(y) <= 1024,
                "{primitives}: {x} {y} {z}"
            );
        }
    }
}
