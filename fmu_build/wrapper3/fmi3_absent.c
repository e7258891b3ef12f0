/* Functions that an FMI 3.0 library has to export and this kind of FMU does not provide: each reports
 * itself. The arguments after the first are left where the caller put them. */
#include "front.h"

#define ABSENT_INSTANCE(NAME)                                                                     \
    FMI3_EXPORT fmi3Instance NAME(fmi3String name) {                                              \
        (void)name;                                                                               \
        return NULL;                                                                              \
    }
#define ABSENT(NAME)                                                                              \
    FMI3_EXPORT fmi3Status NAME(fmi3Instance c) { return not_provided(c, #NAME); }

ABSENT_INSTANCE(fmi3InstantiateModelExchange)
ABSENT_INSTANCE(fmi3InstantiateScheduledExecution)

ABSENT(fmi3GetNumberOfVariableDependencies)
ABSENT(fmi3GetVariableDependencies)
ABSENT(fmi3GetDirectionalDerivative)
ABSENT(fmi3GetAdjointDerivative)
ABSENT(fmi3GetOutputDerivatives)
ABSENT(fmi3EnterConfigurationMode)
ABSENT(fmi3ExitConfigurationMode)

ABSENT(fmi3EnterStepMode)
ABSENT(fmi3EnterEventMode)
ABSENT(fmi3EvaluateDiscreteStates)
ABSENT(fmi3UpdateDiscreteStates)
ABSENT(fmi3GetIntervalDecimal)
ABSENT(fmi3GetIntervalFraction)
ABSENT(fmi3GetShiftDecimal)
ABSENT(fmi3GetShiftFraction)
ABSENT(fmi3SetIntervalDecimal)
ABSENT(fmi3SetIntervalFraction)
ABSENT(fmi3SetShiftDecimal)
ABSENT(fmi3SetShiftFraction)
ABSENT(fmi3ActivateModelPartition)

ABSENT(fmi3EnterContinuousTimeMode)
ABSENT(fmi3CompletedIntegratorStep)
ABSENT(fmi3SetTime)
ABSENT(fmi3SetContinuousStates)
ABSENT(fmi3GetContinuousStates)
ABSENT(fmi3GetContinuousStateDerivatives)
ABSENT(fmi3GetEventIndicators)
ABSENT(fmi3GetNominalsOfContinuousStates)
ABSENT(fmi3GetNumberOfEventIndicators)
ABSENT(fmi3GetNumberOfContinuousStates)
