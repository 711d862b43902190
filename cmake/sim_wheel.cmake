# SPDX-License-Identifier: MIT
# The parts of the wheel pixstep-sim (sim/wheel): the program, linked statically so that it runs on
# every Linux of its kind of processor, and what GPL-3.0 asks for: the sources of the simulator, and
# where those of the libraries are.
set(wheel_sources "${PROJECT_BINARY_DIR}/source.tar.gz")
file(
    GLOB_RECURSE archived CONFIGURE_DEPENDS
    "${PROJECT_SOURCE_DIR}/sim/*" "${PROJECT_SOURCE_DIR}/cmake/*" "${PROJECT_SOURCE_DIR}/firmware/*"
)
add_custom_command(
    OUTPUT "${wheel_sources}"
    COMMAND "${CMAKE_COMMAND}" -E tar czf "${wheel_sources}" --format=gnutar -- CMakeLists.txt
            CMakePresets.json LICENSE cmake sim firmware tools/src/pixstep/version.py
    DEPENDS ${archived}
    WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
    COMMENT "Sources of the simulator"
    VERBATIM
)
add_custom_target(wheel_parts DEPENDS pixstep-sim "${wheel_sources}")

# The packages of the system that the linked libraries come from, and their sources' versions.
set(rows "")
foreach(package IN ITEMS libsimavr-dev libelf-dev zlib1g-dev libc6-dev)
    execute_process(
        COMMAND dpkg-query --show "--showformat=\${source:Package}=\${source:Version}" ${package}
        OUTPUT_VARIABLE source ERROR_QUIET RESULT_VARIABLE failed
    )
    if(failed)
        set(source "unknown: this system has no package ${package}")
    endif()
    string(APPEND rows "${package}: ${source}\n")
endforeach()
file(CONFIGURE OUTPUT SOURCES.txt @ONLY CONTENT
"What is linked into bin/pixstep-sim beside the sources in source.tar.gz: the system's package, and
its source package. `apt-get source NAME=VERSION` on Debian brings one; all versions are kept at
https://snapshot.debian.org.

@rows@")

install(PROGRAMS "$<TARGET_FILE:pixstep-sim>" DESTINATION pixstep_sim/bin)
install(FILES "${wheel_sources}" "${CMAKE_CURRENT_BINARY_DIR}/SOURCES.txt" DESTINATION pixstep_sim)
