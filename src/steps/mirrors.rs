//! Steps after a view's last step, in scenes with mirrors, glass or veils (partly transparent surfaces). They trace the
//! rays that these surfaces reflect and transmit. First hits may be reused from another view, but each eye traces these
//! rays itself.

use super::step;
use crate::{
    Gpu,
    frame::{
        fewest_rows,
        plan::{Launch, Step},
        targets::{bounced_bytes, state_limit},
        uniforms::Part,
    },
    kernel::layout::{BOUNCED_ROUNDS, TO_TRACE},
    kernel::{Hits, Kernel, Resource, Role, Shading, kernel},
};

pub(crate) const LIST_MIRRORS: Kernel = kernel!("mirrors", "list_mirrors", Role::Shade(Shading::ListMirrors));
pub(crate) const TRACE_MIRRORED: Kernel = kernel!("mirrors", "trace_mirrored", Role::Shade(Shading::Mirrored));
/// Begins rounds with first hits.
pub(crate) const BEGIN_BOUNCED: Kernel = kernel!("mirrors", "begin_bounced", Role::Hits(Hits::Bounced));
pub(crate) const TRACE_BOUNCED: Kernel = kernel!("mirrors", "trace_bounced", Role::Hits(Hits::Bounced));
pub(crate) const LIGHT_BOUNCED: Kernel = kernel!("mirrors", "light_bounced", Role::Shade(Shading::Mirrored));
pub(crate) const SEND_BOUNCED: Kernel = kernel!("mirrors", "send_bounced", Role::Shade(Shading::MirroredLit));
/// Follows the rays that no round is left for.
pub(crate) const FINISH_BOUNCED: Kernel = kernel!("mirrors", "finish_bounced", Role::Shade(Shading::Mirrored));

/// The kernels of a round.
static ALL_BOUNCED: [Kernel; 3] = [TRACE_BOUNCED, LIGHT_BOUNCED, SEND_BOUNCED];

/// How secondary rays are followed. A pixel's rays and their order are the same in both forms, and so is its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mirrors {
    /// All rays of a pixel by one thread, whose rays wait in an array. This is faster on CPU adapters
    /// (docs/TRAVERSAL.md).
    AtOnce,
    /// One ray of each pixel per round. Separate kernels trace, light and send rays, which wait in a buffer. A GPU
    /// would keep arrays of threads in scratch memory.
    InRounds(Rounds),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rounds {
    /// Number of rounds that trace rays. Another kernel follows the rest.
    count: u32,
    /// Number of parts before those of rounds.
    first_part: usize,
}

impl Mirrors {
    /// Returns the form for a picture, after this number of other parts. `in_rounds` is set on adapters that prefer
    /// rounds. They take a buffer that very wide pictures cannot bind.
    pub(crate) fn of(gpu: &Gpu, in_rounds: bool, [width, height]: [u32; 2], bounces: u32, first_part: usize) -> Self {
        let pixels = u64::from(width) * u64::from(fewest_rows(height));
        match in_rounds && bounced_bytes(pixels) <= state_limit(gpu) {
            // A mirror sends on one ray, and so does the inside of a ball of glass besides the one that leaves.
            true => Self::InRounds(Rounds { count: (2 * bounces).min(BOUNCED_ROUNDS), first_part }),
            false => Self::AtOnce,
        }
    }

    pub(crate) fn parts(self) -> impl Iterator<Item = Part> {
        let rounds = match self {
            Self::AtOnce => 0..0,
            Self::InRounds(Rounds { count, .. }) => 0..count + 2,
        };
        rounds.map(|round| Part::Bounced { round })
    }
}

pub(crate) fn of(view: usize, mirrors: Mirrors) -> Vec<Step> {
    let listed = |kernel| step(kernel, view, Launch::Listed(Resource::Lists, TO_TRACE));
    let list = [Step::EmptyLists, step(&LIST_MIRRORS, view, Launch::Pixels)];
    let follow = match mirrors {
        Mirrors::AtOnce => vec![listed(&TRACE_MIRRORED)],
        Mirrors::InRounds(rounds) => {
            let begin = [Step::EmptyBounced, listed(&BEGIN_BOUNCED)];
            begin.into_iter().chain(rounds.steps(view)).collect()
        }
    };
    list.into_iter().chain(follow).collect()
}

impl Rounds {
    /// Returns the steps after the one that begins the rounds.
    fn steps(self, view: usize) -> impl Iterator<Item = Step> {
        let of_round = move |kernel: &'static Kernel, round: u32| Step::Run {
            name: kernel.name,
            kernel,
            view,
            launch: Launch::Listed(Resource::Bounced, round),
            part: self.first_part + round as usize,
        };
        // First hits are known.
        let kernels = |round: u32| if round == 0 { &ALL_BOUNCED[1..] } else { &ALL_BOUNCED };
        let rounds =
            (0..=self.count).flat_map(move |round| kernels(round).iter().map(move |kernel| of_round(kernel, round)));
        rounds.chain([of_round(&FINISH_BOUNCED, self.count + 1)])
    }
}
