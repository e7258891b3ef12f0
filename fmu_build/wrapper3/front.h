/* An FMI 3.0 instance: that of the FMI 2.0 wrapper, and whom its messages go to. */
#ifndef GMFBO_FRONT_H
#define GMFBO_FRONT_H

#include "fmi3.h"
#include "instance.h"

typedef struct {
    Instance *inner;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Front;

static inline Instance *inner_of(fmi3Instance c) { return ((Front *)c)->inner; }

/* Reports a call that is not provided. */
fmi3Status not_provided(fmi3Instance c, const char *call);

#endif
