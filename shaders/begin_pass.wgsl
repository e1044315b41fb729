// Before the projection and the first pass of a T-buffer, and before its second pass: says which one it is. The host cleared all but the entries before.
//
// launch  one thread
// updates drawing

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> drawing: Drawing;

@compute @workgroup_size(1)
fn begin_pass() {
    drawing.pass_at_work += 1u;
    drawing.few.workgroups_x = FEW_ACROSS;
    drawing.few.workgroups_z = 1u;
    drawing.parts.workgroups_x = PARTS_ACROSS;
    drawing.parts.workgroups_z = 1u;
}
