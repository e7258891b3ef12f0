/* Taking, restoring and serialising the whole state of an instance. */
#include <stdlib.h>
#include <string.h>

#include "instance.h"

/* A stored state: progress, then the model's bytes. */
typedef struct {
    Progress progress;
    unsigned char *model;
} StoredState;

enum { GUID_BYTES = 40 };

static size_t serialised_bytes(void) { return GUID_BYTES + sizeof(Progress) + model_bytes; }

static StoredState *new_state(void) {
    StoredState *state = malloc(sizeof *state + model_bytes);
    if (state) state->model = (unsigned char *)(state + 1);
    return state;
}

FMI2_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *stored) {
    Instance *instance = c;
    if (!*stored) *stored = new_state();
    StoredState *state = *stored;
    if (!state) return report(instance, fmi2Error, "no memory for a copy of the state");
    state->progress = instance->progress;
    memcpy(state->model, instance->model, model_bytes);
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate stored) {
    Instance *instance = c;
    const StoredState *state = stored;
    if (!state) return report(instance, fmi2Error, "expected a state from fmi2GetFMUstate, got NULL");
    instance->progress = state->progress;
    memcpy(instance->model, state->model, model_bytes);
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *stored) {
    (void)c;
    if (stored) {
        free(*stored);
        *stored = NULL;
    }
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate stored, size_t *bytes) {
    (void)c, (void)stored;
    *bytes = serialised_bytes();
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate stored, fmi2Byte bytes[],
                                             size_t size) {
    const StoredState *state = stored;
    if (!state || size < serialised_bytes())
        return report(c, fmi2Error, "a state takes %zu bytes, got room for %zu", serialised_bytes(), size);
    memset(bytes, 0, GUID_BYTES);
    memcpy(bytes, model_guid, strlen(model_guid));
    memcpy(bytes + GUID_BYTES, &state->progress, sizeof state->progress);
    memcpy(bytes + GUID_BYTES + sizeof state->progress, state->model, model_bytes);
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                               fmi2FMUstate *stored) {
    if (size != serialised_bytes() || strncmp(bytes, model_guid, GUID_BYTES) != 0)
        return report(c, fmi2Error, "the serialised state belongs to another model or version of %s",
                      model_name);
    if (!*stored) *stored = new_state();
    StoredState *state = *stored;
    if (!state) return report(c, fmi2Error, "no memory for a copy of the state");
    memcpy(&state->progress, bytes + GUID_BYTES, sizeof state->progress);
    memcpy(state->model, bytes + GUID_BYTES + sizeof state->progress, model_bytes);
    return fmi2OK;
}
