/* Trochoid: pictures that cannot leave their palette, for renderers in C and C++.
 *
 * A look is one output of a document whose passes come from you. Make it once, share it between
 * threads, and give each thread a shader. Shading a batch takes no lock and allocates nothing.
 *
 * Threads: a look may be used by any number of threads at once. A shader, and an error, may be used
 * by one thread at a time. Every function that makes something says what releases it. NULL may be
 * released.
 *
 * Statuses: every function that can fail returns a trochoid_status. What it would have made is then
 * NULL. A panic within the library is caught, and returned as TROCHOID_PANIC; release what was in use.
 *
 * Versions: trochoid_abi() returns TROCHOID_ABI of the library. Structures that can grow begin with
 * their size; fill them with trochoid_options_init() and set what you need.
 */


#ifndef TROCHOID_H
#define TROCHOID_H

#include <stddef.h>
#include <stdint.h>

/**
 * Version of this interface. It grows whenever something that exists changes.
 */
#define TROCHOID_ABI 1

/**
 * Result of a function. The numbers are the exit codes of the program, as far as it has them.
 */
typedef enum {
  /**
   * Done.
   */
  TROCHOID_OK = 0,
  /**
   * Files cannot be read, or their data are bad.
   */
  TROCHOID_IO = 1,
  /**
   * The document is invalid, or an argument is wrong.
   */
  TROCHOID_INVALID = 2,
  /**
   * Inputs have too few channels or samples, or illegal samples.
   */
  TROCHOID_BUFFER = 4,
  /**
   * Memory, or threads, do not suffice.
   */
  TROCHOID_MEMORY = 5,
  /**
   * The progress callback asked to stop.
   */
  TROCHOID_CANCELLED = 130,
  /**
   * The library failed; please report it.
   */
  TROCHOID_PANIC = 255,
} trochoid_status;

/**
 * What happens to illegal samples of inputs, such as a weight of 1.1 or NaN.
 */
typedef enum {
  /**
   * The batch is refused with TROCHOID_BUFFER, and the input and sample are told.
   */
  TROCHOID_REFUSE = 0,
  /**
   * They become the nearest legal number, and NaN becomes 0. Weights are divided by their sum.
   */
  TROCHOID_CLAMP = 1,
} trochoid_illegal;

/**
 * Kind of an input, or of the output.
 */
typedef enum {
  /**
   * Three channels in the working space of the document; finite numbers >= 0.
   */
  TROCHOID_COLOR = 0,
  /**
   * One channel; numbers in [0, 1].
   */
  TROCHOID_MASK = 1,
  /**
   * A channel for each weight; numbers in [0, 1] that sum to 1 within 0.001.
   */
  TROCHOID_WEIGHTS = 2,
  /**
   * A channel for each component; any numbers but NaN.
   */
  TROCHOID_FIELD = 3,
} trochoid_kind;

/**
 * What went wrong. Made by functions that fail; release it with trochoid_error_release().
 */
typedef struct trochoid_error trochoid_error;

/**
 * One output of a document, with inputs of yours. It never changes, and any threads may use it.
 */
typedef struct trochoid_look trochoid_look;

/**
 * What one thread needs to shade samples of a look.
 */
typedef struct trochoid_shader trochoid_shader;

/**
 * How a look is made. Fill it with trochoid_options_init().
 */
typedef struct {
  /**
   * Size of this structure in bytes, by which later versions know what is in it.
   */
  size_t struct_size;
  /**
   * What messages call the document; NULL for "look" or the file's name.
   */
  const char *name;
  /**
   * Folder that the document's paths are relative to, whose files it may read; NULL for the
   * current folder, or that of the document's file.
   */
  const char *folder;
  /**
   * Name of the output; NULL for the only one.
   */
  const char *output;
  /**
   * Names of the inputs for which you supply samples, in this order: a node ("light"), a color of
   * the palette ("palette.foam"), a knob of the document that ports take as it is
   * ("knobs.calm"), or a color or number at a port ("water.weight", "water.stops[1].color").
   */
  const char *const *inputs;
  /**
   * Number of inputs.
   */
  size_t input_count;
  /**
   * Changes of the document, such as "water.smooth=true" or "palette.foam=#fff".
   */
  const char *const *assignments;
  /**
   * Number of assignments.
   */
  size_t assignment_count;
  /**
   * Frame, for documents with keys; 1 by default.
   */
  int64_t frame;
  /**
   * Number of samples that the look will shade in all, if you know that they are few: machine code
   * is made only where it pays. 0 if not known.
   */
  uint64_t samples;
  /**
   * What happens to illegal samples: one of trochoid_illegal.
   */
  uint32_t illegal;
  /**
   * Files and folders that the document may read besides its own folder.
   */
  const char *const *allow;
  /**
   * Number of these.
   */
  size_t allow_count;
  /**
   * Number of threads that make a picture; 0 for one on each core. Shading runs on the caller's.
   */
  size_t threads;
} trochoid_options;

