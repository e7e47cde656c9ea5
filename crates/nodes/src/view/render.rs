//! Render: surfaces as seen by a camera.

use super::edge_on::check_edge_on;
use super::{MOST_DOUBT, NO_RUN, RenderHandle, SurfaceHandle, exact, too_rough};
use crate::geometry::memory;
use std::sync::OnceLock;
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_memory::Scratch;
use trochoid_scene as scene;

/// A view of surfaces from a camera, sample by sample, to the horizon.
///
/// # Formula
/// Each sample sees the nearest surface along its ray. Only the channels requested by passes are computed. Where
/// samples lie, what a ray is, and to which side normals point: see Definitions in the book.
///
/// # Edge cases
/// Where nothing is seen, coverage is 0, depth +∞, the normal (0, 1, 0), the surface −1, and everything else 0.
///
/// # Source
/// View-dependent tessellation after Hinsinger, Neyret and Cani, Interactive Animation of Ocean Waves, 2002, with bicubic
/// Hermite patches between the vertices of seas; the reference traces the continuous surfaces.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 3, role = Render, outputs = Out)]
#[also_called("ScanlineRender", "Renderer", "Rasterize", "RenderLayers", "View")]
pub(crate) struct Render {
    /// Camera of the view.
    pub(crate) camera: One<port::Camera>,
    /// Surfaces to render.
    #[port(1..=64)]
    pub(crate) surfaces: Many<port::Surface>,
    /// Density of mesh vertices, relative to what the picture's pixels require.
    #[knob(default = 1.0, range = 0.125..=8.0, accuracy)]
    fineness: f64,
    /// Points that passes receive: "mesh" uses the mesh that approximates each surface, and for seas the curved patches
    /// between its vertices; "surface" moves from there to the surface itself, which takes a few times as long; "exact"
    /// does so to the precision of the reference, which takes many times as long.
    #[knob(accuracy)]
    points: Points,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Points {
    Mesh,
    Surface,
    Exact,
}

impl Points {
    /// Returns the precision with which samples are moved to surfaces; `None` for the mesh.
    fn sums(self) -> Option<scene::Sums> {
        match self {
            Self::Mesh => None,
            Self::Surface => Some(scene::Sums::Single),
            Self::Exact => Some(scene::Sums::Double),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// The view, for passes.
    #[output(Kind::View)]
    View,
    /// 1 where a surface is seen, otherwise 0.
    #[output(Kind::MASK)]
    Coverage,
}

impl Node for Render {
    fn check(&self, check: &mut Check<'_>) {
        let surfaces = &self.surfaces;
        let again = surfaces.iter().enumerate().find(|(index, source)| surfaces[..*index].contains(source));
        if let Some(twice) = again.and_then(|(_, source)| check.upstream(source)) {
            let found = format!("\"{}\" twice, at the same place", twice.name);
            check.warning(Self::SURFACES, found, "each surface once", "list it once");
        }
        check_edge_on(self, check);
    }
}

impl Stage for Render {
    fn interval(&self, output: usize, channel: usize) -> Option<(f64, f64)> {
        match Out::ALL[output] {
            Out::View => (channel == Channel::Coverage as usize).then_some((0.0, 1.0)),
            Out::Coverage => Some((0.0, 1.0)),
        }
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn is_costly(&self) -> bool {
        true
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        let taken = memory::of_view(&self.surfaces, self.fineness, context);
        let [pixel, most] = taken.thread;
        let of_points = if self.points == Points::Mesh { 0 } else { scene::Visible::BYTES_OF_POINT };
        taken.thread(pixel + of_points, most)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let camera: scene::Camera = prepare.handles(&self.camera)?[0];
        let surfaces: Vec<SurfaceHandle> = prepare.handles(&self.surfaces)?;
        let mut wanted: ChannelSet = Channel::ALL
            .into_iter()
            .zip(&prepare.wanted[usize::from(Out::View)])
            .filter(|(_, wanted)| **wanted)
            .map(|(channel, _)| channel)
            .collect();
        if prepare.wanted[usize::from(Out::Coverage)][0] {
            wanted = wanted.union(ChannelSet::COVERAGE);
        }
        let format = prepare.frame.format;
        let (follows, fineness) = (self.points.sums(), self.fineness);
        let (mut visible, mut certain, mut kept) = (None, None, 0);
        let exact = if prepare.referenced() { exact(&surfaces, wanted, prepare)? } else { surfaces.clone() };
        if wanted != ChannelSet::EMPTY {
            let surfaces = borrowed(&surfaces);
            // Points of surfaces are searched for starting from rest points.
            let mut prepared = if follows.is_some() { wanted.union(ChannelSet::REST) } else { wanted };
            if prepare.bounded() {
                prepared = prepared.union(ChannelSet::REST);
            }
            let stop = prepare.cancellation();
            let part = prepare.part();
            let projector = scene::Projector { fineness, ..camera.projector(format) };
            // Surfaces that do not move are seen as in the frame before. They are identified by their addresses; what
            // is prepared holds them as long as their views, so that no address is reused.
            let view = |surface: &&dyn scene::Surface| {
                kept += 1;
                let address = std::ptr::from_ref(*surface).cast::<()>().addr();
                prepare.shared(&("seen", projector, prepared, part, address), || {
                    kept -= 1;
                    scene::SurfaceView::new(&projector, *surface, prepared, part, stop).ok_or(NodeError::Cancelled)
                })
            };
            let views = surfaces.iter().map(view).collect::<Result<_, NodeError>>()?;
            let part = scene::Visible::of_views(projector, views, format, prepared, part);
            visible = Some(Seen { part, fineness, prepared, whole: OnceLock::new() });
            if prepare.bounded() {
                let found = scene::Certain::new(&camera, &borrowed(&exact), format, stop);
                certain = Some(found.ok_or(NodeError::Cancelled)?);
            }
        }
        let port = self.surfaces.id();
        Ok(Box::new(PreparedRender { port, camera, surfaces, exact, format, follows, visible, certain, kept }))
    }
}

struct PreparedRender {
    /// Port of the surfaces.
    port: PortId,
    camera: scene::Camera,
    surfaces: Vec<SurfaceHandle>,
    /// The surfaces that references see.
    exact: Vec<SurfaceHandle>,
    format: Format,
    /// Precision with which each sample is moved to the surface itself; `None` for the mesh.
    follows: Option<scene::Sums>,
    /// `None` if no channel is wanted.
    visible: Option<Seen>,
    /// Certainty of what is seen; prepared only if bounds are requested.
    certain: Option<scene::Certain>,
    /// Number of surfaces that are seen as in an earlier frame.
    kept: usize,
}

/// What is seen of the surfaces.
struct Seen {
    /// In the part of the picture where most pixels are filled.
    part: scene::Visible,
    fineness: f64,
    prepared: ChannelSet,
    /// In all of it, made when a pixel elsewhere is filled.
    whole: OnceLock<Option<scene::Visible>>,
}

impl Seen {
    fn bytes(&self) -> usize {
        let whole = self.whole.get().and_then(Option::as_ref);
        self.part.stats().bytes + whole.map_or(0, |whole| whole.stats().bytes)
    }
}

impl PreparedRender {
    /// Returns what is seen in some pixels; `None` if no channel is wanted.
    fn visible_in(&self, block: &Block<'_>) -> Option<&scene::Visible> {
        let seen = self.visible.as_ref()?;
        if seen.part.covers(block.scattered.map_or(block.window, scene::around)) {
            return Some(&seen.part);
        }
        let Seen { fineness, prepared, .. } = *seen;
        if seen.whole.get().is_none() {
            let surfaces = borrowed(&self.surfaces);
            let (camera, format) = (&self.camera, self.format);
            // Not within the lock: a thread that waits for others may take up work that asks for it.
            let made = scene::Visible::prepare_unless(camera, &surfaces, format, fineness, prepared, &|| false);
            // Another thread may have been faster; both results are the same.
            let _ = seen.whole.set(made);
        }
        seen.whole.get()?.as_ref()
    }
}

fn borrowed(surfaces: &[SurfaceHandle]) -> Scratch<&dyn scene::Surface> {
    surfaces.iter().map(|surface| surface.as_ref()).collect()
}

/// Error of the reference's own search for the end of a ray, relative to the distance; at grazing angles, it grows
/// accordingly. Normals and quantities derived from them rotate by at most as many radians.
const REFERENCE_RAY: f64 = 1e-8;

/// Returns whether a channel says only which surface is seen.
fn is_whole(channel: Channel) -> bool {
    matches!(channel, Channel::Coverage | Channel::Surface)
}

impl Prepared for PreparedRender {
    fn handle(&self) -> Option<Handle> {
        let (camera, surfaces, exact) = (self.camera, self.surfaces.clone(), self.exact.clone());
        Some(std::sync::Arc::new(RenderHandle { camera, surfaces, exact }))
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(visible) = self.visible_in(block) else { return Ok(()) };
        let mut planes: Scratch<_> =
            Channel::ALL.into_iter().enumerate().filter_map(|(i, c)| Some((c, outputs.take(Out::View, i)?))).collect();
        let mut coverage = outputs.take(Out::Coverage, 0);
        let mut targets = scene::Targets::default();
        if let Some(plane) = &mut coverage {
            targets.ask(Channel::Coverage, plane);
        }
        // The view's own coverage, if it is wanted, takes the place of the other one.
        planes.iter_mut().for_each(|(channel, plane)| targets.ask(*channel, plane));
        match block.scattered {
            None => visible.fill_planes(block.window, block.offset, &mut targets),
            Some(pixels) => visible.fill_planes_at(pixels, block.offset, &mut targets),
        }
        let own = planes.iter().find(|(channel, _)| *channel == Channel::Coverage);
        if let (Some(plane), Some((_, own))) = (&mut coverage, own) {
            plane.copy_from_slice(own);
        }
        if let Some(sums) = self.follows.filter(|_| !planes.is_empty()) {
            let pixels: Scratch<[i64; 2]> = block.pixels().collect();
            let points = visible.points(&borrowed(&self.surfaces), &pixels, block.offset, sums);
            // Where no point of the surface is near, the mesh's point stays.
            let found = points.iter().enumerate().filter_map(|(index, point)| Some((index, point.as_ref()?)));
            for (index, point) in found {
                for (channel, plane) in &mut planes {
                    plane[index] = scene::channel_of(Some(point), *channel) as f32;
                }
            }
        }
        Ok(())
    }

    /// Computes the distance of each channel from the value at the surface's own point, where it is certain that the
    /// sample sees it.
    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let Some(certain) = &self.certain else {
            return Err(NoBound("no bounds were requested"));
        };
        let pixels: Vec<[i64; 2]> = bounding.block.pixels().collect();
        if self.exact.iter().any(|surface| surface.doubt(1.0) > MOST_DOUBT) {
            return Err(NO_RUN);
        }
        let (surfaces, offset) = (borrowed(&self.exact), bounding.block.offset);
        let mut filled = Channel::ALL.into_iter().zip(&bounding.filled[usize::from(Out::View)]);
        let has_values = filled.any(|(channel, plane)| plane.is_some() && !is_whole(channel));
        let asked = match (has_values, self.follows) {
            (false, _) => scene::Asked::Surface,
            // Points of the mesh are farther from the surface than that.
            (true, None) => scene::Asked::Nearly,
            (true, Some(_)) => scene::Asked::Values,
        };
        let sights = certain.sights(&surfaces, &pixels, offset, asked);
        let same = match self.visible_in(bounding.block) {
            Some(visible) => visible.same_sheets(&surfaces, &pixels, offset, &sights),
            None => vec![true; sights.len()],
        };
        let projector = self.camera.projector(self.format);
        let lost = |(sight, [x, y]): (&scene::Sight, [f64; 2])| {
            let scene::Sight::Point(scene::Met { hit, off, .. }) = sight else { return 0.0 };
            let facing = hit.normal.dot(projector.ray(x, y).direction).abs();
            REFERENCE_RAY * (1.0 + hit.distance) + off + self.exact[hit.surface].doubt(facing)
        };
        let lost: Vec<f64> = sights.iter().zip(bounding.block.places()).map(lost).collect();
        let view = Channel::ALL.into_iter().enumerate().map(|(index, channel)| (channel, Out::View, index));
        for (channel, output, index) in view.chain([(Channel::Coverage, Out::Coverage, 0)]) {
            let filled = bounding.filled[usize::from(output)][index];
            let (Some(filled), Some(bounds)) = (filled, outputs.take(output, index)) else { continue };
            for ((((bound, value), sight), same), lost) in
                bounds.iter_mut().zip(filled).zip(&sights).zip(&same).zip(&lost)
            {
                let hit = match sight {
                    scene::Sight::Unclear => {
                        *bound = Bound::UNKNOWN.encode();
                        continue;
                    }
                    scene::Sight::Nothing => None,
                    scene::Sight::Point(met) => Some(&met.hit),
                };
                let (value, exact) = (f64::from(*value), scene::channel_of(hit, channel));
                let distance = if value == exact { 0.0 } else { (value - exact).abs() };
                let lost = if is_whole(channel) { 0.0 } else { *lost };
                *bound = Bound::of(distance + lost).with(*same).encode();
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let surfaces = borrowed(&self.exact);
        let hit = scene::reference::trace(&self.camera, &surfaces, self.format, inputs.at[0], inputs.at[1]);
        let hit = hit.map_err(too_rough)?;
        let channels = Channel::ALL.iter().map(|channel| scene::channel_of(hit.as_ref(), *channel)).collect();
        let coverage = if hit.is_some() { 1.0 } else { 0.0 };
        Ok(vec![Reference::View(channels), Reference::Mask(coverage)])
    }

    fn kept(&self) -> usize {
        self.kept
    }

    fn unseen(&self) -> Vec<(PortId, usize)> {
        let unseen = self.visible.as_ref().map_or_else(Vec::new, |seen| seen.part.unseen());
        unseen.into_iter().map(|surface| (self.port, surface)).collect()
    }

    fn left_out(&self) -> Vec<Omission> {
        let Some(projector) = self.visible.as_ref().map(|seen| seen.part.projector()) else { return Vec::new() };
        let unseen = self.unseen().into_iter().map(|port| Omission {
            port: Some(port),
            what: "surfaces",
            count: 1.0,
            of: 1.0,
            why: "nothing of it is in the picture",
        });
        let seas = self.surfaces.iter().enumerate();
        let seas = seas.filter_map(|(index, surface)| Some((index, surface.as_sea()?.resolved(projector)?)));
        seas.flat_map(|(index, resolved)| {
            let of = resolved.of as f64;
            let waves = |what, count: f64, why| {
                (count > 0.0).then_some(Omission { port: Some((self.port, index)), what, count, of, why })
            };
            let everywhere = "no pixel resolves them: less than 1e-6 of each remains at its footprint";
            let mean = "distant pixels do not resolve them";
            [
                waves("waves", of - resolved.most as f64, everywhere),
                waves("waves at a vertex on average", of - resolved.mean, mean),
            ]
        })
        .flatten()
        .chain(unseen)
        .collect()
    }

    fn bytes(&self) -> usize {
        self.visible.as_ref().map_or(0, Seen::bytes)
    }
}
