//! Machine code in memory, and calls to it.

use crate::program::Program;
use crate::translate::translate;
use crate::{Lanes, Run, Scratch, Set, Stores};
use memmap2::{Mmap, MmapMut};
use std::sync::atomic::AtomicPtr;
use trochoid_memory::Target;

/// Largest number of items: larger programs are not worth compiling, or exceed the range of jumps and slots.
const MOST_ITEMS: usize = 50_000;

/// A compiled program.
#[derive(Debug)]
pub struct Code {
    /// The code: written, then made executable and never written again.
    map: Mmap,
    /// Constants, aligned to cache lines.
    constants: Vec<Lanes>,
    slots: usize,
    inputs: usize,
    lines: usize,
    outputs: usize,
    state: usize,
    stores: Stores,
    step: usize,
}

/// Entry point of the code. Its arguments are the table of rows, the constants, the state, the slots, and the bytes
/// per row.
type Entry = unsafe extern "sysv64" fn(*const *const f32, *const Lanes, *mut Lanes, *mut Lanes, usize);

impl Code {
    /// Compiles a program; `None` if the processor lacks the instructions, the system refuses executable memory, or the
    /// program is too long.
    ///
    /// # Panics
    /// The program has an open gate.
    pub fn compile(program: &Program, set: Set, stores: Stores) -> Option<Self> {
        assert!(program.is_closed(), "every gate is joined");
        let is_there = match set {
            Set::Avx512 => is_x86_feature_detected!("avx512f"),
            Set::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
        };
        if !is_there || program.len() > MOST_ITEMS {
            return None;
        }
        let translated = translate(program, set, stores).ok()?;
        let mut map = MmapMut::map_anon(translated.code.len()).ok()?;
        map.copy_from_slice(&translated.code);
        let lines = translated.constants.chunks(16);
        let constants = lines.map(|line| Lanes(std::array::from_fn(|at| line.get(at).copied().unwrap_or(0)))).collect();
        Some(Self {
            map: map.make_exec().ok()?,
            constants,
            slots: translated.slots,
            inputs: program.inputs,
            lines: program.lines,
            outputs: program.outputs,
            state: program.state,
            stores,
            step: translated.step,
        })
    }

    /// Returns the number of samples that it processes at a time, a divisor of [`STEP`](crate::STEP).
    pub fn step(&self) -> usize {
        self.step
    }

    /// Runs over some samples, and writes to every target from sample `start` on. Allocates nothing if `scratch` has
    /// served a program that is as large.
    ///
    /// # Panics
    /// The number of rows does not match the program, a row is too short, the count is not a multiple of its [`step`](Self::step), or
    /// the code was compiled for targets of whole cache lines and a target is not one.
    pub fn run(&self, run: &Run<'_>, out: &mut [Target<'_>], state: &mut [Lanes], scratch: &mut Scratch) {
        let &Run { inputs, lines, start, count } = run;
        assert_eq!(inputs.len(), self.inputs, "inputs");
        assert_eq!(lines.len(), self.lines, "lines");
        assert_eq!(out.len(), self.outputs, "outputs");
        assert_eq!(state.len(), self.state, "state");
        assert!(count.is_multiple_of(self.step), "{count} samples are no whole steps");
        assert!(inputs.iter().all(|row| row.len() >= count), "inputs of {count} samples");
        assert!(lines.iter().all(|row| !row.is_empty()), "lines of one number");
        if count == 0 {
            return;
        }
        let Scratch { slots, table } = scratch;
        if slots.len() < self.slots {
            slots.resize(self.slots, Lanes([0; 16]));
        }
        table.clear();
        table.extend(inputs.iter().chain(lines).map(|row| AtomicPtr::new(row.as_ptr().cast_mut())));
        for target in out {
            assert!(self.stores == Stores::Cached || target.is_lines(start, count), "targets of whole lines");
            table.push(AtomicPtr::new(target.pointer(start, count)));
        }
        // SAFETY: the map holds the code of `translate`, whole and executable, and lives as long as `self`.
        #[allow(unsafe_code)]
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(self.map.as_ptr()) };
        // SAFETY: the code follows the System V convention (it saves the registers that it must, calls nothing,
        // leaves the upper halves of vectors clear) and uses only instructions that `compile` found to be available.
        // It accesses only the rows of the table, state, slots and constants, each by an index that `Program` or
        // `translate` counted, and
        // - it reads inputs and writes outputs at 0 to 4·count bytes: all lengths were just checked against `count`,
        //   which is a whole number of vectors; outputs are borrowed for writing, so nothing else overlaps them;
        // - it reads 4 bytes of each line, which has at least one number;
        // - it finds the rows in the table, whose entries have the memory of plain pointers;
        // - it reads and writes whole `Lanes` of state, whose length was just checked, and of `slots`, which is as
        //   long as it counted;
        // - it reads the constants that came with it;
        // - it stores around the cache only if targets are whole lines; the code that lent them orders the stores.
        #[allow(unsafe_code)]
        unsafe {
            let table = table.as_ptr().cast::<*const f32>();
            entry(table, self.constants.as_ptr(), state.as_mut_ptr(), slots.as_mut_ptr(), 4 * count);
        }
    }
}
