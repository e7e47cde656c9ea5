//! Measures how smoothly patches join.

use glam::DVec3;

use super::normal::POINT_EDGE;
use super::{Bicubic, curve};

/// Report on the joints of a piecewise surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Continuity {
    /// Number of patches.
    pub patches: usize,
    /// Number of edges that two patches share, including those with gaps within the tolerance.
    pub joints: usize,
    /// Number of joints whose curves are identical to the bit: C0 without a crack.
    pub exact: usize,
    /// Widest gap of a joint, in meters.
    pub widest_gap: f64,
    /// Number of joints whose normals differ by at most 0.1 degrees: G1.
    pub smooth: usize,
    /// Number of joints whose handles are equal and opposite, to 1e-9 of the patches' size: C1.
    pub equal_handles: usize,
    /// Largest angle between normals across a joint, in radians.
    pub greatest_angle: f64,
    /// Number of edges that belong to a single patch.
    pub open: usize,
    /// Number of edges that are single points, or so short that they count as points for normals.
    pub points: usize,
}

impl std::fmt::Display for Continuity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let count = |count: usize, one: &str, many: &str| format!("{count} {}", if count == 1 { one } else { many });
        f.write_str(&count(self.patches, "patch", "patches"))?;
        // A good result takes a few words; only defects are reported in numbers.
        if self.joints == 0 {
            f.write_str(" without joints")?;
        } else {
            write!(f, ", {}: ", count(self.joints, "joint", "joints"))?;
            match self.joints - self.exact {
                0 => f.write_str("no gaps")?,
                gaps => write!(f, "{} of up to {:.3e} m", count(gaps, "gap", "gaps"), self.widest_gap)?,
            }
            match self.joints - self.smooth {
                0 => f.write_str(", all smooth")?,
                sharp => write!(f, ", {sharp} sharp, by up to {:.1} degrees", self.greatest_angle.to_degrees())?,
            }
            if self.smooth == self.joints && self.equal_handles < self.joints {
                write!(f, ", {} with equal and opposite handles", self.equal_handles)?;
            }
        }
        write!(f, "; {}", count(self.open, "open edge", "open edges"))?;
        if self.points > 0 {
            write!(f, ", {}", count(self.points, "edge that is a point", "edges that are points"))?;
        }
        Ok(())
    }
}

/// Number of positions along a joint at which gap and angle are measured.
const SAMPLES: usize = 17;
/// Distance, as a share of the model's size, below which ends of edges may form a joint.
const NEAR: f64 = 1e-4;
/// A direction with which no model is aligned; ends that are close are close along it.
const ODD: DVec3 = DVec3::new(0.578_125, 0.619_140_625, 0.531_25);

/// An edge of a patch, from one of its two ends.
struct End {
    key: f64,
    patch: usize,
    edge: usize,
    reversed: bool,
    curve: [DVec3; 4],
}

/// Measures every joint. Each edge is joined to at most one other: the first that runs between the same ends.
pub fn continuity<'a>(patches: impl IntoIterator<Item = &'a Bicubic>) -> Continuity {
    let patches: Vec<&Bicubic> = patches.into_iter().collect();
    let mut report = Continuity { patches: patches.len(), ..Continuity::default() };
    let Some(first) = patches.first() else { return report };
    let (low, high) =
        patches.iter().map(|patch| patch.bounds()).fold(first.bounds(), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let near = NEAR * (high - low).max_element();
    let mut ends = Vec::new();
    for (patch, shape) in patches.iter().enumerate() {
        for edge in 0..4 {
            let [a, b, c, d] = shape.edge(edge);
            if curve::polygon(&[a, b, c, d]) <= near.max(POINT_EDGE * shape.extent()) {
                report.points += 1;
                continue;
            }
            ends.push(End { key: a.dot(ODD), patch, edge, reversed: false, curve: [a, b, c, d] });
            ends.push(End { key: d.dot(ODD), patch, edge, reversed: true, curve: [d, c, b, a] });
        }
    }
    ends.sort_by(|a, b| a.key.total_cmp(&b.key));
    let mut joined = vec![false; 4 * patches.len()];
    for end in ends.iter().filter(|end| !end.reversed) {
        let own = 4 * end.patch + end.edge;
        if joined[own] {
            continue;
        }
        let start = ends.partition_point(|other| other.key < end.key - near);
        let other = ends[start..].iter().take_while(|other| other.key <= end.key + near).find(|other| {
            let theirs = 4 * other.patch + other.edge;
            theirs != own
                && !joined[theirs]
                && end.curve[0].distance(other.curve[0]) <= near
                && end.curve[3].distance(other.curve[3]) <= near
                && curve::point(end.curve, 0.5).distance(curve::point(other.curve, 0.5)) <= 10.0 * near
        });
        let Some(other) = other else {
            report.open += 1;
            continue;
        };
        joined[own] = true;
        joined[4 * other.patch + other.edge] = true;
        measure(&patches, end, other, &mut report);
    }
    report
}

fn measure(patches: &[&Bicubic], a: &End, b: &End, report: &mut Continuity) {
    report.joints += 1;
    report.exact += usize::from(a.curve == b.curve);
    let (shape_a, shape_b) = (patches[a.patch].for_normals(), patches[b.patch].for_normals());
    let mut sharpest: f64 = 0.0;
    for sample in 0..SAMPLES {
        let t = sample as f64 / (SAMPLES - 1) as f64;
        let gap = curve::point(a.curve, t).distance(curve::point(b.curve, t));
        report.widest_gap = report.widest_gap.max(gap);
        let normals = [(&shape_a, a), (&shape_b, b)].map(|(shape, end)| {
            let [u, v] = place(end, t);
            shape.normal(u, v).vector()
        });
        // If two patches run in the same direction along the joint, one of them is upside down.
        let facing = if a.reversed == b.reversed { -1.0 } else { 1.0 };
        let angle = libm::atan2(normals[0].cross(normals[1]).length(), facing * normals[0].dot(normals[1]));
        sharpest = sharpest.max(angle);
    }
    report.greatest_angle = report.greatest_angle.max(sharpest);
    report.smooth += usize::from(sharpest <= 0.1_f64.to_radians());
    let size = shape_a.extent().max(shape_b.extent());
    let handles = |shape: &Bicubic, end: &End| {
        let mut handles: [DVec3; 4] = std::array::from_fn(|i| match end.edge {
            0 => shape.points[4 + i] - shape.points[i],
            1 => shape.points[4 * i + 2] - shape.points[4 * i + 3],
            2 => shape.points[11 - i] - shape.points[15 - i],
            _ => shape.points[13 - 4 * i] - shape.points[12 - 4 * i],
        });
        if end.reversed {
            handles.reverse();
        }
        handles
    };
    let pairs = handles(patches[a.patch], a).into_iter().zip(handles(patches[b.patch], b));
    let opposite = pairs.map(|(p, q)| (p + q).length()).fold(0.0, f64::max) <= 1e-9 * size;
    report.equal_handles += usize::from(opposite);
}

/// Returns (u, v) at `t` along an edge.
fn place(end: &End, t: f64) -> [f64; 2] {
    let t = if end.reversed { 1.0 - t } else { t };
    [[t, 0.0], [1.0, t], [1.0 - t, 1.0], [0.0, 1.0 - t]][end.edge]
}
