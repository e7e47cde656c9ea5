#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#define AREA ((size_t)WIDTH * HEIGHT)

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// Reads five planes from a file; answers "run N" with N times in seconds, and "write FILE" with "written".
int main(int count, char **arguments) {
    float *planes[8];
    for (int k = 0; k < 8; k++) {
        // On large pages, each at another place of a page.
        size_t bytes = (sizeof(float) * AREA + 4096 + 0x1fffff) & ~(size_t)0x1fffff;
        char *memory = aligned_alloc(0x200000, bytes);
        if (!memory) return 1;
        madvise(memory, bytes, MADV_HUGEPAGE);
        memset(memory, 0, bytes);
        planes[k] = (float *)(memory + 512 * k);
    }
    FILE *file = count == 2 ? fopen(arguments[1], "rb") : NULL;
    if (!file) return 1;
    for (int k = 0; k < 5; k++)
        if (fread(planes[k], sizeof(float), AREA, file) != AREA) return 1;
    fclose(file);
    char line[4096];
    while (fgets(line, sizeof line, stdin)) {
        line[strcspn(line, "\n")] = 0;
        if (!strncmp(line, "run ", 4)) {
            for (int n = atoi(line + 4); n > 0; n--) {
                double started = seconds();
                picture(planes[0], planes[1], planes[2], planes[3], planes[4], planes[5], planes[6], planes[7]);
                printf("%.9f ", seconds() - started);
            }
            printf("\n");
        } else if (!strncmp(line, "write ", 6)) {
            file = fopen(line + 6, "wb");
            if (!file) return 1;
            for (int k = 5; k < 8; k++)
                if (fwrite(planes[k], sizeof(float), AREA, file) != AREA) return 1;
            if (fclose(file)) return 1;
            printf("written\n");
        } else {
            break;
        }
        fflush(stdout);
    }
    return 0;
}
