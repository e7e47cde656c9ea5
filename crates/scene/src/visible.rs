use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use trochoid_image::{Format, Window};

use crate::project::{BIN, Binned, Layer, Raster};
use crate::surface::Between;
use crate::{Camera, ChannelSet, Projector, Samples, Surface, Targets};

/// What a camera sees of some surfaces: made once per frame, then evaluated at any pixels from any thread.
///
/// ```
/// use trochoid_image::Format;
/// use trochoid_scene::{Camera, Channel, ChannelSet, DVec3, Projection, Samples, SeaSurface, Visible};
/// use trochoid_sea::{GerstnerSpectrum, Sea};
///
/// let sea = Sea::new(GerstnerSpectrum { count: 20, ..GerstnerSpectrum::default() }.waves()?);
/// let surface = SeaSurface::new(&sea, 0.0, 0.0);
/// let camera = Camera {
///     position: DVec3::new(0.0, 6.0, 30.0),
///     target: DVec3::new(0.0, 2.0, 0.0),
///     roll: 0.0,
///     projection: Projection::Perspective { fov: 0.7 },
/// };
/// let format = Format::new(64, 36, 1)?;
/// let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::DEPTH);
/// let mut samples = Samples::new();
/// visible.fill(format.window(), format.sample_offset(0), ChannelSet::DEPTH, &mut samples);
/// let depth = samples.channel(Channel::Depth);
/// assert!(depth[0] == f32::INFINITY && depth[35 * 64] < 60.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Visible {
    pub(crate) projector: Projector,
    pub(crate) raster: Raster,
    pub(crate) layers: Vec<Arc<Layer>>,
    /// The views that these are part of.
    views: Vec<Arc<SurfaceView>>,
    /// Number of the first primitive of each layer.
    pub(crate) firsts: Vec<u32>,
    /// Columns and rows of bins.
    pub(crate) bins: [i64; 2],
    /// Start of each bin's primitives; one more entry than there are bins.
    pub(crate) starts: Vec<u32>,
    pub(crate) binned: Vec<u32>,
    /// Positions of the samples within each pixel.
    pub(crate) offsets: Vec<[f64; 2]>,
    /// Unique number of this view within the process.
    pub(crate) number: u64,
    wanted: ChannelSet,
    /// Part of the picture that it covers; all of it for `None`.
    part: Option<Window>,
}

/// One surface as a camera sees it: its mesh, and the bins of the picture in which each of its primitives may be seen. It
/// serves all frames in which surface and camera are the same.
#[derive(Debug)]
pub struct SurfaceView {
    layer: Arc<Layer>,
    /// Start of each bin's primitives; one more entry than there are bins.
    starts: Vec<u32>,
    /// Primitives, counted from the surface's first.
    binned: Vec<u32>,
}

/// Number of views made so far.
static VIEWS: AtomicU64 = AtomicU64::new(0);

/// Cost of a preparation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Number of vertices of all meshes.
    pub vertices: usize,
    /// Number of cells and triangles that may be visible.
    pub primitives: usize,
    /// Bytes held.
    pub bytes: usize,
}

impl Visible {
    /// Tessellates the surfaces for a camera and a format, for all channels that any `fill` will request.
    ///
    /// # Panics
    /// The surfaces have 2³² vertices or cells in total.
    pub fn prepare(camera: &Camera, surfaces: &[&dyn Surface], format: Format, wanted: ChannelSet) -> Self {
        let whole = Self::prepare_unless(camera, surfaces, format, 1.0, wanted, &|| false);
        whole.expect("nothing stops it")
    }

    /// Does the same with vertices `fineness` times as close as pixels require, or returns `None` soon after `stop`
    /// first says that the result is no longer needed.
    ///
    /// # Panics
    /// Same as [`Visible::prepare`].
    pub fn prepare_unless(
        camera: &Camera,
        surfaces: &[&dyn Surface],
        format: Format,
        fineness: f64,
        wanted: ChannelSet,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        Self::prepare_part(camera, surfaces, format, fineness, wanted, None, stop)
    }

