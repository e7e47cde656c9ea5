// Trochoid
// The color "look" of look.json at frame 1.
// Colors are in the document's working space, srgb: encoded for display as sRGB, no linear light.
// It mixes the colors in it, and those that it takes, with weights of at least 0 that sum to 1: it leaves their hull by rounding alone.
// across: the mask "across" (a ScreenX), from 0 to 1, and clamped to that
// down: the mask "down" (a ScreenY), from 0 to 1, and clamped to that
// tint: the color "tint" (a Constant), at least 0
// parts_0: weight 0 of the 3 of "parts" (a Bands), from 0 to 1; all are divided by their sum
// parts_1: weight 1 of the 3 of "parts" (a Bands), from 0 to 1; all are divided by their sum
// parts_2: weight 2 of the 3 of "parts" (a Bands), from 0 to 1; all are divided by their sum

fn look_mask(t: f32) -> f32
{
    return select(0.0, min(t, 1.0), t > 0.0);
}

fn look_ramp(x: f32, low: f32, high: f32) -> f32
{
    return select((select(0.0, min((x - low) / (high - low), 1.0), x >= low)), 1.0, x >= high);
}

fn look_smooth(t: f32) -> f32
{
    return min(t * t * (3.0 - 2.0 * t), 1.0);
}

fn look_share(v: f32, scale: f32) -> f32
{
    return select(0.0, min(v, 3.4028235e38) * scale, v > 0.0);
}

fn look_mix(a: vec3f, b: vec3f, t: f32) -> vec3f
{
    return select(b + (t - 1.0) * (b - a), a + t * (b - a), t < 0.5);
}

fn look(across: f32, down: f32, tint: vec3f, parts_0: f32, parts_1: f32, parts_2: f32) -> vec3f
{
    let t0 = look_mask(across);
    let t2 = look_ramp(t0, 0.1, 0.9);
    let t3 = look_smooth(t2);
    let t4 = look_mask(down);
    let t5 = look_ramp(t4, -0.5, 2.0);
    let q6_2 = t5 * t5;
    let r6_1 = sqrt(t5);
    let t6 = min(q6_2 * r6_1, t5);
    let t7 = t3 * t6;
    let c9 = look_mix(tint, vec3f(0.9254902, 0.9019608, 0.7607843), t7);
    let q10_0 = look_share(t0, 0.5);
    let q10_1 = look_share(t4, 0.5);
    let s10 = q10_0 + q10_1;
    let d10 = max(s10, 0.25);
    let w10_0 = q10_0 / d10;
    let w10_1 = q10_1 / d10;
    let w10_2 = (d10 - s10) / d10;
    let c13 = w10_0 * c9 + w10_1 * vec3f(0.5137255, 0.5686275, 0.5686275) + w10_2 * vec3f(0.15294118, 0.30588236, 0.3254902);
    let t14 = look_mask(parts_0);
    let t15 = look_mask(parts_1);
    let t16 = look_mask(parts_2);
    let s17 = t14 + t15 + t16;
    let w17_0 = select(0.33333334, t14 / s17, s17 > 0.0);
    let w17_1 = select(0.33333334, t15 / s17, s17 > 0.0);
    let w17_2 = select(0.33333334, t16 / s17, s17 > 0.0);
    let c19 = w17_0 * c13 + w17_1 * vec3f(1.0, 1.0, 1.0) + w17_2 * c9;
    let c23 = 0.25 * c19 + 0.75 * tint;
    let t24 = select(0.0, 1.0, t4 >= 0.5);
    let t25 = 1.0 - t24;
    let c26 = look_mix(c23, c19, t25);
    let c29 = look_mix(c26, vec3f(0.0, 0.0, 0.0), w10_1);
    return c29;
}
