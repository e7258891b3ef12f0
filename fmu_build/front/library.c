#define _GNU_SOURCE /* RTLD_DEEPBIND */
#include "library.h"

#include <stdlib.h>
#include <string.h>

/* folder + "/" + name, malloc'ed; NULL without memory. */
static char *join(const char *folder, const char *name) {
    char *path = malloc(strlen(folder) + strlen(name) + 2);
    if (path) sprintf(path, "%s/%s", folder, name);
    return path;
}

#ifdef _WIN32
#include <windows.h>

/* Windows takes UTF-8 in wide calls only. */
static wchar_t *wide(const char *path) {
    int n = MultiByteToWideChar(CP_UTF8, 0, path, -1, NULL, 0);
    wchar_t *text = n > 0 ? malloc((size_t)n * sizeof *text) : NULL;
    if (text) MultiByteToWideChar(CP_UTF8, 0, path, -1, text, n);
    for (wchar_t *c = text; c && *c; ++c)
        if (*c == L'/') *c = L'\\';
    return text;
}

FILE *open_for_reading(const char *folder, const char *name) {
    char *path = join(folder, name);
    wchar_t *text = path ? wide(path) : NULL;
    FILE *file = text ? _wfopen(text, L"rb") : NULL;
    free(text);
    free(path);
    return file;
}

void *open_library(const char *resources) {
    char *path = join(resources, "runtime/win64/container.dll");
    wchar_t *text = path ? wide(path) : NULL;
    HMODULE library = text ? LoadLibraryW(text) : NULL;
    free(text);
    free(path);
    return (void *)library;
}

void *find_symbol(void *library, const char *name) {
    FARPROC found = GetProcAddress((HMODULE)library, name);
    void *symbol;
    memcpy(&symbol, &found, sizeof symbol);
    return symbol;
}

void close_library(void *library) { FreeLibrary((HMODULE)library); }

#else
#include <dlfcn.h>

/* The runtime has functions of the same names, which it shall find before those of this library
 * even where a tool makes these known to all. On macOS libraries know whose function they mean. */
#ifdef __APPLE__
#define RUNTIME_LIBRARY "runtime/darwin64/container.dylib"
#define HOW (RTLD_NOW | RTLD_LOCAL)
#else
#define RUNTIME_LIBRARY "runtime/linux64/container.so"
#define HOW (RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND)
#endif

FILE *open_for_reading(const char *folder, const char *name) {
    char *path = join(folder, name);
    FILE *file = path ? fopen(path, "rb") : NULL;
    free(path);
    return file;
}

void *open_library(const char *resources) {
    char *path = join(resources, RUNTIME_LIBRARY);
    void *library = path ? dlopen(path, HOW) : NULL;
    free(path);
    return library;
}

void *find_symbol(void *library, const char *name) { return dlsym(library, name); }

void close_library(void *library) { dlclose(library); }

#endif
