//! The C interface gives the bits of the Rust library, and keeps every promise of its header.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![allow(clippy::undocumented_unsafe_blocks, reason = "the test is the caller, and keeps what the header asks for")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicBool, Ordering};
use trochoid::{LookBuilder, Samples};
use trochoid_capi::*;

const WATER: &str = include_str!("../examples/water.json");
const POINTS: usize = 600;

fn defaults() -> trochoid_options {
    let mut options = std::mem::MaybeUninit::uninit();
    unsafe {
        let status = trochoid_options_init(options.as_mut_ptr(), size_of::<trochoid_options>());
        assert_eq!(status, trochoid_status::TROCHOID_OK);
        options.assume_init()
    }
}

fn options(inputs: &[*const c_char]) -> trochoid_options {
    trochoid_options { inputs: inputs.as_ptr(), input_count: inputs.len(), ..defaults() }
}

fn make(text: &str, options: &trochoid_options) -> Result<*const trochoid_look, (trochoid_status, String, String)> {
    let (mut look, mut error) = (null(), null_mut());
    unsafe {
        let status = trochoid_look_new(text.as_ptr().cast(), text.len(), options, &raw mut look, &raw mut error);
        if status == trochoid_status::TROCHOID_OK {
            assert!(error.is_null() && !look.is_null());
            return Ok(look);
        }
        assert!(look.is_null());
        let text = |pointer: *const c_char| CStr::from_ptr(pointer).to_str().unwrap().to_owned();
        let told = (status, text(trochoid_error_text(error)), text(trochoid_error_json(error)));
        trochoid_error_release(error);
        Err(told)
    }
}

/// What the example shades, as it prints it.
fn expected() -> String {
    let look = LookBuilder::new(WATER).bind("light").bind("rim").bind("palette.mist").build().unwrap();
    let light: Vec<f32> = (0..POINTS).map(|i| i as f32 / (POINTS - 1) as f32).collect();
    let rim: Vec<f32> = (0..POINTS).map(|i| (i * 7 % POINTS) as f32 / POINTS as f32).collect();
    let mist = [0.25, 0.5, 0.75];
    let mut inputs = vec![Samples::new(&light), Samples::new(&rim)];
    inputs.extend(mist.iter().map(Samples::uniform));
    let mut rgb = vec![0.0; 3 * POINTS];
    look.shader().unwrap().shade_pixels(POINTS, &inputs, &mut rgb, 3).unwrap();
    let line = |pixel: &[f32]| {
        let [r, g, b] = [0, 1, 2].map(|channel| pixel[channel].to_bits());
        format!("{r:08x} {g:08x} {b:08x}\n")
    };
    rgb.chunks(3).map(line).collect()
}

/// `.ci/c` compares the output of the example in C with this file.
#[test]
fn the_results_of_the_example_are_known() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/shade.txt");
    if std::env::var_os("TROCHOID_UPDATE").is_some() {
        std::fs::write(&path, expected()).unwrap();
    }
    assert!(std::fs::read_to_string(&path).unwrap() == expected());
}

