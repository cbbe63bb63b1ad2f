/* Every ball the same share of the axial load, in C without a library for JSON: cc -O2 -o equal equal.c -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double number(const char *text, const char *key) {
    const char *at = text ? strstr(text, key) : NULL;
    if (!at) {
        fprintf(stderr, "no %s in the scene\n", key);
        exit(1);
    }
    return strtod(at + strlen(key), NULL);
}

int main(int count, char **names) {
    FILE *scene = count == 3 ? fopen(names[1], "rb") : NULL;
    if (!scene) {
        fprintf(stderr, "equal scene.json loads.csv\n");
        return 1;
    }
    fseek(scene, 0, SEEK_END);
    long size = ftell(scene);
    rewind(scene);
    char *text = calloc(size + 1, 1);
    if (fread(text, 1, size, scene) != (size_t)size) return 1;
    fclose(scene);

    int balls = 0;
    for (const char *at = text; (at = strstr(at, "{\"ball\": ")); at++) balls++;
    double axial = number(text, "\"axial_force\": "), angle = number(text, "\"contact_angle\": ");
    double share = fabs(axial) / (balls * sin(angle) * cos(number(text, "\"lead_angle\": ")));

    FILE *loads = fopen(names[2], "w");
    if (!loads) return 1;
    fprintf(loads, "ball,flank,newton\n");
    const char *flanks[] = {"SL", "SR", "NL", "NR"};
    for (int ball = 1; ball <= balls; ball++)
        for (int k = 0; k < 4; k++) /* SL and NR carry a force along +z, SR and NL one along -z */
            fprintf(loads, "%d,%s,%.17g\n", ball, flanks[k], (k == 0 || k == 3) == (axial > 0) ? share : 0.0);
    return fclose(loads) != 0;
}
