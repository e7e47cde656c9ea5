/* Shades points on several threads: each thread has a shader, all share one look.
 *
 *     cc shade.c -o shade $(pkg-config --cflags --libs trochoid) -lpthread
 *     ./shade water.json
 *
 * It prints the bits of each result, which are those of every other interface. */
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include "trochoid.h"

enum { THREADS = 4, POINTS = 600 };

/* A renderer's own structure: the inputs and the result lie side by side. */
typedef struct {
  float light, rim;
  int id;
  float rgb[3];
} point;

typedef struct {
  const trochoid_look *look;
  point points[POINTS];
  trochoid_status status;
} job;

/* The mist is the same for all points. */
static const float mist[3] = {0.25f, 0.5f, 0.75f};

static void *work(void *argument) {
  job *j = argument;
  trochoid_shader *shader;
  j->status = trochoid_shader_new(j->look, &shader, NULL);
  if (j->status != TROCHOID_OK) return NULL;
  const ptrdiff_t stride = sizeof(point);
  const trochoid_in in[] = {{&j->points[0].light, stride}, {&j->points[0].rim, stride},
                            {&mist[0], 0}, {&mist[1], 0}, {&mist[2], 0}};
  const trochoid_out out[] = {{&j->points[0].rgb[0], stride},
                              {&j->points[0].rgb[1], stride},
                              {&j->points[0].rgb[2], stride}};
  j->status = trochoid_shade(shader, POINTS, in, out, NULL);
  trochoid_shader_release(shader);
  return NULL;
}

int main(int argc, char **argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: shade DOCUMENT\n");
    return 2;
  }
  if (trochoid_abi() != TROCHOID_ABI) {
    fprintf(stderr, "the library has interface %u, the header %u\n", trochoid_abi(), TROCHOID_ABI);
    return 2;
  }
  const char *inputs[] = {"light", "rim", "palette.mist"};
  trochoid_options options;
  trochoid_options_init(&options, sizeof options);
  options.inputs = inputs;
  options.input_count = 3;
  const trochoid_look *look;
  trochoid_error *error;
  trochoid_status status = trochoid_look_open(argv[1], &options, &look, &error);
  if (status != TROCHOID_OK) {
    fprintf(stderr, "%s\n", trochoid_error_text(error));
    trochoid_error_release(error);
    return status;
  }

  static job jobs[THREADS];
  pthread_t threads[THREADS];
  for (int t = 0; t < THREADS; t++) {
    jobs[t].look = look;
    for (int i = 0; i < POINTS; i++) {
      jobs[t].points[i].light = (float)i / (POINTS - 1);
      jobs[t].points[i].rim = (float)(i * 7 % POINTS) / POINTS;
    }
    pthread_create(&threads[t], NULL, work, &jobs[t]);
  }
  for (int t = 0; t < THREADS; t++) pthread_join(threads[t], NULL);
  for (int t = 0; t < THREADS; t++) {
    if (jobs[t].status != TROCHOID_OK || memcmp(jobs[t].points, jobs[0].points, sizeof jobs[0].points)) {
      fprintf(stderr, "thread %d has status %d, or another result\n", t, jobs[t].status);
      return 1;
    }
  }
  for (int i = 0; i < POINTS; i++) {
    unsigned bits[3];
    memcpy(bits, jobs[0].points[i].rgb, sizeof bits);
    printf("%08x %08x %08x\n", bits[0], bits[1], bits[2]);
  }

  /* An illegal sample is refused, and told. */
  trochoid_shader *shader;
  if (trochoid_shader_new(look, &shader, NULL) != TROCHOID_OK) return 1;
  float light[3] = {0.5f, 0.25f, 1.5f}, rim = 0.5f, rgb[9];
  const trochoid_in in[] = {{light, sizeof(float)}, {&rim, 0}, {&mist[0], 0}, {&mist[1], 0}, {&mist[2], 0}};
  const trochoid_out out[] = {{rgb, 12}, {rgb + 1, 12}, {rgb + 2, 12}};
  trochoid_bad bad;
  status = trochoid_shade(shader, 3, in, out, &bad);
  trochoid_slot slot;
  if (status != TROCHOID_BUFFER || trochoid_look_slot(look, bad.slot, &slot) != TROCHOID_OK) return 1;
  fprintf(stderr, "sample %zu of \"%s\" is illegal\n", bad.sample, slot.name);
  trochoid_shader_release(shader);
  trochoid_look_release(look);
  return 0;
}
