//! Programs to compile: operations on one sample, in single-assignment form.

/// A value of a program: one number per sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Value(pub(crate) u32);

/// Operation that makes a value, with the same bits as in `trochoid_weights::arithmetic`.
#[derive(Clone, Debug, PartialEq)]
pub enum Op {
    /// A sample of an input.
    Input(u32),
    /// The single number of a line.
    Line(u32),
    /// A constant.
    Constant(f32),
    /// `clamp`, with `min` < `min` + `width`, and bounds below `LARGE` of `clamp`, so that nothing overflows.
    Clamp {
        /// The field.
        x: Value,
        /// Lower limit: above it the mask is above 0.
        min: f32,
        /// Distance to the upper limit, from which on the mask is 1; rounded.
        width: f32,
    },
    /// `step`.
    Step {
        /// The field.
        x: Value,
        /// Smallest value where the mask is 1.
        threshold: f32,
    },
    /// `smooth`.
    Smooth(Value),
    /// `power` with an exponent of 1 to 16.
    Power {
        /// The mask.
        t: Value,
        /// The exponent.
        n: u32,
    },
    /// `complement`.
    Complement(Value),
    /// `product`.
    Product(Value, Value),
    /// `mix`.
    Mix {
        /// Result at `t` = 0.
        a: Value,
        /// Result at `t` = 1.
        b: Value,
        /// The mask.
        t: Value,
    },
}

/// One item of a program.
#[derive(Clone, Debug)]
pub(crate) enum Item {
    Compute {
        op: Op,
        to: Value,
    },
    Blend {
        colors: Vec<[Value; 3]>,
        weights: Vec<Value>,
        to: [Value; 3],
    },
    Partition {
        weights: Vec<Value>,
        to: Vec<Value>,
    },
    Fetch(u32),
    /// First, slow half of a clamp: the difference of the field and `min`, divided by `width`.
    Over {
        x: Value,
        min: f32,
        width: f32,
        to: Value,
    },
    /// Second half of a clamp: the limits.
    Within {
        x: Value,
        to: Value,
    },
    /// Prepares a mask, so that mixes by it can start at once.
    Ready(Value),
    See {
        value: Value,
        least: Option<u32>,
        largest: u32,
        shifted: bool,
    },
    SeeSum {
        weights: Vec<Value>,
        state: u32,
    },
    Output {
        value: Value,
        to: u32,
    },
    Gate {
        t: Value,
        closed: f32,
        join: usize,
    },
    Join {
        inside: [Value; 3],
        otherwise: [Value; 3],
        to: [Value; 3],
    },
}

/// Straight-line code for samples, with branches that can be jumped over.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) items: Vec<Item>,
    pub(crate) inputs: usize,
    pub(crate) lines: usize,
    pub(crate) outputs: usize,
    pub(crate) state: usize,
    pub(crate) values: u32,
    /// Indices of the items that open gates.
    gates: Vec<usize>,
}

impl Program {
    /// Makes an empty program with numbers of inputs, lines (inputs with one number for all samples), outputs and
    /// vectors of state.
    pub fn new(inputs: usize, lines: usize, outputs: usize, state: usize) -> Self {
        Self { items: Vec::new(), inputs, lines, outputs, state, values: 0, gates: Vec::new() }
    }

    /// Returns the number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Returns the number of vectors of state.
    pub fn state(&self) -> usize {
        self.state
    }

