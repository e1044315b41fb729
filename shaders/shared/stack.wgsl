// The stack of links that a traversal has yet to follow, with DONE at the bottom.

//! use boxes, fetch, pixels

//! if stack is private
// Each thread has an array as deep as the tree, for CPU adapters.

struct Stack {
    top: i32,
    links: array<u32, STACK_SIZE>,
}

// Starts a kernel's thread, given its index in the workgroup.
fn begin_stack(thread: u32) {}

fn clear(stack: ptr<function, Stack>) {
    (*stack).top = 0;
    (*stack).links[0] = DONE;
}

fn push(stack: ptr<function, Stack>, link: u32) {
    let top = (*stack).top + 1;
    (*stack).top = top;
    (*stack).links[top] = link;
}

fn pop(stack: ptr<function, Stack>) -> u32 {
    let top = (*stack).top;
    (*stack).top = top - 1;
    return (*stack).links[top];
}

// Notes the pair that a traversal visits.
fn visit(stack: ptr<function, Stack>, pair: u32) {}

fn is_climbing(stack: ptr<function, Stack>) -> bool { return false; }

fn climb(stack: ptr<function, Stack>, pair: u32, nearer: u32, farther: u32, both: bool) -> u32 { return DONE; }

//! if stack is workgroup
// Each thread has a column of workgroup memory for its last links, for GPUs. They keep arrays of threads in memory or
// in many registers, and 16 rows of 64 columns take 4 KiB. A link that finds no row overwrites the oldest one.
//
// When only overwritten links are left, the traversal climbs from the last pair that it visited. It tests the boxes of
// each ancestor again. If both are hit and it comes from the nearer child, the farther one is still to be visited. The
// limit of t has only shrunk since the first visit, so this misses nothing. One instruction computes the order for
// visits and climbs, so that both find the same, whatever a compiler does. A leaf may be tested twice then, which
// changes no hit.

// At least 2: the link of the last visited pair, and the rest of a leaf. A power of two.
const STACK_ROWS: i32 = 16;

var<workgroup> stack_rows: array<u32, STACK_ROWS * i32(LIST_WORKGROUP)>;
var<private> stack_column: u32;

struct Stack {
    top: i32,           // index of the last link; one below the last overwritten one while the traversal climbs
    overwritten: i32,   // index of the last overwritten link; -1 if there is none
    pair: u32,          // last visited pair, or the pair that the traversal has climbed from
}

fn begin_stack(thread: u32) { stack_column = thread; }

fn stack_place(index: i32) -> u32 {
    return u32(index & (STACK_ROWS - 1)) * LIST_WORKGROUP + stack_column;
}

fn clear(stack: ptr<function, Stack>) {
    *stack = Stack(0, -1, 0u);
    stack_rows[stack_column] = DONE;
}

fn push(stack: ptr<function, Stack>, link: u32) {
    let top = (*stack).top + 1;
    (*stack).top = top;
    (*stack).overwritten = max((*stack).overwritten, top - STACK_ROWS);
    stack_rows[stack_place(top)] = link;
}

// Returns the next link to follow. If it is overwritten, the result is the parent of the last visited pair.
fn pop(stack: ptr<function, Stack>) -> u32 {
    let top = (*stack).top;
    (*stack).top = top - 1;
    if top == (*stack).overwritten { return parent_or_done((*stack).pair); }
    return stack_rows[stack_place(top)];
}

// The root is visited again to pop the rest of a leaf, which is no visit of its children.
fn visit(stack: ptr<function, Stack>, pair: u32) {
    if pair != 0u { (*stack).pair = pair; }
}

fn is_climbing(stack: ptr<function, Stack>) -> bool { return (*stack).top < (*stack).overwritten; }

// Returns the next link of a traversal that climbs and has tested the boxes of a pair, given the links of its children:
// that of the farther child, if it is still to be visited, or the pair's parent.
fn climb(stack: ptr<function, Stack>, pair: u32, nearer: u32, farther: u32, both: bool) -> u32 {
    let is_open = both && nearer == (*stack).pair;
    (*stack).pair = pair;
    if is_open {
        (*stack).top = (*stack).overwritten;
        return farther;
    }
    return parent_or_done(pair);
}

fn parent_or_done(pair: u32) -> u32 {
    if pair == 0u { return DONE; }
    return parent_of(pair);
}
