/* fmi2Instantiate gets the resources folder as a URI (RFC 8089); models want a path. */
#include "resources.h"

#include <stdlib.h>
#include <string.h>

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/* Both file:///path and file:/path are in use; file://localhost/path is legal too. */
static const char *after_scheme(const char *uri) {
    if (strncmp(uri, "file:", 5) != 0) return uri;
    const char *path = uri + 5;
    if (strncmp(path, "//", 2) == 0) {
        path += 2;
        if (strncmp(path, "localhost/", 10) == 0) path += 9;
    }
#ifdef _WIN32
    if (path[0] == '/' && path[1] && path[2] == ':') ++path; /* /C:/folder */
#endif
    return path;
}

char *path_of_uri(const char *uri) {
    const char *source = after_scheme(uri);
    int escaped = source != uri;
    char *path = malloc(strlen(source) + 1);
    if (!path) return NULL;
    size_t used = 0;
    while (*source) {
        int high = escaped && source[0] == '%' ? hex_digit(source[1]) : -1;
        int low = high >= 0 ? hex_digit(source[2]) : -1;
        if (low >= 0) {
            path[used++] = (char)(16 * high + low);
            source += 3;
        } else {
            path[used++] = *source++;
        }
    }
    while (used > 1 && (path[used - 1] == '/' || path[used - 1] == '\\')) --used;
    path[used] = '\0';
    return path;
}
