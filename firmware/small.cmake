# SPDX-License-Identifier: MIT
# The smaller part's flash is full. A routine that all functions share saves their registers, for
# some 20 cycles a call, and fewer values are kept ready ahead of a loop, which wins most of them
# back (registers are few and wanted inside). The interrupts' half (hal) stays as it is.
set(small -mcall-prologues -mstrict-X -fno-move-loop-invariants -fno-guess-branch-probability)
foreach(layer pixstep_core_objects pixstep_app_objects)
    target_compile_options(${layer} PRIVATE "$<$<COMPILE_LANGUAGE:C>:${small}>")
endforeach()
