# SPDX-License-Identifier: MIT
# Formatting and static analysis as tests (label `lint`), by the versions that tools/setup installs
# (tools/requirements-dev.txt), and the target `format`, which puts the formatting right.
set(bin "${CMAKE_SOURCE_DIR}/build/venv/bin")
foreach(tool IN ITEMS clang-format clang-tidy cppcheck lizard ruff lint-imports mypy)
    string(MAKE_C_IDENTIFIER "PIXSTEP_${tool}" variable)
    find_program(${variable} ${tool} HINTS "${bin}" NO_DEFAULT_PATH)
    if(NOT ${variable})
        message(STATUS "lint: no ${tool} (tools/setup installs it): no lint tests this time")
        unset(${variable} CACHE)
        return()
    endif()
endforeach()

file(
    GLOB_RECURSE sources CONFIGURE_DEPENDS
    "${CMAKE_SOURCE_DIR}/firmware/*.[ch]" "${CMAKE_SOURCE_DIR}/host_tests/*.[ch]"
    "${CMAKE_SOURCE_DIR}/sim/*.[ch]" "${CMAKE_SOURCE_DIR}/tools/native/*.[ch]"
    "${CMAKE_SOURCE_DIR}/fuzz/*.[ch]"
)

function(lint name)
    add_test(NAME lint.${name} COMMAND ${ARGN} WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}")
    set_tests_properties(lint.${name} PROPERTIES LABELS lint)
endfunction()

set(tidy "${PIXSTEP_PYTHON}" "${CMAKE_SOURCE_DIR}/tools/checks/tidy.py")
set(tidy_host "${PIXSTEP_clang_tidy}" "${CMAKE_BINARY_DIR}" firmware host_tests sim tools/native
              fuzz)
set(tidy_avr "${PIXSTEP_clang_tidy}" "${PIXSTEP_MEGA_BUILD}" firmware)
lint(format "${PIXSTEP_clang_format}" --dry-run -Werror ${sources})
# The quick check reads the firmware with the AVR's types alone.
lint(tidy.host ${tidy} --without-paths "${PIXSTEP_clang_tidy}" "${CMAKE_BINARY_DIR}" host_tests sim
     tools/native fuzz)
lint(tidy.avr ${tidy} --without-paths ${tidy_avr})
lint(tidy.host.long ${tidy} ${tidy_host})
lint(tidy.avr.long ${tidy} ${tidy_avr})
lint(
    cppcheck "${PIXSTEP_cppcheck}" "--project=${PIXSTEP_MEGA_BUILD}/compile_commands.json"
    --platform=avr8 --enable=warning,style,performance,portability --inline-suppr
    --suppress=missingIncludeSystem --suppress=unknownMacro:*/avr/boards/* --error-exitcode=1
    --quiet "--file-filter=${CMAKE_SOURCE_DIR}/firmware/*"
)
# Python has its own limits, in tools/pyproject.toml.
lint(complexity "${PIXSTEP_lizard}" -C 10 -L 60 -w -l c firmware sim tools/native fuzz)
lint(ruff "${PIXSTEP_ruff}" check --no-cache --config pyproject.toml . ../sim
     ../docs/examples)
lint(ruff-format "${PIXSTEP_ruff}" format --no-cache --check --config pyproject.toml . ../sim
     ../docs/examples)
# Who may import whom among the packages; types.
lint(imports "${PIXSTEP_lint_imports}" --config tools/checks/imports.toml --no-cache)
lint(
    types "${PIXSTEP_mypy}" --config-file tools/checks/mypy.ini
    --python-executable "${PIXSTEP_PYTHON}" --cache-dir "${CMAKE_BINARY_DIR}/mypy"
)

# Read where its settings are (pyproject.toml).
set_tests_properties(
    lint.ruff lint.ruff-format PROPERTIES WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}/tools"
)

# clang-tidy already works on every core.
set_tests_properties(
    lint.tidy.host lint.tidy.avr lint.tidy.host.long lint.tidy.avr.long PROPERTIES PROCESSORS 2
)
set_tests_properties(lint.tidy.host.long lint.tidy.avr.long PROPERTIES LABELS long)
# What takes long begins early, so that nothing is left to wait for at the end.
set_tests_properties(lint.types PROPERTIES COST 30)
set_tests_properties(lint.tidy.host PROPERTIES COST 25)

add_custom_target(
    format
    COMMAND "${PIXSTEP_clang_format}" -i ${sources}
    COMMAND "${CMAKE_COMMAND}" -E chdir tools "${PIXSTEP_ruff}" format --no-cache
            --config pyproject.toml . ../sim ../docs/examples
    WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
)
add_custom_target(
    lint
    COMMAND "${CMAKE_CTEST_COMMAND}" --test-dir "${CMAKE_BINARY_DIR}" -L lint --output-on-failure
    USES_TERMINAL
)
