# web_client.wasm: the client library for browsers. Built where clang++ with Debian's WASI libraries is there, and then part of the
# admin server; without it the page /play says what to install.
set(WEB_CLIENT ${PROJECT_BINARY_DIR}/web/zoned_client.wasm)
find_program(WASM_CXX NAMES clang++-19)
set(WASM_LIBC /usr/lib/wasm32-wasi/libc.a)
set(WASM_LIBCXX /usr/lib/llvm-19/include/wasm32-wasi/c++/v1)
set(WASM_BUILTINS /usr/lib/llvm-19/lib/clang/19/lib/wasi)
set(ZONED_WEB_CLIENT OFF)
if(WASM_CXX AND EXISTS ${WASM_LIBC} AND EXISTS ${WASM_BUILTINS})
  set(ZONED_WEB_CLIENT ON)
endif()
message(STATUS "client for browsers (WebAssembly): ${ZONED_WEB_CLIENT}")

if(ZONED_WEB_CLIENT)
  set(WEB_SOURCES)
  foreach(FOLDER shared/core shared/math shared/clock shared/motion shared/wire client-sim/link client-sim/view client-sim/audit client-sim/library client-sim/web)
    file(GLOB_RECURSE SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${FOLDER}/*.cpp)
    list(APPEND WEB_SOURCES ${SOURCES})
  endforeach()
  # Sockets, TLS and what an operating system gives: a page has a WebSocket in their place.
  list(FILTER WEB_SOURCES EXCLUDE REGEX "/(seal|websocket_upgrade|websocket_frames|processor|signal_stack|line_reader|replace_file|conditioner|conditioned_network|bottleneck|name_lookup|frame_stream|socket_transport|system_sockets|tls_session|tls_stream|websocket_stream|udp_pool|socket_route|caller_sockets|client_memory|connect_interface)\\.cpp$")
  # Only what a page calls is exported.
  file(STRINGS client-sim/library/zoned_client.h NAMES REGEX "^ZONED_CLIENT_API ")
  file(STRINGS client-sim/web/web_client.cpp MORE REGEX "^ZONED_WEB_EXPORT ")
  set(WEB_EXPORTS)
  foreach(LINE ${NAMES} ${MORE})
    string(REGEX MATCH "(zoned_client|web)_[a-z_]+\\(" NAME "${LINE}")
    string(REPLACE "(" "" NAME "${NAME}")
    list(APPEND WEB_EXPORTS -Wl,--export-if-defined=${NAME})
  endforeach()
  # A few large sources: what takes the time is Eigen.
  set(WEB_OBJECTS)
  list(LENGTH WEB_SOURCES COUNT)
  set(BATCH 45)
  math(EXPR LAST "(${COUNT} - 1) / ${BATCH}")
  set(WASM_OPTIONS --target=wasm32-wasi -std=c++20 -O2 -DNDEBUG -fno-exceptions -fno-rtti -ffp-contract=off -DEIGEN_DONT_VECTORIZE -fvisibility=hidden
    -ffunction-sections -fdata-sections -Wall -Wextra -Werror -isystem ${EIGEN3_INCLUDE_DIRS} -I ${PROJECT_SOURCE_DIR})
  foreach(NUMBER RANGE ${LAST})
    math(EXPR FIRST "${NUMBER} * ${BATCH}")
    list(SUBLIST WEB_SOURCES ${FIRST} ${BATCH} PART)
    set(TEXT "")
    foreach(SOURCE ${PART})
      string(APPEND TEXT "#include \"${SOURCE}\"\n")
    endforeach()
    set(UNITY ${PROJECT_BINARY_DIR}/web/unity_${NUMBER}.cpp)
    file(GENERATE OUTPUT ${UNITY} CONTENT "${TEXT}")
    set(OBJECT ${PROJECT_BINARY_DIR}/web/unity_${NUMBER}.o)
    add_custom_command(OUTPUT ${OBJECT} VERBATIM
      COMMAND ${WASM_CXX} ${WASM_OPTIONS} -MD -MF ${OBJECT}.d -c ${UNITY} -o ${OBJECT}
      DEPENDS ${UNITY} DEPFILE ${OBJECT}.d)
    list(APPEND WEB_OBJECTS ${OBJECT})
  endforeach()
  add_custom_command(OUTPUT ${WEB_CLIENT} VERBATIM
    COMMAND ${WASM_CXX} --target=wasm32-wasi -mexec-model=reactor -O2 ${WEB_OBJECTS} -o ${WEB_CLIENT}
      ${WEB_EXPORTS} -Wl,--gc-sections -Wl,--strip-all -Wl,-z,stack-size=1048576
    DEPENDS ${WEB_OBJECTS})
  add_custom_target(web_client DEPENDS ${WEB_CLIENT})

  # The module with which tests compare this build with the server's.
  if(ZONED_TESTS)
    set(WEB_BITS ${PROJECT_BINARY_DIR}/web/motion_bits.wasm)
    add_custom_command(OUTPUT ${WEB_BITS} VERBATIM
      COMMAND ${WASM_CXX} ${WASM_OPTIONS} -mexec-model=reactor ${PROJECT_SOURCE_DIR}/tests/web/motion_bits.cpp
        ${PROJECT_SOURCE_DIR}/tests/web/module/motion_bits_module.cpp ${WEB_OBJECTS} -o ${WEB_BITS}
        -Wl,--export=bits_count -Wl,--export=bits_numbers -Wl,--gc-sections -Wl,--strip-all
      DEPENDS ${WEB_OBJECTS} ${PROJECT_SOURCE_DIR}/tests/web/motion_bits.cpp ${PROJECT_SOURCE_DIR}/tests/web/motion_bits.h
        ${PROJECT_SOURCE_DIR}/tests/scenario/elementary_bits.h
        ${PROJECT_SOURCE_DIR}/tests/web/module/motion_bits_module.cpp)
    add_custom_target(web_bits DEPENDS ${WEB_BITS})
  endif()
endif()

# The admin server holds the module, or an empty one.
set(WEB_MODULE_SOURCE ${PROJECT_BINARY_DIR}/generated/viewer/web_client_module.cpp)
if(ZONED_WEB_CLIENT)
  set(WEB_MODULE "asm(\".section .rodata\\n.balign 16\\n.global zoned_web_client_begin\\nzoned_web_client_begin:\\n.incbin \\\"${WEB_CLIENT}\\\"\\n.global zoned_web_client_end\\nzoned_web_client_end:\\n.byte 0\\n.previous\");
extern \"C\" const char zoned_web_client_begin[];
extern \"C\" const char zoned_web_client_end[];
std::string_view zoned::admin::web_client_module() {
    return {zoned_web_client_begin, static_cast<std::size_t>(zoned_web_client_end - zoned_web_client_begin)};
}
")
else()
  set(WEB_MODULE "std::string_view zoned::admin::web_client_module() {
    return {};
}
")
endif()
file(CONFIGURE OUTPUT ${WEB_MODULE_SOURCE} CONTENT "// Written by config/web_client.cmake.
#include \"server/admin/viewer_assets.h\"

@WEB_MODULE@" @ONLY)
target_sources(zoned_server_admin PRIVATE ${WEB_MODULE_SOURCE})
set_source_files_properties(${WEB_MODULE_SOURCE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
if(ZONED_WEB_CLIENT)
  set_source_files_properties(${WEB_MODULE_SOURCE} PROPERTIES OBJECT_DEPENDS ${WEB_CLIENT})
endif()
