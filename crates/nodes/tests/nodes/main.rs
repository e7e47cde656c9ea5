//! Tests of the nodes, in folders as the nodes themselves: evaluations of small documents, messages about wrong ones,
//! and bounds of errors. They stand outside, so that the crate is not compiled a second time for them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod bounds;
mod testing;
mod words;

mod convex {
    mod bands;
    mod blend;
    mod constant;
    mod invert;
    mod multiply;
    mod normalize;
    mod patch;
    mod ramp;
    mod screen;
    mod sheet;
    mod stack;
    mod switch;
}

mod field {
    mod field_math;
    mod grain;
    mod noise;
    mod screen_x;
    mod screen_y;
    mod scumble;
    mod shape;
}

mod files {
    mod color;
    mod crypto_mask;
    mod decompose;
    mod kept;
    mod layer;
    mod legal;
    mod passes_of_a_ray;
    mod read;
    mod stream;
    mod texture;
    mod view_from_passes;
}

mod filter {
    mod warp;
}

mod geometry {
    mod bezier_model;
    mod float;
    mod mesh;
    mod model_files;
}

mod lit {
    mod light_pool;
}

mod paint {
    mod brush;
    mod line_set;
    mod seeds;
    mod strokes;
}

mod sea {
    mod bake;
    mod profile;
    mod spray;
    mod toon_sea;
    mod waterline_foam;
}

mod view {
    mod cloud_layers;
    mod clouds;
    mod flow_field;
    mod in_front;
    mod object_mask;
    mod render;
    mod thickness;
}