#[test]
fn structures_of_any_layout_are_shaded_in_place() {
    #[repr(C, packed)]
    struct Point {
        tag: u8,
        light: f32,
        rim: f32,
        rgb: [f32; 3],
    }
    let names = [c"light", c"rim", c"palette.mist"].map(CStr::as_ptr);
    let look = make(WATER, &options(&names)).unwrap();
    let mist = [0.25_f32, 0.5, 0.75];
    let mut points: Vec<Point> = (0..POINTS)
        .map(|i| Point {
            tag: 7,
            light: i as f32 / (POINTS - 1) as f32,
            rim: (i * 7 % POINTS) as f32 / POINTS as f32,
            rgb: [-1.0; 3],
        })
        .collect();
    let stride = size_of::<Point>() as isize;
    unsafe {
        assert_eq!((trochoid_look_inputs(look), trochoid_look_channels(look), trochoid_look_slots(look)), (5, 3, 3));
        let mut shader = null_mut();
        assert_eq!(trochoid_shader_new(look, &raw mut shader, null_mut()), trochoid_status::TROCHOID_OK);
        // From the last to the first.
        let last = points.as_mut_ptr().add(POINTS - 1);
        let uniform = |value: &f32| trochoid_in { samples: value, stride: 0 };
        let inputs = [
            trochoid_in { samples: &raw const (*last).light, stride: -stride },
            trochoid_in { samples: &raw const (*last).rim, stride: -stride },
            uniform(&mist[0]),
            uniform(&mist[1]),
            uniform(&mist[2]),
        ];
        let rgb = (&raw mut (*last).rgb).cast::<f32>();
        let outputs = [0, 1, 2].map(|c| trochoid_out { samples: rgb.wrapping_add(c), stride: -stride });
        let status = trochoid_shade(shader, POINTS, inputs.as_ptr(), outputs.as_ptr(), null_mut());
        assert_eq!(status, trochoid_status::TROCHOID_OK);
        // What leads nowhere is refused, and nothing is written.
        let mut nowhere = inputs;
        nowhere[1].samples = null();
        let mut same = outputs;
        same[2].stride = 0;
        let mut missing = outputs;
        missing[0].samples = null_mut();
        for (inputs, outputs) in [(&nowhere, &outputs), (&inputs, &same), (&inputs, &missing)] {
            let status = trochoid_shade(shader, POINTS, inputs.as_ptr(), outputs.as_ptr(), null_mut());
            assert_eq!(status, trochoid_status::TROCHOID_INVALID);
            let status = trochoid_picture(
                look,
                20,
                30,
                inputs.as_ptr(),
                outputs.as_ptr(),
                None,
                null_mut(),
                null_mut(),
                null_mut(),
            );
            assert_eq!(status, trochoid_status::TROCHOID_INVALID);
        }
        let mut empty: trochoid_report = std::mem::zeroed();
        let status = trochoid_picture(
            look,
            20,
            30,
            inputs.as_ptr(),
            outputs.as_ptr(),
            None,
            null_mut(),
            &raw mut empty,
            null_mut(),
        );
        assert_eq!(status, trochoid_status::TROCHOID_INVALID);
        // The first illegal sample of the first input that has one.
        points[POINTS - 1 - 5].light = f32::NAN;
        points[POINTS - 1 - 3].rim = 2.0;
        let mut bad = trochoid_bad { slot: 9, sample: 9 };
        let status = trochoid_shade(shader, POINTS, inputs.as_ptr(), outputs.as_ptr(), &raw mut bad);
        assert_eq!((status, bad.slot, bad.sample), (trochoid_status::TROCHOID_BUFFER, 0, 5));
        trochoid_look_release(look);
        // A shader outlives its look.
        points[POINTS - 1 - 5].light = 0.5;
        points[POINTS - 1 - 3].rim = 0.5;
        let status = trochoid_shade(shader, POINTS, inputs.as_ptr(), outputs.as_ptr(), &raw mut bad);
        assert_eq!(status, trochoid_status::TROCHOID_OK);
        trochoid_shader_release(shader);
    }
    let expected = expected();
    let known: Vec<&str> = expected.lines().collect();
    for (i, point) in points.iter().enumerate().filter(|(i, _)| ![POINTS - 4, POINTS - 6].contains(i)) {
        let (rgb, tag) = (point.rgb, point.tag);
        let [r, g, b] = rgb.map(f32::to_bits);
        assert_eq!((format!("{r:08x} {g:08x} {b:08x}"), tag), (known[i].to_owned(), 7));
    }
}

