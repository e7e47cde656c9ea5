//! Ways to forge: of each picture and of each thing that a certificate says.

use super::*;

/// A way to forge: a name, the image, and the change.
pub(super) type Way = (&'static str, &'static str, fn(&mut Forgery));

/// Pixel (20, 30) of [`DOCUMENT`], far from what is ambiguous.
pub(super) const HERE: usize = 30 * 70 + 20;
/// Pixel (35, 5), which is ambiguous.
pub(super) const UNCLEAR: usize = 5 * 70 + 35;
/// Pixel (12, 12) of [`SKY`], on the sea, and (12, 2), in the sky.
pub(super) const SEA: usize = 12 * 24 + 12;
pub(super) const ABOVE: usize = 2 * 24 + 12;

/// Paints a pixel with the mean of the controls, which lies in their hull; channels are B, G, R.
pub(super) fn inside(forgery: &mut Forgery, pixel: usize) {
    let controls = forgery.output().controls.as_ref().expect("a color").values.clone();
    let mean = [2, 1, 0].map(|c| controls.iter().map(|color| color[c]).sum::<f32>() / controls.len() as f32);
    forgery.paint(pixel, |channel, _| mean[channel]);
}

/// Ways to change the image of [`DOCUMENT`].
pub(super) const PIXELS: &[Way] = &[
    ("one pixel by 1e-4", "beauty", |f| f.paint(HERE, |_, sample| sample + 1e-4)),
    ("one pixel by a last bit", "beauty", |f| f.paint(HERE, |_, sample| sample.next_up())),
    ("one channel by a last bit", "beauty", |f| f.samples("G")[HERE] = f.samples("G")[HERE].next_down()),
    ("one pixel within the hull", "beauty", |f| inside(f, HERE)),
    ("one ambiguous pixel within its bound", "beauty", |f| f.paint(UNCLEAR, |_, sample| sample.next_up())),
    ("all ambiguous pixels", "beauty", |f| (0..66).for_each(|y| inside(f, y * 70 + 35))),
    ("two neighbors exchanged", "beauty", |f| {
        for channel in ["R", "G", "B"] {
            f.samples(channel).swap(HERE, HERE + 1);
        }
    }),
    ("two blocks exchanged", "beauty", |f| {
        for channel in ["R", "G", "B"] {
            for y in 0..64 {
                (0..6).for_each(|x| f.samples(channel).swap(y * 70 + x, y * 70 + 64 + x));
            }
        }
    }),
    ("mirrored", "beauty", |f| {
        for channel in ["R", "G", "B"] {
            f.samples(channel).chunks_mut(70).for_each(<[f32]>::reverse);
        }
    }),
    ("turned", "beauty", |f| ["R", "G", "B"].into_iter().for_each(|channel| f.samples(channel).reverse())),
    ("a little brighter", "beauty", |f| {
        ["R", "G", "B"].into_iter().for_each(|channel| {
            f.samples(channel).iter_mut().for_each(|sample| *sample *= 1.0 + 1e-6);
        });
    }),
    ("red and blue exchanged", "beauty", |f| {
        let red = f.samples("R").to_vec();
        let blue = f.samples("B").to_vec();
        f.samples("R").copy_from_slice(&blue);
        f.samples("B").copy_from_slice(&red);
    }),
    ("a step of 8 bits", "print", |f| f.paint(HERE, |_, sample| (sample - 1.0 / 255.0).abs())),
    ("a step of 16 bits", "deep", |f| f.paint(HERE, |_, sample| (sample - 1.0 / 65535.0).abs())),
    ("a mask by a last half", "mask", |f| f.paint(HERE, |_, sample| sample * (1.0 + 1.0 / 1024.0))),
    ("weight moved between two", "three", |f| {
        f.samples("three.w0")[HERE] += 0.125;
        f.samples("three.w1")[HERE] -= 0.125;
    }),
    ("a field by a last bit", "three", |f| f.samples("wave.Y")[HERE] = f.samples("wave.Y")[HERE].next_up()),
    ("not a number in a field", "three", |f| f.samples("wave.Y")[HERE] = f32::NAN),
    ("not a number in a color, counted", "beauty", |f| {
        f.paint(HERE, |_, _| f32::NAN);
        let output = f.output();
        output.counts.nan = 1;
        output.guarantee.as_mut().expect("a color").held = None;
    }),
    ("outside of the hull", "beauty", |f| f.paint(HERE, |_, _| 0.9)),
    ("outside of the hull, counted", "beauty", |f| {
        f.paint(HERE, |_, _| 0.9);
        let output = f.output();
        (output.counts.outside, output.counts.outside_by) = (1, 0.25);
        output.guarantee.as_mut().expect("a color").held = None;
    }),
];

