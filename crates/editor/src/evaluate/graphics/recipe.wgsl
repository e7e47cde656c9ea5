// For each tile of a recipe: the first of its places, their number, the first of its samples, and whether what images
// contribute follows the weights.
@group(0) @binding(4) var<storage, read> tiles: array<vec4u>;
@group(0) @binding(5) var<storage, read> places: array<u32>;
// Weight by weight, and for each pixel by pixel.
@group(0) @binding(6) var<storage, read> samples: array<f32>;
// The color of each weight, and 1 if it stands out.
@group(0) @binding(7) var<storage, read> colors: array<vec4f>;

// Share of its brightness that a pixel without the looked for color keeps.
const DIMMED = 0.12;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = id.y * groups.x * 64u + id.x;
    if (at >= settings.count) {
        return;
    }
    let sides = vec2u(settings.tile_width, settings.tile_height);
    let whole = vec2u(settings.width, settings.height);
    let pixel = vec2u(at % whole.x, at / whole.x);
    let corner = pixel / sides;
    let across = (whole.x + sides.x - 1u) / sides.x;
    let tile = tiles[corner.y * across + corner.x];
    let own = min(sides, whole - corner * sides);
    let within = pixel - corner * sides;
    let count = own.x * own.y;
    var sample = tile.z + within.y * own.x + within.x;
    var mixed = vec4f(0.0);
    for (var weight = 0u; weight < tile.y; weight++) {
        mixed += samples[sample] * colors[places[tile.x + weight]];
        sample += count;
    }
    if (tile.w > 0u) {
        mixed += vec4f(samples[sample], samples[sample + count], samples[sample + 2u * count], 0.0);
    }
    var seen = shown(bitcast<vec3u>(mixed.xyz));
    if (settings.dims > 0u) {
        let light = DIMMED + (1.0 - DIMMED) * clamp(mixed.w, 0.0, 1.0);
        let bytes = vec3f((vec3u(seen) >> vec3u(0u, 8u, 16u)) & vec3u(0xffu));
        let dimmed = vec3u(bytes * light + 0.5);
        seen = 0xff000000u | dimmed.x | (dimmed.y << 8u) | (dimmed.z << 16u);
    }
    screen[at] = seen;
}
