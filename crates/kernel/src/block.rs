//! Runs programs over samples without a place in a picture, without allocating.

use crate::code::{BLOCK, Block, CHUNK, Plane};
use crate::native::Native;
use crate::run::{KernelInputs, Machine, PlaneRow};
use crate::sweep::{is_faulty, sweep};
use trochoid_memory::{Target, emptied};

/// Memory of lists that borrow what a call borrows.
#[derive(Debug, Default)]
pub(crate) struct Spare {
    planes: Vec<PlaneRow<'static>>,
    rows: Vec<&'static [f32]>,
    targets: Vec<Target<'static>>,
}

impl Machine<'_> {
    /// Returns the number of samples that are run at a time, a divisor of [`CHUNK`].
    pub fn step(&self) -> usize {
        self.compiled.native.as_ref().and_then(Native::make_ready).unwrap_or(CHUNK)
    }

    /// Runs over `count` samples, a multiple of [`step`](Self::step): one row for each plane in, one for each channel of each root out,
    /// in the order of both iterators. Only the first call allocates.
    ///
    /// # Panics
    /// The numbers of rows do not match the program, a row is too short, the count is no multiple, or the program computes
    /// something by row or by column.
    pub fn rows<'i, 'o>(
        &mut self,
        inputs: impl Iterator<Item = &'i [f32]>,
        count: usize,
        outputs: impl Iterator<Item = &'o mut [f32]>,
    ) {
        assert!(count.is_multiple_of(self.step()), "whole steps");
        self.all(inputs, count, outputs);
    }

    /// Runs over the first `count` samples of blocks. What lies beyond them is overwritten. Only the first call allocates.
    ///
    /// # Panics
    /// The count is 0 or exceeds a block, or as [`rows`](Self::rows).
    pub fn block(&mut self, inputs: &mut [Block], count: usize, outputs: &mut [Block]) {
        assert!((1..=BLOCK).contains(&count), "1 to {BLOCK} samples");
        let whole = count.next_multiple_of(self.step());
        for input in &mut *inputs {
            // Padded with the last sample, which adds nothing new to any audit.
            let last = input.0[count - 1];
            input.0[count..whole].fill(last);
        }
        let inputs = inputs.iter().map(|block| &block.0[..]);
        self.all(inputs, whole, outputs.iter_mut().map(|block| &mut block.0[..]));
    }

    fn all<'i, 'o>(
        &mut self,
        inputs: impl Iterator<Item = &'i [f32]>,
        count: usize,
        outputs: impl Iterator<Item = &'o mut [f32]>,
    ) {
        let compiled = self.compiled;
        assert!(compiled.column.list.is_empty() && compiled.row.list.is_empty(), "nothing is computed apart");
        let mut rows: Vec<&[f32]> = emptied(std::mem::take(&mut self.spare.rows));
        rows.extend(inputs);
        let mut targets: Vec<Target<'_>> = emptied(std::mem::take(&mut self.spare.targets));
        targets.extend(outputs.map(Target::new));
        assert_eq!(rows.len(), compiled.planes.len(), "planes");
        assert_eq!(targets.len(), compiled.main.channels(), "channels");
        let is_done = match &compiled.native {
            Some(native) if !is_faulty(&self.main) => {
                native.samples(&mut self.main, &rows, count, &mut targets, &mut self.scratch)
            }
            _ => false,
        };
        if !is_done {
            let mut planes: Vec<PlaneRow<'_>> = emptied(std::mem::take(&mut self.spare.planes));
            planes
                .extend(rows.iter().map(|row| PlaneRow { plane: Plane { samples: row, start: 0, stride: 0 }, at: 0 }));
            let inputs = KernelInputs { planes: &planes, columns: &[], lines: &[] };
            sweep(self.level, &mut self.main, inputs, count, &mut targets, 0, &mut self.end, None);
            self.spare.planes = emptied(planes);
        }
        (self.spare.rows, self.spare.targets) = (emptied(rows), emptied(targets));
    }
}