#[test]
fn faults_are_told_in_text_and_json() {
    let told = |text: &str, options: &trochoid_options| make(text, options).unwrap_err();
    let (status, text, json) = told(&WATER.replace("\"weight\": \"light\"", "\"weight\": \"lihgt\""), &defaults());
    assert_eq!(status, trochoid_status::TROCHOID_INVALID);
    assert!(text.contains("did you mean \"light\"?"), "{text}");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["status"], &json["diagnostics"][0]["node"]), (&2.into(), &"water".into()), "{json}");
    assert!(json["diagnostics"][0]["line"].as_u64() > Some(1), "{json}");

    let names = [c"rim", c"palette.foan", c"lihgt"].map(CStr::as_ptr);
    let (status, text, json) = told(WATER, &options(&names));
    assert!(text.contains("did you mean \"palette.foam\"?") && text.contains("did you mean \"light\"?"), "{text}");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let faults = json["diagnostics"].as_array().unwrap();
    assert_eq!((status, faults.len()), (trochoid_status::TROCHOID_INVALID, 2), "{json}");
    assert_eq!((&faults[0]["port"], &faults[1]["found"]), (&"inputs[1]".into(), &"\"lihgt\"".into()), "{json}");
    let nothing = [null()];
    assert!(told(WATER, &options(&nothing)).1.contains("inputs[0] is NULL"));
    let larger = trochoid_options { struct_size: 4096, ..defaults() };
    assert!(told(WATER, &larger).1.contains("found a struct_size of 4096"));
    let other = trochoid_options { illegal: 7, ..defaults() };
    assert!(told(WATER, &other).1.contains("found 7 in illegal"));
    unsafe {
        let mut look = null();
        let status = trochoid_look_open(c"no such file".as_ptr(), null(), &raw mut look, null_mut());
        assert_eq!((status, look.is_null()), (trochoid_status::TROCHOID_IO, true));
        assert_eq!(trochoid_look_new(null(), 0, null(), &raw mut look, null_mut()), trochoid_status::TROCHOID_INVALID);
        assert_eq!(trochoid_look_new(null(), 0, null(), null_mut(), null_mut()), trochoid_status::TROCHOID_INVALID);
        // What is missing is told.
        let text = |status, error: *mut trochoid_error| {
            assert_eq!(status, trochoid_status::TROCHOID_INVALID);
            let text = CStr::from_ptr(trochoid_error_text(error)).to_str().unwrap().to_owned();
            trochoid_error_release(error);
            text
        };
        let (mut shader, mut error) = (null_mut(), null_mut());
        let status = trochoid_look_open(c"x".as_ptr(), null(), null_mut(), &raw mut error);
        assert_eq!(text(status, error), "found NULL; expected a place for the look");
        let status = trochoid_shader_new(null(), &raw mut shader, &raw mut error);
        assert_eq!(text(status, error), "found NULL; expected a look");
        let status = trochoid_shader_new(null(), null_mut(), &raw mut error);
        assert_eq!(text(status, error), "found NULL; expected a place for the shader");
        let status = trochoid_picture(null(), 8, 8, null(), null(), None, null_mut(), null_mut(), &raw mut error);
        assert_eq!(text(status, error), "found NULL; expected a look");
        // NULL may be released, and described.
        trochoid_look_release(null());
        trochoid_shader_release(null_mut());
        trochoid_error_release(null_mut());
        assert_eq!(
            (trochoid_look_slots(null()), trochoid_look_inputs(null()), trochoid_look_channels(null())),
            (0, 0, 0)
        );
        assert_eq!(trochoid_look_kind(null()), u32::MAX);
        assert_eq!(CStr::from_ptr(trochoid_error_text(null())), c"");
    }
}

/// Structures of an older interface end earlier: what they lack has its default.
#[test]
fn shorter_options_are_read_as_far_as_they_go() {
    let mut old = defaults();
    old.struct_size = std::mem::offset_of!(trochoid_options, frame);
    (old.frame, old.illegal) = (-77, 99);
    let look = make(WATER, &old).unwrap();
    unsafe { trochoid_look_release(look) };
    // Nor are they written beyond their end.
    let mut short = trochoid_options { frame: -77, illegal: 99, ..defaults() };
    short.output = c"old".as_ptr();
    let size = std::mem::offset_of!(trochoid_options, frame);
    assert_eq!(unsafe { trochoid_options_init(&raw mut short, size) }, trochoid_status::TROCHOID_OK);
    assert_eq!((short.struct_size, short.output, short.frame, short.illegal), (size, null(), -77, 99));
    for (options, size) in [(null_mut(), size), (&raw mut short, 7)] {
        assert_eq!(unsafe { trochoid_options_init(options, size) }, trochoid_status::TROCHOID_INVALID);
    }
}

/// Each node that keeps an output from being shaded has a fault, in the form of a document's.
#[test]
fn nodes_in_the_way_of_shaders_are_told() {
    let text = WATER.replace("{ \"type\": \"ScreenX\" }", "{ \"type\": \"Blur\", \"image\": \"rim\", \"size\": 3 }");
    let look = make(&text, &defaults()).unwrap();
    let (mut shader, mut error) = (null_mut(), null_mut());
    unsafe {
        let status = trochoid_shader_new(look, &raw mut shader, &raw mut error);
        assert_eq!((status, shader.is_null()), (trochoid_status::TROCHOID_INVALID, true));
        let json = CStr::from_ptr(trochoid_error_json(error)).to_str().unwrap();
        let json: serde_json::Value = serde_json::from_str(json).unwrap();
        let nodes: Vec<&str> =
            json["diagnostics"].as_array().unwrap().iter().map(|fault| fault["node"].as_str().unwrap()).collect();
        assert_eq!(nodes, ["light", "rim"], "{json}");
        assert_eq!(json["diagnostics"][0]["line"], 6, "{json}");
        trochoid_error_release(error);
        trochoid_look_release(look);
    }
}

