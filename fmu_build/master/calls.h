/* Calls of one FMU: the same three for FMI 2.0 and for 3.0, each answering with an FMI status. */
#ifndef GMFBO_CALLS_H
#define GMFBO_CALLS_H

#include <stddef.h>

#include "master.h"

enum { FMI_OK, FMI_WARNING, FMI_DISCARD, FMI_ERROR };

/* Variables of one FMU and one type that are set, or read, by one call. */
typedef struct {
    size_t n;
    uint32_t *vr;
    double *value;
    void *raw; /* room for the same values in the type that the call takes */
} Group;

int fmi2_set(const gm_fmu *fmu, int32_t type, const Group *group);
int fmi2_get(const gm_fmu *fmu, int32_t type, Group *group);
int fmi2_step(const gm_fmu *fmu, double t, double h);

int fmi3_set(const gm_fmu *fmu, int32_t type, const Group *group);
int fmi3_get(const gm_fmu *fmu, int32_t type, Group *group);

/* Changes `stage` where the step was made and the FMU asks for what a master like this cannot do. */
int fmi3_step(const gm_fmu *fmu, double t, double h, int32_t *stage);

#endif
