// A thread does all of its work in one dispatch, or so many rounds of its loops in each.

//! if dispatches is one
// None of these does anything.

const paused = false;

fn begin_step(thread: u32) -> bool { return true; }

fn end_step() {}

fn resume(hits: ptr<function, Hits>, stack: ptr<function, Stack>, top: ptr<function, i32>, link: ptr<function, u32>) {}

fn keep_traversal(hits: Hits, stack: ptr<function, Stack>, top: i32, link: u32) -> bool { return false; }

fn spend_round() {}

fn is_tired() -> bool { return false; }

fn is_step_over(link: u32) -> bool { return false; }

fn sum_so_far() -> Light { return no_light(); }

fn first_light() -> u32 { return 0u; }

fn is_put_off(asked: B) -> bool { return false; }

fn keep_lights(sum: Light, light: u32) -> bool { return false; }

//! if dispatches is many
// A thread does so many rounds of its loops in one dispatch, keeps where it stands, and goes on from there in the next:
// for rays and lights that take more rounds than an adapter grants a thread.
//
// A traversal stops in front of a pair of boxes, where hits and stack are all that there is to keep. What it does after
// that is what it would have done, so hits, colours and counts are those of one go, bit for bit.

// What a thread keeps from step to step; all zeros at first.
struct Lane {
    seen: Hits,     // by primary rays, once they are traced
    passed: Hits,   // by the traversal at work
    sum: Light,     // of the lights before the one at work
    stage: u32,     // 0: primary rays are at work; n: light n - 1 is; FINISHED
    link: u32,      // where the traversal goes on; 0: it has not begun
    top: i32,
    stack: Stack,
}

struct Lanes {
    unfinished: atomic<u32>,
    rounds: i32,             // of a step
    _pad: vec2u,
    lanes: array<Lane>,
}

@group(1) @binding(14) var<storage, read_write> steps: Lanes;

const FINISHED: u32 = 0xffffffffu;

// This thread's place in `lanes`.
var<private> lane: u32;
var<private> rounds_left: i32;
var<private> paused: bool;
// Shadow rays counted in this step that will be counted again in the next one.
var<private> to_count_again: u32;

// Whether there is something left to do.
fn begin_step(thread: u32) -> bool {
    lane = thread;
    rounds_left = steps.rounds;
    return steps.lanes[lane].stage != FINISHED;
}

// A lane that was cut short ends too: its frame or list is an error.
fn end_step() {
    if paused & !cut_short { return; }
    steps.lanes[lane].stage = FINISHED;
    atomicSub(&steps.unfinished, 1u);
}

fn spend_round() { rounds_left -= 1; }

fn is_tired() -> bool { return rounds_left <= 0; }

// Whether a traversal that came down to this link is to stop there.
fn is_step_over(link: u32) -> bool { return (link & LEAF) == 0u; }

fn resume(hits: ptr<function, Hits>, stack: ptr<function, Stack>, top: ptr<function, i32>, link: ptr<function, u32>) {
    if steps.lanes[lane].link == 0u { return; }
    *hits = steps.lanes[lane].passed;
    *stack = steps.lanes[lane].stack;
    *top = steps.lanes[lane].top;
    *link = steps.lanes[lane].link;
}

// Whether the traversal is to be gone on with. Where a driver ended its loops, it stands elsewhere and can't be.
fn keep_traversal(hits: Hits, stack: ptr<function, Stack>, top: i32, link: u32) -> bool {
    if link == DONE {
        steps.lanes[lane].link = 0u;
        return false;
    }
    if !is_tired() || !is_step_over(link) { return false; }
    steps.lanes[lane].passed = hits;
    steps.lanes[lane].stack = *stack;
    steps.lanes[lane].top = top;
    steps.lanes[lane].link = link;
    paused = true;
    return true;
}

fn sum_so_far() -> Light { return steps.lanes[lane].sum; }

fn first_light() -> u32 { return steps.lanes[lane].stage - 1u; }

// Whether these rays' answer must wait for the next step, which asks for it again.
fn is_put_off(asked: B) -> bool {
    if paused { to_count_again += count_rays(asked); }
    return paused;
}

// Whether these lights, of which there are more, are to be gone on with.
fn keep_lights(sum: Light, light: u32) -> bool {
    if !is_tired() { return false; }
    steps.lanes[lane].sum = sum;
    steps.lanes[lane].stage = light + 1u;
    paused = true;
    return true;
}