    /// Returns the number of items, which determines the time to compile.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether the program has no items.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    fn make(&mut self) -> Value {
        self.values += 1;
        Value(self.values - 1)
    }

    fn own(&self, values: &[Value]) {
        assert!(values.iter().all(|value| value.0 < self.values), "values of another program");
    }

    /// Appends an operation and returns its value.
    ///
    /// # Panics
    /// A value, input or line of the operation does not exist, or an exponent is outside of 1 to 16.
    pub fn compute(&mut self, op: Op) -> Value {
        match op {
            Op::Input(index) => assert!((index as usize) < self.inputs, "input {index} of {}", self.inputs),
            Op::Line(index) => assert!((index as usize) < self.lines, "line {index} of {}", self.lines),
            Op::Power { n, .. } => assert!((1..=16).contains(&n), "exponent {n}"),
            _ => {}
        }
        op.operands(|operand| self.own(&[operand]));
        let to = self.make();
        self.items.push(Item::Compute { op, to });
        to
    }

    /// Appends a `blend` of colors, channel by channel.
    ///
    /// # Panics
    /// The numbers of weights and colors differ.
    pub fn blend(&mut self, colors: Vec<[Value; 3]>, weights: Vec<Value>) -> [Value; 3] {
        assert_eq!(colors.len(), weights.len(), "a weight for every color");
        self.own(colors.as_flattened());
        self.own(&weights);
        let to = [(); 3].map(|()| self.make());
        self.items.push(Item::Blend { colors, weights, to });
        to
    }

    /// Appends a `round_partition`.
    pub fn partition(&mut self, weights: Vec<Value>) -> Vec<Value> {
        self.own(&weights);
        let to: Vec<Value> = weights.iter().map(|_| self.make()).collect();
        self.items.push(Item::Partition { weights, to: to.clone() });
        to
    }

    /// Appends a prefetch of an input.
    ///
    /// # Panics
    /// The input does not exist.
    pub fn fetch(&mut self, input: u32) {
        assert!((input as usize) < self.inputs, "input {input} of {}", self.inputs);
        self.items.push(Item::Fetch(input));
    }

    /// Updates the smallest and the largest bits of a value in two vectors of state, lane by lane; `shifted` drops
    /// the sign.
    ///
    /// # Panics
    /// The state does not exist.
    pub fn see(&mut self, value: Value, least: Option<u32>, largest: u32, shifted: bool) {
        self.own(&[value]);
        assert!(largest.max(least.unwrap_or(0)) < self.state as u32, "state {largest} of {}", self.state);
        self.items.push(Item::See { value, least, largest, shifted });
    }

    /// Updates the largest |Σ weights − 1| in two vectors of state, in f64.
    ///
    /// # Panics
    /// The state does not exist.
    pub fn see_sum(&mut self, weights: Vec<Value>, state: u32) {
        self.own(&weights);
        assert!(state as usize + 1 < self.state, "state {state} of {}", self.state);
        self.items.push(Item::SeeSum { weights, state });
    }

    /// Appends a store of a value to an output.
    ///
    /// # Panics
    /// The output does not exist.
    pub fn output(&mut self, value: Value, to: u32) {
        self.own(&[value]);
        assert!((to as usize) < self.outputs, "output {to} of {}", self.outputs);
        self.items.push(Item::Output { value, to });
    }

    /// Opens a branch: the items up to the matching [`join`](Self::join) may be jumped over if all lanes of `t` equal
    /// `closed`, bit for bit.
    pub fn gate(&mut self, t: Value, closed: f32) {
        self.own(&[t]);
        self.gates.push(self.items.len());
        self.items.push(Item::Gate { t, closed, join: usize::MAX });
    }

    /// Ends the branch of the last open gate, and returns `inside`, or `otherwise` if the branch was jumped over.
    /// Values made inside of the branch must not be used after it.
    ///
    /// # Panics
    /// No gate is open.
    pub fn join(&mut self, inside: [Value; 3], otherwise: [Value; 3]) -> [Value; 3] {
        self.own(&inside);
        self.own(&otherwise);
        let Some(gate) = self.gates.pop() else { panic!("no gate is open") };
        let at = self.items.len();
        if let Item::Gate { join, .. } = &mut self.items[gate] {
            *join = at;
        }
        let to = [(); 3].map(|()| self.make());
        self.items.push(Item::Join { inside, otherwise, to });
        to
    }

    /// Whether every gate is joined.
    pub(crate) fn is_closed(&self) -> bool {
        self.gates.is_empty()
    }
}

impl Value {
    /// Returns the value in one of several vectors that are processed side by side.
    pub(crate) fn of(self, part: u32, parts: u32) -> Self {
        Self(self.0 * parts + part)
    }
}

