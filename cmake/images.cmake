# SPDX-License-Identifier: MIT
# The host build asks for the boards' images: it calls each board's preset. With
# nothing to do this costs a tenth of a second a board, and an edited preset reaches the image.

# As a script (cmake -DBOARD=... -P): configure one board, silently unless it fails.
if(CMAKE_SCRIPT_MODE_FILE)
    set(unity "")
    if(UNITY_DIR)
        set(unity "-DUNITY_DIR=${UNITY_DIR}")
    endif()
    execute_process(
        COMMAND "${CMAKE_COMMAND}" --preset ${BOARD} ${unity}
        OUTPUT_VARIABLE said ERROR_VARIABLE said RESULT_VARIABLE failed
    )
    if(failed)
        message(FATAL_ERROR "the ${BOARD} board's build could not be configured:\n${said}")
    endif()
    return()
endif()

# pixstep_image(<board>): build the board's whole cross tree as part of this build, and set
# PIXSTEP_<BOARD>_BUILD (its build folder) and PIXSTEP_<BOARD>_IMAGE (the firmware's ELF file).
function(pixstep_image board)
    set(build "${CMAKE_SOURCE_DIR}/build/${board}")
    set(image "${build}/firmware/pixstep-${board}.elf")
    add_custom_target(
        image_${board} ALL
        COMMAND "${CMAKE_COMMAND}" -DBOARD=${board} "-DUNITY_DIR=${UNITY_DIR}"
                -P "${CMAKE_CURRENT_FUNCTION_LIST_FILE}"
        COMMAND "${CMAKE_COMMAND}" --build --preset ${board}
        BYPRODUCTS "${image}"
        WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
        COMMENT "Images of the ${board} board"
        USES_TERMINAL VERBATIM
    )
    add_custom_target(
        suites_${board}
        COMMAND "${CMAKE_COMMAND}" --build --preset ${board} --target unit_suites
        WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
        COMMENT "Suites for the ${board} board"
        USES_TERMINAL VERBATIM
    )
    add_dependencies(suites_${board} image_${board})
    string(TOUPPER ${board} name)
    set(PIXSTEP_${name}_BUILD "${build}" PARENT_SCOPE)
    set(PIXSTEP_${name}_IMAGE "${image}" PARENT_SCOPE)
endfunction()

pixstep_list_boards(PIXSTEP_BOARDS)
# One after the other: each build already uses every core.
set(before "")
foreach(board IN LISTS PIXSTEP_BOARDS)
    pixstep_image(${board})
    if(before)
        add_dependencies(image_${board} ${before})
    endif()
    set(before image_${board})
endforeach()
add_custom_target(images DEPENDS ${before})

# The suites of every board that runs them; `all` builds those of one (host_tests/CMakeLists.txt).
add_custom_target(all_suites)
function(pixstep_add_suites)
    foreach(board IN LISTS PIXSTEP_BOARDS)
        pixstep_read_board(${board})
        if(BOARD_RUNS_SUITES)
            add_dependencies(all_suites suites_${board})
        endif()
    endforeach()
endfunction()
pixstep_add_suites()
