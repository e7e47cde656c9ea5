//! Blur: replaces each pixel by a weighted mean of its neighborhood.

use crate::filter::{BoundedChannel, BoundedSum, fill, kind, mean, numbers, value};
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_weights::kernel::{self, Kernel, filter};

/// Blurs an image: colors, a mask, weights or a field.
///
/// # Formula
/// Σ wⱼ·Σ wₖ·image(x + k, y + j). gaussian: wₖ ~ exp(−k²/2s²) for |k| ≤ ⌈4s⌉; box: wₖ ~ min(1, s + 1 − |k|) for |k| ≤
/// ⌈s⌉; s = `size`; Σ wₖ = 1.
///
/// # Edge cases
/// Size 0 leaves the image unchanged. Beyond its border, an image repeats the nearest pixel; a file with overscan uses
/// those pixels instead if it is connected directly or through other filters. Every result lies between the values
/// under the kernel, and blurred weights still sum to 1. In a field, ±∞ spreads as far as the kernel; where +∞ and −∞
/// meet, the center pixel is kept. Each sample of a pixel is filtered separately. No color is added to the palette.
/// Render time grows with the size.
///
/// # Source
/// Kernels without negative lobes; only those stay in the palette.
#[derive(Clone, Node)]
#[node(stage, end = Back, revision = 1, output(image: Kind::ANY = "The blurred image, of the same kind."))]
#[also_called("GaussianBlur", "Defocus", "Soften", "BoxBlur")]
pub(crate) struct Blur {
    /// Image to blur.
    image: One<port::Image>,
    /// Amount of blur: standard deviation of the Gaussian; a box is 2·size + 1 wide.
    #[knob(default = 1.0, range = 0.0..=MOST, in_pixels)]
    size: f64,
    /// Vertical amount of blur; by default the same as `size`.
    #[knob(range = 0.0..=MOST, in_pixels)]
    size_y: Option<f64>,
    /// Shape of the kernel: gaussian, or box (all pixels within the size weigh the same).
    filter: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Shape {
    Gaussian,
    Box,
}

/// Largest size, in pixels: such a kernel blurs any picture to nothing.
const MOST: f64 = 10_000.0;

impl Blur {
    /// Returns the sizes across and down.
    fn sizes(&self) -> [f64; 2] {
        [self.size, self.size_y.unwrap_or(self.size)]
    }

    fn shape(&self) -> kernel::Shape {
        match self.filter {
            Shape::Gaussian => kernel::Shape::Gaussian,
            Shape::Box => kernel::Shape::Box,
        }
    }
}

impl Node for Blur {
    fn work(&self, format: Format, _time: f64) -> Option<Work> {
        // Seconds to multiply one sample of a color by one weight.
        const WEIGHT: f64 = 2.4e-10;
        let sides = [format.width(), format.height()];
        let weights: f64 = (self.sizes().iter().zip(sides))
            .map(|(size, side)| (2.0 * self.shape().radius(*size) as f64).min(2.0 * f64::from(side)))
            .sum();
        let seconds = WEIGHT * weights * format.window().area() as f64 * f64::from(format.samples());
        Some(Work { seconds, item: Self::SIZE, remedy: "lower \"size\", or use fewer samples or pixels" })
    }
}

impl Stage for Blur {
    fn is_costly(&self) -> bool {
        true
    }

    fn regions_of_interest(&self, _port: PortId, window: Window, _format: Format) -> Window {
        let [across, down] = self.sizes().map(|size| self.shape().radius(size));
        Window::new(window.x0 - across, window.y0 - down, window.x1 + across, window.y1 + down)
    }

    fn takes_whole_rows(&self) -> bool {
        true
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedBlur {
            node: self.clone(),
            kind: kind(prepare),
            kernels: self.sizes().map(|size| Kernel::new(self.shape(), size)),
        }))
    }
}

struct PreparedBlur {
    node: Blur,
    kind: Kind,
    /// Kernels across and down.
    kernels: [Kernel; 2],
}

impl Prepared for PreparedBlur {
    fn data_window(&self, _picture: Window, inputs: &dyn Fn(PortId) -> Window) -> Window {
        inputs(self.node.image.id())
    }

    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let image = &inputs.all(&self.node.image)[0];
        fill(self.kind, block.window.area(), outputs, |channel, out| {
            if let Some(Some(samples)) = image.planes.get(channel) {
                let stop = inputs.cancellation();
                filter(self.kernels.each_ref(), image.window, samples, image.extent, block.window, stop, out);
            }
        });
        inputs.check_cancelled()
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let Window { x0, x1, y0, y1 } = bounding.block.window;
        let [across, down] = self.node.sizes().map(|size| self.node.shape().reference(size));
        let reach = down.last().map_or(0, |(dy, _)| *dy);
        for (image, filled, bounds) in BoundedChannel::channels(bounding, &self.node.image, self.kind, outputs) {
            // Rows beyond the image repeat its first or last row.
            let Window { y0: first, y1: end, .. } = image.window();
            let (top, bottom) = ((y0 - reach).clamp(first, end - 1), (y1 - 1 + reach).clamp(first, end - 1));
            let sum = |weights: &[(i64, f64)], at: &dyn Fn(i64) -> BoundedSum| {
                weights.iter().fold(BoundedSum::NOTHING, |sum, (step, weight)| sum.plus(*weight, at(*step)))
            };
            let rows: Vec<Vec<BoundedSum>> =
                (top..=bottom).map(|y| (x0..x1).map(|x| sum(&across, &|dx| image.at(x + dx, y))).collect()).collect();
            let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
            for ((bound, filled), (x, y)) in bounds.iter_mut().zip(filled).zip(pixels) {
                let row = |dy: i64| rows[((y + dy).clamp(top, bottom) - top) as usize][(x - x0) as usize];
                *bound = sum(&down, &row).of(*filled, 0.0).encode();
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let image = &self.node.image;
        let [across, down] = self.node.sizes().map(|size| self.node.shape().reference(size));
        let row = |dy: i64| {
            let at = |dx: i64| numbers(&inputs.moved(dx as f64, dy as f64), image);
            mean(across.iter().map(|(dx, w)| (*w, at(*dx))), || at(0))
        };
        let numbers = mean(down.iter().map(|(dy, w)| (*w, row(*dy))), || row(0));
        Ok(vec![value(self.kind, numbers)])
    }
}
