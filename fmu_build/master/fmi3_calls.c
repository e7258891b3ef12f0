/* FMI 3.0.1, sections 2.2.7 and 4.2: numbers of every width, a Boolean of one byte, and a step that
 * may ask for event mode. */
#include <math.h>
#include <stdbool.h>

#include "calls.h"

typedef int (*Setter)(void *, const uint32_t *, size_t, const void *, size_t);
typedef int (*Getter)(void *, const uint32_t *, size_t, void *, size_t);
typedef int (*Stepper)(void *, double t, double h, bool no_set_state, bool *event_needed, bool *terminate,
                       bool *early_return, double *last_time);

#define EACH_INTEGER(CASE)                                                                       \
    CASE(GM_INT8, int8_t) CASE(GM_UINT8, uint8_t) CASE(GM_INT16, int16_t) CASE(GM_UINT16, uint16_t) \
    CASE(GM_INTEGER, int32_t) CASE(GM_UINT32, uint32_t) CASE(GM_INT64, int64_t) CASE(GM_UINT64, uint64_t)

int fmi3_set(const gm_fmu *fmu, int32_t type, const Group *group) {
    const void *raw = type == GM_REAL ? (const void *)group->value : group->raw;
    for (size_t i = 0; i < group->n && type != GM_REAL; ++i) {
        double value = group->value[i];
        switch (type) {
#define CASE(TYPE, C_TYPE) case TYPE: ((C_TYPE *)group->raw)[i] = (C_TYPE)llround(value); break;
            EACH_INTEGER(CASE)
#undef CASE
        case GM_BOOLEAN: ((bool *)group->raw)[i] = value != 0.0; break;
        case GM_FLOAT32: ((float *)group->raw)[i] = (float)value; break;
        default: break;
        }
    }
    return ((Setter)fmu->set[type])(fmu->component, group->vr, group->n, raw, group->n);
}

int fmi3_get(const gm_fmu *fmu, int32_t type, Group *group) {
    void *raw = type == GM_REAL ? (void *)group->value : group->raw;
    int status = ((Getter)fmu->get[type])(fmu->component, group->vr, group->n, raw, group->n);
    for (size_t i = 0; i < group->n && type != GM_REAL; ++i) {
        switch (type) {
#define CASE(TYPE, C_TYPE) case TYPE: group->value[i] = (double)((const C_TYPE *)raw)[i]; break;
            EACH_INTEGER(CASE) CASE(GM_BOOLEAN, bool) CASE(GM_FLOAT32, float)
#undef CASE
        default: break;
        }
    }
    return status;
}

int fmi3_step(const gm_fmu *fmu, double t, double h, int32_t *stage) {
    bool event_needed = false, terminate = false, early_return = false;
    double last_time = t + h;
    int status = ((Stepper)fmu->do_step)(fmu->component, t, h, true, &event_needed, &terminate, &early_return,
                                         &last_time);
    if (status > FMI_WARNING || !(event_needed || terminate || early_return)) return status;
    *stage = terminate ? GM_STAGE_ENDED : GM_STAGE_EVENT;
    return FMI_DISCARD;
}