/// What is counted can be told from what is not; the kind of the output says which of both it is.
#[test]
fn reports_tell_what_was_judged() {
    let masks = WATER.replace("\"outputs\": {", "\"outputs\": { \"rim\": { \"weights\": \"rim\" },");
    let names = [c"palette.mist"].map(CStr::as_ptr);
    let mist = [0.25_f32, 0.5, 0.75];
    let inputs = [0, 1, 2].map(|c| trochoid_in { samples: &raw const mist[c], stride: 0 });
    for (output, kind, judged, controls) in
        [(c"beauty", trochoid_kind::TROCHOID_COLOR, 64, 4), (c"rim", trochoid_kind::TROCHOID_MASK, 0, 0)]
    {
        let look = make(&masks, &trochoid_options { output: output.as_ptr(), threads: 1, ..options(&names) }).unwrap();
        let mut planes = vec![0.0; 3 * 64];
        let out = [0, 1, 2].map(|c| trochoid_out { samples: planes.as_mut_ptr().wrapping_add(64 * c), stride: 4 });
        let mut report = trochoid_report { struct_size: size_of::<trochoid_report>(), ..Default::default() };
        unsafe {
            assert_eq!(trochoid_look_kind(look), kind as u32);
            let status = trochoid_picture(
                look,
                8,
                8,
                inputs.as_ptr(),
                out.as_ptr(),
                None,
                null_mut(),
                &raw mut report,
                null_mut(),
            );
            assert_eq!(status, trochoid_status::TROCHOID_OK);
            trochoid_look_release(look);
        }
        assert_eq!((report.pixels, report.judged, report.hull_exits), (64, judged, 0));
        // Three colors of the document and the mist, which is one color for all pixels.
        assert_eq!((report.control_count, report.threads), (controls, 1));
    }
}

