/* The nominal flux map as a text of integers, so that reading it depends on no locale. */
#ifndef GMFBO_DRIVE_FLUX_MAP_FILE_H
#define GMFBO_DRIVE_FLUX_MAP_FILE_H

#include <stdio.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#endif

#include "flux_map.h"

static inline FILE *open_resource(const char *folder, const char *name) {
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/%s", folder, name);
    if (length < 0 || (size_t)length >= sizeof path) return NULL;
#ifdef _WIN32
    wchar_t wide[4096]; /* paths of FMUs are UTF-8, fopen would take them as the ANSI code page */
    if (!MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 4096)) return NULL;
    return _wfopen(wide, L"rb");
#else
    return fopen(path, "rb");
#endif
}

/* Next integer of the text; lines that begin with # are skipped. Returns whether there is one. */
static inline int next_integer(FILE *file, long long *value) {
    char line[512];
    while (fscanf(file, "%lld", value) != 1) {
        if (fscanf(file, " %1[#]", line) != 1) return 0;
        if (!fgets(line, sizeof line, file)) return 0;
    }
    return 1;
}

/* Reads nodes a side, half width [pWb], then the tables of i_d and i_q [nA]. */
static inline const char *flux_map_read(FluxMap *map, const char *folder) {
    FILE *file = open_resource(folder, "flux_map.txt");
    if (!file) return "resources/flux_map.txt cannot be opened: unpack the whole FMU";
    long long nodes = 0, half_width = 0, value = 0;
    int complete = next_integer(file, &nodes) && next_integer(file, &half_width);
    complete = complete && nodes == MAP_NODES && half_width > 0;
    for (int axis = 0; axis < 2; ++axis) {
        for (int i = 0; i < MAP_NODES; ++i) {
            for (int j = 0; j < MAP_NODES; ++j) {
                complete = complete && next_integer(file, &value);
                map->table[i][j][axis] = 1e-9 * (double)value;
            }
        }
    }
    fclose(file);
    map->half_width = 1e-12 * (double)half_width;
    map->cells_per_flux = complete ? (MAP_NODES - 1) / (2.0 * map->half_width) : 0.0;
    return complete ? NULL : "resources/flux_map.txt is not the table that this model was built for";
}

#endif
