# SPDX-License-Identifier: MIT
# The Python tests (label `python`), run by the clone's own environment. A file that takes more than
# twelve seconds of processor time is a ctest entry of its own, `py.<name>`; the others share an
# interpreter, `py.short.<n>`, since the import of libraries takes longer than many of them. A file
# that knows more cases (tools/tests/effort.py) is run with all of them by `py.<name>.long` (label
# `long`). All of these begin first: nothing else takes as long.
set(PIXSTEP_LONG_RUNNING
    bench board board_images campaign costs every_output examples figures guarantee holes homing
    job_campaigns late_interrupts lock motor_record_traces pixel_rates program_run programs
    programs_jerk programs_mode1 programs_smooth trajectory_runs wrong_values
)
# These talk to a simulated board over a pseudo terminal, in real time. Much of it they wait: one
# after the other they run beside the rest, on the job that the presets have beyond the cores.
set(PIXSTEP_REAL_TIME
    board_port board_trouble conformance console_doc ioc ioc_clients ioc_command ioc_faults
    ioc_saved job_port late_replies motion_port motor_drive_port plc server serving tutorial
    virtual_bench
)
# A stream of some minutes in real time runs dry where other tests take its processor: with all its
# cases it runs alone.
set(PIXSTEP_ALONE_WHEN_LONG serving)
set(PIXSTEP_SHORT_TOGETHER 12)
# The longest of the long check, minutes each: they begin first.
set(PIXSTEP_LONGEST lock_sim programs trajectory_runs)

# What every Python program of a test is run with: byte code is kept where tools/check keeps it, not
# beside the sources, and what is missing fails a test instead of skipping it.
set(PIXSTEP_PYTHON_ENVIRONMENT
    "PYTHONPYCACHEPREFIX=${CMAKE_SOURCE_DIR}/build/pycache" PYTHONDONTWRITEBYTECODE=
    PIXSTEP_REQUIRE_BUILT=1
)

# python_test(<name> <label> FILES <file>... ENVIRONMENT <variable>...)
function(python_test name label)
    cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "FILES;ENVIRONMENT")
    add_test(
        NAME ${name}
        COMMAND "${PIXSTEP_PYTHON}" -m pytest -q -p no:cacheprovider -c tools/pyproject.toml
                ${arg_FILES}
        WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
    )
    set_tests_properties(
        ${name} PROPERTIES LABELS "${label}" COST 20
        ENVIRONMENT "${PIXSTEP_PYTHON_ENVIRONMENT};${arg_ENVIRONMENT}"
    )
    string(REGEX REPLACE "^py[.]|[.]long$" "" file "${name}")
    if(label STREQUAL "long" AND file IN_LIST PIXSTEP_LONGEST)
        set_tests_properties(${name} PROPERTIES COST 60)
    elseif(file IN_LIST PIXSTEP_REAL_TIME)
        set_tests_properties(${name} PROPERTIES RESOURCE_LOCK real_time COST 40)
        if(label STREQUAL "long" AND file IN_LIST PIXSTEP_ALONE_WHEN_LONG)
            set_tests_properties(${name} PROPERTIES RUN_SERIAL TRUE)
        endif()
    elseif(file MATCHES "^short[.]")
        set_tests_properties(${name} PROPERTIES COST 30)
    endif()
endfunction()

# The product's files and the proof's, which have fixtures of their own.
set(by_itself ${PIXSTEP_LONG_RUNNING} ${PIXSTEP_REAL_TIME})
set(short_number 1)
foreach(folder IN ITEMS tools/tests tools/dev/tests)
    file(GLOB files CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/${folder}/test_*.py")
    set(short "")
    foreach(file IN LISTS files)
        get_filename_component(name "${file}" NAME_WE)
        string(REGEX REPLACE "^test_" "" name "${name}")
        file(STRINGS "${file}" knows_more REGEX "^from effort import" LIMIT_COUNT 1)
        if(knows_more)
            python_test(py.${name}.long long FILES "${file}" ENVIRONMENT PIXSTEP_LONG=1)
        endif()
        if(name IN_LIST by_itself)
            python_test(py.${name} python FILES "${file}")
        else()
            list(APPEND short "${file}")
        endif()
        list(LENGTH short together)
        if(together EQUAL PIXSTEP_SHORT_TOGETHER)
            python_test(py.short.${short_number} python FILES ${short})
            math(EXPR short_number "${short_number} + 1")
            set(short "")
        endif()
    endforeach()
    if(short)
        python_test(py.short.${short_number} python FILES ${short})
        math(EXPR short_number "${short_number} + 1")
    endif()
endforeach()

# The wheel, installed into an empty environment. It takes the images that are built here.
add_test(
    NAME wheel.install
    COMMAND "${PIXSTEP_PYTHON}" tools/checks/wheel.py "${CMAKE_BINARY_DIR}/wheel"
    WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
)
set_tests_properties(
    wheel.install PROPERTIES LABELS python COST 20 ENVIRONMENT "${PIXSTEP_PYTHON_ENVIRONMENT}"
)

# Both wheels, built as they are given away, and installed by pip from the package index.
add_test(
    NAME wheels.install.long
    COMMAND "${PIXSTEP_PYTHON}" tools/checks/wheels.py "${CMAKE_BINARY_DIR}/wheels"
    WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
)
set_tests_properties(wheels.install.long PROPERTIES LABELS long COST 20)