/// Ways to change what is said about the pixels of [`DOCUMENT`], and how that hides a changed pixel.
pub(super) const STATEMENTS: &[Way] = &[
    ("a painted pixel, ambiguous", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.ambiguous[HERE] = true);
    }),
    ("a painted pixel, ambiguous, of a bound of 1", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| (stated.ambiguous[HERE], stated.bounds[HERE]) = (true, PixelBound::of(1.0)));
    }),
    ("a painted pixel of a bound of 1", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0));
    }),
    ("a painted pixel without a bound", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.bounds[HERE] = PixelBound::Unknown);
    }),
    ("a painted pixel that counts as infinite", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.bounds[HERE] = PixelBound::Infinite);
    }),
    ("a bound of 1", "beauty", |f| f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0))),
    ("a bound a level higher", "beauty", |f| f.state(|stated| stated.bounds[HERE] = shifted(stated.bounds[HERE], 1))),
    ("a bound a level lower", "beauty", |f| f.state(|stated| stated.bounds[HERE] = shifted(stated.bounds[HERE], -1))),
    ("a bound of 0", "beauty", |f| f.state(|stated| stated.bounds[HERE] = PixelBound::Exact)),
    ("no bound", "beauty", |f| f.state(|stated| stated.bounds[HERE] = PixelBound::Unknown)),
    ("all bounds doubled", "beauty", |f| {
        f.state(|stated| stated.bounds.iter_mut().for_each(|bound| *bound = shifted(*bound, 8)));
    }),
    ("all bounds halved", "beauty", |f| {
        f.state(|stated| stated.bounds.iter_mut().for_each(|bound| *bound = shifted(*bound, -8)));
    }),
    ("all bounds 0", "beauty", |f| f.state(|stated| stated.bounds.fill(PixelBound::Exact))),
    ("no bounds at all", "beauty", |f| f.state(|stated| stated.bounds.fill(PixelBound::Unknown))),
    ("every pixel ambiguous", "beauty", |f| f.state(|stated| stated.ambiguous.fill(true))),
    ("a clear pixel ambiguous", "beauty", |f| f.state(|stated| stated.ambiguous[HERE] = true)),
    ("an ambiguous pixel clear", "beauty", |f| f.state(|stated| stated.ambiguous[UNCLEAR] = false)),
    ("ambiguous pixels exchanged", "beauty", |f| f.state(|stated| stated.ambiguous.swap(UNCLEAR, HERE))),
    ("bounds exchanged", "beauty", |f| f.state(|stated| stated.bounds.swap(UNCLEAR, HERE))),
    ("largest bounds of 1", "beauty", |f| {
        let channel = &mut f.output().error.channels[0];
        for summary in [&mut channel.all, &mut channel.clear] {
            (summary.max, summary.p999) = (summary.max.map(one), summary.p999.map(one));
        }
    }),
    ("a smaller maximum", "beauty", |f| {
        let max = f.output().error.channels[0].all.max.as_mut();
        max.expect("known").bound = 1e-7;
    }),
    ("a smaller percentile", "beauty", |f| {
        let p999 = f.output().error.channels[0].clear.p999.as_mut();
        p999.expect("known").bound = 1e-9;
    }),
    ("the maximum elsewhere", "beauty", |f| {
        let max = f.output().error.channels[0].all.max.as_mut();
        max.expect("known").pixel = [0, 0];
    }),
    ("the maximum outside of the picture", "beauty", |f| {
        let max = f.output().error.channels[0].all.max.as_mut();
        max.expect("known").pixel = [-1, i64::MAX];
    }),
    ("no maximum", "beauty", |f| f.output().error.channels[0].all.max = None),
    ("fewer pixels with a bound", "beauty", |f| f.output().error.channels[0].all.bounded -= 1),
    ("a smaller display bound", "beauty", |f| {
        let max = f.output().error.display.as_mut().and_then(|display| display.all.max.as_mut());
        max.expect("known").bound *= 0.5;
    }),
    ("no display bounds", "beauty", |f| f.output().error.display = None),
    ("another base", "beauty", |f| f.output().error.channels[0].base -= 8),
    ("the largest base", "beauty", |f| f.output().error.channels[0].base = i32::MAX),
    ("another unit", "beauty", |f| f.output().error.unit = "display value".into()),
    ("other names of channels", "beauty", |f| f.output().error.channels[0].names.reverse()),
    ("a map of another output", "beauty", |f| {
        f.output().error.channels[0].map = BoundMap::new([PixelBound::Exact; 9].into_iter()).encode();
    }),
    ("fewer ambiguous pixels", "beauty", |f| f.output().error.ambiguous.pixels = 0),
];

