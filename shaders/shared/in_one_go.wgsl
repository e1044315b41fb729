// A thread does all of its work in one dispatch, and none of these does anything. Twin of in_steps.wgsl: same names.

const paused = false;

fn begin_step(thread: u32) -> bool { return true; }

fn end_step() {}

fn resume(hits: ptr<function, Hits>, stack: ptr<function, Stack>, top: ptr<function, i32>, link: ptr<function, u32>) {}

fn keep_traversal(hits: Hits, stack: ptr<function, Stack>, top: i32, link: u32) -> bool { return false; }

fn spend_round() {}

fn is_tired() -> bool { return false; }

fn is_step_over(link: u32) -> bool { return false; }

fn sum_so_far() -> F3 { return all3(vec3f(0.0)); }

fn first_light() -> u32 { return 0u; }

fn is_put_off(asked: B) -> bool { return false; }

fn keep_lights(sum: F3, light: u32) -> bool { return false; }
