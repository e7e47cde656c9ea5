//! The colors of a picture as points in color space, inside the convex hull of the control colors.

use super::inspector::swatch;
use crate::evaluate::Result;
use crate::format::thousands;
use egui::{
    Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo,
    WidgetType, pos2, vec2,
};
use std::sync::Arc;
use trochoid::Picture;

/// Maximum number of points drawn.
const POINTS: usize = 20_000;
/// Maximum number of drawn edges and vertices of the hull: a photograph has more than can be told apart.
const EDGES: usize = 4_000;

type Point = [f32; 3];

/// The color space view and its rotation.
pub(super) struct Space {
    pub(super) shown: bool,
    /// Rotation about the vertical axis, and elevation, in radians.
    turn: [f32; 2],
    zoom: f32,
    cloud: Option<Cloud>,
}

impl Default for Space {
    fn default() -> Self {
        Self { shown: false, turn: [0.6, 0.35], zoom: 1.0, cloud: None }
    }
}

/// Geometry of a picture's colors.
struct Cloud {
    of: Arc<Picture>,
    points: Vec<(Point, Color32)>,
    corners: Vec<(Point, Color32)>,
    edges: Vec<[Point; 2]>,
    /// Number of vertices and edges of the whole hull.
    count: [usize; 2],
    /// Center of the hull, and its radius.
    center: Point,
    radius: f32,
}

impl Cloud {
    fn new(result: &Result) -> Option<Self> {
        let picture = &result.picture;
        let hull = picture.hull.as_deref()?;
        let [r, g, b] = picture.planes.as_slice() else { return None };
        let space = result.lens.graph.space();
        let seen = |color: Point| (color, swatch(space, color.map(f64::from)));
        let count = r.samples().len();
        let step = count.div_ceil(POINTS).max(1);
        // Not a divisor of the picture's width, which would sample whole columns.
        let step = if step > 1 && r.window().width() % step == 0 { step + 1 } else { step };
        let points = (0..count).step_by(step).map(|at| [r, g, b].map(|plane| plane.samples()[at]));
        let points = points.filter(|color| color.iter().all(|value| value.is_finite())).map(seen).collect();
        let (vertices, edges) = (hull.vertices(), hull.edges());
        let ends = |axis: usize| {
            let values = || vertices.iter().map(|color| color[axis]);
            [values().fold(f32::INFINITY, f32::min), values().fold(f32::NEG_INFINITY, f32::max)]
        };
        let ends = [0, 1, 2].map(ends);
        let center = ends.map(|[low, high]| if low <= high { 0.5 * (low + high) } else { 0.5 });
        let reach = |v: &Point| (0..3).map(|axis| (v[axis] - center[axis]).powi(2)).sum::<f32>().sqrt();
        let radius = vertices.iter().map(reach).fold(0.0, f32::max).max(1e-3);
        // The hull of a single point has one edge of length zero.
        let real = edges.iter().filter(|[a, b]| a != b);
        Some(Self {
            of: picture.clone(),
            points,
            corners: vertices.iter().take(EDGES).copied().map(seen).collect(),
            edges: real.clone().take(EDGES).map(|edge| edge.map(|end| end.map(|value| value as f32))).collect(),
            count: [vertices.len(), real.count()],
            center,
            radius,
        })
    }
}

/// Parallel projection, rotated about the center of the hull.
struct Projection {
    center: Point,
    turn: [f32; 2],
    scale: f32,
    origin: Pos2,
}

impl Projection {
    /// Returns where a point is drawn, and its depth (larger is nearer).
    fn place(&self, point: Point) -> (Pos2, f32) {
        let [x, y, z] = [0, 1, 2].map(|axis| point[axis] - self.center[axis]);
        let ((sin, cos), (rise, flat)) = (self.turn[0].sin_cos(), self.turn[1].sin_cos());
        let (across, toward) = (cos * x + sin * z, cos * z - sin * x);
        let (up, near) = (flat * y - rise * toward, rise * y + flat * toward);
        (self.origin + vec2(across, -up) * self.scale, near)
    }
}

