# SPDX-License-Identifier: MIT
# The boards' images in a wheel of the package. `pip install .` builds them with avr-gcc;
# --config-settings=cmake.define.PIXSTEP_IMAGES=OFF leaves them out, and a folder in the place of
# OFF says where they were built, as in a clone's `build`.
add_custom_target(wheel_parts DEPENDS python_parts)
# `pixstep demo` works without the clone.
install(FILES tools/data/AccProfM39-30Hz-1.PRN DESTINATION pixstep/_built)
# `pixstep --version` names the commit; sources that are no clone have none.
set(commit "")
if(EXISTS "${PROJECT_SOURCE_DIR}/.git")
    execute_process(
        COMMAND git describe --always --dirty "--exclude=*" --abbrev=10
        WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
        OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE
    )
endif()
if(commit)
    file(CONFIGURE OUTPUT commit.txt CONTENT "@commit@\n" @ONLY)
    install(FILES "${CMAKE_CURRENT_BINARY_DIR}/commit.txt" DESTINATION pixstep/_built)
endif()
set(PIXSTEP_IMAGES BUILD CACHE STRING "Images in the wheel: BUILD, OFF, or a folder that has them")

if(PIXSTEP_IMAGES STREQUAL "OFF")
    return()
endif()

# Build a board's image in a folder of its own by the board's preset, without its suites.
function(build_image board folder)
    add_custom_target(
        wheel_image_${board}
        COMMAND "${CMAKE_COMMAND}" -E env --unset=CFLAGS --unset=LDFLAGS "${CMAKE_COMMAND}"
                --preset ${board} -G "${CMAKE_GENERATOR}" -B "${folder}/${board}"
                "-DCMAKE_MAKE_PROGRAM=${CMAKE_MAKE_PROGRAM}" -DPIXSTEP_SUITES=OFF
        COMMAND "${CMAKE_COMMAND}" --build "${folder}/${board}" --target pixstep-${board}
        WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
        COMMENT "Image of the ${board} board"
        VERBATIM
    )
    add_dependencies(wheel_parts wheel_image_${board})
endfunction()

set(images "${PIXSTEP_IMAGES}")
if(PIXSTEP_IMAGES STREQUAL "BUILD")
    set(images "${PROJECT_BINARY_DIR}/images")
    find_program(PIXSTEP_AVR_GCC avr-gcc NO_CMAKE_SYSTEM_PATH)
    if(NOT PIXSTEP_AVR_GCC)
        message(FATAL_ERROR "no avr-gcc: install gcc-avr and avr-libc, or see docs/INSTALL.md")
    endif()
endif()

pixstep_list_boards(boards)
foreach(board IN LISTS boards)
    set(image "${images}/${board}/firmware/pixstep-${board}")
    if(PIXSTEP_IMAGES STREQUAL "BUILD")
        build_image(${board} "${images}")
    elseif(NOT EXISTS "${image}.hex")
        message(FATAL_ERROR "PIXSTEP_IMAGES: ${image}.hex is missing")
    endif()
    install(FILES "${image}.hex" "${image}.elf" DESTINATION pixstep/_built)
endforeach()
