# SPDX-License-Identifier: MIT
# The Python tests, one ctest entry a file (label `python`), run by the clone's own environment.
# tools/tests: the product's; tools/dev/tests: the proof's.
file(
    GLOB files CONFIGURE_DEPENDS
    "${CMAKE_SOURCE_DIR}/tools/tests/test_*.py" "${CMAKE_SOURCE_DIR}/tools/dev/tests/test_*.py"
)
foreach(file IN LISTS files)
    get_filename_component(name "${file}" NAME_WE)
    string(REGEX REPLACE "^test_" "py." name "${name}")
    add_test(
        NAME ${name}
        COMMAND "${PIXSTEP_PYTHON}" -m pytest -q -p no:cacheprovider -c tools/pyproject.toml
                "${file}"
        WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
    )
    set_tests_properties(${name} PROPERTIES LABELS python TIMEOUT 600)
endforeach()

# These talk to a simulated board over a pseudo terminal, in real time: nothing runs beside them.
set_tests_properties(py.tutorial py.console_doc py.board_port PROPERTIES RUN_SERIAL TRUE)

# The wheel, installed into an empty environment. It takes the images that are built here.
add_test(
    NAME wheel.install
    COMMAND "${PIXSTEP_PYTHON}" tools/checks/wheel.py "${CMAKE_BINARY_DIR}/wheel"
    WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
)
set_tests_properties(wheel.install PROPERTIES LABELS python TIMEOUT 600)