/**
 * An input of a look.
 */
typedef struct {
  /**
   * Name, as in trochoid_options. It lives as long as the look.
   */
  const char *name;
  /**
   * Kind: one of trochoid_kind.
   */
  uint32_t kind;
  /**
   * Index of its first channel among those of all inputs.
   */
  size_t first;
  /**
   * Number of its channels.
   */
  size_t channels;
  /**
   * 1 if the output depends on it. If not, its samples are never read and may be NULL.
   */
  uint32_t is_used;
} trochoid_slot;

/**
 * Where the samples of an input channel are.
 */
typedef struct {
  /**
   * The first sample. It need not be aligned.
   */
  const float *samples;
  /**
   * Distance from one sample to the next in bytes: 4 if they follow one another, the size of your
   * structure if they are within one, 0 for one value for all samples. It may be negative.
   */
  ptrdiff_t stride;
} trochoid_in;

/**
 * Where the samples of an output channel go.
 */
typedef struct {
  /**
   * The first sample. It need not be aligned.
   */
  float *samples;
  /**
   * Distance from one sample to the next in bytes, not 0.
   */
  ptrdiff_t stride;
} trochoid_out;

/**
 * The first illegal sample of a refused batch.
 */
typedef struct {
  /**
   * Index of the input.
   */
  size_t slot;
  /**
   * Index of the sample in the batch.
   */
  size_t sample;
} trochoid_bad;

/**
 * Is told how many of all tiles are done, from any thread, from several at once, and not in order;
 * returns 0 to go on, and anything else to cancel. It must not throw.
 */
typedef int32_t (*trochoid_progress)(size_t done, size_t total, void *user);

/**
 * What was counted on a picture. Set struct_size before the call.
 */
typedef struct {
  /**
   * Size of this structure in bytes.
   */
  size_t struct_size;
  /**
   * Number of pixels.
   */
  uint64_t pixels;
  /**
   * Number of control colors, which the output mixes: the different ones of the document, and of each
   * input or file with colors the corners of the hull of its pixels; one if it is the same
   * everywhere. 0 of an output that is no color.
   */
  uint64_t control_count;
  /**
   * Number of pixels outside of the hull of the control colors: 0, unless the library is broken. Only
   * pixels that are judged are counted: look at judged.
   */
  uint64_t hull_exits;
  /**
   * Number of values that are NaN.
   */
  uint64_t nan_count;
  /**
   * Seconds that it took.
   */
  double seconds;
  /**
   * Number of pixels that are judged, whether they are in the hull of the control colors: all of a
   * color, none of an output that is no color.
   */
  uint64_t judged;
  /**
   * Number of threads that it ran on.
   */
  size_t threads;
} trochoid_report;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Returns TROCHOID_ABI of the library, to be compared with that of the header.
 */
uint32_t trochoid_abi(void);

/**
 * Returns the version of Trochoid, such as "0.1.0". It lives as long as the program.
 */
const char *trochoid_version(void);

/**
 * Returns the error as a text: every fault, with its place and what to do. It lives as long as the
 * error.
 */
const char *trochoid_error_text(const trochoid_error *error);

/**
 * Returns the error as JSON: "status", "message", and "diagnostics", a list of faults with "severity",
 * "file", "line", "column", "node", "port", "found", "expected", "remedy" and "used". A fault of the
 * options has the line 0, and "port" is the option, such as "output" or "inputs[1]". It lives as long
 * as the error.
 */
