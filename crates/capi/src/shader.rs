//! Shaders.

use crate::batch::{are_there, trochoid_in, trochoid_out};
use crate::error::{hand_over, there, trochoid_error};
use crate::look::trochoid_look;
use crate::options::size_t;
use crate::status::{guarded, or_panic, trochoid_status};
use trochoid::ShadeError;
use trochoid_foreign::{ForeignShader, Input, Output};

/// What one thread needs to shade samples of a look.
pub struct trochoid_shader {
    shader: ForeignShader,
    /// Channels of a batch.
    inputs: Vec<Input>,
    outputs: Vec<Output>,
}

/// The first illegal sample of a refused batch.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trochoid_bad {
    /// Index of the input.
    pub slot: size_t,
    /// Index of the sample in the batch.
    pub sample: size_t,
}

/// Makes a shader of a look: one for each thread. Release it with trochoid_shader_release().
/// TROCHOID_INVALID if the output needs a picture, for example for a blur: the error tells each node that
/// is in the way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_shader_new(
    look: *const trochoid_look,
    shader: *mut *mut trochoid_shader,
    error: *mut *mut trochoid_error,
) -> trochoid_status {
    let make = || {
        // SAFETY: null or a look of this library.
        let shader = unsafe { there(look, "a look")? }.look.shader()?;
        let made = trochoid_shader { shader: ForeignShader::new(shader), inputs: Vec::new(), outputs: Vec::new() };
        Ok(Box::into_raw(Box::new(made)))
    };
    // SAFETY: as the header says.
    unsafe { hand_over(shader, "the shader", error, make) }
}

/// Releases a shader.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_shader_release(shader: *mut trochoid_shader) {
    or_panic((), || {
        if !shader.is_null() {
            // SAFETY: a shader of this library, released once.
            drop(unsafe { Box::from_raw(shader) });
        }
    });
}

/// Shades count samples. in has an entry for each channel of each input, in their order
/// (trochoid_look_inputs() in all), and out one for each channel of the output
/// (trochoid_look_channels()). Results may be written where inputs are, sample by sample. Nothing is
/// allocated after the first batch. The results are those of pictures, bit for bit.
///
/// If a sample of an input is illegal, returns TROCHOID_BUFFER, and writes to bad, unless that is NULL,
/// where it is. What is in out then is undefined. If the samples of an input that is used or of the
/// output are NULL, or the stride of the output is 0, returns TROCHOID_INVALID, and writes nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_shade(
    shader: *mut trochoid_shader,
    count: size_t,
    r#in: *const trochoid_in,
    out: *const trochoid_out,
    bad: *mut trochoid_bad,
) -> trochoid_status {
    guarded(|| {
        // SAFETY: null or a shader of this library, which no other thread uses now.
        let Some(shader) = (unsafe { shader.as_mut() }) else { return trochoid_status::TROCHOID_INVALID };
        let look = shader.shader.look();
        if (r#in.is_null() && look.inputs() > 0) || out.is_null() {
            return trochoid_status::TROCHOID_INVALID;
        }
        shader.inputs.clear();
        shader.outputs.clear();
        // SAFETY: as many channels and samples as the header asks for.
        let done = unsafe {
            shader.inputs.extend((0..look.inputs()).map(|channel| Input::from(r#in.add(channel).read())));
            shader.outputs.extend((0..look.channels()).map(|channel| Output::from(out.add(channel).read())));
            if !are_there(look, &shader.inputs, &shader.outputs) && count > 0 {
                return trochoid_status::TROCHOID_INVALID;
            }
            shader.shader.shade(count, &shader.inputs, &shader.outputs)
        };
        match done {
            Ok(()) => trochoid_status::TROCHOID_OK,
            Err(error) => {
                if let (ShadeError::Illegal { slot, sample, .. }, false) = (error, bad.is_null()) {
                    // SAFETY: not null, and a place by the caller's promise.
                    unsafe { bad.write(trochoid_bad { slot, sample }) };
                }
                trochoid_status::TROCHOID_BUFFER
            }
        }
    })
}
