/// Quantities that an evaluation computes; others cost nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FieldSet {
    /// Displacement from the rest point.
    pub displacement: bool,
    /// Derivatives of the displacement by the rest point: normals, Jacobian.
    pub derivatives: bool,
    /// Slope variance that the footprint filtered out.
    pub slope_variance: bool,
    /// Velocity of the water that rests at a point.
    pub velocity: bool,
}

/// Number of sums of waves that an evaluation can compute: three displacements, five derivatives, three velocities.
pub(crate) const SUMS: usize = 11;

impl FieldSet {
    /// All quantities.
    pub const ALL: Self = Self { displacement: true, derivatives: true, slope_variance: true, velocity: true };

    /// Returns which of the sums are computed.
    pub(crate) fn sums(self) -> [bool; SUMS] {
        std::array::from_fn(|sum| match sum {
            0..3 => self.displacement,
            3..8 => self.derivatives,
            _ => self.velocity,
        })
    }
}

/// Rest points in meters, with the footprint at each point in meters (0 keeps every wave unchanged).
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    /// World x of the rest points.
    pub x: &'a [f64],
    /// World z of the rest points.
    pub z: &'a [f64],
    /// Footprints, ≥ 0.
    pub footprint: &'a [f64],
}

/// The displaced surface at one rest point, in f64.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Displacement x, y, z in meters.
    pub displacement: [f64; 3],
    /// ∂y/∂x₀ and ∂y/∂z₀.
    pub slope: [f64; 2],
    /// ∂Δx/∂x₀, ∂Δx/∂z₀ = ∂Δz/∂x₀, ∂Δz/∂z₀.
    pub strain: [f64; 3],
    /// Slope variance ½Σ(a·k)²(1 − attenuation²) that the footprint filtered out, summed over both directions.
    pub slope_variance: f64,
    /// ∂/∂t of the displacement, in m/s: the velocity of the water that rests here.
    pub velocity: [f64; 3],
}

impl Sample {
    /// Returns the Jacobian determinant of (x₀, z₀) → (x, z): the area ratio, negative where the sea is folded.
    pub fn jacobian(&self) -> f64 {
        let [xx, xz, zz] = self.strain;
        (1.0 + xx) * (1.0 + zz) - xz * xz
    }

    /// Returns the normal ∂P/∂z₀ × ∂P/∂x₀, not normalized; its y is the [`jacobian`](Self::jacobian).
    ///
    /// ∂P/∂x₀ = (1+xx, yx, xz) and ∂P/∂z₀ = (xz, yz, 1+zz).
    pub fn normal(&self) -> [f64; 3] {
        let ([yx, yz], [xx, xz, zz]) = (self.slope, self.strain);
        [yz * xz - (1.0 + zz) * yx, self.jacobian(), xz * yx - yz * (1.0 + xx)]
    }
}

/// Results at many rest points: one vector per quantity, empty if it was not requested.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// Displacement x, y, z in meters.
    pub displacement: [Vec<f32>; 3],
    /// ∂y/∂x₀ and ∂y/∂z₀.
    pub slope: [Vec<f32>; 2],
    /// ∂Δx/∂x₀, ∂Δx/∂z₀ = ∂Δz/∂x₀, ∂Δz/∂z₀.
    pub strain: [Vec<f32>; 3],
    /// Slope variance that the footprint filtered out, as in [`Sample::slope_variance`].
    pub slope_variance: Vec<f32>,
    /// Velocity x, y, z in m/s, as in [`Sample::velocity`].
    pub velocity: [Vec<f32>; 3],
}

impl Fields {
    /// Makes room for `len` points of each wanted quantity, all 0, and empties the others.
    pub fn reset(&mut self, wanted: FieldSet, len: usize) {
        let size = |wanted: bool| if wanted { len } else { 0 };
        let fill = |values: &mut Vec<f32>, len: usize| {
            values.clear();
            values.resize(len, 0.0);
        };
        for values in &mut self.displacement {
            fill(values, size(wanted.displacement));
        }
        for values in self.slope.iter_mut().chain(&mut self.strain) {
            fill(values, size(wanted.derivatives));
        }
        for values in &mut self.velocity {
            fill(values, size(wanted.velocity));
        }
        fill(&mut self.slope_variance, size(wanted.slope_variance));
    }

    /// Returns the sums of waves, in the order of the kernel's outputs.
    pub(crate) fn sums_mut(&mut self) -> [&mut Vec<f32>; SUMS] {
        let ([dx, dy, dz], [yx, yz], [xx, xz, zz]) = (&mut self.displacement, &mut self.slope, &mut self.strain);
        let [vx, vy, vz] = &mut self.velocity;
        [dx, dy, dz, yx, yz, xx, xz, zz, vx, vy, vz]
    }
}
