// Runs before each pass of a T-buffer. It increments the pass number and sets the number of workgroups that draw the
// primitives listed by project_primitives. The host has emptied the lists before.
//
// launch  one thread
// updates drawing

//! use t_buffer

var<storage, read_write> drawing: Drawing;

@compute @workgroup_size(1)
fn begin_pass() {
    drawing.pass_at_work += 1u;
    let few = atomicLoad(&drawing.few.count);
    drawing.few.workgroups = vec3u(FEW_ACROSS, (few + FEW_IN_ROW - 1u) / FEW_IN_ROW, 1u);
    let more = atomicLoad(&drawing.more.count);
    drawing.more.workgroups = vec3u(MORE_ACROSS, (more + MORE_IN_ROW - 1u) / MORE_IN_ROW, 1u);
    let parts = atomicLoad(&drawing.parts.count);
    drawing.parts.workgroups = vec3u(PARTS_ACROSS, (parts + PARTS_IN_ROW - 1u) / PARTS_IN_ROW, 1u);
}