    /// Does the same for a part of the picture, if one is given. What is filled there has the same bits.
    ///
    /// # Panics
    /// Same as [`Visible::prepare`].
    pub fn prepare_part(
        camera: &Camera,
        surfaces: &[&dyn Surface],
        format: Format,
        fineness: f64,
        wanted: ChannelSet,
        part: Option<Window>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let projector = Projector { fineness, ..camera.projector(format) };
        let views =
            surfaces.iter().map(|surface| SurfaceView::new(&projector, *surface, wanted, part, stop).map(Arc::new));
        Some(Self::of_views(projector, views.collect::<Option<_>>()?, format, wanted, part))
    }

    /// Returns whether a window of the picture can be filled.
    pub fn covers(&self, window: Window) -> bool {
        self.part.is_none_or(|part| part.intersect(window) == window)
    }

    /// Does the same from views of the surfaces, which were made for the same projector, channels and part.
    ///
    /// # Panics
    /// Same as [`Visible::prepare`].
    pub fn of_views(
        projector: Projector,
        views: Vec<Arc<SurfaceView>>,
        format: Format,
        wanted: ChannelSet,
        part: Option<Window>,
    ) -> Self {
        let (mut firsts, mut first) = (Vec::new(), 0_usize);
        for SurfaceView { layer, .. } in views.iter().map(AsRef::as_ref) {
            firsts.push(u32::try_from(first).expect("fewer than 2³² primitives"));
            first += layer.primitives + layer.clipped.len();
        }
        let count = views.iter().map(|view| view.binned.len()).sum::<usize>();
        assert!(u32::try_from(first.max(count)).is_ok(), "fewer than 2³² primitives");
        let bins = bins(&projector);
        let (mut starts, mut binned) = (vec![0], Vec::with_capacity(count));
        for bin in 0..(bins[0] * bins[1]) as usize {
            for (view, first) in views.iter().zip(&firsts) {
                let own = &view.binned[view.starts[bin] as usize..view.starts[bin + 1] as usize];
                binned.extend(own.iter().map(|primitive| first + primitive));
            }
            starts.push(binned.len() as u32);
        }
        let layers = views.iter().map(|view| view.layer.clone()).collect();
        let raster = Raster::new(&projector);
        let offsets = (0..format.samples()).map(|sample| format.sample_offset(sample)).collect();
        let number = VIEWS.fetch_add(1, Ordering::Relaxed);
        Self { projector, raster, layers, views, firsts, bins, starts, binned, offsets, number, wanted, part }
    }

    /// Returns the camera's projection.
    pub fn projector(&self) -> &Projector {
        &self.projector
    }

    /// Returns the indices of the surfaces of which nothing is in the picture; none if that is not known, because only a
    /// part is covered.
    pub fn unseen(&self) -> Vec<usize> {
        if self.part.is_some() {
            return Vec::new();
        }
        let mut seen = vec![false; self.layers.len()];
        self.binned.iter().for_each(|primitive| seen[self.layer(*primitive)] = true);
        (0..seen.len()).filter(|surface| !seen[*surface]).collect()
    }

    /// Returns the size of this view.
    pub fn stats(&self) -> Stats {
        let bytes = |layer: &Layer| {
            let mesh = &layer.mesh;
            mesh.positions.len() * 12
                + mesh.normals.len() * 12
                + (mesh.rests.len() + mesh.uvs.len()) * 8
                + mesh.rest_heights.len() * 4
                + mesh.slope_variances.len() * 4
                + mesh.trails.iter().map(|values| values.len() * 4).sum::<usize>()
                + layer.screen.len() * 12
                + layer.clipped.len() * 20
                + match &mesh.between {
                    Between::Patches(patches) => patches.bytes(),
                    Between::Heights(field) => field.bytes(),
                    Between::Triangles => 0,
                }
        };
        Stats {
            vertices: self.layers.iter().map(|layer| layer.mesh.positions.len()).sum(),
            primitives: self.binned.len(),
            bytes: self.layers.iter().map(|layer| bytes(layer)).sum::<usize>()
                + (self.binned.len() + self.starts.len()) * 4
                + self.views.iter().map(|view| (view.binned.len() + view.starts.len()) * 4).sum::<usize>(),
        }
    }

    /// Computes exactly the channels of `wanted` at one sample of each pixel of a window. The sample is at `offset`
    /// from the pixel's upper left corner; each part is from 0 to 1 and rounded to the raster.
    ///
    /// Windows of 16 rows or more are fastest; all windows give the same bits.
    ///
    /// # Panics
    /// A wanted channel was not prepared, or the window is not [covered](Self::covers).
    pub fn fill(&self, window: Window, offset: [f64; 2], wanted: ChannelSet, out: &mut Samples) {
        out.shape(window, wanted);
        self.fill_planes(window, offset, &mut out.targets());
    }