impl Space {
    /// Draws the color space and handles rotation and zoom.
    pub(super) fn ui(&mut self, ui: &mut Ui, area: Rect, result: &Result) -> Response {
        let response = ui.allocate_rect(area, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Image, true, "Hull of the palette"));
        let painter = ui.painter().with_clip_rect(area);
        painter.rect_filled(area, 0.0, super::picture::SURROUND);
        let known = self.cloud.as_ref().is_some_and(|cloud| Arc::ptr_eq(&cloud.of, &result.picture));
        if !known {
            self.cloud = Cloud::new(result);
        }
        let Some(cloud) = &self.cloud else {
            let text = "Only colors have a palette: view a Color output.";
            painter.text(
                area.center(),
                Align2::CENTER_CENTER,
                text,
                FontId::proportional(13.0),
                Color32::from_gray(190),
            );
            return response;
        };
        if response.dragged() {
            let by = response.drag_delta() * 0.01;
            self.turn = [self.turn[0] + by.x, (self.turn[1] + by.y).clamp(-1.55, 1.55)];
        }
        if response.hovered() {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            self.zoom = (self.zoom * (scroll * 0.004).exp() * pinch).clamp(0.2, 40.0);
        }
        if response.double_clicked() {
            *self = Self { shown: true, cloud: self.cloud.take(), ..Self::default() };
            return response;
        }
        let room = 0.5 * area.width().min(area.height()) - 18.0;
        let turned = Projection {
            center: cloud.center,
            turn: self.turn,
            scale: room.max(8.0) / cloud.radius * self.zoom,
            origin: area.center(),
        };
        axes(&painter, &turned);
        draw(&painter, cloud, &turned);
        captions(&painter, area, cloud, result);
        response
    }
}

/// Draws the axes of the working space, from black to 1 in each channel.
fn axes(painter: &Painter, turned: &Projection) {
    let ends = [
        ([1.0, 0.0, 0.0], "R", Color32::from_rgb(0xd0, 0x60, 0x60)),
        ([0.0, 1.0, 0.0], "G", Color32::from_rgb(0x60, 0xb0, 0x60)),
        ([0.0, 0.0, 1.0], "B", Color32::from_rgb(0x70, 0x88, 0xe0)),
    ];
    let origin = turned.place([0.0; 3]).0;
    for (end, name, color) in ends {
        let at = turned.place(end).0;
        painter.line_segment([origin, at], Stroke::new(1.0, color.gamma_multiply(0.6)));
        let beside = (at - origin).normalized() * 9.0;
        // An axis may end outside; its letter then stands at the edge.
        let letter = painter.clip_rect().shrink(8.0).clamp(at + beside);
        painter.text(letter, Align2::CENTER_CENTER, name, FontId::proportional(11.0), color);
    }
}

fn draw(painter: &Painter, cloud: &Cloud, turned: &Projection) {
    let mut points: Vec<(Pos2, f32, Color32)> = Vec::with_capacity(cloud.points.len());
    for (point, color) in &cloud.points {
        let (at, near) = turned.place(*point);
        points.push((at, near, *color));
    }
    // Near points cover far ones.
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut mesh = Mesh::default();
    for (at, _, color) in points {
        mesh.add_colored_rect(Rect::from_center_size(at, Vec2::splat(2.0)), color);
    }
    let line = Color32::from_white_alpha(if cloud.edges.len() > 400 { 24 } else { 90 });
    for [a, b] in &cloud.edges {
        painter.line_segment([turned.place(*a).0, turned.place(*b).0], Stroke::new(1.0, line));
    }
    painter.add(Shape::mesh(mesh));
    let radius = if cloud.corners.len() > 100 { 2.5 } else { 4.0 };
    for (corner, color) in &cloud.corners {
        painter.circle(turned.place(*corner).0, radius, *color, Stroke::new(1.0, Color32::from_white_alpha(200)));
    }
}

fn captions(painter: &Painter, area: Rect, cloud: &Cloud, result: &Result) {
    let audit = &result.picture.audit;
    let many = |n: usize, one: &str, more: &str| format!("{} {}", thousands(n as u64), if n == 1 { one } else { more });
    let lines = [
        format!("{}, {}", many(cloud.count[0], "vertex", "vertices"), many(cloud.count[1], "edge", "edges")),
        format!("{} of {} pixels outside", thousands(audit.hull_exits), thousands(audit.pixels)),
    ];
    let mut at = area.left_top() + vec2(10.0, 8.0);
    for line in lines {
        let drawn = painter.text(at, Align2::LEFT_TOP, line, FontId::proportional(12.0), Color32::from_gray(200));
        at = pos2(at.x, drawn.bottom() + 2.0);
    }
}
