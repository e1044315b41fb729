// A thread does all its work in one dispatch, or it runs a limited number of loop rounds in each of several dispatches.

//! use boxes, counters, lane, light, rays, stack

//! if dispatches is one
// With one dispatch, these functions do nothing.

const paused = false;

fn begin_step(thread: u32) -> bool { return true; }

fn end_step() {}

fn resume(hits: ptr<function, Hits>, stack: ptr<function, Stack>, link: ptr<function, u32>) {}

fn keep_traversal(hits: Hits, stack: ptr<function, Stack>, link: u32) -> bool { return false; }

fn spend_round() {}

fn is_tired() -> bool { return false; }

fn is_step_over(link: u32) -> bool { return false; }

fn sum_so_far() -> Light { return no_light(); }

fn first_light() -> u32 { return 0u; }

fn is_put_off(asked: B) -> bool { return false; }

fn keep_lights(sum: Light, light: u32) -> bool { return false; }

//! if dispatches is many
// A thread runs a limited number of loop rounds per dispatch, saves its state, and resumes in the next dispatch. This
// serves rays and lights that need more rounds than an adapter allows per thread.
//
// A traversal pauses only before it tests a pair of boxes. Its complete state there consists of the hits, the stack and
// the next link. So the hits, colours and counters of several dispatches are bit-identical to the results of a single
// dispatch.

// State that a thread saves between dispatches. All fields are initially 0.
struct Lane {
    seen: Hits,     // hits of primary rays, once traced
    passed: Hits,   // hits of the current traversal
    sum: Light,     // sum of the light of the previous lights
    stage: u32,     // 0: primary rays; n: light n - 1; FINISHED
    link: u32,      // next link of the traversal; 0 if no traversal has begun
    stack: Stack,
}

struct Lanes {
    unfinished: atomic<u32>,
    rounds: i32,             // loop rounds per dispatch
    _pad: vec2u,
    lanes: array<Lane>,
}

var<storage, read_write> steps: Lanes;

const FINISHED: u32 = 0xffffffffu;

// This thread's index in `lanes`.
var<private> lane: u32;
var<private> rounds_left: i32;
var<private> paused: bool;
// Number of shadow rays counted in this dispatch that the next dispatch counts again.
var<private> to_count_again: u32;

// Starts a dispatch; returns whether the thread has work left.
fn begin_step(thread: u32) -> bool {
    lane = thread;
    rounds_left = steps.rounds;
    return steps.lanes[lane].stage != FINISHED;
}

// Ends a thread's dispatch. A lane that was cut short is finished too, since its frame or list is reported as an error.
fn end_step() {
    if paused & !cut_short { return; }
    steps.lanes[lane].stage = FINISHED;
    atomicSub(&steps.unfinished, 1u);
}

fn spend_round() { rounds_left -= 1; }

fn is_tired() -> bool { return rounds_left <= 0; }

// Returns whether a traversal without rounds left may pause at this link.
fn is_step_over(link: u32) -> bool { return (link & LEAF) == 0u; }

fn resume(hits: ptr<function, Hits>, stack: ptr<function, Stack>, link: ptr<function, u32>) {
    if steps.lanes[lane].link == 0u { return; }
    *hits = steps.lanes[lane].passed;
    *stack = steps.lanes[lane].stack;
    *link = steps.lanes[lane].link;
}

// Saves a traversal; returns whether it will resume. A traversal that a driver cut short cannot resume.
fn keep_traversal(hits: Hits, stack: ptr<function, Stack>, link: u32) -> bool {
    if link == DONE {
        steps.lanes[lane].link = 0u;
        return false;
    }
    if !is_tired() || !is_step_over(link) { return false; }
    steps.lanes[lane].passed = hits;
    steps.lanes[lane].stack = *stack;
    steps.lanes[lane].link = link;
    paused = true;
    return true;
}

fn sum_so_far() -> Light { return steps.lanes[lane].sum; }

fn first_light() -> u32 { return steps.lanes[lane].stage - 1u; }

// Returns whether these rays must wait for the next dispatch, which traces them again.
fn is_put_off(asked: B) -> bool {
    if paused { to_count_again += count_rays(asked); }
    return paused;
}

// Saves the sum over the lights so far; returns whether the loop will resume. The function is called only if lights
// remain.
fn keep_lights(sum: Light, light: u32) -> bool {
    if !is_tired() { return false; }
    steps.lanes[lane].sum = sum;
    steps.lanes[lane].stage = light + 1u;
    paused = true;
    return true;
}