const char *trochoid_error_json(const trochoid_error *error);

/**
 * Releases an error.
 */
void trochoid_error_release(trochoid_error *error);

/**
 * Fills options with every default. size is sizeof(trochoid_options) as your program was compiled, so
 * that newer libraries, whose options are longer, write no further.
 */
trochoid_status trochoid_options_init(trochoid_options *options,
                                      size_t size);

/**
 * Makes a look from the text of a document of so many bytes. options may be NULL. Release the look
 * with trochoid_look_release(), and the error, if error is not NULL, with trochoid_error_release().
 */
trochoid_status trochoid_look_new(const char *document,
                                  size_t length,
                                  const trochoid_options *options,
                                  const trochoid_look **look,
                                  trochoid_error **error);

/**
 * Does the same with a document in a file.
 */
trochoid_status trochoid_look_open(const char *path,
                                   const trochoid_options *options,
                                   const trochoid_look **look,
                                   trochoid_error **error);

/**
 * Makes a look of the same document with further assignments, at a frame. Release it too.
 */
trochoid_status trochoid_look_with(const trochoid_look *from,
                                   const char *const *assignments,
                                   size_t assignment_count,
                                   int64_t frame,
                                   const trochoid_look **look,
                                   trochoid_error **error);

/**
 * Counts one more owner of a look, and returns it. Each owner releases it once.
 */
const trochoid_look *trochoid_look_retain(const trochoid_look *look);

/**
 * Releases a look. Shaders that were made of it stay valid.
 */
void trochoid_look_release(const trochoid_look *look);

/**
 * Returns the number of inputs that were named.
 */
size_t trochoid_look_slots(const trochoid_look *look);

/**
 * Describes an input, counted from 0. TROCHOID_INVALID if there are not so many.
 */
trochoid_status trochoid_look_slot(const trochoid_look *look, size_t index, trochoid_slot *slot);

/**
 * Returns the number of channels of all inputs together.
 */
size_t trochoid_look_inputs(const trochoid_look *look);

/**
 * Returns the number of channels of the output: 3 for a color.
 */
size_t trochoid_look_channels(const trochoid_look *look);

/**
 * Returns the kind of the output: one of trochoid_kind; UINT32_MAX if there is no look. Its weights are
 * as many as its channels; a mask has one channel for both of its.
 */
uint32_t trochoid_look_kind(const trochoid_look *look);

/**
 * Makes a shader of a look: one for each thread. Release it with trochoid_shader_release().
 * TROCHOID_INVALID if the output needs a picture, for example for a blur: the error tells each node that
 * is in the way.
 */
trochoid_status trochoid_shader_new(const trochoid_look *look,
                                    trochoid_shader **shader,
                                    trochoid_error **error);

/**
 * Releases a shader.
 */
void trochoid_shader_release(trochoid_shader *shader);

/**
 * Shades count samples. in has an entry for each channel of each input, in their order
 * (trochoid_look_inputs() in all), and out one for each channel of the output
 * (trochoid_look_channels()). Results may be written where inputs are, sample by sample. Nothing is
 * allocated after the first batch. The results are those of pictures, bit for bit.
 *
 * If a sample of an input is illegal, returns TROCHOID_BUFFER, and writes to bad, unless that is NULL,
 * where it is. What is in out then is undefined. If the samples of an input that is used or of the
 * output are NULL, or the stride of the output is 0, returns TROCHOID_INVALID, and writes nothing.
 */
trochoid_status trochoid_shade(trochoid_shader *shader,
                               size_t count,
                               const trochoid_in *in,
                               const trochoid_out *out,
                               trochoid_bad *bad);

/**
 * Makes a picture of width x height pixels. in has an entry for each channel of each input, whose
 * samples are the pixels row by row from the top, and out one for each channel of the output. Runs on
 * as many threads as the options of the look say, which is one for each core unless told. progress, report and error may be NULL.
 */
trochoid_status trochoid_picture(const trochoid_look *look,
                                 uint32_t width,
                                 uint32_t height,
                                 const trochoid_in *in,
                                 const trochoid_out *out,
                                 trochoid_progress progress,
                                 void *user,
                                 trochoid_report *report,
                                 trochoid_error **error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TROCHOID_H */
