// Written by the example fused of Trochoid; main below only calls and times the function.

#define _GNU_SOURCE
#define WIDTH 1920
#define HEIGHT 1080

static inline float limited(float x) {
    x = x > 0.0f ? x : 0.0f;
    return x < 1.0f ? x : 1.0f;
}

__attribute__((noinline)) static void picture(
    const float *restrict c_,
    const float *restrict s_,
    const float *restrict f_,
    const float *restrict a_,
    const float *restrict z_,
    float *restrict r_, float *restrict g_, float *restrict b_) {
    static float columns[7][WIDTH];
    for (int x = 0; x < WIDTH; x++) {
        const float across = (float)x / 1919.0f;
        const float n24r = 0.88f + 0.07999998f * across;
        const float n24g = 0.76f - 0.76f * across;
        const float n24b = 0.36f + 0.07999998f * across;
        const float n34_t0 = limited(across * 2.9411764f);
        const float n34_t1 = limited(across * 3.5714285f - 1.2142857f);
        const float n34_t2 = limited(across * 2.631579f - 1.6315789f);
        columns[0][x] = across;
        columns[1][x] = n24r;
        columns[2][x] = n24g;
        columns[3][x] = n24b;
        columns[4][x] = n34_t0;
        columns[5][x] = n34_t1;
        columns[6][x] = n34_t2;
    }
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            const long i = (long)y * WIDTH + x;
            const float c = c_[i];
            const float s = s_[i];
            const float f = f_[i];
            const float a = a_[i];
            const float z = z_[i];
            const float across = columns[0][x];
            const float n24r = columns[1][x];
            const float n24g = columns[2][x];
            const float n24b = columns[3][x];
            const float n34_t0 = columns[4][x];
            const float n34_t1 = columns[5][x];
            const float n34_t2 = columns[6][x];
            const float n1 = limited(z * 0.0012820513f - 0.025641026f);
            const float n2 = s + across * (1.0f - s);
            const float n3 = n2 * across;
            const float n4r = 0.17f + 0.010000005f * n3;
            const float n4g = 0.17f + 0.47999996f * n3;
            const float n4b = 0.87f - 0.49f * n3;
            const float n5 = n1 + a * (1.0f - n1);
            const float n6r = n4r + (0.71f - n4r) * n5;
            const float n6g = n4g + (0.16f - n4g) * n5;
            const float n6b = n4b + (0.23f - n4b) * n5;
            const float n7r = n6r + (n4r - n6r) * f;
            const float n7g = n6g + (n4g - n6g) * f;
            const float n7b = n6b + (n4b - n6b) * f;
            const float n8r = n4r + (n7r - n4r) * c;
            const float n8g = n4g + (n7g - n4g) * c;
            const float n8b = n4b + (n7b - n4b) * c;
            const float n9r = n4r + (0.84f - n4r) * a;
            const float n9g = n4g + (0.27f - n4g) * a;
            const float n9b = n4b + (0.21f - n4b) * a;
            const float n10r = 0.21f + (n9r - 0.21f) * n2;
            const float n10g = 0.04f + (n9g - 0.04f) * n2;
            const float n10b = 0.73f + (n9b - 0.73f) * n2;
            const float n11r = n10r + (n8r - n10r) * n5;
            const float n11g = n10g + (n8g - n10g) * n5;
            const float n11b = n10b + (n8b - n10b) * n5;
            const float n12_0r = 0.93f + (n8r - 0.93f) * n1;
            const float n12_0g = 0.53f + (n8g - 0.53f) * n1;
            const float n12_0b = 0.37f + (n8b - 0.37f) * n1;
            const float n12_1r = n7r + (n4r - n7r) * n1;
            const float n12_1g = n7g + (n4g - n7g) * n1;
            const float n12_1b = n7b + (n4b - n7b) * n1;
            const float n12r = n12_0r + (n12_1r - n12_0r) * n3;
            const float n12g = n12_0g + (n12_1g - n12_0g) * n3;
            const float n12b = n12_0b + (n12_1b - n12_0b) * n3;
            const float n13 = limited(n3 * 1.5151515f - 0.18181819f);
            const float n14_t0 = limited(c * 2.9411764f);
            const float n14_t1 = limited(c * 3.2258065f - 1.0967742f);
            const float n14_t2 = limited(c * 2.857143f - 1.8571428f);
            const float n14_0r = n6r + (0.02f - n6r) * n14_t0;
            const float n14_0g = n6g + (0.44f - n6g) * n14_t0;
            const float n14_0b = n6b + (0.72f - n6b) * n14_t0;
            const float n14_1r = n14_0r + (1.0f - n14_0r) * n14_t1;
            const float n14_1g = n14_0g + (0.98f - n14_0g) * n14_t1;
            const float n14_1b = n14_0b + (0.88f - n14_0b) * n14_t1;
            const float n14r = n14_1r + (0.61f - n14_1r) * n14_t2;
            const float n14g = n14_1g + (0.29f - n14_1g) * n14_t2;
            const float n14b = n14_1b + (0.92f - n14_1b) * n14_t2;
            const float n15r = n6r + (n4r - n6r) * n13;
            const float n15g = n6g + (n4g - n6g) * n13;
            const float n15b = n6b + (n4b - n6b) * n13;
            const float n16r = n15r + (n6r - n15r) * s;
            const float n16g = n15g + (n6g - n15g) * s;
            const float n16b = n15b + (n6b - n15b) * s;
            const float n17 = limited(z * 0.0013513514f - 0.13513513f);
            const float n18r = 0.5f + (n4r - 0.5f) * n17;
            const float n18g = 0.09f + (n4g - 0.09f) * n17;
            const float n18b = 0.79f + (n4b - 0.79f) * n17;
            const float n19_0r = 0.52f - 0.099999994f * n2;
            const float n19_0g = 0.41f + 0.00999999f * n2;
            const float n19_0b = 0.45f - 0.22999999f * n2;
            const float n19_1r = 0.0f + 0.09f * n2;
            const float n19_1g = 0.83f - 0.58f * n2;
            const float n19_1b = 0.64f + 0.18f * n2;
            const float n19r = n19_0r + (n19_1r - n19_0r) * c;
            const float n19g = n19_0g + (n19_1g - n19_0g) * c;
            const float n19b = n19_0b + (n19_1b - n19_0b) * c;
            const float n20r = 0.98f + (n19r - 0.98f) * n1;
            const float n20g = 0.13f + (n19g - 0.13f) * n1;
            const float n20b = 0.56f + (n19b - 0.56f) * n1;
            const float n21r = n18r + (n6r - n18r) * n17;
            const float n21g = n18g + (n6g - n18g) * n17;
            const float n21b = n18b + (n6b - n18b) * n17;
            const float n22_t0 = limited(n17 * 3.7037036f);
            const float n22_t1 = limited(n17 * 2.7027028f - 0.7297297f);
            const float n22_t2 = limited(n17 * 2.7777777f - 1.7777778f);
            const float n22_0r = n15r + (n21r - n15r) * n22_t0;
            const float n22_0g = n15g + (n21g - n15g) * n22_t0;
            const float n22_0b = n15b + (n21b - n15b) * n22_t0;
            const float n22_1r = n22_0r + (0.6f - n22_0r) * n22_t1;
            const float n22_1g = n22_0g + (0.56f - n22_0g) * n22_t1;
            const float n22_1b = n22_0b + (0.67f - n22_0b) * n22_t1;
            const float n22r = n22_1r + (0.43f - n22_1r) * n22_t2;
            const float n22g = n22_1g + (0.37f - n22_1g) * n22_t2;
            const float n22b = n22_1b + (0.23f - n22_1b) * n22_t2;
            const float n23r = 0.36f + (n18r - 0.36f) * n5;
            const float n23g = 0.11f + (n18g - 0.11f) * n5;
            const float n23b = 0.98f + (n18b - 0.98f) * n5;
            const float n25r = n24r + (n14r - n24r) * n2;
            const float n25g = n24g + (n14g - n24g) * n2;
            const float n25b = n24b + (n14b - n24b) * n2;
            const float n26 = across * n13;
            const float n27_0r = n7r + (0.59f - n7r) * n26;
            const float n27_0g = n7g + (0.45f - n7g) * n26;
            const float n27_0b = n7b + (0.98f - n7b) * n26;
            const float n27_1r = 0.97f + (n25r - 0.97f) * n26;
            const float n27_1g = 0.49f + (n25g - 0.49f) * n26;
            const float n27_1b = 0.01f + (n25b - 0.01f) * n26;
            const float n27r = n27_0r + (n27_1r - n27_0r) * n5;
            const float n27g = n27_0g + (n27_1g - n27_0g) * n5;
            const float n27b = n27_0b + (n27_1b - n27_0b) * n5;
            const float n28r = 0.37f + (n14r - 0.37f) * c;
            const float n28g = 0.49f + (n14g - 0.49f) * c;
            const float n28b = 0.07f + (n14b - 0.07f) * c;
            const float n29_0r = n14r + (0.13f - n14r) * s;
            const float n29_0g = n14g + (0.82f - n14g) * s;
            const float n29_0b = n14b + (0.33f - n14b) * s;
            const float n29_1r = n25r + (n18r - n25r) * s;
            const float n29_1g = n25g + (n18g - n25g) * s;
            const float n29_1b = n25b + (n18b - n25b) * s;
            const float n29r = n29_0r + (n29_1r - n29_0r) * n13;
            const float n29g = n29_0g + (n29_1g - n29_0g) * n13;
            const float n29b = n29_0b + (n29_1b - n29_0b) * n13;
            const float n30r = 0.74f + (n29r - 0.74f) * f;
            const float n30g = 0.93f + (n29g - 0.93f) * f;
            const float n30b = 0.85f + (n29b - 0.85f) * f;
            const float n31r = n6r + (n30r - n6r) * f;
            const float n31g = n6g + (n30g - n6g) * f;
            const float n31b = n6b + (n30b - n6b) * f;
            const float n32r = n25r + (0.78f - n25r) * n13;
            const float n32g = n25g + (0.31f - n25g) * n13;
            const float n32b = n25b + (0.31f - n25b) * n13;
            const float n33r = n32r + (n9r - n32r) * across;
            const float n33g = n32g + (n9g - n32g) * across;
            const float n33b = n32b + (n9b - n32b) * across;
            const float n34_0r = n33r + (0.03f - n33r) * n34_t0;
            const float n34_0g = n33g + (0.66f - n33g) * n34_t0;
            const float n34_0b = n33b + (0.14f - n33b) * n34_t0;
            const float n34_1r = n34_0r + (0.9f - n34_0r) * n34_t1;
            const float n34_1g = n34_0g + (0.39f - n34_0g) * n34_t1;
            const float n34_1b = n34_0b + (0.09f - n34_0b) * n34_t1;
            const float n34r = n34_1r + (n24r - n34_1r) * n34_t2;
            const float n34g = n34_1g + (n24g - n34_1g) * n34_t2;
            const float n34b = n34_1b + (n24b - n34_1b) * n34_t2;
            const float n35 = n3 + n2 * (1.0f - n3);
            const float n36 = n35 * a;
            const float n37r = 0.34f + 0.65f * n13;
            const float n37g = 0.06f + 0.32f * n13;
            const float n37b = 0.39f + 0.04000002f * n13;
            const float n38r = 0.53f + (n37r - 0.53f) * n36;
            const float n38g = 0.85f + (n37g - 0.85f) * n36;
            const float n38b = 0.37f + (n37b - 0.37f) * n36;
            const float n39r = n11r + (0.96f - n11r) * n2;
            const float n39g = n11g + (0.83f - n11g) * n2;
            const float n39b = n11b + (0.19f - n11b) * n2;
            const float n40 = f * n36;
            const float n41_0r = 0.06f + (n31r - 0.06f) * n40;
            const float n41_0g = 0.53f + (n31g - 0.53f) * n40;
            const float n41_0b = 0.41f + (n31b - 0.41f) * n40;
            const float n41_1r = 0.94f + (n9r - 0.94f) * n40;
            const float n41_1g = 0.0f + (n9g - 0.0f) * n40;
            const float n41_1b = 0.98f + (n9b - 0.98f) * n40;
            const float n41r = n41_0r + (n41_1r - n41_0r) * n5;
            const float n41g = n41_0g + (n41_1g - n41_0g) * n5;
            const float n41b = n41_0b + (n41_1b - n41_0b) * n5;
            const float n42r = 0.02f + (n10r - 0.02f) * n35;
            const float n42g = 0.48f + (n10g - 0.48f) * n35;
            const float n42b = 0.59f + (n10b - 0.59f) * n35;
            const float n43 = 1.0f - n35;
            const float n44_0 = limited(n43 * 5.0f - 0.6f);
            const float n44_1 = limited(n43 * 5.0f - 2.6f);
            const float n45_0r = n6r + (n42r - n6r) * n44_0;
            const float n45_0g = n6g + (n42g - n6g) * n44_0;
            const float n45_0b = n6b + (n42b - n6b) * n44_0;
            const float n45r = n45_0r + (n37r - n45_0r) * n44_1;
            const float n45g = n45_0g + (n37g - n45_0g) * n44_1;
            const float n45b = n45_0b + (n37b - n45_0b) * n44_1;
            const float n46r = 0.82f + (n41r - 0.82f) * n35;
            const float n46g = 0.65f + (n41g - 0.65f) * n35;
            const float n46b = 0.57f + (n41b - 0.57f) * n35;
            const float n47r = n46r + (0.51f - n46r) * n1;
            const float n47g = n46g + (0.72f - n46g) * n1;
            const float n47b = n46b + (0.57f - n46b) * n1;
            const float n48r = n45r + (n47r - n45r) * n43;
            const float n48g = n45g + (n47g - n45g) * n43;
            const float n48b = n45b + (n47b - n45b) * n43;
            const float n49r = n39r + (n48r - n39r) * n2;
            const float n49g = n39g + (n48g - n39g) * n2;
            const float n49b = n39b + (n48b - n39b) * n2;
            const float n50r = n38r + (n49r - n38r) * n2;
            const float n50g = n38g + (n49g - n38g) * n2;
            const float n50b = n38b + (n49b - n38b) * n2;
            const float n51r = n34r + (n50r - n34r) * n35;
            const float n51g = n34g + (n50g - n34g) * n35;
            const float n51b = n34b + (n50b - n34b) * n35;
            const float n52r = n28r + (n51r - n28r) * c;
            const float n52g = n28g + (n51g - n28g) * c;
            const float n52b = n28b + (n51b - n28b) * c;
            const float n53r = n27r + (n52r - n27r) * n13;
            const float n53g = n27g + (n52g - n27g) * n13;
            const float n53b = n27b + (n52b - n27b) * n13;
            const float n54r = n23r + (n53r - n23r) * n35;
            const float n54g = n23g + (n53g - n23g) * n35;
            const float n54b = n23b + (n53b - n23b) * n35;
            const float n55r = n22r + (n54r - n22r) * n40;
            const float n55g = n22g + (n54g - n22g) * n40;
            const float n55b = n22b + (n54b - n22b) * n40;
            const float n56r = n20r + (n55r - n20r) * n35;
            const float n56g = n20g + (n55g - n20g) * n35;
            const float n56b = n20b + (n55b - n20b) * n35;
            const float n57r = n16r + (n56r - n16r) * n3;
            const float n57g = n16g + (n56g - n16g) * n3;
            const float n57b = n16b + (n56b - n16b) * n3;
            const float n58r = n12r + (n57r - n12r) * n35;
            const float n58g = n12g + (n57g - n12g) * n35;
            const float n58b = n12b + (n57b - n12b) * n35;
            r_[i] = n58r;
            g_[i] = n58g;
            b_[i] = n58b;
        }
    }
}

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
