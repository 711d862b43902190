# SPDX-License-Identifier: MIT
# The smaller part's flash is full. A routine that all functions share saves their registers, for
# some 20 cycles a call, and fewer values are kept ready ahead of a loop, which wins most of them
# back (registers are few and wanted inside). The interrupts' half (hal) stays as it is.
set(small -mcall-prologues -mstrict-X -fno-move-loop-invariants -fno-guess-branch-probability)
foreach(layer pixstep_core pixstep_app)
    target_compile_options(${layer} PRIVATE "$<$<COMPILE_LANGUAGE:C>:${small}>")
endforeach()

# What else makes a file smaller, tried one optimisation after the other: 750 bytes together. None
# of these changes what the code does; a new compiler may want others.
function(smaller file)
    set_property(SOURCE ${file} APPEND PROPERTY COMPILE_OPTIONS ${ARGN})
endfunction()
smaller(app/commands.c -fno-tree-dominator-opts -fno-forward-propagate -fno-jump-tables
        -fno-tree-loop-optimize)
smaller(app/data.c -fno-split-wide-types -fno-forward-propagate -fira-algorithm=priority
        -fno-tree-copy-prop -fno-tree-reassoc -fno-expensive-optimizations -fno-cse-follow-jumps
        -fno-gcse)
smaller(app/report.c -fno-tree-forwprop)
smaller(app/safety.c -fno-tree-ter -fno-forward-propagate -fno-tree-fre -fno-tree-pre)
smaller(app/seek.c -fira-algorithm=priority -fno-tree-reassoc)
smaller(app/start.c -fno-ipa-pure-const -fno-tree-dominator-opts -fno-forward-propagate
        -fira-algorithm=priority)
smaller(core/motion/axis.c -fno-ipa-sra -fno-tree-dominator-opts -fguess-branch-probability
        -fno-reorder-blocks -fno-tree-reassoc -fno-tree-copy-prop -fno-tree-fre
        -fno-tree-loop-optimize -fno-forward-propagate)
smaller(core/motion/clock_watch.c -fno-split-wide-types -fno-tree-dominator-opts -fno-tree-forwprop)
smaller(core/motion/curve.c -fno-tree-ter)
smaller(core/motion/curve_flat.c -fno-expensive-optimizations -fno-tree-reassoc)
smaller(core/motion/even.c -fno-gcse)
smaller(core/motion/feed.c -fno-tree-forwprop -fno-tree-sink -fno-tree-vrp)
smaller(core/motion/ledger.c -fno-tree-forwprop -fno-tree-reassoc -fno-gcse -fno-reorder-blocks)
smaller(core/motion/line.c -fno-tree-ter -fira-algorithm=priority -fno-ipa-sra -fno-tree-fre
        -fno-forward-propagate -fno-tree-copy-prop -fno-tree-ccp)
smaller(core/motion/line_check.c -fira-algorithm=priority -fguess-branch-probability -fno-tree-vrp
        -fno-split-wide-types -fno-tree-fre -fno-shrink-wrap)
smaller(core/motion/step_engine.c -fno-tree-ter -fno-tree-dominator-opts)
smaller(core/motion/walk.c -fira-algorithm=priority)
smaller(app/bits.c -fno-ivopts -fira-algorithm=priority)
smaller(core/wire/server.c -fguess-branch-probability -fno-tree-dominator-opts)
smaller(app/settings.c -fira-algorithm=priority -fno-shrink-wrap)
smaller(app/store.c -fguess-branch-probability -fno-tree-pre)
smaller(app/machine.c -fno-gcse -fno-cse-follow-jumps)
smaller(core/wire/frame.c -fno-tree-pre)
smaller(app/inputs.c -fno-tree-ter)
smaller(app/round.c -fno-peephole2)
smaller(core/motion/run_queue.c -fira-algorithm=priority)
