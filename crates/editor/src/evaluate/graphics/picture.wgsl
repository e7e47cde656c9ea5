// The channels of a picture, one after another; of a field only the one that is shown.
@group(0) @binding(4) var<storage, read> planes: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = id.y * groups.x * 64u + id.x;
    if (at >= settings.count) {
        return;
    }
    if (settings.mode == FIELD) {
        screen[at] = shaded(planes[at]);
    } else {
        screen[at] = shown(vec3u(planes[at], planes[settings.count + at], planes[2u * settings.count + at]));
    }
}
