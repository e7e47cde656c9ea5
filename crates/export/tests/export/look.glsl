// Trochoid
// The color "look" of look.json at frame 1.
// Colors are in the document's working space, srgb: encoded for display as sRGB, no linear light.
// It mixes the colors in it, and those that it takes, with weights of at least 0 that sum to 1: it leaves their hull by rounding alone.
// GLSL 1.30 and newer, or ES 3.00 with floats of high precision.
// across: the mask "across" (a ScreenX), from 0 to 1, and clamped to that
// down: the mask "down" (a ScreenY), from 0 to 1, and clamped to that
// tint: the color "tint" (a Constant), at least 0
// parts_0: weight 0 of the 3 of "parts" (a Bands), from 0 to 1; all are divided by their sum
// parts_1: weight 1 of the 3 of "parts" (a Bands), from 0 to 1; all are divided by their sum
// parts_2: weight 2 of the 3 of "parts" (a Bands), from 0 to 1; all are divided by their sum

float look_mask(float t)
{
    return t > 0.0 ? min(t, 1.0) : 0.0;
}

float look_ramp(float x, float low, float high)
{
    return x >= high ? 1.0 : (x >= low ? min((x - low) / (high - low), 1.0) : 0.0);
}

float look_smooth(float t)
{
    return min(t * t * (3.0 - 2.0 * t), 1.0);
}

float look_share(float v, float scale)
{
    return v > 0.0 ? min(v, 3.4028235e38) * scale : 0.0;
}

vec3 look_mix(vec3 a, vec3 b, float t)
{
    return t < 0.5 ? a + t * (b - a) : b + (t - 1.0) * (b - a);
}

vec3 look(float across, float down, vec3 tint, float parts_0, float parts_1, float parts_2)
{
    float t0 = look_mask(across);
    float t2 = look_ramp(t0, 0.1, 0.9);
    float t3 = look_smooth(t2);
    float t4 = look_mask(down);
    float t5 = look_ramp(t4, -0.5, 2.0);
    float q6_2 = t5 * t5;
    float r6_1 = sqrt(t5);
    float t6 = min(q6_2 * r6_1, t5);
    float t7 = t3 * t6;
    vec3 c9 = look_mix(tint, vec3(0.9254902, 0.9019608, 0.7607843), t7);
    float q10_0 = look_share(t0, 0.5);
    float q10_1 = look_share(t4, 0.5);
    float s10 = q10_0 + q10_1;
    float d10 = max(s10, 0.25);
    float w10_0 = q10_0 / d10;
    float w10_1 = q10_1 / d10;
    float w10_2 = (d10 - s10) / d10;
    vec3 c13 = w10_0 * c9 + w10_1 * vec3(0.5137255, 0.5686275, 0.5686275) + w10_2 * vec3(0.15294118, 0.30588236, 0.3254902);
    float t14 = look_mask(parts_0);
    float t15 = look_mask(parts_1);
    float t16 = look_mask(parts_2);
    float s17 = t14 + t15 + t16;
    float w17_0 = s17 > 0.0 ? t14 / s17 : 0.33333334;
    float w17_1 = s17 > 0.0 ? t15 / s17 : 0.33333334;
    float w17_2 = s17 > 0.0 ? t16 / s17 : 0.33333334;
    vec3 c19 = w17_0 * c13 + w17_1 * vec3(1.0, 1.0, 1.0) + w17_2 * c9;
    vec3 c23 = 0.25 * c19 + 0.75 * tint;
    float t24 = t4 >= 0.5 ? 1.0 : 0.0;
    float t25 = 1.0 - t24;
    vec3 c26 = look_mix(c23, c19, t25);
    vec3 c29 = look_mix(c26, vec3(0.0, 0.0, 0.0), w10_1);
    return c29;
}