/// Files outside of the document's folder are read if the options allow them.
#[test]
fn files_are_read_as_far_as_they_are_allowed() {
    let folder = std::env::temp_dir().join(format!("trochoid-capi-{}", std::process::id()));
    let (own, other) = (folder.join("own"), folder.join("other"));
    std::fs::create_dir_all(&own).unwrap();
    std::fs::create_dir_all(&other).unwrap();
    let (from, to) = (WATER.find("\"palette\": {").unwrap(), WATER.find("\"nodes\"").unwrap());
    let colors = &WATER[from + "\"palette\": ".len()..to];
    std::fs::write(other.join("colors.json"), colors.trim_end().trim_end_matches(',')).unwrap();
    let text = WATER.replace(&WATER[from..to], "\"palette\": \"../other/colors.json\", ");
    let path = |path: &Path| CString::new(path.to_str().unwrap()).unwrap();
    let (own, other) = (path(&own), path(&other));
    let allowed = [other.as_ptr()];
    let strict = trochoid_options { folder: own.as_ptr(), ..defaults() };
    let refused = make(&text, &strict).unwrap_err().1;
    assert!(refused.contains("colors.json") && refused.contains("allow it if you trust the document"), "{refused}");
    let look = make(&text, &trochoid_options { allow: allowed.as_ptr(), allow_count: 1, ..strict }).unwrap();
    unsafe { trochoid_look_release(look) };
    let nothing = [null()];
    let refused = make(&text, &trochoid_options { allow: nothing.as_ptr(), allow_count: 1, ..strict }).unwrap_err().1;
    assert!(refused.contains("allow[0] is NULL"), "{refused}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn changes_make_another_look() {
    unsafe {
        let look = make(WATER, &defaults()).unwrap();
        let shared = trochoid_look_retain(look);
        let mut changed = null();
        let set = CString::new("beauty.weight=1").unwrap();
        let sets = [set.as_ptr()];
        let status = trochoid_look_with(look, sets.as_ptr(), 1, 1, &raw mut changed, null_mut());
        assert_eq!(status, trochoid_status::TROCHOID_OK);
        trochoid_look_release(look);
        let mut rgb = vec![0.0; 3 * 64];
        let out = [0, 1, 2].map(|c| trochoid_out { samples: rgb.as_mut_ptr().wrapping_add(c), stride: 12 });
        let mut report = trochoid_report { struct_size: size_of::<trochoid_report>(), ..Default::default() };
        for (look, is_mist) in [(changed, true), (shared, false)] {
            let status =
                trochoid_picture(look, 8, 8, null(), out.as_ptr(), None, null_mut(), &raw mut report, null_mut());
            assert_eq!((status, report.pixels, report.hull_exits), (trochoid_status::TROCHOID_OK, 64, 0));
            let mist = rgb.chunks(3).all(|pixel| pixel == rgb[..3].as_ref());
            assert_eq!(mist, is_mist);
        }
        unsafe extern "C" fn stop(_: usize, _: usize, asked: *mut c_void) -> i32 {
            unsafe { &*asked.cast::<AtomicBool>() }.store(true, Ordering::Relaxed);
            1
        }
        let asked = AtomicBool::new(false);
        let user = (&raw const asked).cast_mut().cast();
        // Of many tiles.
        let mut rgb = vec![0.0; 3 << 22];
        let large = [0, 1, 2].map(|c| trochoid_out { samples: rgb.as_mut_ptr().wrapping_add(c), stride: 12 });
        let stopped =
            trochoid_picture(shared, 2048, 2048, null(), large.as_ptr(), Some(stop), user, null_mut(), null_mut());
        assert_eq!(stopped, trochoid_status::TROCHOID_CANCELLED);
        assert!(asked.into_inner());
        let huge =
            trochoid_picture(shared, 65_000, 32_000, null(), large.as_ptr(), None, null_mut(), null_mut(), null_mut());
        assert_eq!(huge, trochoid_status::TROCHOID_MEMORY);
        let status = trochoid_picture(shared, 0, 8, null(), out.as_ptr(), None, null_mut(), null_mut(), null_mut());
        assert_eq!(status, trochoid_status::TROCHOID_INVALID);
        trochoid_look_release(shared);
        trochoid_look_release(changed);
    }
}

#[test]
fn batches_allocate_nothing_whatever_the_first_one_was() {
    let names = [c"light", c"rim", c"palette.mist"].map(CStr::as_ptr);
    let look = make(WATER, &options(&names)).unwrap();
    let samples: Vec<f32> = (0..5 * POINTS).map(|i| i as f32 / (5 * POINTS) as f32).collect();
    let mut rgb = vec![0.0; 3 * POINTS];
    // Side by side, or a row for each channel.
    let mut shade = |shader: *mut trochoid_shader, is_row: bool, count: usize| {
        let [place, [ins, outs]] = if is_row { [[POINTS; 2], [1, 1]] } else { [[1, 1], [5, 3]] };
        let stride = |samples: usize| (samples * size_of::<f32>()) as isize;
        let inputs = [0, 1, 2, 3, 4].map(|channel: usize| trochoid_in {
            samples: samples.as_ptr().wrapping_add(channel * place[0]),
            stride: stride(ins),
        });
        let outputs = [0, 1, 2].map(|channel: usize| trochoid_out {
            samples: rgb.as_mut_ptr().wrapping_add(channel * place[1]),
            stride: stride(outs),
        });
        let status = unsafe { trochoid_shade(shader, count, inputs.as_ptr(), outputs.as_ptr(), null_mut()) };
        assert_eq!(status, trochoid_status::TROCHOID_OK);
    };
    for is_row in [false, true] {
        let mut shader = null_mut();
        assert_eq!(unsafe { trochoid_shader_new(look, &raw mut shader, null_mut()) }, trochoid_status::TROCHOID_OK);
        shade(shader, is_row, 1);
        let counted = allocation_counter::measure(|| {
            for count in [1, 16, POINTS] {
                shade(shader, !is_row, count);
                shade(shader, is_row, count);
            }
        });
        assert_eq!(counted.count_total, 0, "rows first: {is_row}");
        unsafe { trochoid_shader_release(shader) };
    }
    unsafe { trochoid_look_release(look) };
}
