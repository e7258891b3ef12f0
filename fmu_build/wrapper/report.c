/* Messages to the environment. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "instance.h"

enum { LINE_BYTES = 1024 };

static const char *category_of(fmi2Status status) {
    switch (status) {
    case fmi2Warning: return "logStatusWarning";
    case fmi2Discard: return "logStatusDiscard";
    case fmi2Error: return "logStatusError";
    case fmi2Fatal: return "logStatusFatal";
    default: return "logEvents";
    }
}

/* The environment reads a message as a printf format, so each '%' is doubled. */
static void escape_percent(const char *line, char *escaped, size_t bytes) {
    size_t used = 0;
    for (; *line && used + 2 < bytes; ++line) {
        escaped[used++] = *line;
        if (*line == '%') escaped[used++] = '%';
    }
    escaped[used] = '\0';
}

fmi2Status report(const Instance *instance, fmi2Status status, const char *format, ...) {
    if (!instance->logger || (status == fmi2OK && !instance->logging)) return status;
    char line[LINE_BYTES], escaped[LINE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    escape_percent(line, escaped, sizeof escaped);
    instance->logger(instance->environment, instance->name, status, category_of(status), escaped);
    return status;
}

fmi2Status status_of(const Instance *instance, const char *answer) {
    if (!answer) return fmi2OK;
    fmi2Status status = strncmp(answer, "warning:", 8) == 0   ? fmi2Warning
                        : strncmp(answer, "discard:", 8) == 0 ? fmi2Discard
                                                              : fmi2Error;
    return report(instance, status, "%s", answer);
}