/// Ways to change what is said about document, plan, inputs, outputs and file of [`DOCUMENT`].
pub(super) const CLAIMS: &[Way] = &[
    ("no pixel outside", "beauty", |f| {
        f.paint(HERE, |_, _| 0.9);
        f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0));
    }),
    ("a guarantee that is not held", "beauty", |f| f.output().guarantee.as_mut().expect("a color").held = None),
    ("a guarantee of another class", "beauty", |f| {
        f.output().guarantee.as_mut().expect("a color").class = "box".into();
    }),
    ("a requirement", "print", |f| f.output().guarantee.as_mut().expect("a color").required = Some("hull".into())),
    ("no requirement", "beauty", |f| f.output().guarantee.as_mut().expect("a color").required = None),
    ("a wider palette", "beauty", |f| {
        let controls = f.output().controls.as_mut().expect("a color");
        let mut values = controls.values.clone();
        values.push([4.0, 4.0, 4.0]);
        *controls = controls_of(&values, controls.margin);
    }),
    ("a narrower palette", "beauty", |f| {
        let controls = f.output().controls.as_mut().expect("a color");
        *controls = controls_of(&controls.values[1..], controls.margin);
    }),
    ("a wider margin", "beauty", |f| f.output().controls.as_mut().expect("a color").margin = 1.0),
    ("an outside pixel and a wide margin", "beauty", |f| {
        f.paint(HERE, |_, _| 0.9);
        f.output().controls.as_mut().expect("a color").margin = 1.0;
    }),
    ("no controls", "beauty", |f| f.output().controls = None),
    ("controls of a mask", "mask", |f| f.output().controls = Some(controls_of(&[[0.0; 3]], 0.0))),
    ("another kind", "mask", |f| f.output().kind = "Field".into()),
    ("a stage without bounds", "beauty", |f| {
        f.output().unbounded = vec![Unbounded { node: "wave".into(), why: "its method has none".into() }];
    }),
    ("a node left out", "beauty", |f| {
        let node = f.certificate.plan.iter_mut().find(|node| node.name == "ramp").expect("planned");
        (node.state, node.why) = ("left_out".into(), Some("nothing needs it".into()));
    }),
    ("a node less in the plan", "beauty", |f| drop(f.certificate.plan.pop())),
    ("another document", "beauty", |f| f.document("#c05030", "#c05031")),
    ("another document for a node that nothing needs", "beauty", |f| f.document("#ff00ff", "#ff00fe")),
    ("another frame", "beauty", |f| f.certificate.frame = 2),
    ("another size", "beauty", |f| (f.certificate.format.width, f.certificate.format.height) = (66, 70)),
    ("more samples", "beauty", |f| f.certificate.format.samples = 16),
    ("adaptive sampling", "beauty", |f| f.certificate.format.adaptive = Some("0.01".into())),
    ("other shading", "beauty", |f| f.certificate.format.shading = "pixel".into()),
    ("another space", "beauty", |f| f.certificate.format.working_space = "acescg".into()),
    ("another output of the same kind", "print", |f| {
        f.certificate.outputs[0].name = "deep".into();
        f.certificate.outputs[0].controls = Some(controls_of(&[[0.0; 3]; 3], 0.0));
    }),
    ("an output twice", "beauty", |f| f.certificate.outputs.push(f.certificate.outputs[0].clone())),
    ("an output less", "three", |f| drop(f.certificate.outputs.pop())),
    ("no output", "beauty", |f| f.certificate.outputs.clear()),
    ("an input", "beauty", |f| {
        let input = InputHash { bytes: 1, hash: "0".repeat(64), path: "a.json".into() };
        f.certificate.inputs.push(input);
    }),
    ("another type of samples", "beauty", |f| f.certificate.image.channels[0].stored = "half".into()),
    ("another kind of file", "beauty", |f| f.certificate.image.kind = "PNG".into()),
    ("larger blocks", "beauty", |f| f.certificate.image.block = 128),
    ("a block less", "beauty", |f| drop(f.certificate.image.blocks.pop())),
    ("blocks exchanged", "beauty", |f| f.certificate.image.blocks.swap(0, 1)),
    ("another fingerprint", "beauty", |f| f.certificate.fingerprint = "0".repeat(64)),
];

