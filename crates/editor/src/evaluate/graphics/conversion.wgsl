// Shows numbers and colors as the processor does, by the processor's tables. A compiler may join or reorder
// operations of floating-point numbers, and may assume that none is infinite or NaN: so these are recognized by their bits,
// and what a place in a table depends on is kept apart.

struct Settings {
    count: u32,
    width: u32,
    height: u32,
    tile_width: u32,
    tile_height: u32,
    mode: u32,
    channel: u32,
    dims: u32,
    gain: f32,
    low: f32,
    high: f32,
    zero: u32,
    rows: array<vec4f, 3>,
}

@group(0) @binding(0) var<storage, read_write> screen: array<u32>;
@group(0) @binding(1) var<uniform> settings: Settings;
@group(0) @binding(2) var<storage, read> table: array<u32>;
// Light by place, and then the smallest light of each place.
@group(0) @binding(3) var<storage, read> encoding: array<f32>;

const COLOR = 0u;
const CONVERTED = 1u;
const CHANNEL = 2u;
const LUMINANCE = 3u;
const ENCODED = 4u;
const FIELD = 5u;

const LAST = 4095u;
const LARGE = 3.4028235e38;
// Bytes 255, 0, 255, 255.
const NOT_A_NUMBER = 0xffff00ffu;

// The same number, of which no compiler knows how it was made.
fn apart(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ settings.zero);
}

fn is_nan(bits: u32) -> bool {
    return (bits & 0x7fffffffu) > 0x7f800000u;
}

fn is_infinite(bits: u32) -> bool {
    return (bits & 0x7fffffffu) == 0x7f800000u;
}

// The number with these bits; the largest instead of an infinite one.
fn number(bits: u32) -> f32 {
    return bitcast<f32>(select(bits, bits - 1u, is_infinite(bits)));
}

// The place of a value in the table, of which the last is that of 1/gain and beyond.
fn place(value: f32, gain: f32) -> u32 {
    let shown = min(apart(clamp(value, 0.0, 1.0 / gain) * gain), 1.0);
    return u32(apart(shown * 4095.0) + 0.5);
}

// A quarter of the sum of a color's channels by a row, so that it is finite; the largest number instead of an infinite
// one, and 0 instead of NaN, which the processor shows at the same places.
fn quarter(bits: vec3u, row: vec3f) -> f32 {
    var sum = 0.0;
    var up = false;
    var down = false;
    for (var at = 0u; at < 3u; at++) {
        sum = apart(sum + apart(row[at] * (number(bits[at]) * 0.25)));
        let rises = (bits[at] >> 31u) == u32(row[at] < 0.0);
        up = up || (is_infinite(bits[at]) && rises);
        down = down || (is_infinite(bits[at]) && !rises);
    }
    if (up && down) {
        return 0.0;
    }
    return select(select(sum, -LARGE, down), LARGE, up);
}

// The light of an encoded value.
fn decoded(value: f32) -> f32 {
    let at = apart(clamp(value, 0.0, 1.0) * 4095.0);
    let index = min(u32(at), LAST - 1u);
    let low = encoding[index];
    let rise = apart(apart(at - f32(index)) * apart(encoding[index + 1u] - low));
    return apart(low + rise);
}

// The place of the luminance of an encoded color.
fn encoded(bits: vec3u) -> u32 {
    var sum = 0.0;
    for (var at = 0u; at < 3u; at++) {
        sum = apart(sum + apart(decoded(number(bits[at])) * settings.rows[0][at]));
    }
    var low = 0u;
    for (var step = 2048u; step > 0u; step >>= 1u) {
        if (encoding[LAST + 1u + low + step] <= sum) {
            low += step;
        }
    }
    return low;
}

// The pixel of a color, whose channels are given by their bits.
fn shown(bits: vec3u) -> u32 {
    if (is_nan(bits.x) || is_nan(bits.y) || is_nan(bits.z)) {
        return NOT_A_NUMBER;
    }
    let gain = settings.gain;
    switch (settings.mode) {
        case CHANNEL: {
            return table[place(number(bits[settings.channel]), gain)];
        }
        case LUMINANCE: {
            return table[place(quarter(bits, settings.rows[0].xyz), 4.0 * gain)];
        }
        case ENCODED: {
            return table[encoded(bits)];
        }
        default: {}
    }
    var pixel = 0xff000000u;
    for (var at = 0u; at < 3u; at++) {
        var found: u32;
        if (settings.mode == CONVERTED) {
            found = place(quarter(bits, settings.rows[at].xyz), 4.0 * gain);
        } else {
            found = place(number(bits[at]), gain);
        }
        pixel |= (table[found] & 0xffu) << (8u * at);
    }
    return pixel;
}

// The pixel of a number within the range.
fn shaded(bits: u32) -> u32 {
    if (is_nan(bits)) {
        return NOT_A_NUMBER;
    }
    let above = apart(clamp(number(bits), settings.low, settings.high) - settings.low);
    return table[place(above, settings.gain)];
}
