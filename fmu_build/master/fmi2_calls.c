/* FMI 2.0.2, sections 2.1.7 and 4.2: Integer and Boolean are both int. */
#include <math.h>

#include "calls.h"

typedef int (*RealSetter)(void *, const uint32_t *, size_t, const double *);
typedef int (*RealGetter)(void *, const uint32_t *, size_t, double *);
typedef int (*WholeSetter)(void *, const uint32_t *, size_t, const int32_t *);
typedef int (*WholeGetter)(void *, const uint32_t *, size_t, int32_t *);
typedef int (*Stepper)(void *, double t, double h, int no_set_state);

int fmi2_set(const gm_fmu *fmu, int32_t type, const Group *group) {
    if (type == GM_REAL) return ((RealSetter)fmu->set[type])(fmu->component, group->vr, group->n, group->value);
    int32_t *whole = group->raw;
    for (size_t i = 0; i < group->n; ++i)
        whole[i] = type == GM_BOOLEAN ? group->value[i] != 0.0 : (int32_t)lround(group->value[i]);
    return ((WholeSetter)fmu->set[type])(fmu->component, group->vr, group->n, whole);
}

int fmi2_get(const gm_fmu *fmu, int32_t type, Group *group) {
    if (type == GM_REAL) return ((RealGetter)fmu->get[type])(fmu->component, group->vr, group->n, group->value);
    int32_t *whole = group->raw;
    int status = ((WholeGetter)fmu->get[type])(fmu->component, group->vr, group->n, whole);
    for (size_t i = 0; i < group->n; ++i) group->value[i] = whole[i];
    return status;
}

int fmi2_step(const gm_fmu *fmu, double t, double h) {
    return ((Stepper)fmu->do_step)(fmu->component, t, h, 1);
}
