/* Stands for Open Image Denoise in tests: it turns the channels of the picture round, and fails on request. */
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#ifndef FAIL
#define FAIL 0
#endif
#ifndef VERSION
#define VERSION 20501
#endif

static int device, filter;
static bool committed, hdr;
static const char *error;
static const float *color, *albedo, *normal;
static float *output;
static size_t count, W, H;

void *oidnNewDevice(int type) { return type == 1 ? &device : NULL; }
void oidnSetDeviceBool(void *to, const char *name, bool value) {
    if (to != &device || strcmp(name, "setAffinity") || value) error = "wrong bool";
}
void oidnSetDeviceInt(void *to, const char *name, int value) {
    if (to != &device || strcmp(name, "numThreads") || value < 1) error = "wrong int";
}
int oidnGetDeviceInt(void *of, const char *name) {
    return of == &device && !strcmp(name, "version") ? VERSION : -1;
}
void oidnCommitDevice(void *which) { committed = which == &device; }
int oidnGetDeviceError(void *of, const char **message) {
    if (of != &device || !committed) error = "no device";
    *message = error;
    return error ? 2 : 0;
}
void oidnReleaseDevice(void *which) { (void)which; }
#ifndef OLD
void *oidnNewFilter(void *of, const char *type) { return of == &device && !strcmp(type, "RT") ? &filter : NULL; }
void oidnSetSharedFilterImage(void *of, const char *name, void *image, int format, size_t width, size_t height,
                              size_t offset, size_t pixel, size_t row) {
    if (of != &filter || format != 3 || offset || pixel || row) error = "wrong image";
    if (count && (width != W || height != H)) error = "wrong size";
    count = width * height, W = width, H = height;
    if (!strcmp(name, "color")) color = image;
    if (!strcmp(name, "albedo")) albedo = image;
    if (!strcmp(name, "normal")) normal = image;
    if (!strcmp(name, "output")) output = image;
}
void oidnSetFilterBool(void *of, const char *name, bool value) { hdr = of == &filter && !strcmp(name, "hdr") && value; }
void oidnCommitFilter(void *which) { (void)which; }
void oidnExecuteFilter(void *which) {
    if (which != &filter || !hdr || !color || !output || (normal && !albedo)) error = "not set up";
    /* Colours of surfaces are none of their directions: only those may be negative. */
    bool below = false;
    for (size_t i = 0; normal && albedo && i < 3 * count; i++) below |= normal[i] < 0, error = albedo[i] < 0 ? "mixed up" : error;
    if (normal && !below) error = "no normals";
    if (FAIL) error = "out of\nmemory";
    for (size_t i = 0; !error && i < 3 * count; i++) output[i] = color[i / 3 * 3 + (i + 1) % 3];
}
void oidnReleaseFilter(void *which) { (void)which; }
#endif
