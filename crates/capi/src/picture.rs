//! Pictures.

use crate::batch::{are_there, trochoid_in, trochoid_out};
use crate::error::{Fault, explained, there, trochoid_error};
use crate::look::trochoid_look;
use crate::options::size_t;
use crate::status::trochoid_status;
use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, Ordering};
use trochoid::{Cache, Format, Monitor, Samples};
use trochoid_foreign::{Input, Output};

/// Is told how many of all tiles are done, from any thread, from several at once, and not in order;
/// returns 0 to go on, and anything else to cancel. It must not throw.
pub type trochoid_progress = Option<unsafe extern "C" fn(done: size_t, total: size_t, user: *mut c_void) -> i32>;

/// What was counted on a picture. Set struct_size before the call.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct trochoid_report {
    /// Size of this structure in bytes.
    pub struct_size: size_t,
    /// Number of pixels.
    pub pixels: u64,
    /// Number of control colors, which the output mixes: the different ones of the document, and of each
    /// input or file with colors the corners of the hull of its pixels; one if it is the same
    /// everywhere. 0 of an output that is no color.
    pub control_count: u64,
    /// Number of pixels outside of the hull of the control colors: 0, unless the library is broken. Only
    /// pixels that are judged are counted: look at judged.
    pub hull_exits: u64,
    /// Number of values that are NaN.
    pub nan_count: u64,
    /// Seconds that it took.
    pub seconds: f64,
    /// Number of pixels that are judged, whether they are in the hull of the control colors: all of a
    /// color, none of an output that is no color.
    pub judged: u64,
    /// Number of threads that it ran on.
    pub threads: size_t,
}

/// Tells C about progress.
struct Teller {
    progress: trochoid_progress,
    user: *mut c_void,
    stopped: AtomicBool,
}

// SAFETY: the header says that the callback is called from several threads at once, and `user` is only handed on to it.
unsafe impl Sync for Teller {}

impl Monitor for Teller {
    fn progress(&self, done: usize, total: usize) {
        if let Some(progress) = self.progress
            // SAFETY: a function of the caller, called as it is declared.
            && unsafe { progress(done, total, self.user) } != 0
        {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    fn cancelled(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

/// Makes a picture of width x height pixels. in has an entry for each channel of each input, whose
/// samples are the pixels row by row from the top, and out one for each channel of the output. Runs on
/// as many threads as the options of the look say, which is one for each core unless told. progress, report and error may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_picture(
    look: *const trochoid_look,
    width: u32,
    height: u32,
    r#in: *const trochoid_in,
    out: *const trochoid_out,
    progress: trochoid_progress,
    user: *mut c_void,
    report: *mut trochoid_report,
    error: *mut *mut trochoid_error,
) -> trochoid_status {
    let run = || {
        // SAFETY: all pointers are as the header says, as for the functions above.
        unsafe {
            let look = &there(look, "a look")?.look;
            if (r#in.is_null() && look.inputs() > 0) || out.is_null() {
                return Err(Fault::invalid("found NULL; expected the channels of the inputs and of the output"));
            }
            let format = Format::new(width, height, 1).map_err(|fault| Fault::invalid(fault.to_string()))?;
            if !report.is_null() && (&raw const (*report).struct_size).read() == 0 {
                let text = "found a report with a struct_size of 0; expected sizeof(trochoid_report)";
                return Err(Fault::invalid(text));
            }
            let inputs: Vec<Input> = (0..look.inputs()).map(|channel| Input::from(r#in.add(channel).read())).collect();
            let outputs: Vec<Output> =
                (0..look.channels()).map(|channel| Output::from(out.add(channel).read())).collect();
            if !are_there(look, &inputs, &outputs) {
                let text =
                    "found NULL, or an output with a stride of 0; expected samples in every channel that is used";
                return Err(Fault::invalid(text));
            }
            let area = format.window().area();
            let used = |channel: usize| look.slots().iter().any(|slot| slot.is_used && slot.has(channel));
            // The picture copies uniform channels, while the copies made here are still there.
            look.check_memory(format, (0..inputs.len()).filter(|channel| used(*channel)).count())?;
            let mut planes: Vec<Vec<f32>> = Vec::with_capacity(look.inputs());
            for slot in look.slots() {
                let count = if slot.is_used { area } else { 0 };
                let channels = &inputs[slot.first..slot.first + slot.channels()];
                planes.extend(
                    channels.iter().map(|input| input.copied(if input.stride == 0 { count.min(1) } else { count })),
                );
            }
            let passes = planes.iter().zip(&inputs).map(|(plane, input)| match (&plane[..], input.stride) {
                ([value], 0) => Samples::uniform(value),
                (plane, _) => Samples::new(plane),
            });
            let passes: Vec<Samples<'_>> = passes.collect();
            let teller = Teller { progress, user, stopped: AtomicBool::new(false) };
            let started = std::time::Instant::now();
            let frame = look.picture(format, &passes, &mut Cache::new(), &teller)?;
            let seconds = started.elapsed().as_secs_f64();
            let picture = &frame.pictures[0];
            for (output, plane) in outputs.iter().zip(&picture.planes) {
                output.take(plane.samples());
            }
            if !report.is_null() {
                let counted = trochoid_report {
                    struct_size: (&raw const (*report).struct_size).read(),
                    pixels: picture.audit.pixels,
                    control_count: picture.control_count as u64,
                    hull_exits: picture.audit.hull_exits,
                    nan_count: picture.audit.nan_count,
                    seconds,
                    judged: picture.audit.judged,
                    threads: frame.threads,
                };
                let size = counted.struct_size.min(size_of::<trochoid_report>());
                std::ptr::copy_nonoverlapping((&raw const counted).cast::<u8>(), report.cast::<u8>(), size);
            }
            Ok(())
        }
    };
    // SAFETY: as the header says.
    unsafe { explained(error, run) }
}
