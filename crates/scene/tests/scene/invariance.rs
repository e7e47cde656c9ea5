//! Tests that every tile size, number of threads and choice of channels gives the same bits.

use crate::random::Draw;
use trochoid_image::{Format, Window};
use trochoid_scene::{Camera, Channel, ChannelSet, DVec3, Projection, Samples, SeaSurface, Visible};
use trochoid_sea::{GerstnerSpectrum, Sea};

fn scene() -> (Sea, Camera, Format) {
    let spectrum = GerstnerSpectrum { count: 60, height: 3.0, sharpness: 2.0, ..GerstnerSpectrum::default() };
    let camera = Camera {
        position: DVec3::new(0.0, 3.0, 10.0),
        target: DVec3::new(2.0, 1.0, 0.0),
        roll: 0.1,
        projection: Projection::Perspective { fov: 0.8 },
    };
    (Sea::new(spectrum.waves().expect("valid")), camera, Format::new(200, 120, 4).expect("valid"))
}

/// Returns all channels over the picture, filled in windows of this size.
fn picture(visible: &Visible, format: Format, tile: [usize; 2], sample: u32) -> Vec<Vec<u32>> {
    let width = format.width() as usize;
    let mut planes = vec![vec![0; format.window().area()]; Channel::ALL.len()];
    let mut samples = Samples::new();
    for window in format.window().tiles(tile[0], tile[1]) {
        visible.fill(window, format.sample_offset(sample), ChannelSet::ALL, &mut samples);
        for (plane, channel) in planes.iter_mut().zip(Channel::ALL) {
            for (index, value) in samples.channel(channel).iter().enumerate() {
                let x = window.x0 as usize + index % window.width();
                let y = window.y0 as usize + index / window.width();
                plane[y * width + x] = value.to_bits();
            }
        }
    }
    planes
}

#[test]
fn windows_do_not_change_a_bit() {
    let (sea, camera, format) = scene();
    let surface = SeaSurface::new(&sea, 3.0, 0.0);
    let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::ALL);
    for sample in 0..4 {
        let whole = picture(&visible, format, [200, 120], sample);
        for tile in [[200, 1], [1, 120], [64, 64], [37, 23], [7, 5]] {
            assert!(picture(&visible, format, tile, sample) == whole, "tiles of {tile:?}");
        }
    }
}

/// Tiles on a farm are prepared one by one: from near and far, level and steep, with crests that hide what is behind them,
/// by cameras that see the horizon, look down, or are orthographic.
#[test]
fn a_part_has_the_bits_of_the_whole() {
    let mut draw = Draw(17);
    let mut between = |low: f64, high: f64| low + (high - low) * draw.next();
    let format = Format::new(320, 200, 4).expect("valid");
    for case in 0..24 {
        let spectrum = GerstnerSpectrum {
            count: 40,
            height: between(0.2, 5.0),
            sharpness: between(0.0, 3.0),
            seed: case,
            ..GerstnerSpectrum::default()
        };
        let sea = Sea::new(spectrum.waves().expect("valid"));
        let surface = SeaSurface::new(&sea, between(0.0, 9.0), 0.5);
        let steep = case % 4 == 3;
        let camera = Camera {
            position: DVec3::new(between(-9.0, 9.0), between(0.7, 12.0), 10.0),
            target: DVec3::new(between(-9.0, 9.0), if steep { -40.0 } else { between(-3.0, 4.0) }, 0.0),
            roll: between(-0.4, 0.4),
            projection: match case % 5 {
                4 => Projection::Orthographic { height: between(8.0, 60.0) },
                _ => Projection::Perspective { fov: between(0.3, 1.5) },
            },
        };
        let whole = Visible::prepare(&camera, &[&surface], format, ChannelSet::ALL);
        let mut expected = Samples::new();
        let mut found = Samples::new();
        for _ in 0..6 {
            let [x, y] = [between(0.0, 300.0) as i64, between(0.0, 190.0) as i64];
            let part = Window::new(x, y, (x + 1 + between(0.0, 90.0) as i64).min(320), (y + 25).min(200));
            let wanted = Some(part);
            let local = Visible::prepare_part(&camera, &[&surface], format, 1.0, ChannelSet::ALL, wanted, &|| false)
                .expect("made");
            assert!(local.covers(part) && !local.covers(format.window()) && local.unseen().is_empty());
            for sample in 0..4 {
                let offset = format.sample_offset(sample);
                whole.fill(part, offset, ChannelSet::ALL, &mut expected);
                local.fill(part, offset, ChannelSet::ALL, &mut found);
                for channel in Channel::ALL {
                    let bits =
                        |samples: &Samples| samples.channel(channel).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                    assert!(bits(&found) == bits(&expected), "case {case}, {channel:?} in {part}");
                }
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let (sea, camera, format) = scene();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let surface = SeaSurface::new(&sea, 3.0, 0.0);
            let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::ALL);
            picture(&visible, format, [200, 120], 1)
        })
    };
    assert!(run(1) == run(5));
}

#[test]
fn channels_that_are_left_out_do_not_change_the_others() {
    let (sea, camera, format) = scene();
    let surface = SeaSurface::new(&sea, 3.0, 0.0);
    let window = Window::new(20, 10, 150, 110);
    let fill = |prepared: ChannelSet, wanted: ChannelSet| {
        let mut samples = Samples::new();
        Visible::prepare(&camera, &[&surface], format, prepared).fill(window, [0.5, 0.5], wanted, &mut samples);
        samples
    };
    let all = fill(ChannelSet::ALL, ChannelSet::ALL);
    for channel in Channel::ALL {
        let one = fill(ChannelSet::of(&[channel]), ChannelSet::of(&[channel]));
        assert!(one.channel(channel) == all.channel(channel), "{channel:?}");
        for other in Channel::ALL.into_iter().filter(|&other| other != channel) {
            assert!(one.channel(other).is_empty());
        }
    }
}

#[test]
fn no_pixel_below_the_horizon_is_missed() {
    // Cracks would show the sky through the sea.
    let (sea, camera, format) = scene();
    let camera = Camera { position: DVec3::new(0.0, 8.0, 10.0), roll: 0.0, ..camera };
    let surface = SeaSurface::new(&sea, 3.0, 0.0);
    let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::COVERAGE);
    let mut samples = Samples::new();
    for sample in 0..4 {
        visible.fill(format.window(), format.sample_offset(sample), ChannelSet::COVERAGE, &mut samples);
        let rows: Vec<&[f32]> = samples.channel(Channel::Coverage).chunks(200).collect();
        for column in 0..200 {
            let first = rows.iter().position(|row| row[column] == 1.0).expect("sea below the horizon");
            assert!(rows[first..].iter().all(|row| row[column] == 1.0), "hole in column {column}");
        }
    }
}