impl Op {
    /// Replaces every operand.
    fn map(&self, f: impl Fn(Value) -> Value) -> Self {
        match *self {
            Self::Input(_) | Self::Line(_) | Self::Constant(_) => self.clone(),
            Self::Clamp { x, min, width } => Self::Clamp { x: f(x), min, width },
            Self::Step { x, threshold } => Self::Step { x: f(x), threshold },
            Self::Smooth(t) => Self::Smooth(f(t)),
            Self::Power { t, n } => Self::Power { t: f(t), n },
            Self::Complement(t) => Self::Complement(f(t)),
            Self::Product(t, u) => Self::Product(f(t), f(u)),
            Self::Mix { a, b, t } => Self::Mix { a: f(a), b: f(b), t: f(t) },
        }
    }

    /// Calls `f` with every operand.
    pub(crate) fn operands(&self, mut f: impl FnMut(Value)) {
        match self {
            Self::Input(_) | Self::Line(_) | Self::Constant(_) => {}
            Self::Clamp { x: t, .. }
            | Self::Step { x: t, .. }
            | Self::Smooth(t)
            | Self::Power { t, .. }
            | Self::Complement(t) => f(*t),
            Self::Product(t, u) => [*t, *u].into_iter().for_each(f),
            Self::Mix { a, b, t } => [*a, *b, *t].into_iter().for_each(f),
        }
    }
}

impl Item {
    /// Calls `f` with every result.
    pub(crate) fn results(&self, mut f: impl FnMut(Value)) {
        match self {
            Self::Compute { to, .. } | Self::Over { to, .. } | Self::Within { to, .. } => f(*to),
            Self::Blend { to, .. } | Self::Join { to, .. } => to.iter().for_each(|to| f(*to)),
            Self::Partition { to, .. } => to.iter().for_each(|to| f(*to)),
            Self::Fetch(_)
            | Self::Ready(_)
            | Self::See { .. }
            | Self::SeeSum { .. }
            | Self::Output { .. }
            | Self::Gate { .. } => {}
        }
    }

    /// Replaces every operand and result.
    pub(crate) fn map(&self, f: impl Fn(Value) -> Value) -> Self {
        let all = |values: &[Value]| -> Vec<Value> { values.iter().map(|value| f(*value)).collect() };
        match self {
            Self::Compute { op, to } => Self::Compute { op: op.map(&f), to: f(*to) },
            Self::Blend { colors, weights, to } => Self::Blend {
                colors: colors.iter().map(|color| color.map(&f)).collect(),
                weights: all(weights),
                to: to.map(&f),
            },
            Self::Partition { weights, to } => Self::Partition { weights: all(weights), to: all(to) },
            Self::Fetch(input) => Self::Fetch(*input),
            Self::Ready(t) => Self::Ready(f(*t)),
            Self::Over { x, min, width, to } => Self::Over { x: f(*x), min: *min, width: *width, to: f(*to) },
            Self::Within { x, to } => Self::Within { x: f(*x), to: f(*to) },
            Self::See { value, least, largest, shifted } => {
                Self::See { value: f(*value), least: *least, largest: *largest, shifted: *shifted }
            }
            Self::SeeSum { weights, state } => Self::SeeSum { weights: all(weights), state: *state },
            Self::Output { value, to } => Self::Output { value: f(*value), to: *to },
            Self::Gate { t, closed, join } => Self::Gate { t: f(*t), closed: *closed, join: *join },
            Self::Join { inside, otherwise, to } => {
                Self::Join { inside: inside.map(&f), otherwise: otherwise.map(&f), to: to.map(&f) }
            }
        }
    }

    /// Calls `f` with every operand.
    pub(crate) fn operands(&self, mut f: impl FnMut(Value)) {
        match self {
            Self::Compute { op, .. } => op.operands(f),
            Self::Blend { colors, weights, .. } => {
                colors.as_flattened().iter().chain(weights).for_each(|value| f(*value));
            }
            Self::Partition { weights, .. } | Self::SeeSum { weights, .. } => {
                weights.iter().for_each(|value| f(*value))
            }
            Self::Fetch(_) => {}
            Self::See { value, .. }
            | Self::Output { value, .. }
            | Self::Gate { t: value, .. }
            | Self::Ready(value)
            | Self::Over { x: value, .. }
            | Self::Within { x: value, .. } => f(*value),
            Self::Join { inside, otherwise, .. } => inside.iter().chain(otherwise).for_each(|value| f(*value)),
        }
    }
}
