/* The look of crates/trochoid/benches/look.json in C, with vectors of eight samples, for processors with AVX2 and FMA: what
 * the processor takes for the same operations where nothing is checked.
 *
 *     cc -O3 -march=native tests/bench/look.c -o look && ./look
 *
 * prints nanoseconds a sample, the median over many batches of 4096.
 */
#include <immintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { COUNT = 4096, BATCHES = 2001, ROUNDS = 10 };

typedef __m256 Vector;
typedef struct {
    Vector r, g, b;
} Color;

static inline Vector all(float value) {
    return _mm256_set1_ps(value);
}

/* (x - least) / width, kept in [0, 1]. */
static inline Vector clamped(Vector x, float least, float width) {
    const Vector t = _mm256_div_ps(_mm256_sub_ps(x, all(least)), all(width));
    return _mm256_min_ps(_mm256_max_ps(t, all(0)), all(1));
}

/* t * t * (3 - 2t) in f64. */
static inline Vector smooth(Vector t) {
    const __m256d two = _mm256_set1_pd(2), three = _mm256_set1_pd(3);
    __m256d low = _mm256_cvtps_pd(_mm256_castps256_ps128(t)), high = _mm256_cvtps_pd(_mm256_extractf128_ps(t, 1));
    low = _mm256_mul_pd(_mm256_mul_pd(low, low), _mm256_fnmadd_pd(two, low, three));
    high = _mm256_mul_pd(_mm256_mul_pd(high, high), _mm256_fnmadd_pd(two, high, three));
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(low)), _mm256_cvtpd_ps(high), 1);
}

/* The mix that cannot leave [a, b]: a + t(b - a) below one half, b + (t - 1)(b - a) from there on. */
static inline Vector channel(Vector a, Vector b, Vector is_half, Vector t) {
    return _mm256_fnmadd_ps(t, _mm256_sub_ps(a, b), _mm256_blendv_ps(a, b, is_half));
}

static inline Color mix(Color a, Color b, Vector t) {
    const Vector is_half = _mm256_cmp_ps(t, all(0.5f), _CMP_GE_OQ);
    const Vector rest = _mm256_sub_ps(t, _mm256_and_ps(is_half, all(1)));
    return (Color){channel(a.r, b.r, is_half, rest), channel(a.g, b.g, is_half, rest), channel(a.b, b.b, is_half, rest)};
}

static inline Color color(unsigned hex) {
    return (Color){all((hex >> 16 & 255) / 255.0f), all((hex >> 8 & 255) / 255.0f), all((hex & 255) / 255.0f)};
}

static void shade(float *const passes[4], float *const out[3]) {
    for (int i = 0; i < COUNT; i += 8) {
        const Vector light = _mm256_loadu_ps(passes[0] + i), rim = _mm256_loadu_ps(passes[1] + i);
        const Vector depth = _mm256_loadu_ps(passes[2] + i), glint = _mm256_loadu_ps(passes[3] + i);
        const Vector lit = smooth(clamped(light, 0.1f, 0.8f));
        Color c = mix(color(0x1f4a52), color(0x7f8f90), clamped(lit, 0, 0.6f));
        c = mix(c, color(0xe8e2bf), clamped(lit, 0.6f, 0.4f));
        c = mix(c, color(0x8a9aa4), rim);
        c = mix(c, color(0xfff2d0), _mm256_mul_ps(_mm256_mul_ps(glint, lit), all(0.8f)));
        c = mix(c, color(0x909fa2), clamped(depth, 3, 57));
        _mm256_storeu_ps(out[0] + i, c.r);
        _mm256_storeu_ps(out[1] + i, c.g);
        _mm256_storeu_ps(out[2] + i, c.b);
    }
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

static int order(const void *a, const void *b) {
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

int main(void) {
    float *passes[4], *out[3];
    for (int pass = 0; pass < 4; pass++) {
        passes[pass] = malloc(sizeof(float) * COUNT);
        for (int i = 0; i < COUNT; i++)
            passes[pass][i] = (pass == 2 ? 90.0f : 1.0f) * (float)rand() / (float)RAND_MAX;
    }
    for (int i = 0; i < 3; i++)
        out[i] = malloc(sizeof(float) * COUNT);
    static double times[BATCHES];
    for (int batch = 0; batch < BATCHES; batch++) {
        const double start = now();
        for (int round = 0; round < ROUNDS; round++)
            shade(passes, out);
        times[batch] = (now() - start) / ROUNDS / COUNT;
    }
    qsort(times, BATCHES, sizeof *times, order);
    /* A sum of the results, so that none is left out. */
    double sum = 0;
    for (int i = 0; i < 3 * COUNT; i++)
        sum += out[i / COUNT][i % COUNT];
    printf("%.2f ns a sample (mean of the results: %.6f)\n", times[BATCHES / 2], sum / 3 / COUNT);
    return 0;
}
