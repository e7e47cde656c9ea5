//! Machine code in memory, and how it is called.

use crate::program::Program;
use crate::translate::translate;
use crate::{Lanes, Run, STEP, Set, Stores};
use memmap2::{Mmap, MmapMut};
use trochoid_memory::Target;

/// Items from which on a program is not worth compiling, or too large for the distances that jumps and slots reach.
const MOST_ITEMS: usize = 50_000;

/// A compiled program.
#[derive(Debug)]
pub struct Code {
    /// Written, then made executable and never written again.
    map: Mmap,
    /// On cache lines.
    constants: Vec<Lanes>,
    slots: usize,
    inputs: usize,
    lines: usize,
    outputs: usize,
    state: usize,
    stores: Stores,
}

/// What the code is called with: the table of rows, the constants, the state, the slots, and the bytes of a row.
type Entry = unsafe extern "sysv64" fn(*const *const f32, *const Lanes, *mut Lanes, *mut Lanes, usize);

impl Code {
    /// Compiles a program; `None` where the processor lacks the instructions, the system refuses executable memory, or
    /// the program is too long.
    ///
    /// # Panics
    /// A gate is open.
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
        })
    }

    /// Runs over some samples, and writes to every target from sample `start` on. `scratch` is for what does not fit into
    /// registers.
    ///
    /// # Panics
    /// The numbers of rows are not those of the program, a row is too short, the count is no multiple of [`STEP`], or
    /// targets are no whole cache lines though that is what the code was compiled for.
    pub fn run(&self, run: &Run<'_>, out: &mut [Target<'_>], state: &mut [Lanes], scratch: &mut Vec<Lanes>) {
        let &Run { inputs, lines, start, count } = run;
        assert_eq!(inputs.len(), self.inputs, "inputs");
        assert_eq!(lines.len(), self.lines, "lines");
        assert_eq!(out.len(), self.outputs, "outputs");
        assert_eq!(state.len(), self.state, "state");
        assert!(count.is_multiple_of(STEP), "{count} samples are no whole steps");
        assert!(inputs.iter().all(|row| row.len() >= count), "inputs of {count} samples");
        assert!(lines.iter().all(|row| !row.is_empty()), "lines of one number");
        if count == 0 {
            return;
        }
        if scratch.len() < self.slots {
            scratch.resize(self.slots, Lanes([0; 16]));
        }
        let mut table: Vec<*const f32> = Vec::with_capacity(inputs.len() + lines.len() + out.len());
        table.extend(inputs.iter().chain(lines).map(|row| row.as_ptr()));
        for target in out {
            assert!(self.stores == Stores::Cached || target.is_lines(start, count), "targets of whole lines");
            table.push(target.pointer(start, count).cast_const());
        }
        // SAFETY: the map holds the code of `translate`, whole and executable, and lives as long as `self`.
        #[allow(unsafe_code)]
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(self.map.as_ptr()) };
        // SAFETY: the code follows the System V convention (it saves what it must, calls nothing, leaves the upper halves
        // of vectors clear) and uses only instructions that `compile` found to be there. `rows` of the table, state, slots
        // and constants are all that it names, each by an index that `Program` or `translate` counted, and
        // - it reads inputs and writes outputs at 0 to 4·count bytes: all of them were just held against `count`, which
        //   is a whole number of vectors; outputs are borrowed for writing, so nothing else overlaps them;
        // - it reads 4 bytes of each line, which holds one number;
        // - it reads and writes whole `Lanes` of state, whose length was just checked, and of `scratch`, which is as long
        //   as it counted;
        // - it reads the constants that came with it;
        // - it stores around the cache only where targets are whole lines; who lent those orders the stores.
        #[allow(unsafe_code)]
        unsafe {
            entry(table.as_ptr(), self.constants.as_ptr(), state.as_mut_ptr(), scratch.as_mut_ptr(), 4 * count);
        }
    }
}
