# SPDX-License-Identifier: MIT
# The project's rules as tests (label `rules`): who may include whom, what must not be in an image,
# how large it may be, how plain the text is, whether a generated table still says what the source
# says. Those about the text and the code need nothing but Python's own library.
# rule(<name> <program> <argument>...): a test `rules.<name>` that runs a program from the root.
function(rule name)
    add_test(NAME rules.${name} COMMAND ${ARGN} WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}")
    set_tests_properties(rules.${name} PROPERTIES LABELS rules)
endfunction()

set(checks "${CMAKE_SOURCE_DIR}/tools/checks")
rule(layers "${PIXSTEP_PYTHON}" "${checks}/layers.py")
rule(imports "${PIXSTEP_PYTHON}" "${checks}/imports.py")
rule(class_names "${PIXSTEP_PYTHON}" "${checks}/class_names.py")
rule(protocol "${PIXSTEP_PYTHON}" -m pixstep_dev docs protocol --check docs/PROTOCOL.md)
rule(commands "${PIXSTEP_PYTHON}" -m pixstep_dev docs grammar --check docs/COMMANDS.md)
rule(api "${PIXSTEP_PYTHON}" -m pixstep_dev docs api --check docs/API.md)
rule(operations "${PIXSTEP_PYTHON}" -m pixstep_dev docs operations --check docs/OPERATIONS.md)
rule(files "${PIXSTEP_PYTHON}" -m pixstep_dev docs files --check docs/FILES.md)
rule(faults "${PIXSTEP_PYTHON}" -m pixstep_dev docs faults --check docs/FAULTS.md)
rule(epics "${PIXSTEP_PYTHON}" -m pixstep_dev docs epics --check docs/EPICS.md)
rule(wiring "${PIXSTEP_PYTHON}" -m pixstep_dev docs wiring --check docs/WIRING.md)
rule(drivers "${PIXSTEP_PYTHON}" -m pixstep_dev docs drivers --check docs/WIRING.md)
rule(shields "${PIXSTEP_PYTHON}" -m pixstep_dev docs shields --check docs/WIRING.md)
rule(drawings "${PIXSTEP_PYTHON}" -m pixstep_dev docs drawings docs/wiring)
rule(rates "${PIXSTEP_PYTHON}" -m pixstep_dev docs rates --check README.md)
rule(comparison "${PIXSTEP_PYTHON}" -m pixstep_dev docs comparison --check docs/comparison.svg)
rule(flashing "${PIXSTEP_PYTHON}" -m pixstep_dev docs flashing --check docs/FLASHING.md)
rule(text "${PIXSTEP_PYTHON}" "${checks}/text.py")
set(images "")
set(named_images "")
foreach(board IN LISTS PIXSTEP_BOARDS)
    string(TOUPPER "${board}" name)
    list(APPEND images "${PIXSTEP_${name}_IMAGE}")
    list(APPEND named_images "${board}=${PIXSTEP_${name}_IMAGE}")
endforeach()
rule(symbols "${PIXSTEP_PYTHON}" "${checks}/symbols.py" ${images})
rule(sizes "${PIXSTEP_PYTHON}" "${checks}/sizes.py" ${named_images})
# Builds and runs the suites once more, with counters; seconds, as they are.
rule(coverage "${PIXSTEP_PYTHON}" "${checks}/coverage.py" --check docs/TESTING.md)
set_tests_properties(
    rules.coverage PROPERTIES PROCESSORS 2 COST 25 ENVIRONMENT "UNITY_DIR=${UNITY_DIR}"
)

# The modules: who uses whom, what of their state others can write, what flash and RAM each takes.
# These ask the native build and the build of every board in firmware/avr/boards.
rule(circles "${PIXSTEP_PYTHON}" "${checks}/circles.py" "${CMAKE_BINARY_DIR}")
rule(writable "${PIXSTEP_PYTHON}" "${checks}/writable.py" "${CMAKE_BINARY_DIR}")
rule(module_graph "${PIXSTEP_PYTHON}" "${checks}/module_graph.py" --check docs/MODULES.md)
rule(package_graph "${PIXSTEP_PYTHON}" "${checks}/package_graph.py" --check docs/MODULES.md)
rule(module_sizes "${PIXSTEP_PYTHON}" "${checks}/module_sizes.py" --check docs/TIMING.md)
# All feature switches turned over, on one board of each set of defaults; the other boards, and each
# switch by itself with what it costs, take longer.
rule(features "${PIXSTEP_PYTHON}" "${checks}/features.py" --together)
set_tests_properties(rules.features PROPERTIES COST 15)
rule(features.together.long "${PIXSTEP_PYTHON}" "${checks}/features.py" --together --each-board)
set_tests_properties(rules.features.together.long PROPERTIES LABELS long)
rule(features.long "${PIXSTEP_PYTHON}" "${checks}/features.py" --check docs/TIMING.md)
set_tests_properties(rules.features.long PROPERTIES LABELS long PROCESSORS 2)
rule(figures "${PIXSTEP_PYTHON}" "${checks}/figures.py")
