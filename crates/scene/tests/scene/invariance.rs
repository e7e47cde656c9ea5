//! Tests that every tile size, number of threads and choice of channels gives the same bits.

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
