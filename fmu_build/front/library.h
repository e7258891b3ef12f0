/* Files and libraries below the resources folder, by paths in UTF-8. */
#ifndef GMFBO_LIBRARY_H
#define GMFBO_LIBRARY_H

#include <stdio.h>

/* NULL if it is not there. */
FILE *open_for_reading(const char *folder, const char *name);

/* The container's runtime for this system in runtime/; NULL if it cannot be loaded. */
void *open_library(const char *resources);
void *find_symbol(void *library, const char *name);
void close_library(void *library);

#endif
