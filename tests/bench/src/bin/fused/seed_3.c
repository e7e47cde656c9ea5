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
    static float columns[1][WIDTH];
    for (int x = 0; x < WIDTH; x++) {
        const float across = (float)x / 1919.0f;
        columns[0][x] = across;
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
            const float n1 = limited(z * 0.0012820513f - 0.025641026f);
            const float n2_t0 = limited(s * 2.7777777f);
            const float n2_t1 = limited(s * 2.5641026f - 0.9230769f);
            const float n2_t2 = limited(s * 4.0f - 3.0f);
            const float n2r = 0.29f + 0.38000003f * n2_t0 - 0.62f * n2_t1 + 0.67f * n2_t2;
            const float n2g = 0.0f + 0.94f * n2_t0 - 0.23000002f * n2_t1 - 0.07999998f * n2_t2;
            const float n2b = 0.94f + 0.060000002f * n2_t0 - 0.77f * n2_t1 + 0.08999999f * n2_t2;
            const float n3 = n1 * c;
            const float n4r = n2r + (0.59f - n2r) * across;
            const float n4g = n2g + (0.73f - n2g) * across;
            const float n4b = n2b + (0.02f - n2b) * across;
            const float n5_0r = n2r + (n4r - n2r) * n3;
            const float n5_0g = n2g + (n4g - n2g) * n3;
            const float n5_0b = n2b + (n4b - n2b) * n3;
            const float n5_1r = 0.65f - 0.109999955f * n3;
            const float n5_1g = 0.7f - 0.63f * n3;
            const float n5_1b = 0.8f - 0.46f * n3;
            const float n5r = n5_0r + (n5_1r - n5_0r) * s;
            const float n5g = n5_0g + (n5_1g - n5_0g) * s;
            const float n5b = n5_0b + (n5_1b - n5_0b) * s;
            const float n6r = 0.32f + 0.45999998f * s;
            const float n6g = 0.24f + 0.060000017f * s;
            const float n6b = 0.8f - 0.19999999f * s;
            const float n7_0r = n6r + (0.36f - n6r) * a;
            const float n7_0g = n6g + (0.37f - n6g) * a;
            const float n7_0b = n6b + (0.52f - n6b) * a;
            const float n7_1r = 0.67f + (n2r - 0.67f) * a;
            const float n7_1g = 0.14f + (n2g - 0.14f) * a;
            const float n7_1b = 0.78f + (n2b - 0.78f) * a;
            const float n7r = n7_0r + (n7_1r - n7_0r) * f;
            const float n7g = n7_0g + (n7_1g - n7_0g) * f;
            const float n7b = n7_0b + (n7_1b - n7_0b) * f;
            const float n8 = n1 * n3;
            const float n9r = 0.19f + 0.36f * n1;
            const float n9g = 0.26f + 0.66f * n1;
            const float n9b = 0.71f + 0.29000002f * n1;
            const float n10 = c * n8;
            const float n11 = 1.0f - n10;
            const float n12_t0 = limited(n11 * 3.4482758f);
            const float n12_t1 = limited(n11 * 2.9411764f - 0.85294116f);
            const float n12_t2 = limited(n11 * 2.7027028f - 1.7027028f);
            const float n12_0r = n9r + (0.23f - n9r) * n12_t0;
            const float n12_0g = n9g + (0.84f - n9g) * n12_t0;
            const float n12_0b = n9b + (0.85f - n9b) * n12_t0;
            const float n12_1r = n12_0r + (n5r - n12_0r) * n12_t1;
            const float n12_1g = n12_0g + (n5g - n12_0g) * n12_t1;
            const float n12_1b = n12_0b + (n5b - n12_0b) * n12_t1;
            const float n12r = n12_1r + (n7r - n12_1r) * n12_t2;
            const float n12g = n12_1g + (n7g - n12_1g) * n12_t2;
            const float n12b = n12_1b + (n7b - n12_1b) * n12_t2;
            const float n13_0r = n12r + (n6r - n12r) * s;
            const float n13_0g = n12g + (n6g - n12g) * s;
            const float n13_0b = n12b + (n6b - n12b) * s;
            const float n13_1r = 0.97f - 0.39000005f * s;
            const float n13_1g = 0.94f - 0.65999997f * s;
            const float n13_1b = 0.52f - 0.029999971f * s;
            const float n13r = n13_0r + (n13_1r - n13_0r) * a;
            const float n13g = n13_0g + (n13_1g - n13_0g) * a;
            const float n13b = n13_0b + (n13_1b - n13_0b) * a;
            const float n14 = 1.0f - n11;
            const float n15 = limited(n14 * 1.25f - 0.0125f);
            const float n16 = n15 * n11;
            const float n17r = 0.69f + (n13r - 0.69f) * n15;
            const float n17g = 0.08f + (n13g - 0.08f) * n15;
            const float n17b = 0.01f + (n13b - 0.01f) * n15;
            const float n18_0r = n17r + (0.48f - n17r) * n16;
            const float n18_0g = n17g + (0.24f - n17g) * n16;
            const float n18_0b = n17b + (0.68f - n17b) * n16;
            const float n18_1r = n12r + (n4r - n12r) * n16;
            const float n18_1g = n12g + (n4g - n12g) * n16;
            const float n18_1b = n12b + (n4b - n12b) * n16;
            const float n18r = n18_0r + (n18_1r - n18_0r) * a;
            const float n18g = n18_0g + (n18_1g - n18_0g) * a;
            const float n18b = n18_0b + (n18_1b - n18_0b) * a;
            const float n19 = limited(z * 0.0014705883f - 0.29411766f);
            const float n20r = n18r + (n13r - n18r) * c;
            const float n20g = n18g + (n13g - n18g) * c;
            const float n20b = n18b + (n13b - n18b) * c;
            const float n21r = n12r + (n20r - n12r) * n1;
            const float n21g = n12g + (n20g - n12g) * n1;
            const float n21b = n12b + (n20b - n12b) * n1;
            const float n22r = n5r + (0.71f - n5r) * n8;
            const float n22g = n5g + (0.92f - n5g) * n8;
            const float n22b = n5b + (0.87f - n5b) * n8;
            const float n23_0r = 0.26f + 0.46000004f * n14;
            const float n23_0g = 0.21f - 0.08f * n14;
            const float n23_0b = 0.4f - 0.15f * n14;
            const float n23_1r = n22r + (0.03f - n22r) * n14;
            const float n23_1g = n22g + (0.38f - n22g) * n14;
            const float n23_1b = n22b + (0.13f - n22b) * n14;
            const float n23r = n23_0r + (n23_1r - n23_0r) * s;
            const float n23g = n23_0g + (n23_1g - n23_0g) * s;
            const float n23b = n23_0b + (n23_1b - n23_0b) * s;
            const float n24r = n23r + (n22r - n23r) * f;
            const float n24g = n23g + (n22g - n23g) * f;
            const float n24b = n23b + (n22b - n23b) * f;
            const float n25 = limited(n8 * 1.3513514f - 0.10810811f);
            const float n26r = n24r + (0.18f - n24r) * n15;
            const float n26g = n24g + (0.22f - n24g) * n15;
            const float n26b = n24b + (0.63f - n24b) * n15;
            const float n27 = limited(f * 1.2048193f - 0.024096385f);
            const float n28r = n17r + (0.45f - n17r) * n1;
            const float n28g = n17g + (0.45f - n17g) * n1;
            const float n28b = n17b + (0.27f - n17b) * n1;
            const float n29 = c * n1;
            const float n30r = n28r + (0.04f - n28r) * n29;
            const float n30g = n28g + (0.03f - n28g) * n29;
            const float n30b = n28b + (0.54f - n28b) * n29;
            const float n31r = n13r + (n30r - n13r) * c;
            const float n31g = n13g + (n30g - n13g) * c;
            const float n31b = n13b + (n30b - n13b) * c;
            const float n32 = n3 * n27;
            const float n33r = 0.42f - 0.42f * n14;
            const float n33g = 0.26f + 0.14000002f * n14;
            const float n33b = 0.38f + 0.28000003f * n14;
            const float n34r = 0.2f + (n33r - 0.2f) * n32;
            const float n34g = 0.36f + (n33g - 0.36f) * n32;
            const float n34b = 0.68f + (n33b - 0.68f) * n32;
            const float n35_t0 = limited(n25 * 4.1666665f);
            const float n35_t1 = limited(n25 * 2.0408163f - 0.48979592f);
            const float n35_t2 = limited(n25 * 3.7037036f - 2.7037036f);
            const float n35_0r = 0.31f + (n34r - 0.31f) * n35_t0;
            const float n35_0g = 0.44f + (n34g - 0.44f) * n35_t0;
            const float n35_0b = 0.81f + (n34b - 0.81f) * n35_t0;
            const float n35_1r = n35_0r + (n2r - n35_0r) * n35_t1;
            const float n35_1g = n35_0g + (n2g - n35_0g) * n35_t1;
            const float n35_1b = n35_0b + (n2b - n35_0b) * n35_t1;
            const float n35r = n35_1r + (0.51f - n35_1r) * n35_t2;
            const float n35g = n35_1g + (0.32f - n35_1g) * n35_t2;
            const float n35b = n35_1b + (0.44f - n35_1b) * n35_t2;
            const float n36r = 0.26f + 0.47000003f * n32;
            const float n36g = 0.67f - 0.51f * n32;
            const float n36b = 0.23f + 0.21999998f * n32;
            const float n37 = n19 * c;
            const float n38 = limited(z * 0.0015151515f - 0.16666667f);
            const float n39 = n16 * n19;
            const float n40r = n26r + (0.03f - n26r) * n1;
            const float n40g = n26g + (0.86f - n26g) * n1;
            const float n40b = n26b + (0.56f - n26b) * n1;
            const float n41r = n35r + (0.73f - n35r) * n39;
            const float n41g = n35g + (0.58f - n35g) * n39;
            const float n41b = n35b + (0.26f - n35b) * n39;
            const float n42_0r = n23r + (n35r - n23r) * n25;
            const float n42_0g = n23g + (n35g - n23g) * n25;
            const float n42_0b = n23b + (n35b - n23b) * n25;
            const float n42_1r = n34r + (n41r - n34r) * n25;
            const float n42_1g = n34g + (n41g - n34g) * n25;
            const float n42_1b = n34b + (n41b - n34b) * n25;
            const float n42r = n42_0r + (n42_1r - n42_0r) * n15;
            const float n42g = n42_0g + (n42_1g - n42_0g) * n15;
            const float n42b = n42_0b + (n42_1b - n42_0b) * n15;
            const float n43_0 = limited(n38 * 5.0f - 1.3f);
            const float n43_1 = limited(n38 * 5.0f - 3.1f);
            const float n44_0r = n9r + (n13r - n9r) * n43_0;
            const float n44_0g = n9g + (n13g - n9g) * n43_0;
            const float n44_0b = n9b + (n13b - n9b) * n43_0;
            const float n44r = n44_0r + (n42r - n44_0r) * n43_1;
            const float n44g = n44_0g + (n42g - n44_0g) * n43_1;
            const float n44b = n44_0b + (n42b - n44_0b) * n43_1;
            const float n45 = limited(n37 * 1.1904762f - 0.16666667f);
            const float n46 = limited(n45 * 1.0989012f);
            const float n47 = a * n46;
            const float n48 = limited(n37 * 1.1764706f - 0.1764706f);
            const float n49r = n9r + (n13r - n9r) * n48;
            const float n49g = n9g + (n13g - n9g) * n48;
            const float n49b = n9b + (n13b - n9b) * n48;
            const float n50 = limited(z * 0.0012987013f - 0.051948052f);
            const float n51r = n49r + (n44r - n49r) * n19;
            const float n51g = n49g + (n44g - n49g) * n19;
            const float n51b = n49b + (n44b - n49b) * n19;
            const float n52r = n40r + (n28r - n40r) * n45;
            const float n52g = n40g + (n28g - n40g) * n45;
            const float n52b = n40b + (n28b - n40b) * n45;
            const float n53r = 0.21f + (n52r - 0.21f) * n50;
            const float n53g = 0.91f + (n52g - 0.91f) * n50;
            const float n53b = 0.88f + (n52b - 0.88f) * n50;
            const float n54_0r = 0.72f + (n31r - 0.72f) * n48;
            const float n54_0g = 0.65f + (n31g - 0.65f) * n48;
            const float n54_0b = 0.67f + (n31b - 0.67f) * n48;
            const float n54_1r = n53r + (n36r - n53r) * n48;
            const float n54_1g = n53g + (n36g - n53g) * n48;
            const float n54_1b = n53b + (n36b - n53b) * n48;
            const float n54r = n54_0r + (n54_1r - n54_0r) * n47;
            const float n54g = n54_0g + (n54_1g - n54_0g) * n47;
            const float n54b = n54_0b + (n54_1b - n54_0b) * n47;
            const float n55r = n41r + (n34r - n41r) * n14;
            const float n55g = n41g + (n34g - n41g) * n14;
            const float n55b = n41b + (n34b - n41b) * n14;
            const float n56r = n54r + (n55r - n54r) * n47;
            const float n56g = n54g + (n55g - n54g) * n47;
            const float n56b = n54b + (n55b - n54b) * n47;
            const float n57r = n51r + (n56r - n51r) * c;
            const float n57g = n51g + (n56g - n51g) * c;
            const float n57b = n51b + (n56b - n51b) * c;
            const float n58r = n21r + (n57r - n21r) * n39;
            const float n58g = n21g + (n57g - n21g) * n39;
            const float n58b = n21b + (n57b - n21b) * n39;
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
