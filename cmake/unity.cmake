# SPDX-License-Identifier: MIT
# Unity 2.7.0, the C test framework, as target `unity`. Looked for in this order: -DUNITY_DIR or the
# environment's UNITY_DIR, sources on the system, build/deps/unity (filled by tools/setup).
set(UNITY_DIR "$ENV{UNITY_DIR}"
    CACHE PATH "Folder with Unity's sources; empty: the system's or build/deps"
)

find_path(
    PIXSTEP_UNITY_SRC unity.c
    HINTS ${UNITY_DIR}
    PATHS /usr/local/share/unity /usr/share/unity /usr/local/src/unity /usr/src/unity
          "${CMAKE_SOURCE_DIR}/build/deps/unity"
    PATH_SUFFIXES src
    NO_CACHE NO_DEFAULT_PATH NO_CMAKE_FIND_ROOT_PATH
)
if(NOT PIXSTEP_UNITY_SRC)
    message(FATAL_ERROR "Unity is missing: run tools/setup, or give its folder by -DUNITY_DIR=...")
endif()

add_library(unity STATIC "${PIXSTEP_UNITY_SRC}/unity.c")
target_include_directories(unity SYSTEM PUBLIC "${PIXSTEP_UNITY_SRC}")
target_include_directories(unity PUBLIC "${CMAKE_SOURCE_DIR}/host_tests")
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_CONFIG_H)