/// Ways to change depths of [`SKY`], and what is said about them.
pub(super) const DEPTHS: &[Way] = &[
    ("all depths scaled", "depth", |f| f.samples("Z").iter_mut().for_each(|depth| *depth *= 1.01)),
    ("all depths scaled, with bounds", "depth", |f| {
        f.samples("Z").iter_mut().for_each(|depth| *depth *= 1.01);
        f.state(|stated| stated.bounds.iter_mut().for_each(|bound| *bound = shifted(*bound, 80)));
    }),
    ("a sky far away", "depth", |f| {
        f.samples("Z").iter_mut().filter(|depth| depth.is_infinite()).for_each(|depth| *depth = 1e6);
    }),
    ("a hole in the sky", "depth", |f| {
        f.samples("Z")[ABOVE] = 100.0;
        f.state(|stated| stated.bounds[ABOVE] = PixelBound::Exact);
        f.output().counts.infinite -= 1;
    }),
    ("sea that is sky", "depth", |f| {
        f.samples("Z")[SEA] = f32::INFINITY;
        f.output().counts.infinite += 1;
    }),
    ("sea that is sky, as stated", "depth", |f| {
        f.samples("Z")[SEA] = f32::INFINITY;
        f.state(|stated| stated.bounds[SEA] = PixelBound::Infinite);
        f.output().counts.infinite += 1;
    }),
    ("sky of the other sign", "depth", |f| f.samples("Z")[ABOVE] = f32::NEG_INFINITY),
    ("sky without a bound", "depth", |f| f.state(|stated| stated.bounds[ABOVE] = PixelBound::Unknown)),
    ("sky without an error", "depth", |f| f.state(|stated| stated.bounds[ABOVE] = PixelBound::Exact)),
    ("sea as infinite", "depth", |f| f.state(|stated| stated.bounds[SEA] = PixelBound::Infinite)),
    ("not a number", "depth", |f| {
        f.samples("Z")[SEA] = f32::NAN;
        f.output().counts.nan = 1;
    }),
    ("fewer infinities", "depth", |f| f.output().counts.infinite -= 1),
    ("a null for the maximum", "depth", |f| f.output().error.channels[0].all.max = None),
    ("the sea painted", "beauty", |f| f.paint(SEA, |_, sample| sample * (1.0 + 1.0 / 512.0))),
];

pub(super) fn shifted(bound: PixelBound, by: i32) -> PixelBound {
    if let PixelBound::AtMost(level) = bound { PixelBound::AtMost(level + by) } else { bound }
}

fn one(at: BoundAt) -> BoundAt {
    BoundAt { bound: 1.0, ..at }
}