    /// Does the same into planes of the caller.
    ///
    /// # Panics
    /// Same as [`Visible::fill`], or a plane does not have the window's size.
    pub fn fill_planes(&self, window: Window, offset: [f64; 2], out: &mut Targets<'_>) {
        let wanted = out.wanted(window.area());
        assert!(self.wanted.includes(wanted), "a view is asked only for the channels it was prepared for");
        assert!(self.covers(window), "a view is asked only for the part it was prepared for");
        if window.is_empty() || wanted == ChannelSet::EMPTY {
            return;
        }
        self.look(window, offset, |seen| self.resolve(seen.within(window), offset, wanted, out));
    }

    /// Does the same as [`Visible::fill`] for single pixels, written as one row; each has the same bits as in any window.
    ///
    /// # Panics
    /// Same as [`Visible::fill`].
    pub fn fill_pixels(&self, pixels: &[[i64; 2]], offset: [f64; 2], wanted: ChannelSet, out: &mut Samples) {
        out.shape(Window::new(0, 0, pixels.len() as i64, 1), wanted);
        self.fill_planes_at(pixels, offset, &mut out.targets());
    }

    /// Does the same into planes of the caller.
    ///
    /// Pixels of a window that the thread has just computed are fastest, row by row.
    ///
    /// # Panics
    /// Same as [`Visible::fill_planes`].
    pub fn fill_planes_at(&self, pixels: &[[i64; 2]], offset: [f64; 2], out: &mut Targets<'_>) {
        let wanted = out.wanted(pixels.len());
        assert!(self.wanted.includes(wanted), "a view is asked only for the channels it was prepared for");
        if pixels.is_empty() || wanted == ChannelSet::EMPTY {
            return;
        }
        let around = around(pixels);
        assert!(self.covers(around), "a view is asked only for the part it was prepared for");
        self.look_around(around, offset, |seen| self.resolve(seen.at(pixels), offset, wanted, out));
    }
}

impl SurfaceView {
    /// Tessellates a surface for a projector, as [`Visible::prepare_part`] does; `None` soon after `stop` says so.
    pub fn new(
        projector: &Projector,
        surface: &dyn Surface,
        wanted: ChannelSet,
        part: Option<Window>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let mesh = surface.tessellate_part(projector, wanted, part, stop)?;
        let (bins, mut pairs) = (bins(projector), Vec::new());
        let layer = Layer::new(mesh, projector, bins, 0, &mut pairs);
        let (starts, binned) = sort((bins[0] * bins[1]) as usize, &pairs);
        Some(Self { layer: Arc::new(layer), starts, binned })
    }
}

/// Returns the columns and rows of bins of a picture.
fn bins(projector: &Projector) -> [i64; 2] {
    [0, 1].map(|axis| (projector.size[axis] as i64).div_euclid(BIN[axis]) + 1)
}

/// Returns the smallest window that has some pixels.
pub fn around(pixels: &[[i64; 2]]) -> Window {
    if pixels.is_empty() {
        return Window::default();
    }
    let (mut low, mut high) = ([i64::MAX; 2], [i64::MIN; 2]);
    for pixel in pixels {
        for axis in 0..2 {
            low[axis] = low[axis].min(pixel[axis]);
            high[axis] = high[axis].max(pixel[axis]);
        }
    }
    Window::new(low[0], low[1], high[0] + 1, high[1] + 1)
}

/// Sorts lists of pairs of (bin, primitive) by counting: returns the start of each bin, and the primitives bin by bin.
fn sort(bins: usize, lists: &[Vec<Binned>]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; bins + 1];
    for &(bin, _) in lists.iter().flatten() {
        starts[bin as usize + 1] += 1;
    }
    for bin in 0..bins {
        starts[bin + 1] += starts[bin];
    }
    let mut next = starts.clone();
    let mut binned = vec![0; starts[bins] as usize];
    for &(bin, primitive) in lists.iter().flatten() {
        let place = &mut next[bin as usize];
        binned[*place as usize] = primitive;
        *place += 1;
    }
    (starts, binned)
}
