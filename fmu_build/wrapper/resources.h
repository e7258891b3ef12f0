#ifndef GMFBO_RESOURCES_H
#define GMFBO_RESOURCES_H

/* Path that a file URI names, percent escapes decoded, without a final slash; malloc'ed, NULL
 * without memory. Text that is no file URI is taken as a path. */
char *path_of_uri(const char *uri);

#endif
